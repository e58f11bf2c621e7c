/* The one file with the implementation: the tree's structure, refits, rebuilds, independence of workers. */
#define PKTRT_IMPLEMENTATION
#include "stability.h"
#include "tree.h"
#include "twins.h"

/* --- the checker of trees: NULL, or what is wrong. A tree must be up to date with the meshes: after a build or refit, before or
   after the pending positions became the committed ones --- */

/* Straight from the definition, beside the builder. */
static bool has_area(const float *const v[3]) {
  const double ax = (double)v[1][0] - (double)v[0][0], bx = (double)v[2][0] - (double)v[0][0];
  const double ay = (double)v[1][1] - (double)v[0][1], by = (double)v[2][1] - (double)v[0][1];
  const double az = (double)v[1][2] - (double)v[0][2], bz = (double)v[2][2] - (double)v[0][2];
  return (ay * bz - az * by != 0.0) | (az * bx - ax * bz != 0.0) | (ax * by - ay * bx != 0.0);
}

static const char *check_block(
    const pk_bvh *bvh, uint32_t block, const pk_mesh *meshes, uint32_t mesh_count, uint64_t *set, uint64_t *count) {
  const uint32_t *tri = bvh->block_triangles + (size_t)block * 8;
  pk_block *at = pk_bvh_block(bvh, block);
  if (tri[0] == PKTRT_NONE) return "A block has no triangle.";
  for (size_t l = 0; l < 8; l++) {
    bool area = false, none = tri[l] == PKTRT_NONE;
    for (size_t i = 0; i < l; i++)
      if (!none && (tri[i] ^ tri[l]) << 1 == 0) return "A block has a triangle twice.";
    if (!none && l && tri[l - 1] == PKTRT_NONE) return "A block has a triangle behind a free lane.";
    uint32_t t = tri[none ? 0 : l] & ~PK_DUPLICATE, owner = pk_mesh_of_triangle(meshes, mesh_count, t, 0);
    const pk_mesh *m = &meshes[owner];
    float half[3][3]; /* the corners half-way from the key before */
    const float *const between[3] = {half[0], half[1], half[2]}, *before[3] = {NULL, NULL, NULL};
    if (t - m->first_id >= m->triangle_count || m->key_count != bvh->key_count) return "A triangle is foreign.";
    for (uint32_t k = 0; k < bvh->key_count; k++) {
      const float *row = pk_block_vertices(at, k) + l;
      const float *v[3];
      pk_mesh_corners(m, true, t - m->first_id, k, v);
      for (size_t i = 0; i < 9; i++) {
        if (memcmp(&row[i * 8], &v[i / 3][i % 3], sizeof(float))) return "A vertex is not the owner's.";
        if (k) half[i / 3][i % 3] = 0.5f * before[i / 3][i % 3] + 0.5f * v[i / 3][i % 3];
      }
      area = area || has_area(v) || (k && has_area(between));
      for (int c = 0; c < 3; c++) before[c] = v[c];
    }
    if (at->id[l] != (area && !none ? t : PKTRT_NONE)) return "An id in a block is wrong.";
    if (!none && !(tri[l] & PK_DUPLICATE)) *set += pk_hash(t), *count += 1;
  }
  return NULL;
}

/* Whether triangles of a tree are split. Then boxes of leaves may be smaller than those of their triangles; see tree_uncovered. */
static bool is_split(const pk_bvh *bvh) {
  for (size_t i = 0; i < (size_t)bvh->block_count * 8; i++)
    if (bvh->block_triangles[i] != PKTRT_NONE && bvh->block_triangles[i] & PK_DUPLICATE) return true;
  return false;
}

/* Straight from the definition, beside the kernel. */
static const char *check_child(const pk_bvh *bvh, pk_node *node, int c, bool split) {
  uint32_t ref = node->child[c];
  for (uint32_t k = 0; k < bvh->key_count; k++) {
    for (int p = 0; p < 6; p++) {
      float want = p & 1 ? -PK_FAR : PK_FAR, got = pk_node_planes(node, k)[8 * p + c];
      for (int i = 0; i < 24 && ref != PK_EMPTY; i++) {
        float x;
        if (ref & PK_LEAF) {
          size_t block = ref & ~PK_LEAF;
          if (bvh->block_triangles[block * 8 + (size_t)i / 3] == PKTRT_NONE) continue;
          x = pk_block_vertices(pk_bvh_block(bvh, (uint32_t)block), k)[i % 3 * 24 + p / 2 * 8 + i / 3];
        } else {
          pk_node *below = pk_bvh_node(bvh, ref);
          if (below->child[i / 3] == PK_EMPTY) continue;
          x = pk_node_planes(below, k)[8 * p + i / 3];
        }
        if (p & 1 ? x > want : x < want) want = x;
      }
      if (got <= want && got >= want) continue;
      if (split && ref & PK_LEAF && (p & 1 ? got < want : got > want)) continue;
      return ref == PK_EMPTY ? "An empty child has bounds." : "Bounds are not exact.";
    }
  }
  return NULL;
}

static const char *check_orders(const pk_node *node) {
  for (int octant = 0; octant < 8; octant++) {
    uint32_t perm = node->order[octant], seen = 0;
    for (int i = 0; i < 8; i++) seen |= 1u << (perm >> 3 * i & 7);
    if (seen != 255 || perm >> 24) return "An order of children is no permutation.";
  }
  return NULL;
}

/* Each triangle, node and block once: by number and by the sums of mixed indices. */
static const char *check_tree(const pk_bvh *bvh, const pk_mesh *meshes, uint32_t mesh_count) {
  struct {
    uint32_t node, depth;
  } stack[PK_STACK];
  uint64_t nodes = 0, blocks = 0, tris = 0, nodes_set = 0, blocks_set = 0, tris_set = 0;
  uint32_t top = 0;
  const char *wrong = NULL;
  const bool split = is_split(bvh);
  stack[top].node = 0, stack[top++].depth = 0;
  while (top) {
    uint32_t n = stack[--top].node, depth = stack[top].depth, used = 0;
    pk_node *node = pk_bvh_node(bvh, n);
    nodes++, nodes_set += pk_hash(n);
    if (nodes > bvh->node_count) return "A node has two parents.";
    wrong = check_orders(node);
    for (int c = 0; c < 8 && !wrong; c++) {
      uint32_t ref = node->child[c];
      bool leaf = (ref & PK_LEAF) != 0;
      used += ref != PK_EMPTY;
      if (ref != PK_EMPTY) {
        if (depth + 1 > PK_MAX_DEPTH) return "The tree is too deep.";
        if (leaf && (ref & ~PK_LEAF) >= bvh->block_count) return "A child is no block.";
        if (!leaf && (ref <= n || ref >= bvh->node_count)) return "A child does not follow its parent.";
        if (!leaf) stack[top].node = ref, stack[top++].depth = depth + 1;
        if (leaf) wrong = check_block(bvh, ref & ~PK_LEAF, meshes, mesh_count, &tris_set, &tris);
        if (leaf) blocks++, blocks_set += pk_hash(ref & ~PK_LEAF);
      }
      if (!wrong) wrong = check_child(bvh, node, c, split);
    }
    if (wrong) return wrong;
    if (!used) return "A node has no child.";
  }
  for (uint32_t i = 0; i < bvh->node_count; i++) nodes--, nodes_set -= pk_hash(i);
  for (uint32_t i = 0; i < bvh->block_count; i++) blocks--, blocks_set -= pk_hash(i);
  for (uint32_t i = 0; i < mesh_count; i++) {
    for (uint32_t t = 0; meshes[i].key_count == bvh->key_count && t < meshes[i].triangle_count; t++) {
      tris--, tris_set -= pk_hash((uint64_t)meshes[i].first_id + t);
    }
  }
  if (nodes || nodes_set) return "Not every node is reached once.";
  if (blocks || blocks_set) return "Not every block is reached once.";
  return tris || tris_set ? "Not every triangle is there once." : NULL;
}

const char *tree_fault(const pktrt_scene *s) {
  const char *wrong = NULL;
  for (uint32_t g = 0; g < s->bvh_count && !wrong; g++) wrong = check_tree(&s->bvhs[g], s->meshes, s->mesh_count);
  return wrong;
}

/* --- of split triangles --- */

typedef struct leaf_box {
  uint32_t id;
  float lo[3], hi[3];
} leaf_box;
static int by_id(const void *a, const void *b) {
  const uint32_t x = ((const leaf_box *)a)->id, y = ((const leaf_box *)b)->id;
  return (x > y) - (x < y);
}

/* Whether the point where an edge crosses the plane at x_a = at lies in one of the boxes. Exact on grids of few bits. */
static bool crossing_is_covered(const float *p, const float *q, int a, float at, const leaf_box *box, size_t n) {
  const double all = (double)q[a] - (double)p[a], part = (double)at - (double)p[a], sign = all < 0 ? -1 : 1;
  for (size_t i = 0; i < n; i++) {
    bool within = box[i].lo[a] <= at && at <= box[i].hi[a];
    for (int b = 0; b < 3; b++) {
      const double way = ((double)q[b] - (double)p[b]) * part * sign, size = all * sign;
      if (b == a) continue;
      within = within && ((double)box[i].lo[b] - (double)p[b]) * size <= way;
      within = within && way <= ((double)box[i].hi[b] - (double)p[b]) * size;
    }
    if (within) return true;
  }
  return false;
}

