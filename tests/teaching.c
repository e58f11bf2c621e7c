/* What is there to look at: steps of the paper path that can be left out, trees, events, packets and cost of renders, and
   a sampler of one's own. */
#include "pictures.h"

enum { RAYS = 3000, EDGE = 24, STEPS = 6 };

static world moving_or_not(bool moving) { return moving ? world_moving(2) : world_static(2); }

/* --- steps --- */

static void add_event(void *user, const pktrt_event *e) {
  uint64_t *n = user;
  n[0]++, n[1] += e->tested;
  n[2] += e->kind == PKTRT_EVENT_TRIM, n[3] += e->kind == PKTRT_EVENT_LEAF_TEST,
      n[4] += e->kind == PKTRT_EVENT_FRUSTUM_CULL;
  n[5] += e->kind == PKTRT_EVENT_INTERVAL_CULL;
  if (e->kind == PKTRT_EVENT_LEAF_TEST) n[6] += e->active;
}

static pktrt_counts by_steps(const pktrt_scene *s, uint32_t steps, uint32_t size, const pktrt_ray *ray, pktrt_hit *hit,
    bool *occluded, uint64_t told[7]) {
  static pktrt_stats stats;
  pktrt_query_desc q;
  memset(&q, 0, sizeof q), memset(&stats, 0, sizeof stats), memset(told, 0, 7 * sizeof *told);
  q.path = PKTRT_PATH_PAPER, q.packet_size = size, q.paper_steps = steps, q.stats = &stats;
  q.trace = add_event, q.user = told;
  if (hit) pktrt_intersect_ex(s, &q, ray, hit, RAYS);
  else pktrt_occluded_ex(s, &q, ray, occluded, RAYS);
  return stats.by_type[0];
}

static void steps_change_no_answer(void) {
  static pktrt_ray ray[RAYS];
  static pktrt_hit hit[RAYS], want[RAYS];
  static bool dark[RAYS], dark_too[RAYS];
  uint64_t asked = 0, told[7];
  for (int moving = 0; moving < 2; moving++) {
    world w = moving_or_not(moving);
    pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 1);
    for (int kind = RAYS_CAMERA; kind <= RAYS_SPAWNED; kind++) {
      make_rays(&w, s, (ray_kind)kind, 5, 0, ray, RAYS);
      pktrt_intersect_n(s, ray, want, RAYS), pktrt_occluded_n(s, ray, dark, RAYS);
      for (uint32_t i = 0; i < 3 + 2 * STEPS; i++) {
        if (small_run && (i + (uint32_t)kind) % 3) continue;
        const uint32_t one = 1u << i % STEPS, mask = i < STEPS       ? one
                                                     : i < 2 * STEPS ? 63 & ~one
                                                     : i % STEPS > 1 ? 0
                                                     : i % STEPS     ? PKTRT_PAPER_STEPS_2007
                                                                     : PKTRT_PAPER_STEP_NONE;
        const uint32_t size = (uint32_t[]){64, 16, 256, 1, 37}[i % 5];
        pktrt_counts c = by_steps(s, mask, size, ray, hit, NULL, told);
        CHECK(memcmp(hit, want, sizeof hit) == 0, "steps %x", mask);
        CHECK(told[1] == c.box_tests, "events tell of every box that was tested: %llu of %llu",
            (unsigned long long)told[1], (unsigned long long)c.box_tests);
        const uint32_t all = mask ? mask : 63;
        CHECK(all & PKTRT_PAPER_STEP_TRIM || told[2] == 0), CHECK(all & PKTRT_PAPER_STEP_FRUSTUM || told[4] == 0);
        CHECK(all & PKTRT_PAPER_STEP_INTERVALS || told[5] == 0);
        by_steps(s, mask, size, ray, NULL, dark_too, told);
        CHECK(memcmp(dark, dark_too, sizeof dark) == 0, "steps %x", mask);
        asked += 2 * RAYS;
      }
    }
    pktrt_scene_destroy(s);
    world_free(&w);
  }
  say("%llu rays asked with some of the steps", (unsigned long long)asked);
}

