/* Looks around in a scene or a mesh file: a window in which one can orbit, let the scene move, and change how the picture is made.
   `view --help` tells options and keys. Needs SDL2.

   While anything moves, the picture is a single pass, or with the filter two, at as many pixels as fit into a fifteenth of
   a second. When all is
   still, it is rendered at full size in passes, each of which is shown; the title tells what error is left, as
   estimated from the scatter of the passes. Whatever the user does ends that at once.

   The window belongs to the main thread, which also renders: pktrt_render calls it back after every pass, and after
   every tile that it has finished itself, and both times it looks after the user. */
#include "common.h"

#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

#include "filter.h"
#include "heat.h"
#include "mesh_view.h"
#include "scenes.h"
#include "words.h"
#include <SDL.h>
#include <getopt.h>

/* >>options -------------------------------------------------------------------------------------------------------- */

/* What keys and mouse change, and R sets back. */
typedef struct settings {
  pktrt_camera camera;
  int mode, sampler, path; /* values of the library's enumerations */
  unsigned packet;
  double shutter, time; /* parts of the animation, which is a loop */
  bool adaptive, filter;
  int heat; /* 0: the picture; else, less 1, what of its cost is shown */
} settings;

typedef struct options {
  const char *scene, *mesh, *output; /* mesh: of a file, in place of a scene; NULL: none */
  unsigned width, height, threads, samples, passes;
  double target_error;
  settings first; /* but for its camera */
  bool has_mode;
} options;

static const char *const packet_names[] = {"2", "4", "8", "16", NULL};

static void print_keys(void) {
  printf("mouse:  drag to orbit, with the right button to move sideways; the wheel goes nearer and farther\n"
         "keys:   arrows  move sideways            space   start and stop the animation\n"
         "        M       rcs, wrt, drt            P       packets of 2 x 2, 4 x 4, 8 x 8, 16 x 16\n"
         "        + -     aperture (drt)           T       traversal: fast, paper, single\n"
         "        . ,     shutter (drt)            N       next sampler\n"
         "        A       adaptive or uniform      R       everything as at the start\n"
         "        S       save what is shown       H       this text\n"
         "        F       filter while it moves    Esc, Q  quit\n"
         "        C       what it costs: boxes, triangles, vectors (paper path), and again the picture\n");
  fflush(stdout);
}

static void print_help(void) {
  printf("usage: view [options] [FILE]\n\n"
         "  FILE             a mesh file in place of a scene: .tri"
#ifdef HAVE_ASSIMP
         ", and what assimp reads, with its materials, lights and camera: .obj .gltf .glb ...\n");
#else
         " (built without assimp: nothing else)\n");
#endif
  print_words("  --scene NAME     a built-in scene (default rtrt):", scene_names());
  print_words(
      "  --mode MODE      ray casting, Whitted's (default), distribution ray tracing (that of files with gloss):",
      mode_words);
  printf("  --size WxH       of the window, in pixels (default 640x480)\n"
         "  --spp N          samples per pixel and pass, 1 to 64 (default 2)\n"
         "  --passes N       at most, 1 to 65536 (default 128)\n"
         "  --target-error E passes also end when the estimated error of what is shown is not above this: RMSE, of\n"
         "                   channels from 0 to 1\n"
         "  --adaptive       passes go where the error is\n");
  print_words("  --sampler NAME   where the samples lie:", sampler_words());
  print_words("  --path PATH      how packets are traced:", path_words);
  print_words("  --packet N       rays along a packet's edge (default 8):", packet_names);
  printf("  --threads N      (default: one per processor)\n"
         "  -o FILE          the .png that S saves (default view.png)\n"
         "  --help           this text\n\n");
  print_keys();
}

static bool parse_scene(const char *text, const char **name) {
  int i = 0;
  if (!ex_parse_word("scene", text, scene_names(), &i)) return false;
  *name = scene_names()[i];
  return true;
}

static bool parse_packet(const char *text, unsigned *packet) {
  int i = 0;
  if (!ex_parse_word("packet", text, packet_names, &i)) return false;
  *packet = 2u << i;
  return true;
}

static bool parse_output(const char *text, const char **output) {
  *output = text;
  return ex_has_suffix(text, ".png") || ex_fail("-o: \"%s\" does not end in .png", text);
}