static uint64_t triangle_uncovered(float v[3][3], const leaf_box *box, size_t n, uint64_t *points) {
  uint64_t lost = 0;
  for (size_t i = 0; i < 6 * n; i++) {
    const int a = (int)(i % 3);
    const float at = i % 6 < 3 ? box[i / 6].lo[a] : box[i / 6].hi[a];
    for (int c = 0, d = 2; c < 3; d = c++) {
      if (!((v[c][a] <= at && at < v[d][a]) || (v[d][a] <= at && at < v[c][a]))) continue;
      lost += !crossing_is_covered(v[c], v[d], a, at, box, n);
      *points += 1;
    }
  }
  return lost;
}

uint64_t tree_uncovered(const pktrt_scene *s, float shrink, uint64_t *points) {
  uint64_t lost = 0;
  for (uint32_t g = 0; g < s->bvh_count; g++) {
    const pk_bvh *x = &s->bvhs[g];
    leaf_box *box = calloc((size_t)x->block_count * 8, sizeof *box);
    size_t n = 0;
    if (!box) abort();
    for (uint32_t i = 0; i < x->node_count * 8; i++) {
      pk_node *node = pk_bvh_node(x, i / 8);
      const uint32_t ref = node->child[i % 8];
      for (uint32_t l = 0; l < 8 && ref != PK_EMPTY && ref & PK_LEAF; l++) {
        const uint32_t id = pk_bvh_block(x, ref & ~PK_LEAF)->id[l];
        if (id == PKTRT_NONE) continue;
        for (uint32_t a = 0; a < 3; a++) {
          box[n].lo[a] = node->plane[2 * a][i % 8], box[n].hi[a] = node->plane[2 * a + 1][i % 8];
          box[n].lo[a] += shrink * fabsf(box[n].lo[a]), box[n].hi[a] -= shrink * fabsf(box[n].hi[a]);
        }
        box[n++].id = id;
      }
    }
    qsort(box, n, sizeof *box, by_id);
    for (size_t i = 0, end; i < n; i = end) {
      const uint32_t m = pk_mesh_of_triangle(s->meshes, s->mesh_count, box[i].id, 0);
      float v[3][3];
      for (end = i + 1; end < n && box[end].id == box[i].id;) end++;
      pk_mesh_triangle(&s->meshes[m], false, box[i].id - s->meshes[m].first_id, 0, v);
      lost += triangle_uncovered(v, box + i, end - i, points);
    }
    free(box);
  }
  return lost;
}

uint64_t tree_split(const pktrt_scene *s) {
  uint64_t again = 0;
  for (uint32_t g = 0; g < s->bvh_count; g++)
    for (size_t i = 0; i < (size_t)s->bvhs[g].block_count * 8; i++)
      again += s->bvhs[g].block_triangles[i] != PKTRT_NONE && s->bvhs[g].block_triangles[i] & PK_DUPLICATE;
  for (uint32_t m = 0; m < s->model_count; m++) again += tree_split(s->models[m]);
  return again;
}

static bool sound(const pktrt_scene *s, const char *when) {
  const char *wrong = tree_fault(s);
  return CHECK(wrong == NULL, "%s: %s", when, wrong);
}

/* A box is lo x, hi x, lo y, hi y, lo z, hi z, as in nodes. */
static void box_grow(float box[6], const float lo_hi[6]) {
  for (int p = 0; p < 6; p++) box[p] = p & 1 ? fmaxf(box[p], lo_hi[p]) : fminf(box[p], lo_hi[p]);
}

static void box_grow_by_block(
    float box[6], const pktrt_scene *s, const pk_bvh *g, uint32_t block, const world *w, uint32_t key) {
  const uint32_t *id = g->block_triangles + (size_t)block * 8;
  for (uint32_t l = 0, m = 0; l < 8 && id[l] != PKTRT_NONE; l++) {
    const uint32_t which = id[l] & ~PK_DUPLICATE;
    while (which < s->meshes[m].first_id || which - s->meshes[m].first_id >= w->m[m].nt) m = (m + 1) % w->n;
    const mesh *from = &w->m[m];
    for (uint32_t c = 0; c < 3; c++) {
      const uint32_t vertex = from->i[3 * (which - s->meshes[m].first_id) + c];
      const float *p = from->p + 3 * ((size_t)key * from->nv + vertex);
      box_grow(box, (float[6]){p[0], p[0], p[1], p[1], p[2], p[2]});
    }
  }
}

static uint64_t group_bounds_off(const pktrt_scene *s, const pk_bvh *g, const world *w, uint64_t *compared) {
  static const float none[6] = {PK_FAR, -PK_FAR, PK_FAR, -PK_FAR, PK_FAR, -PK_FAR};
  uint64_t off = 0;
  float(*whole)[6] = calloc((size_t)g->node_count * g->key_count, sizeof *whole), all[6];
  if (!whole) abort();
  memcpy(all, none, sizeof all);
  for (uint32_t i = g->node_count * g->key_count; i-- > 0;) { /* children come after their parents */
    const uint32_t n = i / g->key_count, key = i % g->key_count;
    pk_node *node = pk_bvh_node(g, n);
    memcpy(whole[i], none, sizeof none);
    for (int c = 0; c < 8; c++) {
      const uint32_t ref = node->child[c];
      float want[6];
      memcpy(want, none, sizeof none);
      if (ref != PK_EMPTY && ref & PK_LEAF) box_grow_by_block(want, s, g, ref & ~PK_LEAF, w, key);
      else if (ref != PK_EMPTY) memcpy(want, whole[(size_t)ref * g->key_count + key], sizeof want);
      for (int p = 0; p < 6; p++) off += pk_node_planes(node, key)[8 * p + c] != want[p];
      box_grow(whole[i], want);
      *compared += 6;
    }
    if (n == 0) box_grow(all, whole[i]);
  }
  for (int a = 0; a < 3; a++) off += g->lo[a] != all[2 * a], off += g->hi[a] != all[2 * a + 1];
  *compared += 6;
  free(whole);
  return off;
}

uint64_t tree_bounds_off(const pktrt_scene *s, const world *w, uint64_t *compared) {
  uint64_t off = 0;
  for (uint32_t g = 0; g < s->bvh_count; g++) off += group_bounds_off(s, &s->bvhs[g], w, compared);
  for (int a = 0; a < 3; a++) {
    float lo = INFINITY, hi = -INFINITY;
    for (uint32_t m = 0; m < w->n; m++)
      for (size_t i = 0; i < (size_t)w->m[m].nt * 3 * w->m[m].keys; i++) {
        const size_t key = i / (w->m[m].nt * 3), vertex = w->m[m].i[i % (w->m[m].nt * 3)];
        const float x = w->m[m].p[3 * (key * w->m[m].nv + vertex) + (size_t)a];
        lo = fminf(lo, x), hi = fmaxf(hi, x);
      }
    off += s->lo[a] != lo, off += s->hi[a] != hi;
    *compared += 2;
  }
  return off;
}

uint32_t tree_depth(const pktrt_scene *s) {
  uint32_t most = 0;
  for (uint32_t i = 0; i < s->bvh_count; i++) {
    const pk_bvh *g = &s->bvhs[i];
    uint32_t *depth = calloc(g->node_count, sizeof *depth);
    if (!depth) abort();
    for (uint32_t n = 0; n < g->node_count; n++) {
      const uint32_t *child = pk_bvh_node(g, n)->child;
      for (int c = 0; c < 8; c++)
        if (child[c] != PK_EMPTY && !(child[c] & PK_LEAF)) depth[child[c]] = depth[n] + 1;
      if (depth[n] + 1 > most) most = depth[n] + 1;
    }
    free(depth);
  }
  return most;
}

bool tree_lane(const pktrt_scene *s, uint32_t group, uint32_t block, uint32_t lane, uint32_t *of, uint32_t *triangle) {
  const pk_bvh *g = &s->bvhs[group];
  if (block >= g->block_count || lane >= 8) return false;
  const uint32_t kept = g->block_triangles[(size_t)block * 8 + lane], id = kept & ~PK_DUPLICATE;
  for (uint32_t m = 0; kept != PKTRT_NONE && m < s->mesh_count; m++) {
    *of = m, *triangle = id - s->meshes[m].first_id;
    if (id >= s->meshes[m].first_id && *triangle < s->meshes[m].triangle_count) return true;
  }
  return false;
}

/* Whether a ray meets a box that is so much wider, in double. */
static bool slabs_meet(const pktrt_ray *r, const double lo[3], const double hi[3], double wider) {
  double from = (double)r->tmin, to = (double)r->tmax;
  for (int a = 0; a < 3; a++) {
    const double o = (double)r->origin[a], d = (double)r->direction[a];
    const double n = ((d < 0 ? hi[a] + wider : lo[a] - wider) - o) / d,
                 f = ((d < 0 ? lo[a] - wider : hi[a] + wider) - o) / d;
    from = fmax(from, n), to = fmin(to, f);
  }
  return from <= to;
}

static bool work_meets(const pktrt_ray *r, const double lo[3], const double hi[3], double margin, tree_work *w) {
  const bool surely = slabs_meet(r, lo, hi, -margin), perhaps = slabs_meet(r, lo, hi, margin);
  w->unsure |= surely != perhaps;
  return perhaps;
}