/* Each step does what it says it does: without it there is more of something, or less. */
static void each_step_counts(void) {
  static pktrt_ray ray[RAYS];
  static pktrt_hit hit[RAYS];
  world w = world_static(4);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 1);
  uint64_t told[7];
  for (uint32_t i = 0; i < RAYS; i++) { /* of a pinhole, packets of 8 x 8 */
    const uint32_t x = i / 64 % 8 * 8 + i % 8, y = i / 512 * 8 + i / 8 % 8;
    const float eye[3] = {0.3f, 1.5f, 4}, to[3] = {((float)x - 31.3f) / 40, ((float)y - 22.4f) / 40 - 0.3f, -1};
    ray[i] = pktrt_make_ray(eye, to);
  }
  const pktrt_counts all = by_steps(s, 0, 64, ray, hit, NULL, told);
  const pktrt_counts same = by_steps(s, 63, 64, ray, hit, NULL, told);
  CHECK(!memcmp(&all, &same, sizeof all) && told[2] > 0 && told[3] > 0 && told[4] > 0 && told[5] > 0);
  pktrt_counts less[STEPS];
  for (int i = 0; i < STEPS; i++) less[i] = by_steps(s, 63u & ~(1u << i), 64, ray, hit, NULL, told);
  CHECK(less[0].vector_box_tests > all.vector_box_tests, "groups of the first active ray");
  CHECK(less[1].box_tests > all.box_tests && less[1].interval_culls == 0, "interval arithmetic");
  CHECK(less[2].box_tests > all.box_tests && less[2].frustum_culls == 0, "frustum");
  CHECK(less[3].box_tests != all.box_tests, "trimming");
  CHECK(less[4].triangle_tests > all.triangle_tests, "boxes of leaves");
  CHECK(less[5].triangle_tests > all.triangle_tests && less[5].node_visits > all.node_visits, "order of children");
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* --- trees --- */

static bool box_may_be_hit(const pktrt_node *n, int k, const pktrt_ray *r, double far_) {
  double in = r->tmin, out = far_;
  for (int a = 0; a < 3; a++) {
    const double lo = (double)n->lo[k][a] - (double)r->origin[a], hi = (double)n->hi[k][a] - (double)r->origin[a];
    const double d = r->direction[a], slack = 1e-6 * (fabs(lo) + fabs(hi) + fabs((double)r->origin[a]));
    if (d == 0) {
      if (lo - slack > 0 || hi + slack < 0) return false;
      continue;
    }
    in = fmax(in, fmin((lo - slack) / d, (hi + slack) / d)), out = fmin(out, fmax((lo - slack) / d, (hi + slack) / d));
  }
  return in <= out * (1 + 1e-6);
}

/* The nearest hit by walking the trees that the library shows; triangles are tested by the reference. shrink: of boxes, the
   control. */
static bool walk(const world *w, const pktrt_scene *s, const pktrt_ray *ray, double shrink, pktrt_hit *hit) {
  pktrt_tree t;
  bool any = false;
  memset(hit, 0, sizeof *hit);
  hit->t = ray->tmax;
  for (uint32_t tree = 0; pktrt_get_tree(s, tree, &t); tree++) {
    uint32_t stack[512], sp = 0;
    stack[sp++] = 0;
    while (sp) {
      pktrt_node n;
      if (!CHECK(pktrt_get_node(s, tree, stack[--sp], ray->time, &n))) break;
      for (int k = 0; k < 8; k++) {
        if (n.child[k] == PKTRT_NONE) continue;
        for (int a = 0; a < 3; a++) n.lo[k][a] += (float)shrink, n.hi[k][a] -= (float)shrink;
        if (!box_may_be_hit(&n, k, ray, hit->t)) continue;
        if (!n.leaf[k]) stack[sp++] = n.child[k];
        for (int i = 0; n.leaf[k] && i < 8; i++) {
          float corner[9];
          uint32_t index[3] = {0, 1, 2};
          pktrt_hit one_hit;
          world one = world_none();
          if (n.mesh[k][i] == PKTRT_NONE) continue;
          const mesh *m = &w->m[n.mesh[k][i]];
          for (uint32_t c = 0; c < 3; c++) ref_vertex(m, m->i[3 * n.triangle[k][i] + c], ray->time, corner + 3 * c);
          one.m[0].p = corner, one.m[0].i = index, one.m[0].nv = 3, one.m[0].nt = one.m[0].keys = 1, one.n = 1;
          if (!ref_intersect(&one, ray, &one_hit)) continue;
          one_hit.mesh = n.mesh[k][i], one_hit.triangle = n.triangle[k][i];
          const bool first =
              !any || one_hit.t < hit->t ||
              (one_hit.t == hit->t &&
                  (one_hit.mesh < hit->mesh || (one_hit.mesh == hit->mesh && one_hit.triangle < hit->triangle)));
          if (first) *hit = one_hit, any = true;
        }
      }
    }
  }
  return any;
}