enum option_name {
  OPT_SCENE = 256,
  OPT_MODE,
  OPT_SIZE,
  OPT_SPP,
  OPT_PASSES,
  OPT_TARGET_ERROR,
  OPT_ADAPTIVE,
  OPT_SAMPLER,
  OPT_PATH,
  OPT_PACKET,
  OPT_THREADS
};

static bool parse_option(options *o, int option, const char *text) {
  switch (option) {
  case OPT_SCENE: return parse_scene(text, &o->scene);
  case OPT_MODE: o->has_mode = true; return ex_parse_word("mode", text, mode_words, &o->first.mode);
  case OPT_SIZE: return ex_parse_size(text, &o->width, &o->height);
  case OPT_SPP: return ex_parse_uint("spp", text, 1, 64, &o->samples);
  case OPT_PASSES: return ex_parse_uint("passes", text, 1, 65536, &o->passes);
  case OPT_TARGET_ERROR: return ex_parse_real("target-error", text, 1e-6, 1e6, &o->target_error);
  case OPT_ADAPTIVE: o->first.adaptive = true; return true;
  case OPT_SAMPLER: return ex_parse_word("sampler", text, sampler_words(), &o->first.sampler);
  case OPT_PATH: return ex_parse_word("path", text, path_words, &o->first.path);
  case OPT_PACKET: return parse_packet(text, &o->first.packet);
  case OPT_THREADS: return ex_parse_uint("threads", text, 1, EX_MAX_THREADS, &o->threads);
  case 'o': return parse_output(text, &o->output);
  case 'h': print_help(); exit(0);
  }
  return false;
}

static bool parse_options(options *o, int argc, char **argv) {
  static const struct option list[] = {{"scene", required_argument, NULL, OPT_SCENE},
      {"mode", required_argument, NULL, OPT_MODE}, {"size", required_argument, NULL, OPT_SIZE},
      {"spp", required_argument, NULL, OPT_SPP}, {"passes", required_argument, NULL, OPT_PASSES},
      {"target-error", required_argument, NULL, OPT_TARGET_ERROR}, {"adaptive", no_argument, NULL, OPT_ADAPTIVE},
      {"sampler", required_argument, NULL, OPT_SAMPLER}, {"path", required_argument, NULL, OPT_PATH},
      {"packet", required_argument, NULL, OPT_PACKET}, {"threads", required_argument, NULL, OPT_THREADS},
      {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0}};
  memset(o, 0, sizeof *o);
  o->scene = "rtrt", o->output = "view.png";
  o->width = 640, o->height = 480, o->samples = 2, o->passes = 128;
  o->threads = ex_processors();
  o->first.mode = PKTRT_MODE_WRT, o->first.packet = 8, o->first.shutter = 1.0 / 240;
  opterr = 0; /* our own line instead */
  for (;;) {
    int at = optind, option = getopt_long(argc, argv, "o:h", list, NULL);
    if (option == -1) break;
    if (option == '?')
      return ex_fail("%s: unknown, ambiguous, or its value is missing or too much; see --help", argv[at]);
    if (!parse_option(o, option, optarg)) return false;
  }
  if (optind < argc) o->mesh = argv[optind++];
  return optind >= argc ||
         ex_fail("%s: an argument too many: the only one without an option is a file; see --help", argv[optind]);
}

/* >>viewer --------------------------------------------------------------------------------------------------------- */

typedef struct viewer {
  options given;
  settings now, first;
  /* What the user has done, by whichever function called take_events last. */
  bool changed, animating, resized, quit;
  bool failed; /* a hook could not show a picture, and has said so */

  ex_threads threads;
  scene built_in;         /* zeroed for a file */
  mesh_file file;         /* zeroed for a scene */
  pktrt_render_desc look; /* of a file: camera and surroundings */
  double size;            /* of the scene, against which distances are measured: 10 for those built in */
  double exposure;        /* 0: not known yet */
  pktrt_scene *world;     /* in the pose of posed_time and posed_shutter */
  double posed_time, posed_shutter;
  double ticked; /* when the animation was advanced last */

  SDL_Window *window;
  SDL_Renderer *renderer;
  SDL_Texture *texture;
  SDL_threadID main_thread;
  SDL_atomic_t stop;      /* the render shall end: set by the main thread, read by all */
  unsigned width, height; /* of texture and buffers */
  float *pixels;
  float *depth, *normal, *albedo; /* for the filter, in one block */
  float *cost, *heat;             /* tests per sample, and their colours, in another */
  filter_halves halves;           /* of a preview's passes */
  unsigned char *codes;           /* what is shown, sRGB, shown_width x shown_height */
  unsigned shown_width, shown_height;

  double preview_pixels;          /* how many a preview may have */
  bool refining, done;            /* what is shown is made of passes; and no more will come */
  pktrt_report report;            /* of them */
  double shown_at, frame_seconds; /* when a picture was shown last, and the mean time from one to the next */
  double titled_at;
} viewer;

