/* flicker.h - flicker over an animation: samples that are the same for each frame against fresh ones (the paper,
   section 4: a static set "removes the temporal scintillation artifacts").

   The camera stands still. Every frame is rendered twice, with the scene's moving meshes and without them: a pixel is
   still if the two are equal, bit for bit, in all frames. With static sets nothing may change there; whether it does is
   measured, not assumed, for what the other moving meshes do to tree and packets is in every frame. */
#ifndef ERROR_FLICKER_H
#define ERROR_FLICKER_H

#include "error.h"
#include "scatter.h"

enum { FLICKER_FRAMES = 4, FLICKER_SAMPLES = 4, FLICKER_WIDTH = 64, FLICKER_HEIGHT = 48, FLICKER_FRESH = 100 };
#define FLICKER_START 0.3        /* of the loop: all is under way */
#define FLICKER_STEP (1.0 / 240) /* frames of the loop; the shutter is open for a whole one */

typedef struct film { /* a scene with its moving meshes, and without */
  stage with, without;
  double shutter;
} film;

/* Root mean squares over pixels and channels of the deviation over frames: of radiance, and as a screen shows it, where
   what is brighter than 1 is white, so that a few glints do not outweigh all else. */
enum { RADIANCE, SCREEN, SHOWN };

typedef struct flicker {
  double still[2][SHOWN], moving[2][SHOWN]; /* of static and of fresh sets */
  size_t still_pixels, pixels;
} flicker;

/* The scene without what moves. Lights that are meshes must not. */
static void remove_movers(const scene *all, scene *left) {
  *left = *all;
  left->meshes = (scene_mesh *)calloc(all->mesh_count, sizeof *left->meshes);
  left->lights = (pktrt_light *)calloc(all->light_count, sizeof *left->lights);
  if (!left->meshes || !left->lights) fatal("not enough memory");
  memcpy(left->lights, all->lights, all->light_count * sizeof *left->lights);
  left->mesh_count = 0;
  for (size_t i = 0; i < all->mesh_count; i++) {
    for (size_t k = 0; k < all->light_count; k++)
      if (all->lights[k].kind == PKTRT_LIGHT_MESH && all->lights[k].mesh == i) {
        if (all->meshes[i].deforms) fatal("a lamp moves");
        left->lights[k].mesh = (uint32_t)left->mesh_count;
      }
    if (!all->meshes[i].deforms) left->meshes[left->mesh_count++] = all->meshes[i];
  }
}

static void open_film(film *f, const char *name, pktrt_mode mode, unsigned threads) {
  scene left;
  stage *g = &f->with;
  memset(f, 0, sizeof *f);
  f->shutter = mode == PKTRT_MODE_DRT ? FLICKER_STEP : 0;
  snprintf(g->name, sizeof g->name, "%s", name);
  if (!scene_make(name, &g->made)) fatal("a scene cannot be made");
  g->built_in = true;
  remove_movers(&g->made, &left);
  for (int i = 0; i < 2; i++) {
    stage *s = i ? &f->without : &f->with;
    stage_world(s), stage_room(s, FLICKER_WIDTH, FLICKER_HEIGHT);
    if (scene_add_at(s->world, i ? &left : &g->made, FLICKER_START, f->shutter) != PKTRT_OK ||
        pktrt_commit(s->world) != PKTRT_OK)
      fatal(pktrt_last_error(s->world));
    s->threads.count = threads;
    s->view.mode = mode, s->view.tile_size = 16, s->view.camera = g->made.camera;
    s->view.camera.shutter = f->shutter > 0 ? 1 : 0; /* from the first key to the second */
    memcpy(s->view.background, g->made.background, sizeof s->view.background);
    memcpy(s->view.ambient, g->made.ambient, sizeof s->view.ambient);
  }
  free(left.meshes), free(left.lights);
}

static void close_film(film *f) { stage_close(&f->with), stage_close(&f->without); }