static void walks_find_hits(void) {
  static pktrt_ray ray[RAYS];
  uint64_t hits = 0, lost = 0, wrong = 0;
  for (int moving = 0; moving < 2; moving++) {
    world w = moving_or_not(moving);
    pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 1);
    for (int kind = RAYS_CAMERA; kind <= RAYS_SPAWNED; kind++) {
      make_rays(&w, s, (ray_kind)kind, 6, 0, ray, RAYS);
      for (uint32_t i = 0; i < RAYS; i += 10) {
        pktrt_hit want, got;
        const bool hit = pktrt_intersect(s, &ray[i], &want);
        if (!ref_valid(&ray[i])) continue;
        const bool found = walk(&w, s, &ray[i], 0, &got);
        wrong += found != hit || (hit && (got.t != want.t || got.mesh != want.mesh || got.triangle != want.triangle));
        hits += hit;
        lost += hit && (!walk(&w, s, &ray[i], 0.02, &got) || got.t != want.t);
      }
    }
    pktrt_scene_destroy(s);
    world_free(&w);
  }
  CHECK(wrong == 0, "%llu of %llu", (unsigned long long)wrong, (unsigned long long)hits);
  CHECK(hits > 500 && lost > 20, "%llu hits, %llu lost with boxes too small", (unsigned long long)hits,
      (unsigned long long)lost);
}

/* Every triangle lies in one lane, in the boxes above it, and what there is not is told. */
static void trees_are_whole(void) {
  world w = world_moving(2);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 1);
  pktrt_tree t;
  pktrt_node n;
  uint64_t triangles = 0, of = 0;
  uint32_t trees = 0;
  for (; pktrt_get_tree(s, trees, &t); trees++) {
    uint32_t nodes = 1, leaves = 0;
    CHECK(t.model == PKTRT_NONE && t.keys >= 1 && t.mask != 0);
    for (uint32_t i = 0; i < t.nodes; i++) {
      if (!CHECK(pktrt_get_node(s, trees, i, 0.3f, &n))) break;
      for (int k = 0; k < 8; k++) {
        uint32_t seen = 0;
        for (int j = 0; j < 8; j++) seen |= 1u << n.order[k][j];
        CHECK(seen == 255, "an order names each place once");
        nodes += n.child[k] != PKTRT_NONE && !n.leaf[k], leaves += n.leaf[k];
        for (int j = 0; j < 8; j++) {
          if (n.mesh[k][j] == PKTRT_NONE) continue;
          const mesh *m = &w.m[n.mesh[k][j]];
          CHECK(n.leaf[k] && m->keys == t.keys), triangles++;
          for (uint32_t c = 0; c < 3; c++) {
            float v[3];
            ref_vertex(m, m->i[3 * n.triangle[k][j] + c], 0.3f, v);
            for (int a = 0; a < 3; a++)
              CHECK(v[a] >= n.lo[k][a] && v[a] <= n.hi[k][a] && v[a] >= t.lo[a] && v[a] <= t.hi[a]);
          }
        }
      }
    }
    CHECK(nodes == t.nodes && leaves == t.leaves);
    CHECK(!pktrt_get_node(s, trees, t.nodes, 0, &n) && n.child[0] == 0 && !pktrt_get_node(s, trees, PKTRT_NONE, 0, &n));
  }
  for (uint32_t i = 0; i < w.n; i++) of += w.m[i].nt;
  CHECK(triangles > of * 9 / 10 && triangles <= of && trees == 4, "%llu of %llu triangles in %u trees",
      (unsigned long long)triangles, (unsigned long long)of, trees);
  CHECK(!pktrt_get_node(s, trees, 0, 0, &n) && !pktrt_get_tree(s, PKTRT_NONE, &t) && t.nodes == 0);
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* Asks for so many rays of a camera on the paper path, whose events go to `note`. */
static void trace_rays(const world *w, const pktrt_scene *s, uint32_t packet_size, size_t n,
    void (*note)(void *, const pktrt_event *), void *user) {
  static pktrt_ray ray[RAYS];
  static pktrt_hit hit[RAYS];
  pktrt_query_desc q;
  memset(&q, 0, sizeof q);
  q.path = PKTRT_PATH_PAPER, q.packet_size = packet_size, q.trace = note, q.user = user;
  CHECK(n <= RAYS);
  make_rays(w, s, RAYS_CAMERA, 5, 0, ray, n);
  pktrt_intersect_ex(s, &q, ray, hit, n);
}