/* >>camera --------------------------------------------------------------------------------------------------------- */

static double distance_of(const pktrt_camera *c) {
  double sum = 0;
  for (int a = 0; a < 3; a++) sum += pow((double)c->eye[a] - (double)c->target[a], 2);
  return sqrt(sum);
}

/* Around the target: angles in radians, to the right and up, not quite to the poles. */
static void orbit(pktrt_camera *c, double right, double up) {
  const double x = (double)c->eye[0] - (double)c->target[0], y = (double)c->eye[1] - (double)c->target[1],
               z = (double)c->eye[2] - (double)c->target[2], distance = distance_of(c);
  const double turn = atan2(x, z) + right, rise = fmax(-1.5, fmin(1.5, asin(y / distance) + up));
  c->eye[0] = (float)((double)c->target[0] + distance * cos(rise) * sin(turn));
  c->eye[1] = (float)((double)c->target[1] + distance * sin(rise));
  c->eye[2] = (float)((double)c->target[2] + distance * cos(rise) * cos(turn));
}

/* Nearer to the target or farther; what is sharp stays as far before or behind it, in proportion. */
static void zoom(pktrt_camera *c, double factor, double size) {
  const double distance = factor * distance_of(c);
  if (distance < 0.002 * size || distance > 20 * size) return;
  for (int a = 0; a < 3; a++)
    c->eye[a] = (float)((double)c->target[a] + factor * ((double)c->eye[a] - (double)c->target[a]));
  c->focus = (float)(factor * (double)c->focus);
}

/* Eye and target sideways and up, by parts of the picture's height as it is at the target. */
static void pan(pktrt_camera *c, double right, double up) {
  const double distance = distance_of(c), height = 2 * distance * tan(0.5 * (double)c->fov_y * SC_PI / 180);
  const sc_v3 eye = sc_v((double)c->eye[0], (double)c->eye[1], (double)c->eye[2]);
  const sc_v3 target = sc_v((double)c->target[0], (double)c->target[1], (double)c->target[2]);
  const sc_v3 back = sc_unit(sc_sub(eye, target)), x = sc_unit(sc_cross(sc_v(0, 1, 0), back)), y = sc_cross(back, x);
  const sc_v3 by = sc_add(sc_mul(x, height * right), sc_mul(y, height * up));
  const double step[3] = {by.x, by.y, by.z};
  for (int a = 0; a < 3; a++) {
    c->eye[a] = (float)((double)c->eye[a] + step[a]);
    c->target[a] = (float)((double)c->target[a] + step[a]);
  }
}

/* >>window --------------------------------------------------------------------------------------------------------- */

static bool sdl_failed(const char *what) { return ex_fail("%s: %s", what, SDL_GetError()); }

