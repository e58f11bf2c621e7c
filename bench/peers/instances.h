/* instances.h - part of peers.c: instances of pktrt beside those of Embree, and the same triangles added directly
   likewise. The field of ../field.h, at rest and moving between two keys; the same rays for all, in turns.

   What must be reached is a quotient: the ratio of pktrt to Embree on instances, over that on meshes.

   Contents: field, pairs, racing, tables. */
#ifndef PEERS_INSTANCES_H
#define PEERS_INSTANCES_H

#include "race.h"
#include "rays.h"
#include "report.h"
#include "scenes.h"
#include "../embree.h"
#include "../field.h"

/* >>field ---------------------------------------------------------------------------------------------------------- */

typedef enum form { AS_MESHES, AS_INSTANCES, FORMS } form; /* of the field */
static const char *const form_names[FORMS] = {"meshes", "instances"};
static const char *const call_names[2] = {"many", "single"};
static const char *const quotient_names[2] = {"many over meshes", "single over meshes"};
#define QUOTIENT 0.85 /* required, of means over the kinds of rays */

enum { FIELD_SETTINGS = 2 };
static const setting field_settings[FIELD_SETTINGS] = {
    {REST, 0, 0, false, false, false}, {"moving", 0.01, 0, false, false, false}};
static field_sphere field_ball;

static unsigned field_keys(const setting *how) { return how->share > 0 ? 2 : 1; }

/* A quarter of the rays of other stages. */
static unsigned field_across(const options *o, const setting *how) {
  const unsigned across = rays_across(o, how) / 32 * 16;
  return across ? across : 16;
}

/* The field as meshes: of instances the names alone differ. */
static void open_field(const setting *how, stage g[FORMS]) {
  static const float eye[3] = {0.5f * (int)FIELD_SIDE - 0.5f, 0.5f * (int)FIELD_SIDE - 0.5f, -0.8f * (int)FIELD_SIDE};
  static const float light[3] = {0.4f * (int)FIELD_SIDE, 1.5f * (int)FIELD_SIDE, -0.5f * (int)FIELD_SIDE};
  const unsigned keys = field_keys(how);
  memset(g, 0, FORMS * sizeof *g);
  stage_room(&g->s, FIELD_COUNT);
  for (uint32_t i = 0; i < FIELD_COUNT; i++) {
    scene_mesh *m = &g->s.meshes[i];
    float matrix[2][12];
    field_transforms(i, matrix);
    mesh_room(m, keys * FIELD_VERTICES, FIELD_TRIANGLES);
    m->vertex_count = FIELD_VERTICES, m->key_count = keys;
    for (unsigned k = 0; k < keys; k++)
      field_place(&field_ball, matrix[k], (float(*)[3])m->positions + k * FIELD_VERTICES);
    memcpy(m->indices, field_ball.indices, sizeof field_ball.indices);
  }
  pktrt_camera *c = &g->s.camera;
  memcpy(c->eye, eye, sizeof eye), memcpy(c->target, eye, sizeof eye), memcpy(g->light, light, sizeof light);
  c->target[2] = 0, c->fov_y = 53;
  stage_finish(g, form_names[AS_MESHES], GENERATED);
  g[AS_INSTANCES] = g[AS_MESHES];
  snprintf(g[AS_INSTANCES].name, sizeof g->name, "%s", form_names[AS_INSTANCES]);
}

/* >>pairs ---------------------------------------------------------------------------------------------------------- */

static void place_ours(pair *p, unsigned keys) {
  pktrt_scene_desc desc;
  pktrt_mesh_desc d;
  pktrt_instance_desc at;
  memset(&desc, 0, sizeof desc), memset(&d, 0, sizeof d), memset(&at, 0, sizeof at);
  desc.isa = p->isa;
  d.positions = field_ball.positions[0], d.vertex_count = FIELD_VERTICES;
  d.indices = field_ball.indices[0], d.triangle_count = FIELD_TRIANGLES;
  p->ours = pktrt_scene_create(&desc);
  if (!p->ours || pktrt_add_model(p->ours, &d, 1, &at.model) != PKTRT_OK) fatal(pktrt_last_error(p->ours));
  for (uint32_t i = 0; i < FIELD_COUNT; i++) {
    float matrix[2][12];
    field_transforms(i, matrix);
    at.transforms = matrix[0], at.key_count = keys;
    if (pktrt_add_instance(p->ours, &at, NULL) != PKTRT_OK) fatal(pktrt_last_error(p->ours));
  }
  if (pktrt_commit(p->ours) != PKTRT_OK) fatal(pktrt_last_error(p->ours));
}

static RTCScene new_scene(RTCDevice device) { /* as build_theirs makes them */
  const RTCScene s = rtcNewScene(device);
  rtcSetSceneBuildQuality(s, RTC_BUILD_QUALITY_MEDIUM);
  rtcSetSceneFlags(s, RTC_SCENE_FLAG_NONE);
  return s;
}