/* A model's tree comes after those of the scene, and events in its instances name it. */
static void note_tree(void *user, const pktrt_event *e) {
  uint64_t *n = user;
  if (e->tree < 3) n[e->tree]++;
  n[3] += e->tree >= 3 || (e->packet == PKTRT_NONE) != (e->tree == 2);
}
static void models_are_shown(void) {
  world w = world_static(2);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 1);
  mesh ball = mesh_sphere(2, 0, 1);
  pktrt_instance_desc in;
  pktrt_tree t;
  pktrt_node n;
  uint32_t model = 7, triangles = 0;
  memset(&in, 0, sizeof in);
  const pktrt_mesh_desc d = mesh_desc(&ball);
  for (int i = 0; i < 2; i++) CHECK(pktrt_add_model(s, &d, 1, &model) == PKTRT_OK);
  in.model = model;
  CHECK(pktrt_add_instance(s, &in, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
  CHECK(pktrt_get_tree(s, 0, &t) && t.model == PKTRT_NONE && pktrt_get_tree(s, 1, &t) && t.model == 0);
  CHECK(pktrt_get_tree(s, 2, &t) && t.model == 1 && !pktrt_get_tree(s, 3, &t));
  pktrt_get_tree(s, 2, &t);
  for (uint32_t i = 0; i < t.nodes; i++) {
    CHECK(pktrt_get_node(s, 2, i, 0, &n));
    for (int k = 0; k < 64; k++) {
      triangles += n.mesh[k / 8][k % 8] != PKTRT_NONE;
      CHECK(n.mesh[k / 8][k % 8] == PKTRT_NONE || (n.mesh[k / 8][k % 8] == 0 && n.triangle[k / 8][k % 8] < ball.nt));
    }
  }
  CHECK(triangles == ball.nt, "%u of %u triangles", triangles, ball.nt);
  uint64_t told[4] = {0};
  trace_rays(&w, s, 0, RAYS, note_tree, told);
  CHECK(told[0] > 100 && told[1] == 0 && told[2] > 100 && told[3] == 0, "%llu, %llu, %llu events",
      (unsigned long long)told[0], (unsigned long long)told[1], (unsigned long long)told[2]);
  pktrt_scene_destroy(s);
  mesh_free(&ball), world_free(&w);
}

/* --- renders --- */

/* A mirror and a floor under a lamp. */
static pktrt_scene *mirror_and_floor(void) {
  pktrt_scene *s = stage_open();
  pktrt_material m[2] = {material_of(0.7, PKTRT_SPECULAR_NONE, 0), material_of(0.2, PKTRT_SPECULAR_MIRROR, 0.6)};
  quad floor = quad_of(vec_of(0, -1, 0), vec_of(0, 0, 4), vec_of(4, 0, 0));
  quad mirror = quad_of(vec_of(0, 0, -2), vec_of(2, 0, 0.3), vec_of(0, 1.5, 0));
  stage_quad(s, &floor, stage_material(s, &m[0])), stage_quad(s, &mirror, stage_material(s, &m[1]));
  pktrt_light l = light_of(PKTRT_LIGHT_POINT, 30);
  l.position[1] = 4, l.position[2] = 2;
  stage_light(s, &l);
  stage_commit(s);
  return s;
}

typedef struct seen {
  uint64_t events, packets, rays, in_area, told, off;
  bool last_in_area, counts_area;
  uint32_t samples[EDGE][EDGE];
  uint64_t heading[3]; /* shadow rays for each of the watched lights, and for neither */
  const pktrt_camera *camera;
} seen;
static void see_event(void *user, const pktrt_event *e) {
  seen *l = user;
  l->events++, l->told += e->tested, l->off += e->packet != 0 || (l->counts_area && !l->last_in_area);
}
/* Tells whether ray i of a packet of the camera goes through its pixel. */
static bool goes_through_pixel(const pktrt_camera *camera, const pktrt_packet *p, uint32_t i) {
  const double x = p->x[i] + 0.5, y = p->y[i] + 0.5;
  const vec to = vec_unit(vec_of((double)p->direction[0][i], (double)p->direction[1][i], (double)p->direction[2][i]));
  const vec middle = stage_through(camera, x, y, EDGE, EDGE),
            corner = stage_through(camera, x + 0.6, y + 0.6, EDGE, EDGE);
  return vec_length(vec_sub(to, middle)) < vec_length(vec_sub(corner, middle));
}
/* Tells which of two lights ray i of a packet heads for: that of mirror_and_floor(), or another; 2: neither. */
static const vec watched_lights[2] = {{0, 4, 2}, {-1, 3, 1}};
static int heads_for(const pktrt_packet *p, uint32_t i) {
  const vec from = vec_of((double)p->origin[0][i], (double)p->origin[1][i], (double)p->origin[2][i]);
  const vec way = vec_of((double)p->direction[0][i], (double)p->direction[1][i], (double)p->direction[2][i]);
  int light = 0;
  while (light < 2 && !(vec_length(vec_sub(vec_unit(way), vec_unit(vec_sub(watched_lights[light], from)))) < 1e-4))
    light++;
  return light;
}
static void see_packet(void *user, const pktrt_packet *p) {
  seen *l = user;
  l->packets++, l->rays += p->n, l->last_in_area = false;
  for (uint32_t i = 0; i < p->n; i++) {
    if (p->x[i] >= EDGE || p->y[i] >= EDGE || p->sample[i] >= 2) {
      l->off++;
      continue;
    }
    if (p->type == PKTRT_RAY_PRIMARY) l->samples[p->y[i]][p->x[i]] |= 1u << p->sample[i];
    if (p->x[i] >= 3 && p->x[i] < 8 && p->y[i] >= 9 && p->y[i] < 11) l->last_in_area = true;
    const double d2 =
        pow((double)p->direction[0][i], 2) + pow((double)p->direction[1][i], 2) + pow((double)p->direction[2][i], 2);
    l->off += !(d2 > 0) || (p->type == PKTRT_RAY_PRIMARY && fabs((double)p->origin[2][i] - 5) > 1e-6);
    if (p->type == PKTRT_RAY_SHADOW) l->heading[heads_for(p, i)]++;
    if (p->type != PKTRT_RAY_PRIMARY) continue;
    l->off += p->rays[i] >= p->n; /* numbers in their own packet */
    l->off += !goes_through_pixel(l->camera, p, i);
  }
  l->in_area += l->last_in_area;
}

static void renders_can_be_watched(void) {
  pktrt_scene *s = mirror_and_floor();
  pktrt_light another = light_of(PKTRT_LIGHT_POINT, 10);
  vec_put(watched_lights[1], another.position);
  stage_light(s, &another);
  float *want = stage_pixels(EDGE * EDGE * 3), *got = stage_pixels(EDGE * EDGE * 3);
  pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, EDGE, EDGE, want, vec_of(0, 0.5, 5), vec_of(0, 0, 0));
  d.samples = 2;
  stage_render(s, &d);
  for (int path = 0; path < 3; path++)
    for (int assembly = 0; assembly <= PKTRT_ASSEMBLY_NONE; assembly++)
      for (int area = 0; area < 2; area++) {
        static seen l;
        static pktrt_stats stats;
        float cost[3][EDGE * EDGE];
        uint64_t sum[3] = {0};
        memset(&l, 0, sizeof l);
        d.pixels = got, d.path = (pktrt_path)path, d.assembly = (pktrt_assembly)assembly, d.packet_size = 4;
        d.packet = see_packet, d.trace = see_event, d.user = &l, l.counts_area = area, l.camera = &d.camera;
        for (int i = 0; i < 4; i++) d.trace_area[i] = area ? (uint32_t[]){3, 9, 5, 2}[i] : 0;
        d.stats = &stats;
        for (int of = 0; of < 3; of++) {
          memset(&stats, 0, sizeof stats);
          d.cost = cost[of], d.cost_of = (pktrt_cost)of;
          stage_render(s, &d);
          CHECK(memcmp(got, want, EDGE * EDGE * 3 * sizeof *got) == 0, "path %d, assembly %d", path, assembly);
          for (int i = 0; i < PKTRT_RAY_TYPE_COUNT; i++) {
            const pktrt_counts *c = &stats.by_type[i];
            sum[of] += of == 0   ? c->box_tests
                       : of == 1 ? c->triangle_tests
                                 : c->vector_box_tests + c->vector_triangle_tests;
          }
          double all = 0;
          for (int i = 0; i < EDGE * EDGE; i++) all += 2 * (double)cost[of][i];
          CHECK(fabs(all - (double)sum[of]) <= 1e-5 * (double)sum[of], "cost %d: %g of %llu", of, all,
              (unsigned long long)sum[of]);
        }
        const bool apart = assembly != PKTRT_ASSEMBLY_BLIND; /* which tells shadow rays among the others */
        CHECK((l.heading[0] > EDGE) == apart && l.heading[0] == l.heading[1] && l.heading[2] == 0,
            "%llu, %llu and %llu", (unsigned long long)l.heading[0], (unsigned long long)l.heading[1],
            (unsigned long long)l.heading[2]);
        CHECK(l.off == 0 && l.rays > 3 * 2 * EDGE * EDGE, "%llu faults", (unsigned long long)l.off);
        for (int i = 0; i < EDGE * EDGE; i++) CHECK(l.samples[i / EDGE][i % EDGE] == 3, "every sample is told");
        if (path != PKTRT_PATH_PAPER) CHECK(l.events == 0);
        else if (area) CHECK(l.events > 0 && l.told < 3 * sum[0] / 2 && l.in_area < l.packets);
        else CHECK(l.told > 0 && (assembly == PKTRT_ASSEMBLY_NONE || l.told == 3 * sum[0]));
      }
  free(want), free(got);
  pktrt_scene_destroy(s);
}