/* Texture and buffers of the window's size. Until the next picture there is none to show. */
static bool fit_window(viewer *v) {
  int width = 0, height = 0;
  if (SDL_GetRendererOutputSize(v->renderer, &width, &height) != 0) return sdl_failed("the window's size");
  v->width = width < 1 ? 1 : (unsigned)width, v->height = height < 1 ? 1 : (unsigned)height;
  if (v->width > EX_MAX_SIZE || v->height > EX_MAX_SIZE)
    return ex_fail("a window of %u x %u is too large", v->width, v->height);
  const size_t n = (size_t)v->width * v->height * 3;
  if (v->texture) SDL_DestroyTexture(v->texture);
  free(v->pixels);
  free(v->depth);
  free(v->cost);
  free(v->codes);
  v->shown_width = v->shown_height = 0;
  v->texture =
      SDL_CreateTexture(v->renderer, SDL_PIXELFORMAT_RGB24, SDL_TEXTUREACCESS_STREAMING, (int)v->width, (int)v->height);
  v->pixels = (float *)calloc(n, sizeof(float));
  v->codes = (unsigned char *)malloc(n);
  v->depth = (float *)calloc(n / 3 * 7, sizeof(float));
  v->normal = v->depth ? v->depth + n / 3 : NULL, v->albedo = v->depth ? v->depth + n / 3 * 4 : NULL;
  v->cost = (float *)calloc(n / 3 * 4, sizeof(float)), v->heat = v->cost ? v->cost + n / 3 : NULL;
  v->resized = false;
  if (!v->texture) return sdl_failed("the window's picture");
  return (v->pixels && v->codes && v->depth && v->cost) ||
         ex_fail("not enough memory for a picture of %u x %u", v->width, v->height);
}

static bool open_window(viewer *v) {
  if (SDL_Init(SDL_INIT_VIDEO) != 0) return sdl_failed("no window");
  v->main_thread = SDL_ThreadID();
  v->window = SDL_CreateWindow("pktrt", SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED, (int)v->given.width,
      (int)v->given.height, SDL_WINDOW_RESIZABLE);
  if (!v->window) return sdl_failed("no window");
  v->renderer = SDL_CreateRenderer(v->window, -1, 0);
  return v->renderer ? fit_window(v) : sdl_failed("no window");
}

static void close_window(viewer *v) {
  if (v->texture) SDL_DestroyTexture(v->texture);
  if (v->renderer) SDL_DestroyRenderer(v->renderer);
  if (v->window) SDL_DestroyWindow(v->window);
  SDL_Quit();
  free(v->pixels);
  free(v->depth);
  free(v->cost);
  free(v->codes);
}

/* Puts the last picture, whatever its size, onto the whole window. */
static void present(viewer *v) {
  SDL_Rect part;
  part.x = part.y = 0, part.w = (int)v->shown_width, part.h = (int)v->shown_height;
  if (!v->shown_width) return;
  SDL_RenderCopy(v->renderer, v->texture, &part, NULL);
  SDL_RenderPresent(v->renderer);
}

/* What is looked at. */
static const char *seen_name(const viewer *v) { return v->given.mesh ? v->given.mesh : v->given.scene; }

static const char *const heat_titles[] = {": boxes", ": triangles", ": vectors"};

/* Frames per second are previews, or passes, shown within a second. */
static void show_title(viewer *v) {
  const settings *s = &v->now;
  char text[256], error[32] = "-";
  const double estimate = v->report.display_error < INFINITY ? v->report.display_error : v->report.rmse;
  if (v->refining && estimate < INFINITY) snprintf(error, sizeof error, "%.5f", estimate);
  snprintf(text, sizeof text,
      "%s %s%s, %.1f frames/s, error %s, %.4g spp%s%s%s - packets %u %s, %s, aperture %.3g, shutter %.3g, "
      "time %.2f",
      seen_name(v), mode_words[s->mode], s->heat ? heat_titles[s->heat - 1] : "",
      v->frame_seconds > 0 ? 1 / v->frame_seconds : 0.0, error,
      v->refining ? v->report.samples_mean
      : s->filter ? 4.0
                  : 1.0,
      s->adaptive ? " adaptive" : "", s->filter ? " filter" : "",
      v->done        ? ", done"
      : v->animating ? ", moving"
                     : "",
      s->packet, path_words[s->path], sampler_words()[s->sampler], (double)s->camera.aperture, s->shutter, s->time);
  SDL_SetWindowTitle(v->window, text);
  v->titled_at = ex_seconds();
}