/* All frames into `with`; what differs without the movers is marked in `moving`. */
static void shoot_film(film *f, pktrt_sampler sampler, bool fresh, const pile *with, bool *moving) {
  const pile without = pile_of(with->values, 1);
  for (unsigned i = 0; i < with->count; i++) {
    const shot s = shot_of(sampler, FLICKER_SAMPLES, 1, fresh ? FLICKER_FRESH + i : FIRST_SEED);
    if (scene_pose(f->with.world, &f->with.made, FLICKER_START + i * FLICKER_STEP, f->shutter) != PKTRT_OK ||
        pktrt_refit(f->with.world) != PKTRT_OK)
      fatal(pktrt_last_error(f->with.world));
    pile_render(&f->with, &s, NULL, with, i), pile_render(&f->without, &s, NULL, &without, 0);
    for (size_t v = 0; v < with->values; v++)
      if (memcmp(pile_at(with, i) + v, without.pixels + v, sizeof(float)) != 0) moving[v / 3] = true;
  }
  free(without.pixels);
}

static double shown(float radiance, int how) { return how == SCREEN ? fmin((double)radiance, 1) : (double)radiance; }

/* Adds the variance over frames of a pixel's channels: exactly 0 where all are equal. */
static void add_flicker(const pile *p, size_t pixel, double to[SHOWN]) {
  for (int how = 0; how < SHOWN; how++)
    for (size_t v = pixel * 3; v < pixel * 3 + 3; v++) {
      double sum = 0, squares = 0;
      for (unsigned i = 1; i < p->count; i++) {
        const double x = shown(pile_at(p, i)[v], how) - shown(p->pixels[v], how);
        sum += x, squares += x * x;
      }
      to[how] += (squares - sum * sum / p->count) / (p->count - 1);
    }
}

/* Pixels count as still that are so in the frames of static sets and in those of fresh ones. */
static flicker measure_flicker(film *f, pktrt_sampler sampler) {
  const size_t n = stage_pixels(&f->with);
  const pile sets[2] = {pile_of(n * 3, FLICKER_FRAMES), pile_of(n * 3, FLICKER_FRAMES)};
  bool *moving = (bool *)calloc(n, sizeof(bool));
  flicker r;
  if (!moving) fatal("not enough memory");
  memset(&r, 0, sizeof r);
  pin(false);
  for (int fresh = 0; fresh < 2; fresh++) shoot_film(f, sampler, fresh != 0, &sets[fresh], moving);
  pin(true);
  r.pixels = n;
  for (size_t i = 0; i < n; i++) r.still_pixels += !moving[i];
  const double still = (double)r.still_pixels, others = (double)(n - r.still_pixels);
  for (int k = 0; k < 2; k++) {
    for (size_t i = 0; i < n; i++) add_flicker(&sets[k], i, moving[i] ? r.moving[k] : r.still[k]);
    for (int how = 0; how < SHOWN; how++) {
      r.still[k][how] = still > 0 ? sqrt(r.still[k][how] / (3 * still)) : 0;
      r.moving[k][how] = others > 0 ? sqrt(r.moving[k][how] / (3 * others)) : 0;
    }
    free(sets[k].pixels);
  }
  free(moving);
  return r;
}

/* >>report --------------------------------------------------------------------------------------------------------- */

static void say_samplers(const bench *b, const char *first) {
  say(&b->out, "%s", first);
  for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) say(&b->out, " %s |", pktrt_sampler_string((pktrt_sampler)s));
  say(&b->out, "\n");
}