/* The packets that were told last, one of each depth, and what is wrong with the parents of those that followed. */
typedef struct family {
  bool by_types; /* what reflection and refraction rays met is shaded together */
  pktrt_ray_type last_type;
  uint32_t last_depth, n[16], x[16][256], y[16][256], sample[16][256];
  uint64_t children[PKTRT_RAY_TYPE_COUNT], beyond, strangers, later, by_first;
} family;
static void see_family(void *user, const pktrt_packet *p) {
  family *f = user;
  if (!CHECK(p->depth < 16 && p->n <= 256)) return;
  for (uint32_t i = 0; i < p->n && p->depth; i++) {
    const uint32_t above = p->depth - 1, k = p->rays[i];
    f->children[p->type]++;
    if (k >= f->n[above]) {
      f->beyond++;
      continue;
    }
    f->strangers += f->x[above][k] != p->x[i] || f->y[above][k] != p->y[i] || f->sample[above][k] != p->sample[i];
    f->by_first += f->x[above][0] != p->x[i] || f->y[above][0] != p->y[i] || f->sample[above][0] != p->sample[i];
    f->later += k > 0;
  }
  const bool joined = f->by_types && p->type == PKTRT_RAY_REFRACTION && f->last_type == PKTRT_RAY_REFLECTION &&
                      p->depth == f->last_depth;
  f->last_type = p->type;
  f->last_depth = p->depth;
  if (p->type == PKTRT_RAY_SHADOW) return;
  const uint32_t before = joined ? f->n[p->depth] : 0;
  if (!CHECK(before + p->n <= 256)) return;
  f->n[p->depth] = before + p->n;
  memcpy(f->x[p->depth] + before, p->x, p->n * sizeof *p->x);
  memcpy(f->y[p->depth] + before, p->y, p->n * sizeof *p->y);
  memcpy(f->sample[p->depth] + before, p->sample, p->n * sizeof *p->sample);
}