/* The node, and what lies below it. */
static void work_of_node(const pk_bvh *g, uint32_t n, const pktrt_ray *r, double margin, tree_work *w) {
  pk_node *node = pk_bvh_node(g, n);
  float weight1;
  const uint32_t key = pk_time_segment(r->time, g->key_count, &weight1), next = g->key_count > 1 ? key + 1 : key;
  const float *k0 = pk_node_planes(node, key), *k1 = pk_node_planes(node, next);
  w->nodes++;
  for (uint32_t c = 0; c < 8; c++) {
    const uint32_t ref = node->child[c];
    double lo[3], hi[3];
    if (ref == PK_EMPTY) continue;
    w->boxes++;
    for (uint32_t a = 0; a < 3; a++) {
      lo[a] = pk_mix_double(weight1, k0[16 * a + c], k1[16 * a + c]);
      hi[a] = pk_mix_double(weight1, k0[16 * a + 8 + c], k1[16 * a + 8 + c]);
    }
    if (!work_meets(r, lo, hi, margin, w)) continue;
    if (!(ref & PK_LEAF)) work_of_node(g, ref, r, margin, w);
    const uint32_t *id = pk_bvh_block(g, ref & ~PK_LEAF)->id;
    for (uint32_t l = 0; ref & PK_LEAF && l < 8; l++) w->triangles += id[l] != PKTRT_NONE;
  }
}

tree_work tree_work_of(const pktrt_scene *s, const pktrt_ray *r, bool ask_groups) {
  tree_work w = {0, 0, 0, false};
  double largest = 0;
  for (int a = 0; a < 3; a++)
    largest = fmax(largest, fmax(fabs((double)r->origin[a]), fmax(fabs((double)s->lo[a]), fabs((double)s->hi[a]))));
  for (uint32_t i = 0; i < s->bvh_count; i++) {
    const pk_bvh *g = &s->bvhs[i];
    double lo[3], hi[3];
    for (int a = 0; a < 3; a++) lo[a] = (double)g->lo[a], hi[a] = (double)g->hi[a];
    if (ask_groups && g->key_count > 1 && !work_meets(r, lo, hi, 1e-5 * largest, &w)) continue;
    work_of_node(g, 0, r, 1e-5 * largest, &w);
  }
  return w;
}

uint32_t tree_groups(const pktrt_scene *s) { return s->bvh_count; }

uint32_t tree_children(const pktrt_scene *s, uint32_t group, uint32_t node) {
  const pk_bvh *g = &s->bvhs[group];
  uint32_t there = 0;
  if (node >= g->node_count) return 0;
  const uint32_t *child = pk_bvh_node(g, node)->child;
  for (uint32_t c = 0; c < 8; c++)
    if (child[c] != PK_EMPTY) there |= 1u << c;
  return there;
}

void tree_asked_by(pktrt_scene *s, pktrt_isa isa) { s->kernels = pk_kernels_of(isa); }

static bool same_trees(const pktrt_scene *a, const pktrt_scene *b) {
  if (a->bvh_count != b->bvh_count) return false;
  for (uint32_t g = 0; g < a->bvh_count; g++) {
    const pk_bvh *x = &a->bvhs[g], *y = &b->bvhs[g];
    if (x->key_count != y->key_count || x->node_count != y->node_count || x->block_count != y->block_count)
      return false;
    if (memcmp(x->nodes, y->nodes, (size_t)x->node_count * x->node_bytes)) return false;
    if (memcmp(x->blocks, y->blocks, (size_t)x->block_count * x->block_bytes)) return false;
  }
  return true;
}

static size_t differing_hits(const world *w, const pktrt_scene *a, const pktrt_scene *b, size_t n) {
  size_t differ = 0;
  pktrt_ray *rays = calloc(n, sizeof *rays);
  pktrt_hit *h = calloc(2 * n, sizeof *h);
  if (!rays || !h) abort();
  make_rays(w, a, RAYS_EDGE, 3, 0, rays, n / 2);
  make_rays(w, a, RAYS_RANDOM, 3, 0, rays + n / 2, n - n / 2);
  pktrt_intersect_n(a, rays, h, n);
  pktrt_intersect_n(b, rays, h + n, n);
  for (size_t i = 0; i < n; i++) differ += !same_bits(&h[i], &h[n + i], sizeof *h);
  free(rays);
  free(h);
  return differ;
}

static void structure(void) {
  for (int q = PKTRT_BUILD_DEFAULT; q <= PKTRT_BUILD_HIGH; q++) {
    for (int kind = 0; kind < 6; kind++) {
      world w = kind == 0 ? world_static(4) : world_moving(kind == 1 ? 4 : 2);
      if (kind == 2) w.m[0].nt = 0;
      if (kind == 3) mesh_scale(&w.m[3], 1e-20f);
      if (kind == 4) mesh_shift(&w.m[3], 1e20f, 0, 0);
      if (kind == 5)
        for (uint32_t i = 0; i < w.m[3].nt; i++) memcpy(&w.m[3].i[3 * i], &w.m[3].i[0], 12);
      pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, 0);
      d.quality = (pktrt_build_quality)q;
      pktrt_scene *s = pktrt_scene_create(&d), *reference = world_scene(&w, isas[0], 0);
      for (uint32_t i = 0; i < w.n; i++) CHECK(mesh_add(s, &w.m[i], NULL) == PKTRT_OK);
      CHECK(pktrt_commit(s) == PKTRT_OK);
      sound(s, "built");
      if (kind < 2) CHECK(differing_hits(&w, s, reference, scaled(20000)) == 0, "quality %d changes no answer", q);
      pktrt_scene_destroy(s);
      pktrt_scene_destroy(reference);
      world_free(&w);
    }
  }
}