static void place_theirs(pair *p, unsigned keys) {
  const RTCScene model = new_scene(p->device);
  scene_mesh m;
  memset(&m, 0, sizeof m);
  m.positions = field_ball.positions[0], m.vertex_count = FIELD_VERTICES, m.key_count = 1;
  m.indices = field_ball.indices[0], m.triangle_count = FIELD_TRIANGLES;
  embree_add(p->device, model, &m);
  rtcCommitScene(model);
  p->theirs = new_scene(p->device);
  for (uint32_t i = 0; i < FIELD_COUNT; i++) {
    const RTCGeometry g = rtcNewGeometry(p->device, RTC_GEOMETRY_TYPE_INSTANCE);
    float matrix[2][12];
    field_transforms(i, matrix);
    rtcSetGeometryInstancedScene(g, model);
    rtcSetGeometryTimeStepCount(g, keys);
    for (unsigned k = 0; k < keys; k++) rtcSetGeometryTransform(g, k, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, matrix[k]);
    rtcCommitGeometry(g);
    rtcAttachGeometry(p->theirs, g);
    rtcReleaseGeometry(g);
  }
  rtcCommitScene(p->theirs);
  rtcReleaseScene(model); /* its instances keep it */
  if (rtcGetDeviceError(p->device) != RTC_ERROR_NONE) fatal("Embree reports an error after building instances");
}

/* `count` pairs with the field as meshes, then as many with instances. */
static void build_field(pair *both, unsigned count, const stage *g, const setting *how) {
  build_pairs(both, count, g, how, 1);
  for (unsigned i = 0; i < count; i++) {
    pair *p = &both[count + i];
    *p = both[i], p->theirs = NULL, p->instanced = true;
    place_ours(p, field_keys(how));
    if (p->device) place_theirs(p, field_keys(how));
  }
}

/* >>racing --------------------------------------------------------------------------------------------------------- */

/* The answers of those of a form, as if there were no others. */
static job answers_of(const job *j, form of, unsigned count) {
  job part = *j;
  memcpy(part.answer, j->answer + of * count, count * sizeof *part.answer);
  return part;
}

static void add_quotients(report *to, const stage g[FORMS], const setting *how, const pair *p, const char *what) {
  row like;
  memset(&like, 0, sizeof like);
  like.setting = how->name, like.isa = pktrt_isa_string(p->isa);
  for (int c = 0; c < 2; c++) {
    double median[FORMS], best[FORMS];
    for (int f = 0; f < FORMS; f++) {
      snprintf(like.scene, sizeof like.scene, "%s", form_names[f]);
      const row *r = find_row(to, &like, what, "ratio", call_names[c]);
      if (!r) return;
      median[f] = r->median, best[f] = r->best;
    }
    ratio_row(to, &g[AS_INSTANCES], how, p, what, quotient_names[c], median[AS_INSTANCES] / median[AS_MESHES],
        best[AS_INSTANCES] / best[AS_MESHES]);
  }
}

/* All kinds of rays. Returns for how many pktrt contradicts itself. */
static size_t race_field(report *to, const options *o, const setting *how, const stage g[FORMS], const pair *both,
    unsigned count, sources *s, job *j) {
  static figures f;
  size_t wrong = 0;
  make_sources(g, both->ours, field_across(o, how), how->share > 0, s);
  for (int i = 0; i < KINDS; i++) {
    const kind k = (kind)i;
    if (!(o->kinds & BIT(k))) continue;
    make_kind(g, both->ours, k, s, &j->r);
    j->occlusion = kind_occlusion(k);
    if (j->r.count == 0) continue;
    measure(both, FORMS * count, j, o, f);
    for (unsigned a = 0; a < FORMS; a++) {
      const job part = answers_of(j, (form)a, count);
      compare_hits(g, both + a * count, count, &part, f + a * count);
      wrong += contradictions(count, &part);
      printf(" %s\n", form_names[a]);
      for (unsigned p = 0; p < count; p++)
        add_figures(to, &g[a], how, both + a * count, p, count, k, j->r.count, f + a * count);
    }
    for (unsigned p = 0; p < count; p++) add_quotients(to, g, how, &both[p], kind_names[k]);
  }
  return wrong;
}

/* Geometric means over the kinds of rays. */
static void add_quotient_means(report *to, const setting *how, const pair *p) {
  const char *isa = pktrt_isa_string(p->isa);
  for (int c = 0; c < 2; c++) {
    double logs = 0, n = 0;
    for (size_t i = 0; i < to->count; i++) {
      const row *r = &to->rows[i];
      if (strcmp(r->setting, how->name) || strcmp(r->isa, isa) || strcmp(r->mode, quotient_names[c])) continue;
      logs += log(r->median), n++;
    }
    if (n == 0) continue;
    row *mean = add_row(to, NULL, how->name, isa, "all", "ratio", quotient_names[c], "");
    mean->of = GENERATED, mean->median = mean->best = exp(logs / n), mean->required = QUOTIENT;
  }
}