/* Rays of a packet name those that sent them out, in the packet that was told last of those one bounce less deep. */
static void packets_name_their_parents(void) {
  static family f;
  pktrt_scene *s = mirror_and_floor();
  pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  const uint32_t material = stage_material(s, &glass);
  for (int i = 0; i < 3; i++) {
    mesh ball = mesh_sphere(2, 0, 1);
    for (uint32_t k = 0; k < 3 * ball.nv; k++) ball.p[k] = 0.6f * ball.p[k] + (k % 3 == 0 ? 1.3f * (float)(i - 1) : 0);
    pktrt_mesh_desc d = mesh_desc(&ball);
    d.material = material;
    CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
    mesh_free(&ball);
  }
  stage_commit(s);
  float *pixels = stage_pixels(48 * 48 * 3);
  pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, 48, 48, pixels, vec_of(0, 0.5, 5), vec_of(0, 0, 0));
  d.packet = see_family, d.user = &f, d.max_depth = 6, d.samples = 2;
  for (int assembly = 0; assembly <= PKTRT_ASSEMBLY_OCTANTS; assembly++) {
    memset(&f, 0, sizeof f);
    f.by_types = assembly == PKTRT_ASSEMBLY_RAY_TYPES;
    d.assembly = (pktrt_assembly)assembly;
    stage_render(s, &d);
    uint64_t children = 0;
    for (int i = 0; i < PKTRT_RAY_TYPE_COUNT; i++) children += f.children[i];
    CHECK(f.beyond == 0 && f.strangers == 0, "assembly %d: of %llu rays %llu name none, %llu others'", assembly,
        (unsigned long long)children, (unsigned long long)f.beyond, (unsigned long long)f.strangers);
    CHECK(children > 10000 && f.later > children / 2 && f.by_first > children / 2, "%llu rays",
        (unsigned long long)children);
  }
  pktrt_scene_destroy(s);
  free(pixels);
}

/* --- samplers --- */

static uint64_t asked_for;
/* Asks the sampler of the library that `user` points to. */
static float as_in_the_library(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed) {
  const pktrt_sampling sampling = {*(const pktrt_sampler *)user, 4, seed};
  float u;
  asked_for++;
  pktrt_sample(&sampling, x, y, sample, dimension, 1, &u);
  return u;
}
static float outside(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed) {
  (void)user, (void)seed;
  return (x + y + sample + dimension) % 3 ? NAN : dimension % 2 ? 7.0f : -INFINITY;
}

/* Always the same number. */
static float constant(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed) {
  const float *number = user;
  (void)x, (void)y, (void)sample, (void)dimension, (void)seed;
  return *number;
}