/* The control of all that follows: the checker sees a bound one ulp too small or too large, and a triangle that is lost. */
static void checker_sees(void) {
  world w = world_moving(3);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  sound(s, "untouched");
  size_t seen = 0, spoilt = 0;
  for (uint32_t g = 0; g < s->bvh_count; g++) {
    pk_bvh *x = &s->bvhs[g];
    for (uint32_t i = 0; i < 200; i++) {
      rng r = rng_of(i);
      uint32_t node = rng_below(&r, x->node_count), lane = rng_below(&r, 8), plane = rng_below(&r, 6),
               key = rng_below(&r, x->key_count);
      unsigned char *bytes = x->nodes + (size_t)node * x->node_bytes;
      uint32_t child;
      memcpy(&child, bytes + 192 + 4 * lane, 4);
      if (child == PK_EMPTY) continue;
      float *f = (float *)(void *)(bytes + (key ? 256 + (key - 1) * 192 : 0)) + plane * 8 + lane, was = *f;
      *f = nextafterf(was, i & 1 ? INFINITY : -INFINITY);
      spoilt++;
      seen += check_tree(x, s->meshes, s->mesh_count) != NULL;
      *f = was;
    }
    uint32_t was;
    unsigned char *id = x->blocks + 288;
    memcpy(&was, id, 4);
    memset(id, 0xFF, 4);
    spoilt++;
    seen += check_tree(x, s->meshes, s->mesh_count) != NULL;
    memcpy(id, &was, 4);
  }
  sound(s, "restored");
  CHECK(seen == spoilt && spoilt > 50, "%zu of %zu seen", seen, spoilt);
  control_figure("tree", "moving", "trees with a fault", "a bound one ulp off", spoilt, seen);
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* --- flat at its keys --- */

enum { FLAT = 24 };

/* Triangles that are lines at all keys; between two of them they have area if they `open`, and none if not: the lines lie in
   one plane, and turn, or stay. Far enough apart that a ray meets one. */
static mesh flat_at_keys(uint32_t keys, bool open) {
  mesh m = mesh_of(3 * FLAT * keys, FLAT);
  m.nv = 3 * FLAT, m.keys = keys;
  for (uint32_t i = 0; i < 3 * FLAT; i++) m.i[i] = i;
  for (uint32_t k = 0; k < keys; k++)
    for (uint32_t c = 0; c < 3 * FLAT; c++) {
      float *p = m.p + 3 * ((size_t)k * m.nv + c);
      const float along = (float)(c % 3), across = along * (float)(c % 3);
      const bool turned = open && k % 2;
      p[0] = (float)(4 * (c / 3 % 5)) + (turned ? 0 : along), p[1] = (float)(4 * (c / 15)) + (turned ? across : 0);
    }
  return m;
}

/* Asks for the middle of each triangle at a time; how many are hit, by single calls and by packets, as by the reference. */
static size_t hits_in_the_middle(const pktrt_scene *s, const world *w, float time) {
  pktrt_ray ray[FLAT];
  pktrt_hit one, many[FLAT], want;
  bool occluded[FLAT];
  size_t hits = 0;
  for (uint32_t t = 0; t < FLAT; t++) {
    float p[3][3];
    for (uint32_t c = 0; c < 3; c++) ref_vertex(&w->m[0], 3 * t + c, time, p[c]);
    ray[t] = ray_of((p[0][0] + p[1][0] + p[2][0]) / 3, (p[0][1] + p[1][1] + p[2][1]) / 3, 2, 0, 0, -1);
    ray[t].time = time;
  }
  pktrt_intersect_n(s, ray, many, FLAT), pktrt_occluded_n(s, ray, occluded, FLAT);
  for (uint32_t t = 0; t < FLAT; t++) {
    const bool hit = ref_intersect(w, &ray[t], &want);
    pktrt_intersect(s, &ray[t], &one);
    CHECK(same_bits(&one, &want, sizeof one) && same_bits(&many[t], &want, sizeof want), "triangle %u, time %g", t,
        (double)time);
    CHECK(occluded[t] == hit && pktrt_occluded(s, &ray[t]) == hit, "triangle %u, time %g", t, (double)time);
    hits += hit;
  }
  return hits;
}

static void check_flat_at_keys(const pktrt_scene *s, const world *w, bool open, const char *when) {
  pktrt_scene_info info;
  pktrt_get_scene_info(s, &info);
  sound(s, when);
  CHECK(info.degenerate == (open ? 0 : FLAT), "%s: %llu without area", when, (unsigned long long)info.degenerate);
  const uint32_t keys = w->m[0].keys;
  for (uint32_t k = 0; k < 2 * keys - 1; k++) {
    const size_t want = open && k % 2 ? FLAT : 0, hits = hits_in_the_middle(s, w, (float)k / (float)(2 * keys - 2));
    CHECK(hits == want, "%s: %zu hits at %u half keys, not %zu", when, hits, k, want);
  }
}

/* What has area between its keys only is built, and comes with a refit; what never has any goes with one. */
static void flat_between_keys(void) {
  for (uint32_t k = 0; k < 12; k++) {
    const uint32_t keys = 2 + k % 3;
    const bool open = k / 3 % 2, refitted = k / 6 % 2;
    mesh m = flat_at_keys(keys, open), first = flat_at_keys(keys, !open);
    world w = world_of(refitted ? first : m);
    pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
    check_flat_at_keys(s, &w, refitted != open, "built");
    w.m[0] = m;
    for (uint32_t key = 0; key < keys && refitted; key++)
      CHECK(pktrt_set_positions(s, 0, key, m.p + (size_t)key * m.nv * 3) == PKTRT_OK, "%s", pktrt_last_error(s));
    CHECK(pktrt_refit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
    check_flat_at_keys(s, &w, open, refitted ? "refitted" : "refitted for nothing");
    unsigned char *id = s->bvhs[0].blocks + 288; /* the control of the checker: the other answer is wrong */
    const uint32_t other = open ? PKTRT_NONE : s->bvhs[0].block_triangles[0];
    memcpy(id, &other, 4);
    CHECK(tree_fault(s) && strstr(tree_fault(s), "id"), "%s", tree_fault(s) ? tree_fault(s) : "no fault is seen");
    pktrt_scene_destroy(s);
    mesh_free(&m), mesh_free(&first);
  }
}

static void workers_of(int q) {
  for (int moves = 0; moves < 2; moves++) {
    static const int count[4] = {0, 1, 2, 7};
    world w = moves ? world_moving(small_run ? 5 : 7) : world_static(small_run ? 5 : 7);
    pktrt_scene *s[4];
    for (int i = 0; i < 4; i++) {
      pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, count[i]);
      d.quality = (pktrt_build_quality)q;
      s[i] = pktrt_scene_create(&d);
      for (uint32_t m = 0; m < w.n; m++) CHECK(mesh_add(s[i], &w.m[m], NULL) == PKTRT_OK);
      CHECK(pktrt_commit(s[i]) == PKTRT_OK);
    }
    for (int i = 1; i < 4; i++) CHECK(same_trees(s[0], s[i]), "%d workers build another tree", count[i]);
    for (uint32_t m = 0; m < w.n; m++) mesh_place(&w.m[m], (float[3]){1, 0.7f, 1.1f}, (float[3]){0, 0.1f, 0});
    for (int i = 0; i < 4; i++) {
      hooks.workers = count[i];
      for (uint32_t m = 0; m < w.n; m++) {
        for (uint32_t k = 0; k < w.m[m].keys; k++) {
          CHECK(pktrt_set_positions(s[i], m, k, w.m[m].p + (size_t)k * w.m[m].nv * 3) == PKTRT_OK);
        }
      }
      CHECK(pktrt_refit(s[i]) == PKTRT_OK);
    }
    for (int i = 1; i < 4; i++) CHECK(same_trees(s[0], s[i]), "%d workers refit differently", count[i]);
    sound(s[3], "refitted by 7");
    mesh_shift(&w.m[0], 1e-3f, 0, 0);
    CHECK(pktrt_set_positions(s[1], 0, 0, w.m[0].p) == PKTRT_OK && pktrt_refit(s[1]) == PKTRT_OK);
    CHECK(!same_trees(s[0], s[1]), "the control: the comparison sees a change");
    for (int i = 0; i < 4; i++) pktrt_scene_destroy(s[i]);
    world_free(&w);
  }
}

static void workers(void) {
  for (int q = PKTRT_BUILD_DEFAULT; q <= PKTRT_BUILD_HIGH; q++) workers_of(q);
}

/* Refitting one mesh touches no group of other key counts. */
static void one_mesh_only(void) {
  world w = world_moving(3);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  unsigned char *before[8] = {NULL};
  for (uint32_t g = 0; g < s->bvh_count; g++) before[g] = s->bvhs[g].nodes;
  mesh extra = mesh_soup(100, 0.2f, 9);
  mesh_move(&extra, 5, 0.1f, 0.1f, 3);
  CHECK(mesh_add(s, &extra, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
  for (uint32_t g = 0; g < s->bvh_count; g++) {
    bool kept = false;
    for (uint32_t b = 0; b < 8; b++) kept |= before[b] == s->bvhs[g].nodes;
    CHECK(kept == (s->bvhs[g].key_count != 5), "group of %u keys", s->bvhs[g].key_count);
  }
  sound(s, "after the commit of one more mesh");
  pktrt_scene_destroy(s);
  mesh_free(&extra);
  world_free(&w);
}

static void rebuild_policies(void) {
  for (int policy = PKTRT_REBUILD_ADVISE; policy <= PKTRT_REBUILD_AUTOMATIC; policy++) {
    mesh m = mesh_sphere(5, 0.02f, 1);
    world w = world_none();
    w.m[0] = m, w.n = 1;
    pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, 0);
    d.rebuild = (pktrt_rebuild)policy;
    pktrt_scene *s = pktrt_scene_create(&d);
    CHECK(mesh_add(s, &m, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
    pktrt_scene_info built, now;
    pktrt_get_scene_info(s, &built);
    CHECK(built.sah_at_build > 0 && built.sah_now == built.sah_at_build && !built.rebuild_advised);
    hooks.warnings = hooks.notes = 0;
    mesh_scale(&m, 1.25f); /* harmless: the cost stays */
    CHECK(pktrt_set_positions(s, 0, 0, m.p) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK);
    pktrt_get_scene_info(s, &now);
    CHECK(now.sah_now < 1.1 * now.sah_at_build && !now.rebuild_advised && hooks.warnings == 0, "%g", now.sah_now);
    rng r = rng_of(4);
    for (uint32_t v = m.nv - 1; v > 0; v--) { /* scrambled: the old tree is bad */
      uint32_t j = rng_below(&r, v + 1);
      for (int k = 0; k < 3; k++) {
        float x = m.p[3 * v + (uint32_t)k];
        m.p[3 * v + (uint32_t)k] = m.p[3 * j + (uint32_t)k];
        m.p[3 * j + (uint32_t)k] = x;
      }
    }
    unsigned char *nodes = s->bvhs[0].nodes;
    (void)nodes;
    CHECK(pktrt_set_positions(s, 0, 0, m.p) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK);
    pktrt_get_scene_info(s, &now);
    pktrt_scene *fresh = world_scene(&w, isas[isa_count - 1], 0); /* of AUTO there may be more to tell */
    pktrt_scene_info best;
    pktrt_get_scene_info(fresh, &best);
    say("policy %d: cost %.1f at build, %.1f now, %.1f when fresh", policy, now.sah_at_build, now.sah_now,
        best.sah_now);
    if (policy == PKTRT_REBUILD_AUTOMATIC) {
      CHECK(!now.rebuild_advised && now.sah_now == now.sah_at_build && now.sah_now == best.sah_now, "rebuilt as fresh");
      CHECK(same_trees(s, fresh));
    } else {
      CHECK(now.sah_now > 1.5 * now.sah_at_build && now.sah_at_build == built.sah_at_build, "the cost has grown");
      CHECK(!same_trees(s, fresh));
      CHECK(now.rebuild_advised == (policy == PKTRT_REBUILD_ADVISE));
      CHECK((hooks.warnings + hooks.notes > 0) == (policy == PKTRT_REBUILD_ADVISE), "says so: %s", hooks.last_log);
      CHECK(pktrt_mark_changed(s) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
      pktrt_get_scene_info(s, &now);
      CHECK(!now.rebuild_advised && now.sah_now == best.sah_now && same_trees(s, fresh), "after the advised rebuild");
    }
    sound(s, "at the end");
    CHECK(differing_hits(&w, s, fresh, scaled(3000)) == 0);
    pktrt_scene_destroy(fresh);
    pktrt_scene_destroy(s);
    mesh_free(&m);
  }
}

/* Part of the way from a sphere to the same vertices in another order. */
static void put_mixed(pktrt_scene *s, const mesh *m, const uint32_t *other, float part, pktrt_scene_info *info) {
  float *p = malloc((size_t)m->nv * 12);
  if (!p) abort();
  for (uint32_t v = 0; v < m->nv; v++)
    for (uint32_t a = 0; a < 3; a++) p[3 * v + a] = (1 - part) * m->p[3 * v + a] + part * m->p[3 * other[v] + a];
  CHECK(pktrt_set_positions(s, 0, 0, p) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  pktrt_get_scene_info(s, info);
  free(p);
}

static pktrt_scene *worn_scene(const mesh *m, pktrt_rebuild policy) {
  pktrt_scene_desc d = scene_desc_of(isas[isa_count - 1], 0);
  d.rebuild = policy;
  pktrt_scene *s = pktrt_scene_create(&d);
  CHECK(s && mesh_add(s, m, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  return s;
}

/* At 1.49 times the cost nothing is advised nor built anew, at 1.51 times it is. */
static void rebuild_threshold(void) {
  static const double costs[2] = {1.49, 1.51};
  mesh m = mesh_sphere(4, 0, 1);
  uint32_t *other = malloc(m.nv * sizeof *other);
  if (!other) abort();
  rng r = rng_of(4);
  for (uint32_t v = 0; v < m.nv; v++) other[v] = rng_below(&r, m.nv);
  for (int i = 0; i < 2; i++) {
    float lo = 0, hi = 1, part = 0.5f; /* how far to go for that cost */
    pktrt_scene_info info;
    pktrt_scene *s = worn_scene(&m, PKTRT_REBUILD_NEVER);
    for (int step = 0; step < 20; step++) {
      put_mixed(s, &m, other, part, &info);
      *(info.sah_now > costs[i] * info.sah_at_build ? &hi : &lo) = part;
      part = 0.5f * (lo + hi);
    }
    put_mixed(s, &m, other, part, &info);
    const double cost = info.sah_now / info.sah_at_build;
    CHECK(fabs(cost - costs[i]) < 0.005 && !info.rebuild_advised, "%g of the cost, not %g", cost, costs[i]);
    pktrt_scene_destroy(s);
    for (int policy = PKTRT_REBUILD_ADVISE; policy <= PKTRT_REBUILD_AUTOMATIC; policy++) {
      const bool advises = policy == PKTRT_REBUILD_ADVISE && i == 1,
                 builds = policy == PKTRT_REBUILD_AUTOMATIC && i == 1;
      hooks.warnings = hooks.notes = 0;
      s = worn_scene(&m, (pktrt_rebuild)policy);
      put_mixed(s, &m, other, part, &info);
      CHECK(info.rebuild_advised == advises && hooks.warnings == advises && hooks.notes == builds,
          "policy %d, %g of the cost: advised %d, %d warnings, %d notes", policy, cost, info.rebuild_advised,
          hooks.warnings, hooks.notes);
      CHECK((info.sah_now == info.sah_at_build) == builds, "policy %d, %g of the cost: %g now, %g when built", policy,
          cost, info.sah_now, info.sah_at_build);
      pktrt_scene_destroy(s);
    }
  }
  free(other);
  mesh_free(&m);
}

/* Input that tempts a builder into depth: exponentially shrinking triangles. */
static void deep_input_of(int q) {
  mesh m = mesh_of(3 * 3000, 3000);
  for (uint32_t t = 0; t < m.nt; t++) {
    float x = powf(0.97f, (float)t), a[9] = {x, 0, 0, x * 1.01f, 0, 0, x, x * 0.01f, 0};
    memcpy(m.p + 9 * t, a, sizeof a);
    for (uint32_t k = 0; k < 3; k++) m.i[3 * t + k] = 3 * t + k;
  }
  world w = world_none();
  w.m[0] = m, w.n = 1;
  pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, 0);
  d.quality = (pktrt_build_quality)q;
  pktrt_scene *s = pktrt_scene_create(&d);
  CHECK(mesh_add(s, &m, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
  sound(s, "geometric series");
  for (uint32_t t = 0; t < m.nt; t += small_run ? 370 : 37) {
    const float *a = m.p + 9 * t;
    pktrt_ray r = ray_of(a[0] * 1.002f, a[0] * 0.002f, 1, 0, 0, -1);
    pktrt_hit h, want;
    ref_intersect(&w, &r, &want);
    pktrt_intersect(s, &r, &h);
    CHECK(same_bits(&h, &want, sizeof h), "triangle %u", t);
  }
  pktrt_scene_destroy(s);
  mesh_free(&m);
}

static void deep_input(void) {
  for (int q = PKTRT_BUILD_DEFAULT; q <= PKTRT_BUILD_HIGH; q++) deep_input_of(q);
}

/* Moving subtrees makes the tree better, not only other. */
static void high_quality(void) {
  mesh m = mesh_soup(4000, 0.3f, 5), spikes = mesh_soup(400, 2, 6);
  double cost[PKTRT_BUILD_HIGH + 1];
  for (int q = PKTRT_BUILD_DEFAULT; q <= PKTRT_BUILD_HIGH; q++) {
    pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, 0);
    d.quality = (pktrt_build_quality)q;
    pktrt_scene *s = pktrt_scene_create(&d);
    pktrt_scene_info info;
    CHECK(mesh_add(s, &m, NULL) == PKTRT_OK && mesh_add(s, &spikes, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
    pktrt_get_scene_info(s, &info);
    cost[q] = info.sah_at_build;
    sound(s, "small among large");
    pktrt_scene_destroy(s);
  }
  say("cost %.1f, fast %.1f, high %.1f", cost[PKTRT_BUILD_DEFAULT], cost[PKTRT_BUILD_FAST], cost[PKTRT_BUILD_HIGH]);
  CHECK(cost[PKTRT_BUILD_HIGH] < 0.97 * cost[PKTRT_BUILD_DEFAULT]);
  mesh_free(&m);
  mesh_free(&spikes);
}

/* Inputs of the fast quality, which sorts centres: what spoils their order, or leaves none. */
enum { FAST_CHUNKS, FAST_ONE_CENTRE, FAST_ONE_PLACE, FAST_FAR, FAST_HUGE, FAST_TINY, FAST_FLAT, FAST_MOVING, FAST_FEW };

static world fast_input(int kind) {
  const uint32_t few = kind < FAST_FEW ? 0 : (uint32_t)(kind - FAST_FEW) + 1;
  mesh m = mesh_soup(few ? few : kind == FAST_CHUNKS ? 40000 : 3000, few ? 0.5f : 0.05f, 7);
  const float scale = kind == FAST_HUGE ? 0x1p99f : kind == FAST_TINY ? 0x1p-130f : 1;
  mesh_scale(&m, scale);
  for (uint32_t t = 0; t < m.nt; t++) {
    float *v[3];
    for (int c = 0; c < 3; c++) v[c] = m.p + 3 * m.i[3 * t + (uint32_t)c];
    for (int a = 0; a < 3; a++) {
      if (kind == FAST_ONE_CENTRE) v[0][a] = (float)(int)(t % 97), v[1][a] = -v[0][a], v[2][a] = a ? 0 : v[0][a];
      if (kind == FAST_ONE_PLACE) v[0][a] = a == 0, v[1][a] = a == 1, v[2][a] = a == 2;
      if (kind == FAST_FLAT && t % 3 == 0) v[1][a] = v[0][a];
      if (kind == FAST_FAR && t == 5) v[0][a] += 1e6f, v[1][a] += 1e6f, v[2][a] += 1e6f;
    }
  }
  if (kind == FAST_MOVING) mesh_move(&m, 2, 0.3f, 0.01f, 3);
  return world_of(m);
}

static void fast_blocks(void) {
  for (int kind = FAST_CHUNKS; kind < FAST_FEW + 20; kind++) {
    world w = fast_input(kind);
    pktrt_scene *s[3];
    pktrt_scene_info info[3];
    for (int i = 0; i < 3; i++) {
      pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, i == 2 ? 3 : 0);
      d.quality = i ? PKTRT_BUILD_FAST : PKTRT_BUILD_DEFAULT;
      s[i] = pktrt_scene_create(&d);
      CHECK(mesh_add(s[i], &w.m[0], NULL) == PKTRT_OK && pktrt_commit(s[i]) == PKTRT_OK);
      pktrt_get_scene_info(s[i], &info[i]);
    }
    sound(s[1], "fast");
    CHECK(same_trees(s[1], s[2]), "input %d: three workers build another tree", kind);
    CHECK(differing_hits(&w, s[0], s[1], scaled(4000)) == 0, "input %d: other hits", kind);
    CHECK(info[1].sah_at_build < 1.6 * info[0].sah_at_build, "input %d: cost %g, by default %g", kind,
        info[1].sah_at_build, info[0].sah_at_build);
    if (kind == FAST_CHUNKS || kind == FAST_FAR) {
      /* Triangles that are few lie too far from one another for full blocks; those that are not sorted have one each. */
      const uint32_t blocks = s[1]->bvhs->block_count, most = s[0]->bvhs->block_count * (kind == FAST_FAR ? 5u : 2u);
      CHECK(blocks < most, "input %d: %u blocks, at most %u are wanted", kind, (unsigned)blocks, (unsigned)most);
    }
    if (kind == FAST_CHUNKS) {
      mesh_place(&w.m[0], (float[3]){1, 0.7f, 1.1f}, (float[3]){0, 0.1f, 0});
      for (int i = 0; i < 3; i++)
        CHECK(pktrt_set_positions(s[i], 0, 0, w.m[0].p) == PKTRT_OK && pktrt_refit(s[i]) == PKTRT_OK);
      sound(s[1], "fast and refitted");
      CHECK(differing_hits(&w, s[0], s[1], scaled(4000)) == 0, "other hits after a refit");
    }
    for (int i = 0; i < 3; i++) pktrt_scene_destroy(s[i]);
    world_free(&w);
  }
}

/* --- what comments promise of the inside --- */

bool has_frusta(pktrt_isa isa) {
  if (isa == PKTRT_ISA_AUTO) isa = isas[isa_count - 1];
#if defined(PKTRT_NO_FRUSTA)
  return false;
#elif defined(PK_HAS_AVX2)
  return isa != PKTRT_ISA_SCALAR && isa != PKTRT_ISA_SSE2;
#else
  return isa != PKTRT_ISA_SCALAR;
#endif
}

/* Without hooks, memory is as aligned as it is with them: large blocks, of pages, too. */
static void aligned_by_default(void) {
  for (int level = 2; level < 7; level++) {
    mesh m = mesh_sphere(level, 0.05f, 1);
    pktrt_scene *s = pktrt_scene_create(NULL);
    const pktrt_mesh_desc d = mesh_desc(&m);
    CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
    const void *const blocks[3] = {s->bvhs[0].nodes, s->bvhs[0].blocks, s->meshes[0].positions};
    for (int i = 0; i < 3; i++) CHECK((uintptr_t)blocks[i] % 64 == 0, "level %d, block %d at %p", level, i, blocks[i]);
    pktrt_scene_destroy(s);
    mesh_free(&m);
  }
}

/* A walk keeps all children of a node but one, at each depth that the builder allows, and starts with one. */
static void stacks_suffice(void) {
  CHECK((int)PK_STACK >= (int)PK_MAX_DEPTH * (8 - 1) + 1, "%d entries", (int)PK_STACK);
}

/* Exponentials, logarithms, sines and cosines in double: pictures show little of their last bits. libm errs by half a
   step, hence 2^-51 and another 2^-53. */
static void series(void) {
  enum { EXP, LOG, LOG1M, EXPM1, SINE, COSINE, SERIES };
  static const char *const name[SERIES] = {"exp", "log", "log1m", "expm1", "sine", "cosine"};
  double worst[SERIES] = {0}, single = 0;
  const double most = 5 * 0x1p-53;
  rng r = rng_of(91);
  for (size_t i = 0; i < 100000; i++) {
    const double x = ((double)rng_u32(&r) + (double)rng_u32(&r) * 0x1p-32) * 0x1p-32, tiny = ldexp(x, -(int)(i % 50));
    const double e = 1400 * (x - 0.5), wide = ldexp(1 + x, (int)(i % 2000) - 1000);
    double sine, cosine;
    worst[EXP] = fmax(worst[EXP], fabs(pk_math_exp(e) / exp(e) - 1));
    worst[LOG] = fmax(worst[LOG], fabs(pk_math_log(wide) / log(wide) - 1));
    if (tiny > 0 && tiny < 1) {
      worst[LOG1M] = fmax(worst[LOG1M], fabs(pk_math_log1m(tiny) / log1p(-tiny) - 1));
      worst[EXPM1] = fmax(worst[EXPM1], fabs(pk_math_expm1(-tiny) / expm1(-tiny) - 1));
    }
    pk_math_sincos_turn(x * 0.25, &sine, &cosine); /* libm's argument errs by what is at most pi / 2 steps */
    worst[SINE] = fmax(worst[SINE], fabs(sine - sin(x * 1.5707963267948966)));
    worst[COSINE] = fmax(worst[COSINE], fabs(cosine - cos(x * 1.5707963267948966)));
    single = fmax(single, fabs((double)expf((float)e / 8) / exp(e / 8) - 1));
  }
  for (int i = 0; i < SERIES; i++) {
    say("%s errs by %.2f of 2^-51", name[i], worst[i] * 0x1p51);
    CHECK(worst[i] < most, "%s: %g", name[i], worst[i]);
  }
  CHECK(single > 1e6 * most, "the control: float errs by %g", single);
}

/* --- twins of pictures: what one sample is by itself, and among those that kernels make together, in each bit --- */
/* Compares draws of samples: any pixels, samples, groups and seeds. */
static uint64_t twin_samplers(const pk_kernel_table *kernels, pk_sample_batch *batch) {
  uint64_t compared = 0;
  rng r = rng_of(93);
  for (int round = 0; round < TWIN_ROUNDS / 10; round++) {
    const uint32_t few = 1 + rng_below(&r, 40), some = 1u << rng_below(&r, 17);
    pktrt_sampling sampling;
    memset(&sampling, 0, sizeof sampling);
    sampling.sampler = round % 2 ? PKTRT_SAMPLER_RANDOM : PKTRT_SAMPLER_SOBOL;
    sampling.samples = round % 3 ? some : few;
    sampling.seed = rng_u32(&r);
    const uint32_t group = rng_below(&r, 3), first = rng_below(&r, 4), n = 1 + rng_below(&r, 4 - first);
    for (uint32_t k = 0; k < PK_DRAWN; k++) {
      batch->x[k] = k % 9 ? rng_below(&r, 4096) : UINT32_MAX;
      batch->y[k] = k % 7 ? rng_below(&r, 4096) : UINT32_MAX;
      batch->sample[k] = k % 5 ? rng_below(&r, sampling.samples) : sampling.samples - 1;
      batch->group[k] = k % 3 ? 0 : rng_u32(&r);
    }
    kernels->draw_samples(&sampling, batch, 0, group, first, n);
    for (uint32_t k = 0; k < PK_DRAWN; k++) {
      float u[4];
      pk_sampler_sample(
          &sampling, batch->x[k], batch->y[k], batch->sample[k], 4 * (batch->group[k] + group) + first, n, u);
      for (uint32_t i = 0; i < n; i++, compared++)
        CHECK(batch->u[first + i][k] == u[i], "sampler %d: %.9g and %.9g", (int)sampling.sampler,
            (double)batch->u[first + i][k], (double)u[i]);
    }
  }
  return compared;
}

/* Compares rays of pinholes. */
static uint64_t twin_cameras(const pk_kernel_table *kernels, pk_wave *wave) {
  uint64_t compared = 0;
  rng r = rng_of(94);
  for (int round = 0; round < TWIN_ROUNDS; round++) {
    pktrt_camera camera;
    pk_camera_plane plane;
    double x[8], y[8];
    memset(&camera, 0, sizeof camera), memset(&plane, 0, sizeof plane);
    for (int a = 0; a < 3; a++) camera.eye[a] = twin_coordinate(&r), camera.target[a] = twin_coordinate(&r);
    for (int a = 0; a < 2; a++) camera.shift[a] = twin_coordinate(&r);
    camera.fov_y = rng_range(&r, 1, 179);
    if (!pk_camera_plane_at(&camera, 640, 480, 0, &plane)) continue;
    for (int k = 0; k < 8; k++) x[k] = 640 * (double)twin_unit(&r), y[k] = 480 * (double)twin_unit(&r);
    kernels->camera_rays(&plane, x, y, wave, 8);
    for (int k = 0; k < 8; k++) {
      const pk_camera_sample sample = {x[k], y[k], 0, {0, 0}};
      float o[3], d[3];
      pk_camera_ray_at(&camera, 640, 480, &plane, &sample, o, d);
      for (int a = 0; a < 3; a++, compared++)
        CHECK(wave->rays.o[a][8 + k] == o[a] && wave->rays.d[a][8 + k] == d[a], "ray: %.9g and %.9g",
            (double)wave->rays.d[a][8 + k], (double)d[a]);
    }
  }
  return compared;
}

/* Compares samples of lights, and with them sines and cosines, disks and rotations. Counts what kernels leave to the others. */
static uint64_t twin_lights(const pk_fit_table *fit, pk_surfaces *surfaces, pk_light_samples *samples, uint64_t *left) {
  enum { ROWS = sizeof pk_light_rows / sizeof *pk_light_rows }; /* of kinds, and of directional lights with an angle */
  uint64_t compared = 0, seen[ROWS] = {0};
  static pk_render_state render;
  rng r = rng_of(95);
  render.distribute = true;
  for (int round = 0; round < 2 * TWIN_ROUNDS; round++) {
    pktrt_light light;
    pk_light_data data;
    float u[2][PK_ROW];
    memset(&light, 0, sizeof light), memset(&data, 0, sizeof data), memset(u, 0, sizeof u);
    const bool sun = round % ROWS == PKTRT_LIGHT_KIND_COUNT;
    light.kind = sun ? PKTRT_LIGHT_DIRECTIONAL : (pktrt_light_kind)(round % ROWS);
    if (sun) light.angle = 90 - 89 * rng_unit(&r);
    if (pk_light_has(&light, PK_LIGHT_EMISSIVE)) continue;
    const bool vectors = pk_light_has(&light, PK_LIGHT_VECTORS);
    light.radius = ldexpf(rng_range(&r, 0.5f, 1), (int)rng_below(&r, 20) - 15);
    for (int a = 0; a < 3; a++) {
      light.position[a] = twin_coordinate(&r), light.intensity[a] = 1;
      light.direction[a] = rng_sign(&r);
      light.edge[0][a] = twin_coordinate(&r), light.edge[1][a] = twin_coordinate(&r);
    }
    data.source = &light, data.strength = 1 + (double)rng_unit(&r);
    data.row = pk_light_row_of(&light);
    (void)data.row->prepare(&render, &data);
    pk_light_describe(&render, &data);
    surfaces->count = 16;
    for (uint32_t k = 0; k < 16; k++) {
      double n[3] = {(double)rng_sign(&r), (double)rng_sign(&r), (double)rng_sign(&r)};
      if (k % 4 == 0) n[0] = n[1] = 0; /* along z: where rotations change their form */
      if (!pk_normalise(n)) n[2] = 1;
      for (int a = 0; a < 3; a++)
        surfaces->point[a][k] = (double)twin_coordinate(&r), surfaces->smooth_normal[a][k] = (float)n[a];
      u[0][k] = twin_unit(&r), u[1][k] = twin_unit(&r);
    }
    (void)fit->sample_light(&light, &data.target, u[0], u[1], surfaces, samples);
    for (uint32_t k = 0; k < 16; k++) {
      const float at_u[2] = {u[0][k], u[1][k]};
      double at[3] = {0, 0, 0}, color[3];
      pk_light_view from;
      from.time = 0;
      for (int a = 0; a < 3; a++)
        from.point[a] = surfaces->point[a][k], from.normal[a] = (double)surfaces->smooth_normal[a][k];
      if (samples->factor[k] < 0) {
        *left += vectors;
        continue;
      }
      seen[round % ROWS]++;
      const double factor = data.row->sample(&render, &data, at_u, &from, at, color) * data.strength;
      CHECK(samples->factor[k] == factor, "light %d: factor %.17g and %.17g", (int)light.kind, samples->factor[k],
          factor);
      for (int a = 0; factor > 0 && a < 3; a++, compared++)
        CHECK(samples->at[a][k] == at[a], "light %d: %.17g and %.17g", (int)light.kind, samples->at[a][k], at[a]);
    }
  }
  for (int kind = 0; kind < ROWS; kind++)
    CHECK((seen[kind] > 0) == ((pk_light_rows[kind].traits & PK_LIGHT_VECTORS) != 0),
        "light %d: the trait VECTORS and a branch of pk_light_sample_all go together", kind);
  return compared;
}

/* Lights with a size are found in the direction in which they are sampled, with the same density. */
static void lights_are_found(void) {
  static pk_render_state render;
  rng r = rng_of(96);
  render.distribute = true;
  for (int kind = 0; kind < PKTRT_LIGHT_KIND_COUNT; kind++) {
    const pk_light_row *row = &pk_light_rows[kind];
    uint64_t met = 0;
    if (!(row->traits & PK_LIGHT_AREA) || (row->traits & PK_LIGHT_HIT)) continue;
    CHECK(row->meet != NULL, "light %d: nothing finds its point in a direction", kind);
    for (int k = 0; row->meet && k < 200; k++) {
      pktrt_light light;
      pk_light_data data;
      pk_light_view from;
      double at[3], again[3], color[3], direction[3];
      const float u[2] = {rng_unit(&r), rng_unit(&r)};
      memset(&light, 0, sizeof light), memset(&data, 0, sizeof data), memset(&from, 0, sizeof from);
      light.kind = (pktrt_light_kind)kind;
      light.radius = light.edge[0][0] = light.edge[1][2] = 1, light.direction[1] = -1, light.position[1] = 3;
      for (int a = 0; a < 3; a++) light.intensity[a] = 1, from.point[a] = (double)rng_sign(&r), from.normal[a] = a == 1;
      data.source = &light, data.strength = 1;
      CHECK(row->prepare(&render, &data), "light %d", kind);
      const double factor = row->sample(&render, &data, u, &from, at, color);
      for (int a = 0; a < 3; a++) direction[a] = at[a] - from.point[a];
      if (!(factor > 0) || !pk_normalise(direction)) continue;
      const double found = row->meet(&data, &from, direction, again);
      met++;
      CHECK(fabs(found - factor) < 1e-5 * factor && pk_distance2(at, again) < 1e-10,
          "light %d: sampled with 1 / density %g, found with %g, %g apart", kind, factor, found,
          sqrt(pk_distance2(at, again)));
    }
    CHECK(met > 100, "light %d: %llu samples", kind, (unsigned long long)met);
  }
}

static void twins_of_pictures(void) {
  static pk_wave wave;
  static pk_sample_batch batch;
  static pk_surfaces surfaces;
  static pk_light_samples samples;
  for (int i = PKTRT_ISA_SCALAR; i < PKTRT_ISA_COUNT; i++) {
    const pk_kernel_table *kernels = pk_kernels_of((pktrt_isa)i);
    if (!kernels) continue;
    uint64_t left = 0;
    const uint64_t drawn = twin_samplers(kernels, &batch), rays = twin_cameras(kernels, &wave);
    const uint64_t lit = twin_lights(pk_fit_table_of((pktrt_isa)i), &surfaces, &samples, &left);
    say("%s: %llu draws, %llu coordinates of rays, %llu of samples of lights; %llu lights left to the scalar functions",
        pktrt_isa_string((pktrt_isa)i), (unsigned long long)drawn, (unsigned long long)rays, (unsigned long long)lit,
        (unsigned long long)left);
    CHECK(drawn > 10000 && rays > 10000 && lit > 10000 && left > 100);
  }
}

/* --- corners at a time: by pk_mix, of blocks and of meshes, and by pk_mix8 of all kernels, in each bit --- */

enum { CORNER_KEYS = 5, CORNER_TRIANGLES = 16, CORNER_ROUNDS = 20000 };

/* Corners of the triangles in slots 0 to 15 of a tree that moves, and in a mesh. */
typedef struct corner_scene {
  PK_ALIGN64 pk_block blocks[2 * CORNER_KEYS];
  float positions[CORNER_KEYS][CORNER_TRIANGLES][3][3];
  pk_bvh bvh;
  pk_mesh mesh;
  pktrt_scene scene;
} corner_scene;

/* The vector function, as kernels call it: corners [corner][axis][ray] of the triangles that rays 0 to 7 hit. */
typedef void (*corner_kernel)(const pktrt_scene *scene, const pk_batch *batch, float p[3][3][8]);
#define CORNER_KERNEL(isa) \
  static void corners_by_##isa(const pktrt_scene *scene, const pk_batch *batch, float p[3][3][8]) { \
    pk_float8_##isa q[3][3]; \
    pk_resolve_gather_corners_##isa(scene, batch, 0, 0xFF, q); \
    memcpy(p, q, sizeof q); \
  }
#ifdef PK_HAS_SCALAR
CORNER_KERNEL(scalar)
#endif
#ifdef PK_HAS_SSE2
CORNER_KERNEL(sse2)
#endif
#ifdef PK_HAS_AVX2
CORNER_KERNEL(avx2)
#endif
#ifdef PK_HAS_AVX512
CORNER_KERNEL(avx512)
#endif
#ifdef PK_HAS_NEON
CORNER_KERNEL(neon)
#endif
#ifdef PK_HAS_WASM
CORNER_KERNEL(wasm)
#endif

static corner_kernel corner_kernel_of(pktrt_isa isa) {
  if (!pktrt_isa_available(isa)) return NULL;
  switch (isa) {
#ifdef PK_HAS_SCALAR
  case PKTRT_ISA_SCALAR: return corners_by_scalar;
#endif
#ifdef PK_HAS_SSE2
  case PKTRT_ISA_SSE2: return corners_by_sse2;
#endif
#ifdef PK_HAS_AVX2
  case PKTRT_ISA_AVX2: return corners_by_avx2;
#endif
#ifdef PK_HAS_AVX512
  case PKTRT_ISA_AVX512: return corners_by_avx512;
#endif
#ifdef PK_HAS_NEON
  case PKTRT_ISA_NEON: return corners_by_neon;
#endif
#ifdef PK_HAS_WASM
  case PKTRT_ISA_WASM: return corners_by_wasm;
#endif
  default: return NULL;
  }
}

/* Any finite float: zeros of both signs, the largest, the least, and sizes between. */
static float corner_coordinate(rng *r) {
  static const float extreme[] = {
      0, -0.0f, 1e38f, -1e38f, FLT_MAX, -FLT_MAX, FLT_MIN, -FLT_MIN, 1e-45f, -1e-45f, 1e-40f, 1};
  const uint32_t pick = rng_below(r, 4);
  if (pick == 0) return extreme[rng_below(r, sizeof extreme / sizeof *extreme)];
  return pick == 1 ? ldexpf(rng_sign(r), (int)rng_below(r, 276) - 148) : 100 * rng_sign(r);
}

/* A time of a key or next to it, or any other, some outside [0,1]. */
static float corner_time(rng *r, uint32_t keys) {
  const float of_key = (float)rng_below(r, keys) / (float)(keys - 1);
  switch (rng_below(r, 8)) {
  case 0: return 0;
  case 1: return 1;
  case 2: return of_key;
  case 3: return nextafterf(of_key, 2);
  case 4: return nextafterf(of_key, -1);
  case 5: return rng_below(r, 2) ? -0.5f : 1.5f;
  default: return rng_unit(r);
  }
}

static void corner_fill(corner_scene *moving, rng *r, uint32_t keys) {
  memset(moving, 0, sizeof *moving);
  moving->bvh.blocks = PK_CAST(unsigned char *, (void *)moving->blocks);
  moving->bvh.block_bytes = PK_BLOCK_BYTES + (keys - 1) * PK_BLOCK_KEY_BYTES;
  moving->bvh.key_count = moving->mesh.key_count = keys;
  moving->mesh.vertex_count = 3 * CORNER_TRIANGLES;
  moving->scene.bvhs = &moving->bvh;

  for (uint32_t i = 0; i < 9 * CORNER_TRIANGLES * keys; i++) {
    const uint32_t key = i / 9 / CORNER_TRIANGLES, triangle = i / 9 % CORNER_TRIANGLES, corner = i / 3 % 3,
                   axis = i % 3;
    const float x = corner_coordinate(r);
    moving->positions[key][triangle][corner][axis] = x;
    pk_block_vertices(pk_bvh_block(&moving->bvh, triangle / 8), key)[24 * corner + 8 * axis + triangle % 8] = x;
  }
}

static void twins_of_corners(void) {
  static corner_scene moving;
  static pk_batch batch;
  static const uint32_t key_counts[] = {2, 2, 3, 4, CORNER_KEYS};
  if (!PK_MOTION) return;

  for (int i = PKTRT_ISA_AUTO + 1; i < PKTRT_ISA_COUNT; i++) {
    const corner_kernel kernel = corner_kernel_of((pktrt_isa)i);
    uint32_t compared = 0, other[2] = {0, 0};
    rng r = rng_of(97);
    if (!kernel) continue;

    for (uint32_t round = 0; round < CORNER_ROUNDS; round++) {
      const uint32_t keys = key_counts[round / 50 % 5], one = rng_below(&r, CORNER_TRIANGLES);
      float p[3][3][8];
      if (round % 50 == 0) corner_fill(&moving, &r, keys);
      for (int ray = 0; ray < 8; ray++) {
        batch.slot[ray] = rng_below(&r, 4) ? one : rng_below(&r, CORNER_TRIANGLES);
        batch.time[ray] = corner_time(&r, keys);
      }
      kernel(&moving.scene, &batch, p);

      for (int k = 0; k < 8 * 9; k++) {
        const int ray = k / 9, corner = k / 3 % 3, axis = k % 3;
        const float time = batch.time[ray], is = p[corner][axis][ray];
        const uint32_t slot = batch.slot[ray];
        float of_block[3][3], of_mesh[3], weight1;
        pk_tri_corners_at(&moving.bvh, slot, time, of_block);
        pk_mesh_corner_at(&moving.mesh, moving.positions[0][0][0], slot, (uint32_t)corner, time, of_mesh);
        const uint32_t key = pk_time_segment(time, keys, &weight1);
        const float key0 = moving.positions[key][slot][corner][axis],
                    key1 = moving.positions[key + 1][slot][corner][axis];

        CHECK(same_bits(&is, &of_block[corner][axis], sizeof is) && same_bits(&is, &of_mesh[axis], sizeof is),
            "%s, %u keys, time %.9g: %.9g, not %.9g, of the mesh %.9g", pktrt_isa_string((pktrt_isa)i), keys,
            (double)time, (double)is, (double)of_block[corner][axis], (double)of_mesh[axis]);
        if (time <= 0) CHECK(is == moving.positions[0][slot][corner][axis], "not the first key's corner");
        if (time >= 1) CHECK(is == moving.positions[keys - 1][slot][corner][axis], "not the last key's corner");
        compared++;

        /* The controls: along the difference of the keys, and with one product fused, as culling does, are other bits. */
        const float along = key0 + weight1 * (key1 - key0), fused = fmaf(1 - weight1, key0, weight1 * key1);
        other[0] += !same_bits(&is, &along, sizeof is);
        other[1] += !same_bits(&is, &fused, sizeof is);
      }
    }
    say("%s: %u coordinates; other formulas would change %u and %u", pktrt_isa_string((pktrt_isa)i), compared, other[0],
        other[1]);
    CHECK(compared > 1000000 && other[0] > compared / 100 && other[1] > compared / 100);
  }
}

#ifndef PKTRT_NO_RENDER
/* Sets lanes of a wave and its surfaces to hits. */
static void surfaces_of(
    const pktrt_scene *s, const pktrt_ray *rays, const pktrt_hit *hits, uint32_t n, pk_wave *wave, pk_surfaces *found) {
  const pk_bvh *bvh = &s->bvhs[0];
  pk_batch *batch = &wave->rays;

  for (uint32_t i = 0; i < n; i++) {
    for (int axis = 0; axis < 3; axis++) {
      batch->o[axis][i] = rays[i].origin[axis];
      batch->d[axis][i] = rays[i].direction[axis];
      batch->as.hit.normal[axis][i] = hits[i].normal[axis];
    }
    batch->t[i] = hits[i].t;
    batch->as.hit.u[i] = hits[i].u;
    batch->as.hit.v[i] = hits[i].v;
    batch->time[i] = rays[i].time;
    batch->id[i] = hits[i].triangle;
    batch->bvh[i] = batch->instance[i] = 0;
    for (uint32_t slot = 0; slot < 8 * bvh->block_count; slot++)
      if (pk_bvh_block(bvh, slot / 8)->id[slot % 8] == hits[i].triangle) batch->slot[i] = slot;
    found->ray[i] = found->number[i] = i;
    found->mesh[i] = found->material[i] = 0;
    found->triangle[i] = hits[i].triangle;
  }

  found->first = 0;
  found->count = n;
}

/* pk_surface_point8 and its twin pk_spawn_find: the same point, and an offset that is not less, of triangles of any size and
   shape, for hits anywhere on them. */
static void twins_of_points(void) {
  enum { TRIANGLES = 64 };
  static const int sizes[] = {0, -30, 30, 10};
  pk_wave *wave = NULL;
  pk_surfaces *found = NULL;
  size_t compared = 0;

  for (int k = 0; k < 4 * isa_count; k++) {
    rng r = rng_of((uint64_t)(k / isa_count));
    float p[TRIANGLES * 9];
    pktrt_ray rays[PK_BATCH];
    pktrt_hit hits[PK_BATCH];
    pktrt_mesh_desc body;
    pktrt_scene_desc d = scene_desc_of(isas[k % isa_count], 0);
    pktrt_scene *s = pktrt_scene_create(&d);
    uint32_t n = 0;

    /* Every other triangle is a sliver; all lie off the origin, in the last case far off. */
    for (uint32_t i = 0; i < TRIANGLES * 9; i++) {
      const bool sliver = i / 9 % 2 && i % 9 >= 6;
      const float size = sliver ? 1e-3f : 1, off = sizes[k / isa_count] == 10 ? 1e3f : 0;
      p[i] = (sliver ? p[i - 3] : ldexpf(off, sizes[k / isa_count])) +
             ldexpf(rng_range(&r, -size, size), sizes[k / isa_count]);
    }
    memset(&body, 0, sizeof body);
    body.positions = p;
    body.vertex_count = 3 * TRIANGLES;
    body.triangle_count = TRIANGLES;
    CHECK(s && pktrt_add_mesh(s, &body, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));

    for (int tries = 0; tries < 4 * PK_BATCH && n < PK_BATCH; tries++) {
      const float *corner = p + 9 * (tries % TRIANGLES);
      const float u = tries % 3 ? rng_unit(&r) : ldexpf(rng_unit(&r), -20), v = (1 - u) * rng_unit(&r);
      float from[3], way[3];
      for (int axis = 0; axis < 3; axis++) {
        const float at = corner[axis] + u * (corner[3 + axis] - corner[axis]) + v * (corner[6 + axis] - corner[axis]);
        way[axis] = ldexpf(rng_range(&r, -1, 1), sizes[k / isa_count]);
        from[axis] = at - way[axis] * rng_range(&r, 0.1f, 3);
      }
      rays[n] = pktrt_make_ray(from, way);
      n += pktrt_intersect(s, &rays[n], &hits[n]);
    }

    wave = wave ? wave : PK_CAST(pk_wave *, pk_mem_alloc(&s->desc, 1, sizeof *wave));
    found = found ? found : PK_CAST(pk_surfaces *, pk_mem_alloc(&s->desc, 1, sizeof *found));
    if (!wave || !found) abort();
    memset(wave, 0, sizeof *wave);
    surfaces_of(s, rays, hits, n, wave, found);
    s->kernels->find_surfaces(s, false, wave, found);
    compared += n;

    for (uint32_t i = 0; i < n; i++) {
      pk_spawn_point x;
      (void)pk_spawn_from(s, &rays[i], &hits[i], rays[i].direction, &x);
      for (int axis = 0; axis < 3; axis++)
        CHECK(same_bits(&x.at[axis], &found->point[axis][i], sizeof *x.at), "size 2^%d, %s: %.17g and %.17g",
            sizes[k / isa_count], pktrt_isa_string(isas[k % isa_count]), x.at[axis], found->point[axis][i]);
      CHECK((double)found->offset[i] > x.offset * (1 - 1e-6), "the offset is %g, not %g", (double)found->offset[i],
          x.offset);
    }

    if (k + 1 == 4 * isa_count) {
      pk_mem_release(&s->desc, wave, 1, sizeof *wave);
      pk_mem_release(&s->desc, found, 1, sizeof *found);
    }
    pktrt_scene_destroy(s);
  }

  CHECK(compared > 400, "only %u points", (unsigned)compared);
}
#endif

void suite_tree(void) {
  run("trees of all qualities are sound", structure);
  run("stable: the tree checker sees bounds that are one ulp off", checker_sees);
  run("triangles that have area only between their keys are built, refitted and hit there", flat_between_keys);
  run("the high quality has a cheaper tree", high_quality);
  run("the fast quality makes sound trees of any input, three workers the same", fast_blocks);
  run("one, two and seven workers build and refit the same tree", workers);
  run("a commit leaves the trees of unchanged groups alone", one_mesh_only);
  run("each rebuild policy does what it says", rebuild_policies);
  run("a rebuild is advised, or made, from 1.5 times the cost on", rebuild_threshold);
  run("geometric series build a tree of bounded depth", deep_input);
  run("without hooks, memory is aligned, too", aligned_by_default);
  run("the stack of a walk holds what the deepest tree can leave there", stacks_suffice);
  run("scalar and vector forms of one function give the same bits", twins_of_kernels);
  run("exp, log, sine and cosine err by as little as they say", series);
  run("lights with a size are found where they are sampled", lights_are_found);
  run("samples, camera rays and samples of lights are alone as they are together", twins_of_pictures);
  run("corners at a time are those of one ray for eight rays", twins_of_corners);

#ifndef PKTRT_NO_RENDER
  run("points of surfaces by eights are those of one", twins_of_points);
#endif
}