/* Shows a picture of linear floats, at most as large as the window, or its cost. */
static bool show_picture(viewer *v, unsigned width, unsigned height) {
  SDL_Rect part;
  part.x = part.y = 0, part.w = (int)width, part.h = (int)height;
  if (v->now.heat) {
    const heat_picture to = {v->heat, width, height};
    const double scale = heat_scale(v->cost, (size_t)width * height);
    if (scale < 0) return ex_fail("not enough memory for the colours of cost");
    heat_paint(v->cost, scale, &to);
  }
  const size_t n = (size_t)width * height;
  if (!(v->exposure > 0) && !v->now.heat) {
    pktrt_render_desc shown = v->look;
    shown.camera = v->now.camera;
    shown.width = width, shown.height = height;
    v->exposure = mesh_view_exposure(&shown, v->pixels);
  }
  pktrt_to_srgb8(
      v->now.heat ? v->heat : v->pixels, n, v->now.heat ? 0 : (float)v->exposure, PKTRT_TONE_CLAMP, v->codes);
  v->shown_width = width, v->shown_height = height;
  if (SDL_UpdateTexture(v->texture, &part, v->codes, (int)width * 3) != 0) return sdl_failed("the window's picture");
  present(v);
  const double now = ex_seconds(), took = now - v->shown_at;
  v->frame_seconds = v->frame_seconds > 0 ? 0.8 * v->frame_seconds + 0.2 * took : took;
  v->shown_at = now;
  return true;
}

static void save_picture(const viewer *v) {
  const int width = (int)v->shown_width, height = (int)v->shown_height;
  if (!v->shown_width) return;
  errno = 0;
  if (stbi_write_png(v->given.output, width, height, 3, v->codes, 3 * width)) {
    printf("%s: %d x %d\n", v->given.output, width, height);
    fflush(stdout);
  } else {
    ex_fail("%s: could not be written: %s", v->given.output, errno ? strerror(errno) : "out of memory");
  }
}

/* >>events --------------------------------------------------------------------------------------------------------- */

/* They change settings and say so. The scene is left to the main loop: it may just be being rendered. */

/* Larger or smaller by a quarter; below the least there is nothing. */
static double step(double value, double least, double most, bool up) {
  if (up) return value > 0 ? fmin(1.25 * value, most) : least;
  return value > 1.1 * least ? value / 1.25 : 0;
}

static void step_aperture(settings *s, bool up) {
  const double distance = distance_of(&s->camera);
  s->camera.aperture = (float)step((double)s->camera.aperture, 0.001 * distance, distance, up);
}

/* Keys that change what is seen or how it is made; false: not one of these. */
static bool change_settings(settings *s, const settings *first, SDL_Keycode key) {
  switch (key) {
  case SDLK_m: s->mode = (s->mode + 1) % 3; return true;
  case SDLK_t:
    s->path = (s->path + 1) % 3;
    if (s->heat > PKTRT_COST_VECTORS) s->heat = 1; /* which this path does not count */
    return true;
  case SDLK_n: s->sampler = (s->sampler + 1) % PKTRT_SAMPLER_COUNT; return true;
  case SDLK_p: s->packet = s->packet < 16 ? 2 * s->packet : 2; return true;
  case SDLK_c: s->heat = (s->heat + 1) % (s->path == PKTRT_PATH_PAPER ? 4 : 3); return true;
  case SDLK_f: s->filter = !s->filter; return true;
  case SDLK_a: s->adaptive = !s->adaptive; return true;
  case SDLK_PLUS:
  case SDLK_EQUALS: /* the same key without shift */
  case SDLK_KP_PLUS: step_aperture(s, true); return true;
  case SDLK_MINUS:
  case SDLK_KP_MINUS: step_aperture(s, false); return true;
  case SDLK_PERIOD: s->shutter = step(s->shutter, 1.0 / 960, 1, true); return true;
  case SDLK_COMMA: s->shutter = step(s->shutter, 1.0 / 960, 1, false); return true;
  case SDLK_LEFT: pan(&s->camera, -0.02, 0); return true;
  case SDLK_RIGHT: pan(&s->camera, 0.02, 0); return true;
  case SDLK_UP: pan(&s->camera, 0, 0.02); return true;
  case SDLK_DOWN: pan(&s->camera, 0, -0.02); return true;
  case SDLK_r: *s = *first; return true;
  default: return false;
  }
}

static void take_key(viewer *v, SDL_Keycode key) {
  switch (key) {
  case SDLK_ESCAPE:
  case SDLK_q: v->quit = true; return;
  case SDLK_h: print_keys(); return;
  case SDLK_s: save_picture(v); return;
  case SDLK_SPACE:
    v->animating = !v->animating;
    v->ticked = ex_seconds();
    v->changed = true;
    return;
  default:
    if (!change_settings(&v->now, &v->first, key)) return;
    v->animating = v->animating && key != SDLK_r;
    v->changed = true;
  }
}