/* Notes which seeds the passes of pictures with neighbouring seeds are told. */
enum { SEEDS = 12, SEED_PASSES = 16 };
static struct { uint32_t seed[SEEDS * SEED_PASSES + 1], n; } told_seeds;
static float note_seed(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed) {
  uint32_t i = 0;
  (void)user, (void)x, (void)y, (void)sample, (void)dimension;
  while (i < told_seeds.n && told_seeds.seed[i] != seed) i++;
  if (i == told_seeds.n && i < SEEDS * SEED_PASSES) told_seeds.seed[told_seeds.n++] = seed;
  return 0.5f;
}
static void each_pass_of_each_seed_is_another(void) {
  pktrt_scene *s = mirror_and_floor();
  float pixel[3];
  memset(&told_seeds, 0, sizeof told_seeds);
  for (uint32_t seed = 0; seed < SEEDS; seed++) {
    pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, 1, 1, pixel, vec_of(0, 0.5, 5), vec_of(0, 0, 0));
    d.passes = SEED_PASSES, d.seed = seed;
    d.sampler = PKTRT_SAMPLER_CUSTOM, d.custom_sampler = note_seed;
    stage_render(s, &d);
  }
  CHECK(told_seeds.n == SEEDS * SEED_PASSES, "%u seeds of %d", (unsigned)told_seeds.n, SEEDS * SEED_PASSES);
  pktrt_scene_destroy(s);
}

static void samplers_of_ones_own(void) {
  pktrt_scene *s = mirror_and_floor();
  for (int i = 0; i < 3; i++) { /* later ones have coordinates of later groups */
    quad lamp = quad_of(vec_of(2 * i - 2, 3, 0), vec_of(1, 0, 0), vec_of(0, 0, 1));
    pktrt_light l = quad_light(&lamp, 4);
    stage_light(s, &l);
  }
  float *want = stage_pixels(EDGE * EDGE * 3), *got = stage_pixels(EDGE * EDGE * 3);
  pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, EDGE, EDGE, want, vec_of(0, 0.5, 5), vec_of(0, 0, 0));
  d.samples = 4, d.passes = 3, d.camera.aperture = 0.1f, d.seed = 9;
  for (int i = 0; i < PKTRT_SAMPLER_COUNT; i++) {
    pktrt_sampler sampler = (pktrt_sampler)i;
    asked_for = 0;
    d.sampler = sampler, d.pixels = want;
    stage_render(s, &d);
    d.sampler = PKTRT_SAMPLER_CUSTOM, d.custom_sampler = as_in_the_library, d.user = &sampler, d.pixels = got;
    stage_render(s, &d);
    CHECK(memcmp(got, want, EDGE * EDGE * 3 * sizeof *got) == 0, "%s", pktrt_sampler_string(sampler));
    CHECK(asked_for > 4 * 3 * EDGE * EDGE * 4, "%llu numbers", (unsigned long long)asked_for);
  }
  d.custom_sampler = outside;
  stage_render(s, &d);
  CHECK(memcmp(got, want, EDGE * EDGE * 3 * sizeof *got) != 0, "another sampler, other bits");
  for (int i = 0; i < EDGE * EDGE * 3; i++) CHECK(isfinite(got[i]));
  static const float numbers[4] = {1 - 0x1p-24f, 1, 7, INFINITY}; /* the last three are moved to the first */
  d.custom_sampler = constant, d.camera.aperture = 0;
  for (int i = 0; i < 4; i++) {
    float number = numbers[i];
    d.user = &number, d.pixels = i ? got : want;
    stage_render(s, &d);
    CHECK(!i || memcmp(got, want, EDGE * EDGE * 3 * sizeof *got) == 0, "%g is as the last number below 1",
        (double)number);
  }
  d.custom_sampler = NULL;
  CHECK(pktrt_render(s, &d) == PKTRT_INVALID_ARGUMENT && strstr(pktrt_last_error(s), "custom_sampler is NULL"));
  CHECK(!strcmp(pktrt_sampler_string(PKTRT_SAMPLER_CUSTOM), "custom"));
  free(want), free(got);
  pktrt_scene_destroy(s);
}

/* The tree of a model is of no group, whichever the scene has; those of the scene name theirs. */
static void groups_of_trees(void) {
  mesh box = mesh_box();
  pktrt_scene *s = stage_open();
  pktrt_mesh_desc d = mesh_desc(&box);
  pktrt_instance_desc in;
  pktrt_tree t;
  memset(&in, 0, sizeof in);
  CHECK(pktrt_add_model(s, &d, 1, &in.model) == PKTRT_OK && pktrt_add_instance(s, &in, NULL) == PKTRT_OK);
  for (d.group = 5; d.group < 7; d.group++) CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK);
  stage_commit(s);
  uint32_t groups = 0;
  for (uint32_t i = 0; i < 2; i++) groups += pktrt_get_tree(s, i, &t) && t.model == PKTRT_NONE ? t.group : 0;
  CHECK(groups == 5 + 6, "the trees of the scene are of groups 5 and 6: %u in all", (unsigned)groups);
  CHECK(pktrt_get_tree(s, 2, &t) && t.model == 0 && t.group == 0, "the model's is of group %u", (unsigned)t.group);
  pktrt_scene_destroy(s);
  mesh_free(&box);
}

