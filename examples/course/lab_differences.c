/* Why pictures differ: fused multiply-adds, the order of sums, and what a renderer must do to give the same bits.

   Prints how often each of them changes a result, and makes out/course/lab_differences.png. */
#define PKTRT_IMPLEMENTATION
#include "course.h"

enum { WIDTH = 96, ZOOM = 3, PLACES = WIDTH / ZOOM, LARGER = 3, TERMS = 1 << 20, BLOCKS = 64 };
static course_picture picture; /* four panels side by side */
static course_scene shape;

/* [edge] */
/* On which side of the edge from a to b the ray lies, which is the origin here: the sign of a_x b_y - a_y b_x. */
static float edge_plain(const float a[2], const float b[2]) {
  const float left = a[0] * b[1], right = a[1] * b[0]; /* both are rounded, alike for (a, b) and (b, a) */
  return left - right;
}
static float edge_fused(const float a[2], const float b[2]) {
  const float right = a[1] * b[0];
  return fmaf(a[0], b[1], -right); /* one product is rounded, the other is not */
}
static double edge_exact(const float a[2], const float b[2]) {
  return (double)a[0] * b[1] - (double)a[1] * b[0]; /* products of floats are exact in double: so is the sign */
}
/* [end] */

static int sign(double x) { return (x > 0) - (x < 0); }

/* Moves one end of an edge that passes close to the ray, by units in its last place. */
static void edges(void) {
  static const vec colors[3] = {{{0.1f, 0.25f, 0.7f}}, {{0.8f, 0.8f, 0.8f}}, {{0.9f, 0.5f, 0.1f}}};
  unsigned differ = 0, wrong_plain = 0, wrong_fused = 0, torn_plain = 0, torn_fused = 0;
  for (int i = 0; i < PLACES * PLACES; i++) {
    const int x = i % PLACES, y = i / PLACES;
    const float unit = 1.0f / (1 << 24), b[2] = {-0.9f, -1.2f};
    const float a[2] = {0.6f + (float)(x - PLACES / 2) * unit, 0.8f + (float)(PLACES / 2 - y) * unit};
    const int plain = sign(edge_plain(a, b)), fused = sign(edge_fused(a, b)), exact = sign(edge_exact(a, b));
    differ += plain != fused, wrong_plain += plain != exact, wrong_fused += fused != exact;
    /* The triangle on the other side has the same edge from b to a, and must see the ray on the other side. */
    torn_plain += plain != -sign(edge_plain(b, a)), torn_fused += fused != -sign(edge_fused(b, a));
    for (int k = 0; k < ZOOM * ZOOM; k++) {
      vec *pixel = picture.pixel + (y * ZOOM + k / ZOOM) * 4 * WIDTH + x * ZOOM + k % ZOOM;
      pixel[0] = colors[exact + 1], pixel[WIDTH] = colors[plain + 1], pixel[2 * WIDTH] = colors[fused + 1];
    }
  }
  printf("edge function at %d places: signs that differ with a fused multiply-add: %u\n", PLACES * PLACES, differ);
  printf("  signs that are not the exact one: plain %u, fused %u\n", wrong_plain, wrong_fused);
  printf("  seen differently by the two triangles at the edge: plain %u, fused %u\n", torn_plain, torn_fused);
  course_figure("signs", "%d", PLACES * PLACES);
  course_figure("signs.differ", "%u", differ);
  course_figure("signs.wrong.plain", "%u", wrong_plain);
  course_figure("signs.wrong.fused", "%u", wrong_fused);
  course_figure("signs.torn", "%u", torn_fused);
}

/* [sums] */
/* Workers take pieces in turn, and each piece is summed by one of them; its totals are added in the order of the pieces,
   whoever had them. */
static float sum_in_pieces(const float *terms, int n, int pieces, int workers) {
  float totals[BLOCKS] = {0}, total = 0;
  for (int w = 0; w < workers; w++)
    for (int p = w; p < pieces; p += workers)
      for (int i = (int)((int64_t)n * p / pieces); i < (int64_t)n * (p + 1) / pieces; i++) totals[p] += terms[i];
  for (int p = 0; p < pieces; p++) total += totals[p];
  return total;
}
/* [end] */

static void sums(void) {
  static float terms[TERMS];
  for (int i = 0; i < TERMS; i++) terms[i] = 1.0f / (float)(i % 1000 + 1);

  for (int n = 1; n <= 7; n += n < 4 ? n : 3) {
    const double each = (double)sum_in_pieces(terms, TERMS, n, n);
    const double fixed = (double)sum_in_pieces(terms, TERMS, BLOCKS, n);
    char name[32];
    printf("sum of %d floats by %d workers: a piece each %.3f, %d pieces %.3f\n", TERMS, n, each, BLOCKS, fixed);
    snprintf(name, sizeof name, "sum.%d", n);
    course_figure(name, "%.3f", each);
    if (n == 7) course_figure("sum.fixed", "%.3f", fixed);
  }

  course_figure("terms", "%d", TERMS);
  course_figure("pieces", "%d", BLOCKS);
}

