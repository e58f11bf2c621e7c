/* The one file with the implementation: the tree's structure, refits, rebuilds, independence of workers. */
#define PKTRT_IMPLEMENTATION
#include "stability.h"
#include "tree.h"

/* --- the checker of trees: NULL, or what is wrong. A tree must be up to date with the meshes: after a build or refit, before or
   after the pending positions became the committed ones --- */

/* Straight from the definition, beside the builder. */
static bool has_area(const float *const v[3]) {
  const double ax = (double)v[1][0] - (double)v[0][0], bx = (double)v[2][0] - (double)v[0][0];
  const double ay = (double)v[1][1] - (double)v[0][1], by = (double)v[2][1] - (double)v[0][1];
  const double az = (double)v[1][2] - (double)v[0][2], bz = (double)v[2][2] - (double)v[0][2];
  return (ay * bz - az * by != 0.0) | (az * bx - ax * bz != 0.0) | (ax * by - ay * bx != 0.0);
}

static const char *check_block(const pktrt__bvh *bvh, uint32_t block, const pktrt__mesh *meshes, uint32_t mesh_count,
                               uint64_t *set, uint64_t *count) {
  const uint32_t *tri = bvh->block_triangles + (size_t)block * 8;
  pktrt__block *at = pktrt__bvh_block(bvh, block);
  if (tri[0] == PKTRT_NONE) return "A block has no triangle.";
  for (size_t l = 0; l < 8; l++) {
    bool area = false, none = tri[l] == PKTRT_NONE;
    for (size_t i = 0; i < l; i++)
      if (!none && (tri[i] ^ tri[l]) << 1 == 0) return "A block has a triangle twice.";
    if (!none && l && tri[l - 1] == PKTRT_NONE) return "A block has a triangle behind a free lane.";
    uint32_t t = tri[none ? 0 : l] & ~PKTRT__AGAIN, owner = pktrt__mesh_of_triangle(meshes, mesh_count, t, 0);
    const pktrt__mesh *m = &meshes[owner];
    float half[3][3]; /* the corners half-way from the key before */
    const float *const between[3] = {half[0], half[1], half[2]}, *before[3] = {NULL, NULL, NULL};
    if (t - m->first_id >= m->triangle_count || m->key_count != bvh->key_count) return "A triangle is foreign.";
    for (uint32_t k = 0; k < bvh->key_count; k++) {
      const float *row = pktrt__block_vertices(at, k) + l;
      const float *v[3];
      pktrt__mesh_corners(m, true, t - m->first_id, k, v);
      for (size_t i = 0; i < 9; i++) {
        if (memcmp(&row[i * 8], &v[i / 3][i % 3], sizeof(float))) return "A vertex is not the owner's.";
        if (k) half[i / 3][i % 3] = 0.5f * before[i / 3][i % 3] + 0.5f * v[i / 3][i % 3];
      }
      area = area || has_area(v) || (k && has_area(between));
      for (int c = 0; c < 3; c++) before[c] = v[c];
    }
    if (at->id[l] != (area && !none ? t : PKTRT_NONE)) return "An id in a block is wrong.";
    if (!none && !(tri[l] & PKTRT__AGAIN)) *set += pktrt__hash(t), *count += 1;
  }
  return NULL;
}

/* Whether triangles of a tree are split. Then boxes of leaves may be smaller than those of their triangles; see tree_uncovered. */
static bool is_split(const pktrt__bvh *bvh) {
  for (size_t i = 0; i < (size_t)bvh->block_count * 8; i++)
    if (bvh->block_triangles[i] != PKTRT_NONE && bvh->block_triangles[i] & PKTRT__AGAIN) return true;
  return false;
}