static void take_motion(viewer *v, const SDL_MouseMotionEvent *m) {
  const double right = (double)m->xrel / v->height, up = (double)m->yrel / v->height;
  if (m->state & SDL_BUTTON_LMASK) orbit(&v->now.camera, -SC_PI * right, SC_PI * up);
  else if (m->state & (SDL_BUTTON_RMASK | SDL_BUTTON_MMASK)) pan(&v->now.camera, -right, up);
  else return;
  v->changed = true;
}

static void take_window_event(viewer *v, const SDL_WindowEvent *w) {
  if (w->event == SDL_WINDOWEVENT_SIZE_CHANGED) v->resized = v->changed = true;
  if (w->event == SDL_WINDOWEVENT_EXPOSED && !v->resized) present(v);
}

/* All events there are. */
static void take_events(viewer *v) {
  SDL_Event e;
  while (SDL_PollEvent(&e)) switch (e.type) {
    case SDL_QUIT: v->quit = true; break;
    case SDL_KEYDOWN: take_key(v, e.key.keysym.sym); break;
    case SDL_MOUSEMOTION: take_motion(v, &e.motion); break;
    case SDL_MOUSEWHEEL:
      zoom(&v->now.camera, pow(0.9, e.wheel.y), v->size);
      v->changed = true;
      break;
    case SDL_WINDOWEVENT: take_window_event(v, &e.window); break;
    default: break;
    }
}

static bool interrupted(const viewer *v) { return v->changed || v->animating || v->quit; }

/* >>scene ---------------------------------------------------------------------------------------------------------- */

/* A file's meshes, and where one looks from first. */
static bool read_file(viewer *v) {
  const options *o = &v->given;
  const mesh_view view = {o->mesh, (double)o->width / o->height, false, false, false};
  pktrt_scene_info info;
  bool ok = true;
  if (!mesh_file_open(&v->file, v->world, o->mesh, false)) return false;
  if (pktrt_commit(v->world) != PKTRT_OK) return ex_fail("%s", pktrt_last_error(v->world));
  pktrt_get_scene_info(v->world, &info);
  if (info.degenerate >= info.triangles)
    return ex_fail("%s: there is nothing to see: none of its triangles has an area", o->mesh);
  v->look.camera.fov_y = 40;
  if (v->file.has_camera) mesh_view_take_camera(&v->file, &info, &v->look.camera);
  else if (!mesh_view_frame_bounds(&view, &info, &v->look.camera)) return false;
  v->exposure = mesh_view_light(&view, &v->file, v->world, &v->look, &ok) ? 0 : 1;
  v->size = distance_of(&v->look.camera);
  v->first.camera = v->look.camera;
  if (!o->has_mode && (v->file.scatters || v->file.lights > 0)) v->first.mode = PKTRT_MODE_DRT;
  v->now = v->first;
  return ok;
}

static bool make_world(viewer *v, double time, double shutter) {
  pktrt_scene_desc desc;
  memset(&desc, 0, sizeof desc);
  desc.parallel_for = ex_parallel_for;
  desc.user = &v->threads;
  desc.rebuild = PKTRT_REBUILD_AUTOMATIC;
  desc.log = NULL; /* there are lights, and that a mode ignores mirrors or the lens is what its key is for */
  pktrt_scene_destroy(v->world);
  v->world = pktrt_scene_create(&desc);
  if (!v->world) return ex_fail("%s", pktrt_last_error(NULL));
  if (v->given.mesh) return read_file(v);
  const pktrt_status status = scene_add_at(v->world, &v->built_in, time, shutter);
  if (status == PKTRT_OUT_OF_MEMORY) return ex_fail("%s: not enough memory for the scene", v->given.scene);
  if (status != PKTRT_OK || pktrt_commit(v->world) != PKTRT_OK) return ex_fail("%s", pktrt_last_error(v->world));
  return true;
}

/* The pose that the settings ask for, by a refit. An open shutter takes two keys for each mesh that deforms, a shut one
   has one: between these, everything is built anew, which *built tells. Only DRT sees what moves while the shutter is
   open. */