/* [backwards] */
/* A parallel_for without threads that takes the pieces in an order which threads might take, too: from the last on. */
static void backwards(void *user, size_t n, void (*body)(void *arg, size_t i), void *arg) {
  (void)user;
  while (n > 0) body(arg, --n);
}
/* [end] */

/* Renders the scene under three lamps, which are added from number `first` on. */
static void render(pktrt_isa isa, int first, bool last_piece_first, pktrt_render_desc *view) {
  static const float lamps[3][6] = {{-3, 6, 1, 90, 24, 9}, {2, 5, 4, 21, 60, 27}, {1, 7, -2, 9, 27, 120}};
  const pktrt_scene_desc desc = {.isa = isa, .parallel_for = last_piece_first ? backwards : NULL};
  const pktrt_mesh_desc mesh = {.positions = shape.position[0].at,
      .vertex_count = shape.vertices,
      .indices = shape.corner[0],
      .triangle_count = shape.triangles};
  pktrt_scene *scene = pktrt_scene_create(&desc);
  bool ok = scene && !pktrt_add_mesh(scene, &mesh, NULL);
  for (int i = 0; ok && i < 3; i++) {
    pktrt_light light = {0};
    const float *lamp = lamps[(first + i) % 3];
    memcpy(light.position, lamp, sizeof light.position), memcpy(light.intensity, lamp + 3, sizeof light.intensity);
    ok = !pktrt_add_light(scene, &light, NULL);
  }
  const pktrt_camera camera = {
      .eye = {2.7f, 4.1f, 7.3f}, .target = {0.1f, 1.2f, -0.1f}, .fov_y = 39.6f, .aperture = 0.1f};
  view->width = view->height = WIDTH, view->mode = PKTRT_MODE_DRT, view->samples = 1, view->camera = camera;
  if (!ok || pktrt_commit(scene) || pktrt_render(scene, view)) ex_fail("%s", pktrt_last_error(scene)), exit(1);
  pktrt_scene_destroy(scene);
}

/* Adds the same lamps in two orders: each pixel is then the sum of the same numbers in two orders. */
static void lamps(void) {
  static vec pixels[2][WIDTH * WIDTH];
  unsigned differ = 0;
  for (int first = 0; first < 2; first++) {
    pktrt_render_desc view = {.pixels = pixels[first][0].at};
    render(PKTRT_ISA_AUTO, first, false, &view);
  }
  for (int i = 0; i < WIDTH * WIDTH; i++) {
    const bool same = !memcmp(&pixels[0][i], &pixels[1][i], sizeof(vec));
    differ += !same;
    picture.pixel[i / WIDTH * 4 * WIDTH + 3 * WIDTH + i % WIDTH] =
        same ? vec_scale(pixels[0][i], 0.3f) : vec_make(1, 1, 1);
  }
  printf("lamps added in two orders: %u of %d pixels differ\n", differ, WIDTH * WIDTH);
  course_figure("pixels.differ", "%u", differ);
  course_figure("pixels", "%d", WIDTH * WIDTH);
}

/* Renders one picture in all ways that shall not matter, and sums up all bits of it. */
static void promises(void) {
  static float pixels[WIDTH * WIDTH * 3];
  static uint32_t bits[WIDTH * WIDTH * 3];
  uint64_t first = 0;
  unsigned pictures = 0, others = 0;
  for (int isa = PKTRT_ISA_SCALAR; isa < PKTRT_ISA_COUNT; isa++) {
    if (!pktrt_isa_available((pktrt_isa)isa)) continue;
    for (int way = 0; way < 24; way++) {
      pktrt_render_desc view = {.pixels = pixels,
          .path = (pktrt_path)(way % 3),
          .packet_size = way / 3 % 2 ? 16 : 2,
          .tile_size = way / 6 % 2 ? 64 : 7};
      render((pktrt_isa)isa, 0, way / 12 != 0, &view);
      uint64_t sum = 14695981039346656037u; /* FNV-1a, by words */
      memcpy(bits, pixels, sizeof bits);
      for (int i = 0; i < WIDTH * WIDTH * 3; i++) sum = (sum ^ bits[i]) * 1099511628211u;
      if (pictures++ == 0) first = sum;
      others += sum != first;
    }
    printf("%s: after %u pictures %u are other than the first, whose checksum is %016llx\n",
        pktrt_isa_string((pktrt_isa)isa), pictures, others, (unsigned long long)first);
  }
}

int main(void) {
  picture = course_picture_make(4 * WIDTH, WIDTH), shape = course_scene_make();
  edges(), sums(), lamps(), promises();
  course_picture large = course_picture_make(LARGER * 4 * WIDTH, LARGER * WIDTH);
  for (int i = 0; i < LARGER * 4 * WIDTH * LARGER * WIDTH; i++)
    large.pixel[i] = picture.pixel[i / (LARGER * 4 * WIDTH) / LARGER * 4 * WIDTH + i % (LARGER * 4 * WIDTH) / LARGER];
  return course_picture_write(&large, "out/course/lab_differences.png"), 0;
}