/* Straight from the definition, beside the kernel. */
static const char *check_child(const pktrt__bvh *bvh, pktrt__node *node, int c, bool split) {
  uint32_t ref = node->child[c];
  for (uint32_t k = 0; k < bvh->key_count; k++) {
    for (int p = 0; p < 6; p++) {
      float want = p & 1 ? -PKTRT__FAR : PKTRT__FAR, got = pktrt__node_planes(node, k)[8 * p + c];
      for (int i = 0; i < 24 && ref != PKTRT__EMPTY; i++) {
        float x;
        if (ref & PKTRT__LEAF) {
          size_t block = ref & ~PKTRT__LEAF;
          if (bvh->block_triangles[block * 8 + (size_t)i / 3] == PKTRT_NONE) continue;
          x = pktrt__block_vertices(pktrt__bvh_block(bvh, (uint32_t)block), k)[i % 3 * 24 + p / 2 * 8 + i / 3];
        } else {
          pktrt__node *below = pktrt__bvh_node(bvh, ref);
          if (below->child[i / 3] == PKTRT__EMPTY) continue;
          x = pktrt__node_planes(below, k)[8 * p + i / 3];
        }
        if (p & 1 ? x > want : x < want) want = x;
      }
      if (got <= want && got >= want) continue;
      if (split && ref & PKTRT__LEAF && (p & 1 ? got < want : got > want)) continue;
      return ref == PKTRT__EMPTY ? "An empty child has bounds." : "Bounds are not exact.";
    }
  }
  return NULL;
}

static const char *check_orders(const pktrt__node *node) {
  for (int octant = 0; octant < 8; octant++) {
    uint32_t perm = node->order[octant], seen = 0;
    for (int i = 0; i < 8; i++) seen |= 1u << (perm >> 3 * i & 7);
    if (seen != 255 || perm >> 24) return "An order of children is no permutation.";
  }
  return NULL;
}