static size_t run_field(report *to, const options *o, const pair *pairs, unsigned count) {
  static pair both[MAX_PAIRS];
  size_t wrong = 0, most = (size_t)field_across(o, &field_settings[0]) * field_across(o, &field_settings[0]);
  sources s;
  job j;
  if (FORMS * count > MAX_PAIRS) fatal("too many instruction sets");
  field_make_sphere(&field_ball);
  sources_room(&s, most), job_room(&j, most, FORMS * count);
  for (int i = 0; i < FIELD_SETTINGS; i++) {
    const setting *how = &field_settings[i];
    stage g[FORMS];
    if (o->settings && !(o->settings & BIT(i))) continue;
    printf("\n%d spheres of %d triangles as meshes and as instances, %s\n", FIELD_COUNT, FIELD_TRIANGLES, how->name);
    open_field(how, g);
    memcpy(both, pairs, count * sizeof *pairs);
    build_field(both, count, g, how);
    wrong += race_field(to, o, how, g, both, count, &s, &j);
    for (unsigned p = 0; p < count; p++) add_quotient_means(to, how, &pairs[p]);
    close_scenes(both, FORMS * count);
    close_stage(g);
  }
  sources_free(&s), job_free(&j);
  return wrong;
}

/* >>tables --------------------------------------------------------------------------------------------------------- */

/* The speed of Embree's calls that pktrt is compared with. */
static double their_speed(const report *in, const row *like, const char *what, int c) {
  const row *r = find_row(in, like, what, "ratio", call_names[c]);
  return r ? our_speed(in, like, what, call_names[c]) / r->median : 0;
}

static void say_quotient(const report *to, const row *instances, const row *meshes, const char *what, int c) {
  const row *r = find_row(to, instances, what, "ratio", quotient_names[c]);
  if (!r) {
    say(&to->out, " |");
    return;
  }
  say(&to->out, " **%.2f** (%.2f / %.2f) |", r->median,
      our_speed(to, instances, what, call_names[c]) / our_speed(to, meshes, what, call_names[c]),
      their_speed(to, instances, what, c) / their_speed(to, meshes, what, c));
}

static void say_quotients(const report *to, const pair *pairs, unsigned count) {
  say(&to->out,
      "Ratio on instances over that on meshes (speed of pktrt's instances over its meshes / the same of "
      "Embree). Required of means: %.2f.\n\n| | kernels | calls |",
      QUOTIENT);
  for (int k = 0; k < KINDS; k++) say(&to->out, " %s |", kind_names[k]);
  say(&to->out, " mean | |\n|---|---|---|");
  for (int k = 0; k < KINDS; k++) say(&to->out, "--:|");
  say(&to->out, "--:|---|\n");
  for (unsigned i = 0; i < FIELD_SETTINGS * count * 2; i++) {
    const int c = i % 2;
    row like[FORMS], all;
    memset(like, 0, sizeof like);
    for (int f = 0; f < FORMS; f++) {
      snprintf(like[f].scene, sizeof like[f].scene, "%s", form_names[f]);
      like[f].setting = field_settings[i / 2 / count].name, like[f].isa = pktrt_isa_string(pairs[i / 2 % count].isa);
    }
    all = like[AS_INSTANCES];
    snprintf(all.scene, sizeof all.scene, "mean");
    const row *mean = find_row(to, &all, "all", "ratio", quotient_names[c]);
    if (!mean) continue;
    say(&to->out, "| %s | %s | %s |", all.setting, all.isa, call_names[c]);
    for (int k = 0; k < KINDS; k++) say_quotient(to, &like[AS_INSTANCES], &like[AS_MESHES], kind_names[k], c);
    say(&to->out, " **%.2f** | %s |\n", mean->median, outcome_names[mean->median < QUOTIENT ? MISSED : REACHED]);
  }
  say(&to->out, "\n");
}

static void print_field(report *to, const options *o, const pair *pairs, unsigned count) {
  const unsigned rest = field_across(o, &field_settings[0]), moving = field_across(o, &field_settings[1]);
  results_open(&to->out, o->results, "peers_instances");
  printf("\n");
  say(&to->out,
      "%d spheres of %d triangles as instances of one model and as meshes. Embree %s, one core, %u x %u primary rays "
      "(%u x %u where things move), medians of %u rounds.\n\n",
      FIELD_COUNT, FIELD_TRIANGLES, RTC_VERSION_STRING, rest, rest, moving, moving, o->rounds);
  say_quotients(to, pairs, count);
  say_speeds(to, "many", "Many rays: Mrays/s of pktrt's faster call, and the ratio to Embree's fastest mode:");
  say_speeds(to, "single", "Single calls: Mrays/s of pktrt, and the ratio to Embree's:");
  say_hits_head(to);
  for (int f = 0; f < FORMS; f++)
    for (int moves = 0; moves < 2; moves++) say_hits_line(to, form_names[f], moves != 0, "hits");
  say(&to->out, "\n");
  write_csv(to);
  results_close(&to->out);
}

#endif /* PEERS_INSTANCES_H */