static bool pose_world(viewer *v, bool *built) {
  const double time = v->now.time, shutter = v->now.mode == PKTRT_MODE_DRT ? v->now.shutter : 0;
  bool ok = true;
  *built = !v->world || (!v->given.mesh && (shutter > 0) != (v->posed_shutter > 0));
  if (!*built && v->given.mesh) return true; /* which is at rest */
  if (!*built && time == v->posed_time && shutter == v->posed_shutter) return true;
  if (*built) ok = make_world(v, time, shutter);
  else if (scene_pose(v->world, &v->built_in, time, shutter) != PKTRT_OK) ok = ex_fail("the scene could not be posed");
  else if (pktrt_refit(v->world) != PKTRT_OK) ok = ex_fail("%s", pktrt_last_error(v->world));
  v->posed_time = time, v->posed_shutter = shutter;
  return ok;
}

/* >>pictures ------------------------------------------------------------------------------------------------------- */

static void describe(viewer *v, pktrt_render_desc *d) {
  const settings *s = &v->now;
  memset(d, 0, sizeof *d);
  d->samples = 1;
  d->pixels = v->pixels;
  d->mode = (pktrt_mode)s->mode;
  d->camera = s->camera;
  d->camera.time = 0; /* the shutter is open from the first key to the last */
  d->camera.shutter = v->posed_shutter > 0 ? 1 : 0;
  memcpy(d->background, v->look.background, sizeof d->background);
  memcpy(d->ambient, v->look.ambient, sizeof d->ambient);
  d->environment = v->look.environment;
  if (v->file.lights > 16) d->lights = PKTRT_LIGHTS_ONE;
  d->packet_size = s->packet;
  d->path = (pktrt_path)s->path;
  d->sampler = (pktrt_sampler)s->sampler;
  if (s->heat) d->cost = v->cost, d->cost_of = (pktrt_cost)(s->heat - 1);
  d->tile_size = 32; /* the time of a tile is how long the user may have to wait */
}

static const double loop_seconds = 10, preview_seconds = 1.0 / 15;

static bool gather_pass(void *user, const pktrt_report *report) {
  viewer *v = (viewer *)user;
  (void)report;
  filter_add_pass(&v->halves, v->pixels);
  filter_add_features(&v->halves, v->depth, v->normal, v->albedo);
  return true;
}

/* Renders a preview; for the filter in two passes, of two samples, as a single one would lie in the middle each
   time. */
static bool render_preview(viewer *v, pktrt_render_desc *d) {
  filter_picture picture;
  if (!v->now.filter) return pktrt_render(v->world, d) == PKTRT_OK || ex_fail("%s", pktrt_last_error(v->world));
  d->depth = v->depth, d->normal = v->normal, d->albedo = v->albedo;
  d->samples = d->passes = 2, d->pass = gather_pass, d->user = v;
  if (!filter_begin(&v->halves, d->width, d->height)) return ex_fail("not enough memory for the filter");
  bool ok = pktrt_render(v->world, d) == PKTRT_OK || ex_fail("%s", pktrt_last_error(v->world));
  if (ok && filter_finish(&v->halves, &picture)) {
    picture.depth = v->depth, picture.normal = v->normal, picture.albedo = v->albedo;
    const size_t tiles = filter_tiles(&picture);
    bool *failed = (bool *)calloc(tiles, sizeof *failed);
    filter_job job = {&picture, v->pixels, NULL, failed};
    if (failed) ex_parallel_for(&v->threads, tiles, filter_tile, &job);
    ok = failed != NULL;
    for (size_t i = 0; ok && i < tiles; i++) ok = !failed[i];
    free(failed);
    ok = ok || ex_fail("not enough memory for the filter");
  }
  filter_end(&v->halves);
  return ok;
}