/* Each triangle, node and block once: by number and by the sums of mixed indices. */
static const char *check_tree(const pktrt__bvh *bvh, const pktrt__mesh *meshes, uint32_t mesh_count) {
  struct {
    uint32_t node, depth;
  } stack[PKTRT__STACK];
  uint64_t nodes = 0, blocks = 0, tris = 0, nodes_set = 0, blocks_set = 0, tris_set = 0;
  uint32_t top = 0;
  const char *wrong = NULL;
  const bool split = is_split(bvh);
  stack[top].node = 0, stack[top++].depth = 0;
  while (top) {
    uint32_t n = stack[--top].node, depth = stack[top].depth, used = 0;
    pktrt__node *node = pktrt__bvh_node(bvh, n);
    nodes++, nodes_set += pktrt__hash(n);
    if (nodes > bvh->node_count) return "A node has two parents.";
    wrong = check_orders(node);
    for (int c = 0; c < 8 && !wrong; c++) {
      uint32_t ref = node->child[c];
      bool leaf = (ref & PKTRT__LEAF) != 0;
      used += ref != PKTRT__EMPTY;
      if (ref != PKTRT__EMPTY) {
        if (depth + 1 > PKTRT__MAX_DEPTH) return "The tree is too deep.";
        if (leaf && (ref & ~PKTRT__LEAF) >= bvh->block_count) return "A child is no block.";
        if (!leaf && (ref <= n || ref >= bvh->node_count)) return "A child does not follow its parent.";
        if (!leaf) stack[top].node = ref, stack[top++].depth = depth + 1;
        if (leaf) wrong = check_block(bvh, ref & ~PKTRT__LEAF, meshes, mesh_count, &tris_set, &tris);
        if (leaf) blocks++, blocks_set += pktrt__hash(ref & ~PKTRT__LEAF);
      }
      if (!wrong) wrong = check_child(bvh, node, c, split);
    }
    if (wrong) return wrong;
    if (!used) return "A node has no child.";
  }
  for (uint32_t i = 0; i < bvh->node_count; i++) nodes--, nodes_set -= pktrt__hash(i);
  for (uint32_t i = 0; i < bvh->block_count; i++) blocks--, blocks_set -= pktrt__hash(i);
  for (uint32_t i = 0; i < mesh_count; i++) {
    for (uint32_t t = 0; meshes[i].key_count == bvh->key_count && t < meshes[i].triangle_count; t++) {
      tris--, tris_set -= pktrt__hash((uint64_t)meshes[i].first_id + t);
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
    const pktrt__bvh *x = &s->bvhs[g];
    leaf_box *box = calloc((size_t)x->block_count * 8, sizeof *box);
    size_t n = 0;
    if (!box) abort();
    for (uint32_t i = 0; i < x->node_count * 8; i++) {
      pktrt__node *node = pktrt__bvh_node(x, i / 8);
      const uint32_t ref = node->child[i % 8];
      for (uint32_t l = 0; l < 8 && ref != PKTRT__EMPTY && ref & PKTRT__LEAF; l++) {
        const uint32_t id = pktrt__bvh_block(x, ref & ~PKTRT__LEAF)->id[l];
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
      const uint32_t m = pktrt__mesh_of_triangle(s->meshes, s->mesh_count, box[i].id, 0);
      float v[3][3];
      for (end = i + 1; end < n && box[end].id == box[i].id;) end++;
      pktrt__mesh_triangle(&s->meshes[m], false, box[i].id - s->meshes[m].first_id, 0, v);
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
      again += s->bvhs[g].block_triangles[i] != PKTRT_NONE && s->bvhs[g].block_triangles[i] & PKTRT__AGAIN;
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

static void box_grow_by_block(float box[6], const pktrt_scene *s, const pktrt__bvh *g, uint32_t block, const world *w,
                              uint32_t key) {
  const uint32_t *id = g->block_triangles + (size_t)block * 8;
  for (uint32_t l = 0, m = 0; l < 8 && id[l] != PKTRT_NONE; l++) {
    const uint32_t which = id[l] & ~PKTRT__AGAIN;
    while (which < s->meshes[m].first_id || which - s->meshes[m].first_id >= w->m[m].nt) m = (m + 1) % w->n;
    const mesh *from = &w->m[m];
    for (uint32_t c = 0; c < 3; c++) {
      const uint32_t vertex = from->i[3 * (which - s->meshes[m].first_id) + c];
      const float *p = from->p + 3 * ((size_t)key * from->nv + vertex);
      box_grow(box, (float[6]){p[0], p[0], p[1], p[1], p[2], p[2]});
    }
  }
}

static uint64_t group_bounds_off(const pktrt_scene *s, const pktrt__bvh *g, const world *w, uint64_t *compared) {
  static const float none[6] = {PKTRT__FAR, -PKTRT__FAR, PKTRT__FAR, -PKTRT__FAR, PKTRT__FAR, -PKTRT__FAR};
  uint64_t off = 0;
  float(*whole)[6] = calloc((size_t)g->node_count * g->key_count, sizeof *whole), all[6];
  if (!whole) abort();
  memcpy(all, none, sizeof all);
  for (uint32_t i = g->node_count * g->key_count; i-- > 0;) { /* children come after their parents */
    const uint32_t n = i / g->key_count, key = i % g->key_count;
    pktrt__node *node = pktrt__bvh_node(g, n);
    memcpy(whole[i], none, sizeof none);
    for (int c = 0; c < 8; c++) {
      const uint32_t ref = node->child[c];
      float want[6];
      memcpy(want, none, sizeof none);
      if (ref != PKTRT__EMPTY && ref & PKTRT__LEAF) box_grow_by_block(want, s, g, ref & ~PKTRT__LEAF, w, key);
      else if (ref != PKTRT__EMPTY) memcpy(want, whole[(size_t)ref * g->key_count + key], sizeof want);
      for (int p = 0; p < 6; p++) off += pktrt__node_planes(node, key)[8 * p + c] != want[p];
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
    const pktrt__bvh *g = &s->bvhs[i];
    uint32_t *depth = calloc(g->node_count, sizeof *depth);
    if (!depth) abort();
    for (uint32_t n = 0; n < g->node_count; n++) {
      const uint32_t *child = pktrt__bvh_node(g, n)->child;
      for (int c = 0; c < 8; c++)
        if (child[c] != PKTRT__EMPTY && !(child[c] & PKTRT__LEAF)) depth[child[c]] = depth[n] + 1;
      if (depth[n] + 1 > most) most = depth[n] + 1;
    }
    free(depth);
  }
  return most;
}

bool tree_lane(const pktrt_scene *s, uint32_t group, uint32_t block, uint32_t lane, uint32_t *of, uint32_t *triangle) {
  const pktrt__bvh *g = &s->bvhs[group];
  if (block >= g->block_count || lane >= 8) return false;
  const uint32_t kept = g->block_triangles[(size_t)block * 8 + lane], id = kept & ~PKTRT__AGAIN;
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
static void work_of_node(const pktrt__bvh *g, uint32_t n, const pktrt_ray *r, double margin, tree_work *w) {
  pktrt__node *node = pktrt__bvh_node(g, n);
  float ta, tb;
  const uint32_t key = pktrt__time_segment(r->time, g->key_count, &ta, &tb), next = g->key_count > 1 ? key + 1 : key;
  const float *k0 = pktrt__node_planes(node, key), *k1 = pktrt__node_planes(node, next);
  w->nodes++;
  for (uint32_t c = 0; c < 8; c++) {
    const uint32_t ref = node->child[c];
    double lo[3], hi[3];
    if (ref == PKTRT__EMPTY) continue;
    w->boxes++;
    for (uint32_t a = 0; a < 3; a++) {
      lo[a] = (double)ta * (double)k0[16 * a + c] + (double)tb * (double)k1[16 * a + c];
      hi[a] = (double)ta * (double)k0[16 * a + 8 + c] + (double)tb * (double)k1[16 * a + 8 + c];
    }
    if (!work_meets(r, lo, hi, margin, w)) continue;
    if (!(ref & PKTRT__LEAF)) work_of_node(g, ref, r, margin, w);
    const uint32_t *id = pktrt__bvh_block(g, ref & ~PKTRT__LEAF)->id;
    for (uint32_t l = 0; ref & PKTRT__LEAF && l < 8; l++) w->triangles += id[l] != PKTRT_NONE;
  }
}

tree_work tree_work_of(const pktrt_scene *s, const pktrt_ray *r, bool ask_groups) {
  tree_work w = {0, 0, 0, false};
  double largest = 0;
  for (int a = 0; a < 3; a++)
    largest = fmax(largest, fmax(fabs((double)r->origin[a]), fmax(fabs((double)s->lo[a]), fabs((double)s->hi[a]))));
  for (uint32_t i = 0; i < s->bvh_count; i++) {
    const pktrt__bvh *g = &s->bvhs[i];
    double lo[3], hi[3];
    for (int a = 0; a < 3; a++) lo[a] = (double)g->lo[a], hi[a] = (double)g->hi[a];
    if (ask_groups && g->key_count > 1 && !work_meets(r, lo, hi, 1e-5 * largest, &w)) continue;
    work_of_node(g, 0, r, 1e-5 * largest, &w);
  }
  return w;
}

uint32_t tree_groups(const pktrt_scene *s) { return s->bvh_count; }

uint32_t tree_children(const pktrt_scene *s, uint32_t group, uint32_t node) {
  const pktrt__bvh *g = &s->bvhs[group];
  uint32_t there = 0;
  if (node >= g->node_count) return 0;
  const uint32_t *child = pktrt__bvh_node(g, node)->child;
  for (uint32_t c = 0; c < 8; c++)
    if (child[c] != PKTRT__EMPTY) there |= 1u << c;
  return there;
}

void tree_asked_by(pktrt_scene *s, pktrt_isa isa) { s->kernels = pktrt__kernels_of(isa); }

static bool same_trees(const pktrt_scene *a, const pktrt_scene *b) {
  if (a->bvh_count != b->bvh_count) return false;
  for (uint32_t g = 0; g < a->bvh_count; g++) {
    const pktrt__bvh *x = &a->bvhs[g], *y = &b->bvhs[g];
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
    pktrt__bvh *x = &s->bvhs[g];
    for (uint32_t i = 0; i < 200; i++) {
      rng r = rng_of(i);
      uint32_t node = rng_below(&r, x->node_count), lane = rng_below(&r, 8), plane = rng_below(&r, 6),
               key = rng_below(&r, x->key_count);
      unsigned char *bytes = x->nodes + (size_t)node * x->node_bytes;
      uint32_t child;
      memcpy(&child, bytes + 192 + 4 * lane, 4);
      if (child == PKTRT__EMPTY) continue;
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

/* --- what comments promise of the inside --- */

bool has_frusta(pktrt_isa isa) {
  if (isa == PKTRT_ISA_AUTO) isa = isas[isa_count - 1];
#if defined(PKTRT_NO_FRUSTA)
  return false;
#elif defined(PKTRT__HAS_AVX2)
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
  CHECK((int)PKTRT__STACK >= (int)PKTRT__MAX_DEPTH * (8 - 1) + 1, "%d entries", (int)PKTRT__STACK);
}

/* What boxes are asked with, of a ray by itself and of the same ray in a batch: bounds of distances from scenes that lie to
   one side, along each axis in turn. */
#define SETUP_OF(set, target)                                                                               \
  target static void setup_by_##set(const pktrt_scene *s, const pktrt_ray *ray) {                           \
    static pktrt__batch b;                                                                                  \
    pktrt__single q;                                                                                        \
    memset(&q, 0, sizeof q);                                                                                \
    pktrt__batch_load_rest(&b, ray, NULL, 0, 1), pktrt__batch_pad(&b, 1);                                   \
    CHECK(pktrt__batch_setup_##set(s, &b, 0) & 1, #set);                                                    \
    CHECK(pktrt__single_setup_##set(s, ray, &q), #set);                                                     \
    CHECK(b.pad[0] == q.pad, #set ": %g and %g", (double)b.pad[0], (double)q.pad);                          \
    CHECK(b.wf[0] == q.wf && b.wn[0] == q.wn, #set);                                                        \
    for (int a = 0; a < 3; a++)                                                                             \
      CHECK(b.rd[a][0] == q.rd[a] && b.as.slab.cn[a][0] == q.cn[a] && b.as.slab.cf[a][0] == q.cf[a], #set); \
  }
#ifdef PKTRT__HAS_SCALAR
SETUP_OF(scalar, )
#endif
#ifdef PKTRT__HAS_SSE2
SETUP_OF(sse2, )
#endif
#ifdef PKTRT__HAS_AVX2
SETUP_OF(avx2, __attribute__((__target__("avx2,fma,bmi,bmi2,popcnt"))))
#endif
#ifdef PKTRT__HAS_NEON
SETUP_OF(neon, )
#endif
#ifdef PKTRT__HAS_WASM
SETUP_OF(wasm, )
#endif
static void setups_agree(void) {
  for (int axis = 0; axis < 6; axis++) {
    mesh m = mesh_sphere(2, 0, 1);
    mesh_shift(&m, axis == 0 || axis == 1 ? 64.0f : 0, axis == 2 || axis == 3 ? 64.0f : 0, axis > 3 ? 64.0f : 0);
    pktrt_scene *s = pktrt_scene_create(NULL);
    const pktrt_mesh_desc d = mesh_desc(&m);
    CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
    for (int i = 0; i < 6; i++) {
      const float side = axis & 1 ? 128.0f : -0.5f, o[3] = {side, side + 0.25f, side - 0.125f};
      float way[3] = {0.3f, 0.4f, 0.5f};
      way[i % 3] = i & 1 ? -2.0f : 3.0f;
      const pktrt_ray ray = pktrt_make_ray(o, way);
#ifdef PKTRT__HAS_SCALAR
      setup_by_scalar(s, &ray);
#endif
#ifdef PKTRT__HAS_SSE2
      setup_by_sse2(s, &ray);
#endif
#ifdef PKTRT__HAS_AVX2
      if (pktrt_isa_available(PKTRT_ISA_AVX2)) setup_by_avx2(s, &ray);
#endif
#ifdef PKTRT__HAS_NEON
      setup_by_neon(s, &ray);
#endif
#ifdef PKTRT__HAS_WASM
      setup_by_wasm(s, &ray);
#endif
    }
    pktrt_scene_destroy(s);
    mesh_free(&m);
  }
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
    worst[EXP] = fmax(worst[EXP], fabs(pktrt__math_exp(e) / exp(e) - 1));
    worst[LOG] = fmax(worst[LOG], fabs(pktrt__math_log(wide) / log(wide) - 1));
    if (tiny > 0 && tiny < 1) {
      worst[LOG1M] = fmax(worst[LOG1M], fabs(pktrt__math_log1m(tiny) / log1p(-tiny) - 1));
      worst[EXPM1] = fmax(worst[EXPM1], fabs(pktrt__math_expm1(-tiny) / expm1(-tiny) - 1));
    }
    pktrt__math_sincos_turn(x * 0.25, &sine, &cosine); /* libm's argument errs by what is at most pi / 2 steps */
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

void suite_tree(void) {
  run("trees of all qualities are sound", structure);
  run("stable: the tree checker sees bounds that are one ulp off", checker_sees);
  run("triangles that have area only between their keys are built, refitted and hit there", flat_between_keys);
  run("the high quality has a cheaper tree", high_quality);
  run("one, two and seven workers build and refit the same tree", workers);
  run("a commit leaves the trees of unchanged groups alone", one_mesh_only);
  run("each rebuild policy does what it says", rebuild_policies);
  run("a rebuild is advised, or made, from 1.5 times the cost on", rebuild_threshold);
  run("geometric series build a tree of bounded depth", deep_input);
  run("without hooks, memory is aligned, too", aligned_by_default);
  run("the stack of a walk holds what the deepest tree can leave there", stacks_suffice);
  run("a ray is asked with by itself as in a batch", setups_agree);
  run("exp, log, sine and cosine err by as little as they say", series);
}