static void say_still(const bench *b, flicker (*r)[PKTRT_SAMPLER_COUNT], const char *const *labels) {
  say(&b->out, "Flicker of still pixels on a screen, in percent of its white, %d samples, %d frames:\n\n",
      (int)FLICKER_SAMPLES, (int)FLICKER_FRAMES);
  say_samplers(b, "| | still pixels | static sets, all samplers | fresh sets:");
  say(&b->out, "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  for (int k = 0; k < 6; k++) {
    double most = 0, least = 1;
    for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) {
      most = fmax(most, 100 * r[k][s].still[0][RADIANCE]);
      least = fmin(least, (double)r[k][s].still_pixels / (double)r[k][s].pixels);
    }
    say(&b->out, "| %s | %.0f%% | %g |", labels[k], 100 * least, most);
    for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) say(&b->out, " %.2f |", 100 * r[k][s].still[1][SCREEN]);
    say(&b->out, "\n");
  }
}

static void say_moving(const bench *b, flicker (*r)[PKTRT_SAMPLER_COUNT], const char *const *labels) {
  say(&b->out, "\nThe other pixels, static / fresh sets; what moves is in both:\n\n");
  say_samplers(b, "| |");
  say(&b->out, "|---|--:|--:|--:|--:|--:|--:|--:|\n");
  for (int k = 0; k < 6; k++) {
    say(&b->out, "| %s |", labels[k]);
    for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++)
      say(&b->out, " %.1f / %.1f |", 100 * r[k][s].moving[0][SCREEN], 100 * r[k][s].moving[1][SCREEN]);
    say(&b->out, "\n");
  }
  say(&b->out, "\n");
}

static void part_flicker(bench *b) {
  static const char *const labels[6] = {
      "pool hall, WRT", "pool hall, DRT", "conference, WRT", "conference, DRT", "rtrt, WRT", "rtrt, DRT"};
  static film f;
  flicker r[6][PKTRT_SAMPLER_COUNT];
  csv(&b->out, "scene,mode,sampler,samples,frames,pixels,still_pixels,shown,static_still,fresh_still,static_moving,"
               "fresh_moving\n");
  for (int k = 0; k < 6; k++) {
    const char *name = scene_names()[k / 2];
    open_film(&f, name, k % 2 ? PKTRT_MODE_DRT : PKTRT_MODE_WRT, b->given.threads);
    for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) {
      const flicker *x = &r[k][s];
      r[k][s] = measure_flicker(&f, (pktrt_sampler)s);
      for (int how = 0; how < SHOWN; how++)
        csv(&b->out, "%s,%s,%s,%d,%d,%zu,%zu,%s,%.6g,%.6g,%.6g,%.6g\n", name, k % 2 ? "drt" : "wrt",
            pktrt_sampler_string((pktrt_sampler)s), (int)FLICKER_SAMPLES, (int)FLICKER_FRAMES, x->pixels,
            x->still_pixels, how == SCREEN ? "screen" : "radiance", x->still[0][how], x->still[1][how],
            x->moving[0][how], x->moving[1][how]);
    }
    close_film(&f);
  }
  say_still(b, r, labels);
  say_moving(b, r, labels);
}

/* Flicker of still pixels in WRT and DRT of scene c->on. Nothing is shown unless some pixels are still and some are
   not. The control has fresh sets. */
static double check_flicker(bench *b, const claim *c, bool control, char details[DETAILS]) {
  static film f;
  double worst = control ? INFINITY : 0;
  size_t still = SIZE_MAX, others = SIZE_MAX, n = 0;
  for (int drt = 0; drt < 2; drt++) {
    open_film(&f, c->on, drt ? PKTRT_MODE_DRT : PKTRT_MODE_WRT, b->given.threads);
    const flicker r = measure_flicker(&f, PKTRT_SAMPLER_SOBOL);
    close_film(&f);
    n = r.pixels;
    if (r.still_pixels < still) still = r.still_pixels;
    if (n - r.still_pixels < others) others = n - r.still_pixels;
    worst = control ? smaller(worst, r.still[1][RADIANCE]) : larger(worst, r.still[0][RADIANCE]);
  }
  snprintf(details, DETAILS, "of %zu pixels at least %zu are still, %zu are not", n, still, others);
  if (control) return still ? worst : NAN;
  return still && others ? worst : INFINITY;
}

#endif /* ERROR_FLICKER_H */