/* Packets of a call are numbered on, however many rays it asks for. */
enum { NUMBERED = 64 };
static void note_packet(void *user, const pktrt_event *e) {
  uint32_t *events = user;
  events[e->packet < NUMBERED ? e->packet : NUMBERED]++;
}
static void packets_are_numbered_on(void) {
  enum { EACH = 16, N = NUMBERED * EACH };
  uint32_t events[NUMBERED + 1] = {0};
  world w = world_static(2);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 1);
  trace_rays(&w, s, EACH, N, note_packet, events);
  uint32_t told = 0;
  for (uint32_t i = 0; i < NUMBERED; i++) told += events[i] > 0;
  CHECK(told == NUMBERED && events[NUMBERED] == 0, "%u of %u numbers are told, %u events have others", (unsigned)told,
      (unsigned)NUMBERED, (unsigned)events[NUMBERED]);
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* The trees of models follow each other, however many a model has; meshes in them are those of the model. */
static void note_tree_of_last(void *user, const pktrt_event *e) {
  uint64_t *n = user;
  n[e->packet != PKTRT_NONE ? 0 : e->tree == 4 ? 1 : 2]++;
}
static void models_of_several_trees(void) {
  world w = world_static(2);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 1);
  mesh ball = mesh_sphere(1, 0, 1), moving = mesh_sphere(2, 0, 1), box = mesh_box();
  mesh_move(&moving, 2, 0.2f, 0.1f, 3);
  const pktrt_mesh_desc two[2] = {mesh_desc(&ball), mesh_desc(&moving)}, last = mesh_desc(&box);
  pktrt_instance_desc in;
  uint32_t model[3];
  memset(&in, 0, sizeof in);
  CHECK(pktrt_add_model(s, two, 2, &model[0]) == PKTRT_OK && pktrt_add_model(s, two, 1, &model[1]) == PKTRT_OK);
  CHECK(pktrt_add_model(s, &last, 1, &model[2]) == PKTRT_OK);
  in.model = model[2];
  CHECK(pktrt_add_instance(s, &in, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));

  static const uint32_t models[5] = {PKTRT_NONE, 0, 0, 1, 2};
  const uint32_t triangles[5] = {0, ball.nt, moving.nt, ball.nt, box.nt};
  pktrt_tree t;
  pktrt_node n;
  for (uint32_t i = 0; i < 5; i++) {
    uint32_t found = 0;
    CHECK(pktrt_get_tree(s, i, &t) && t.model == models[i], "tree %u is of model %u", (unsigned)i, (unsigned)t.model);
    for (uint32_t k = 0; i && k < t.nodes; k++) {
      CHECK(pktrt_get_node(s, i, k, 0, &n));
      for (int j = 0; j < 64; j++) {
        const uint32_t mesh_index = n.mesh[j / 8][j % 8];
        if (mesh_index == PKTRT_NONE) continue;
        CHECK(mesh_index == (t.keys == 2) && n.triangle[j / 8][j % 8] < triangles[i], "tree %u: mesh %u, triangle %u",
            (unsigned)i, (unsigned)mesh_index, (unsigned)n.triangle[j / 8][j % 8]);
        found++;
      }
    }
    CHECK(!i || found == triangles[i], "tree %u has %u triangles", (unsigned)i, (unsigned)found);
  }
  CHECK(!pktrt_get_tree(s, 5, &t));

  uint64_t told[3] = {0};
  trace_rays(&w, s, 0, RAYS, note_tree_of_last, told);
  CHECK(told[0] > 100 && told[1] > 100 && told[2] == 0, "%llu events in the instance, %llu in another tree",
      (unsigned long long)told[1], (unsigned long long)told[2]);
  pktrt_scene_destroy(s);
  mesh_free(&ball), mesh_free(&moving), mesh_free(&box), world_free(&w);
}

void suite_teaching(void) {
  run("the paper path answers the same with any of its steps left out, and its events tell of every box",
      steps_change_no_answer);
  run("each step of the paper path saves what it is there for", each_step_counts);
  run("a walk over the trees that the library shows finds its hits, and with boxes too small does not",
      walks_find_hits);
  run("the trees that are shown hold every triangle once, within the boxes above it", trees_are_whole);
  run("trees of models come after those of the scene, and events in instances name them", models_are_shown);
  run("trees name their groups, those of models none", groups_of_trees);
  run("packets of a call are numbered on, however many rays it asks for", packets_are_numbered_on);
  run("trees of models follow each other, however many a model has", models_of_several_trees);
  run("who watches packets, events and cost of a render sees every sample, and the picture stays the same",
      renders_can_be_watched);
  run("the rays of a packet that is told name the rays that sent them out", packets_name_their_parents);
  run("each pass of pictures with neighbouring seeds is told another seed", each_pass_of_each_seed_is_another);
  run("a sampler of one's own gives the picture that a built-in one of the same numbers gives", samplers_of_ones_own);
}