/* One pass over fewer pixels, of the window's shape: as many as the last preview's speed allows. */
static bool preview(viewer *v) {
  const double start = ex_seconds();
  pktrt_render_desc d;
  bool built;
  if (v->animating) {
    v->now.time += (start - v->ticked) / loop_seconds;
    v->now.time -= floor(v->now.time);
    v->ticked = start;
  }
  if (!pose_world(v, &built)) return false;
  const double all = (double)v->width * v->height, scale = sqrt(fmin(1, v->preview_pixels / all));
  describe(v, &d);
  d.width = (uint32_t)fmax(1, ceil(scale * v->width)), d.height = (uint32_t)fmax(1, ceil(scale * v->height));
  v->changed = false;
  if (v->refining) { /* what the title says is no longer true, and the mean was of something else */
    v->frame_seconds = 0, v->shown_at = start;
    v->refining = v->done = false;
    show_title(v);
  }
  if (!render_preview(v, &d)) return false;
  if (!show_picture(v, d.width, d.height)) return false;
  const double factor = preview_seconds / (ex_seconds() - start);
  if (!built && (factor < 0.8 || factor > 1.2)) /* else the size would never be at rest */
    v->preview_pixels = fmax(256, fmin(all, v->preview_pixels * fmax(0.25, fmin(2, factor))));
  if (v->shown_at - v->titled_at > 0.2) show_title(v);
  return true;
}

/* Hooks of the render that refines. SDL's events come to the main thread, which is one of those that render. */
static bool go_on(void *user, float done) {
  viewer *v = (viewer *)user;
  (void)done;
  if (SDL_ThreadID() == v->main_thread) {
    take_events(v);
    if (interrupted(v)) SDL_AtomicSet(&v->stop, 1);
  }
  return SDL_AtomicGet(&v->stop) == 0;
}

static bool show_pass(void *user, const pktrt_report *report) {
  viewer *v = (viewer *)user;
  if (!v->refining) v->frame_seconds = 0; /* that of previews */
  v->refining = true;
  v->report = *report;
  v->done = report->stop != PKTRT_STOP_NOT_YET;
  if (!show_picture(v, v->width, v->height)) v->failed = v->quit = true;
  if (v->done || v->shown_at - v->titled_at > 0.1) show_title(v);
  take_events(v);
  return !interrupted(v);
}

/* Passes at full size until the rules say stop, or the user does something. */
static bool refine(viewer *v) {
  pktrt_render_desc d;
  describe(v, &d);
  d.width = v->width, d.height = v->height;
  d.samples = v->given.samples;
  d.passes = v->given.passes;
  d.adaptive = v->now.adaptive && v->given.passes > 1; /* the pilot is two passes */
  d.target_error = (float)v->given.target_error;
  if (d.adaptive || d.target_error > 0) d.measure = PKTRT_ERROR_DISPLAY;
  d.display_exposure = (float)v->exposure; /* 0 where it is not known yet: 1 */
  d.progress = go_on;
  d.pass = show_pass;
  d.user = v;
  SDL_AtomicSet(&v->stop, 0);
  const pktrt_status status = pktrt_render(v->world, &d);
  return status == PKTRT_OK || status == PKTRT_CANCELLED || ex_fail("%s", pktrt_last_error(v->world));
}

static bool look_around(viewer *v) {
  bool ok = true;
  v->changed = true;
  v->preview_pixels = 20000;
  v->shown_at = ex_seconds();
  while (ok && !v->quit) {
    take_events(v);
    if (v->quit) break;
    if (v->resized) ok = fit_window(v);
    if (ok && (v->changed || v->animating)) ok = preview(v);
    else if (ok && !v->done) ok = refine(v);
    else SDL_WaitEvent(NULL); /* leaves it to take_events */
  }
  return ok && !v->failed;
}

/* A built-in scene, with its camera and surroundings. */
static bool take_scene(viewer *v) {
  if (!scene_make(v->given.scene, &v->built_in)) return ex_fail("%s: not enough memory for the scene", v->given.scene);
  v->first.camera = v->built_in.camera;
  memcpy(v->look.background, v->built_in.background, sizeof v->look.background);
  memcpy(v->look.ambient, v->built_in.ambient, sizeof v->look.ambient);
  v->look.environment = v->built_in.environment;
  v->size = 10;
  v->exposure = 1;
  return true;
}

int main(int argc, char **argv) {
  static viewer v; /* static: zeroed */
  if (!parse_options(&v.given, argc, argv)) return 1;
  v.threads.count = v.given.threads;
  v.first = v.given.first;
  if (!v.given.mesh && !take_scene(&v)) return 1;
  v.now = v.first;
  const bool ok = open_window(&v) && look_around(&v);
  close_window(&v);
  pktrt_scene_destroy(v.world);
  ex_threads_stop(&v.threads);
  scene_free(&v.built_in);
  mesh_file_close(&v.file);
  return ok ? 0 : 1;
}
