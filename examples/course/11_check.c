/* Checks exercise 11: directions and shares are the exact ones, and the picture is the library's. Makes
   out/course/11_mine.png.    make course-check N=11 FILE=mine_11.c */
#define COURSE_CHECK
#include "11_picture.c" /* the tracer, which calls the answer */

typedef uint32_t scatter(const picture_material *, vec, vec, picture_way *);

enum { CASES = 20000 };
typedef enum mistake { NUMBER, TYPE, REFLECTED, REFRACTED, SCHLICK, SHARE, MISTAKES } mistake;

typedef struct verdict {
  uint32_t cases[2], wrong[MISTAKES][2]; /* [1]: the ray was inside the body */
  bool too_many;                         /* more ways than there is room for */
} verdict;

typedef struct exact_ways {
  uint32_t ways;
  double reflected[3], refracted[3], share[2];
  bool unclear; /* so near the critical angle that rounding decides */
} exact_ways;

/* Returns a direction, all equally likely but for rounding. */
static vec random_unit(uint32_t *random) {
  for (;;) {
    vec asked;
    for (int a = 0; a < 3; a++) asked.at[a] = 2 * course_random(random) - 1;
    const float squared = vec_dot(asked, asked);
    if (squared > 0.01f && squared < 1) return vec_unit(asked);
  }
}

/* Returns the ways on, computed in double. */
static exact_ways find_exact(const picture_material *material, vec direction, vec normal) {
  exact_ways exact;
  double dot = 0;
  memset(&exact, 0, sizeof exact);

  for (int a = 0; a < 3; a++) dot += (double)direction.at[a] * (double)normal.at[a];
  const double side = dot > 0 ? -1 : 1; /* -1: the ray is inside */
  const double cosine = fabs(dot);
  const double ior = material->ior > 0 ? (double)material->ior : 1;
  const double eta = side > 0 ? ior : 1 / ior;
  const double square = 1 - (1 - cosine * cosine) / (eta * eta);
  const double behind = sqrt(fmax(0, square));

  for (int a = 0; a < 3; a++) {
    const double facing = side * (double)normal.at[a];
    exact.reflected[a] = (double)direction.at[a] + 2 * cosine * facing;
    exact.refracted[a] = (double)direction.at[a] / eta + (cosine / eta - behind) * facing;
  }

  exact.ways = material->mirror > 0 ? 1 : 0;
  exact.share[0] = (double)material->mirror;
  if (material->ior <= 0) return exact;
  exact.unclear = fabs(square) < 1e-3;
  exact.ways = square > 0 ? 2 : 1;
  const double s = (cosine - eta * behind) / (cosine + eta * behind);
  const double p = (eta * cosine - behind) / (eta * cosine + behind);
  exact.share[0] = square > 0 ? (s * s + p * p) / 2 : 1;
  exact.share[1] = 1 - exact.share[0];
  return exact;
}

/* Returns true if a direction is the expected one, up to rounding. */
static bool same_direction(vec mine, const double exact[3]) {
  double squared = 0;
  for (int a = 0; a < 3; a++) squared += ((double)mine.at[a] - exact[a]) * ((double)mine.at[a] - exact[a]);
  return squared < 1e-8;
}

/* Returns the first mistake in an answer, MISTAKES if there is none. */
static mistake find_mistake(const exact_ways *exact, uint32_t ways, const picture_way *way, float ior, double cosine) {
  const pktrt_ray_type type[2] = {PKTRT_RAY_REFLECTION, PKTRT_RAY_REFRACTION};
  if (ways != exact->ways) return NUMBER;
  for (uint32_t k = 0; k < ways; k++)
    if (way[k].type != type[k]) return TYPE;
  if (ways > 0 && !same_direction(way[0].direction, exact->reflected)) return REFLECTED;
  if (ways > 1 && !same_direction(way[1].direction, exact->refracted)) return REFRACTED;

  for (uint32_t k = 0; k < ways; k++) {
    if (fabs((double)way[k].share - exact->share[k]) < 1e-4) continue;
    const double r = ((double)ior - 1) / ((double)ior + 1);
    const double schlick = r * r + (1 - r * r) * pow(1 - cosine, 5);
    return k == 0 && ior > 0 && fabs((double)way[0].share - schlick) < 1e-4 ? SCHLICK : SHARE;
  }
  return MISTAKES;
}

/* Prints one way. */
static void say_way(const char *who, const char *type, const double d[3], double share) {
  printf("  %s: %s along (%.6f, %.6f, %.6f), share %.6f\n", who, type, d[0], d[1], d[2], share);
}

/* Prints a case with what was expected and what came. */
static void say_case(uint32_t number, const picture_material *material, vec d, vec n, const exact_ways *exact,
    uint32_t ways, const picture_way *way) {
  printf("ray %u: material ", (unsigned)number);
  if (material->ior > 0) printf("glass of index %.3f", (double)material->ior);
  else printf(material->mirror > 0 ? "mirror that reflects %.3f" : "matte", (double)material->mirror);
  printf("; the ray comes from %s\n", vec_dot(d, n) > 0 ? "inside" : "outside");
  printf("  direction (%.6f, %.6f, %.6f), normal (%.6f, %.6f, %.6f)\n", (double)d.at[0], (double)d.at[1],
      (double)d.at[2], (double)n.at[0], (double)n.at[1], (double)n.at[2]);
  printf("  expected: ways %u, got: %u\n", (unsigned)exact->ways, (unsigned)ways);

  if (exact->ways > 0) say_way("expected", "reflection", exact->reflected, exact->share[0]);
  if (exact->ways > 1) say_way("expected", "refraction", exact->refracted, exact->share[1]);
  for (uint32_t k = 0; k < ways && k < 2; k++) {
    const double got[3] = {
        (double)way[k].direction.at[0], (double)way[k].direction.at[1], (double)way[k].direction.at[2]};
    const char *type = way[k].type == PKTRT_RAY_REFLECTION   ? "reflection"
                       : way[k].type == PKTRT_RAY_REFRACTION ? "refraction"
                                                             : "another type of ray";
    say_way("got", type, got, (double)way[k].share);
  }
}

/* Asks an answer about mirrors, glass and matte surfaces. Says what differs first if `aloud`. */
static verdict ask(scatter *answer, bool aloud) {
  verdict asked;
  uint32_t random = 11;
  bool said = false;
  memset(&asked, 0, sizeof asked);

  for (uint32_t i = 0; i < CASES; i++) {
    picture_material material;
    memset(&material, 0, sizeof material);
    if (i % 8 == 0) material.mirror = 0.2f + 0.8f * course_random(&random);
    else if (i % 8 == 1) material.albedo = vec_make(0.5f, 0.5f, 0.5f);
    else material.ior = i % 8 == 2 ? 1.5f : i % 8 == 3 ? 0.75f : 1.1f + course_random(&random);

    const vec normal = random_unit(&random);
    const vec direction = random_unit(&random);
    const exact_ways exact = find_exact(&material, direction, normal);
    if (exact.unclear) continue;

    picture_way way[2];
    memset(way, 0, sizeof way);
    const uint32_t ways = answer(&material, direction, normal, way);
    const int inside = vec_dot(direction, normal) > 0;
    const mistake what = find_mistake(&exact, ways, way, material.ior, fabs((double)vec_dot(direction, normal)));

    asked.cases[inside]++;
    asked.too_many = asked.too_many || ways > 2;
    if (what == MISTAKES) continue;
    asked.wrong[what][inside]++;
    if (aloud && !said) say_case(i, &material, direction, normal, &exact, ways, way);
    said = true;
  }
  return asked;
}

/* Returns a sentence on the mistakes, NULL if there are none. */
static const char *reason(const verdict *asked) {
  static const char *const sentence[MISTAKES] = {
      "the number of ways is wrong: matte 0, mirror 1, glass 2, but beyond the critical angle 1",
      "a way has the wrong type: reflection comes first, then refraction",
      "a reflected direction is wrong",
      "a refracted direction is wrong",
      "shares are those of Schlick's formula; the exact reflectance is asked for",
      "a share is wrong",
  };
  uint32_t wrong[2] = {0, 0};

  for (int k = 0; k < MISTAKES; k++)
    for (int inside = 0; inside < 2; inside++) wrong[inside] += asked->wrong[k][inside];
  if (wrong[1] > 0 && wrong[0] == 0)
    return "rays from outside are right, rays from inside are not: mind the side of the normal, and which index is "
           "behind "
           "the surface";
  for (int k = 0; k < MISTAKES; k++)
    if (asked->wrong[k][0] + asked->wrong[k][1] > 0) return sentence[k];
  return NULL;
}

/* A control: takes every ray for one from outside, so it never finds a total reflection. */
static uint32_t careless_scatter(const picture_material *material, vec d, vec n, picture_way way[2]) {
  const float cosine = fabsf(vec_dot(d, n));
  const vec facing = vec_scale(n, vec_dot(d, n) > 0 ? -1 : 1);
  if (material->mirror <= 0 && material->ior <= 0) return 0;
  way[0].type = PKTRT_RAY_REFLECTION;
  way[0].direction = vec_add(d, vec_scale(facing, 2 * cosine));
  way[0].share = material->mirror > 0 ? material->mirror : pktrt_fresnel_dielectric(cosine, material->ior);
  if (material->ior <= 0) return 1;
  const float behind = sqrtf(fmaxf(0, 1 - (1 - cosine * cosine) / (material->ior * material->ior)));
  way[1].type = PKTRT_RAY_REFRACTION;
  way[1].direction = vec_add(vec_scale(d, 1 / material->ior), vec_scale(facing, cosine / material->ior - behind));
  way[1].share = 1 - way[0].share;
  return 2;
}

/* Checks single rays, then the picture. */
int main(void) {
  const limits usual = {1.0f / 256, 50};
  const limits shallow = {1.0f / 256, 5}; /* of a wrong answer, whose shares may never fall; also the control */
  const uint32_t most = WIDTH * HEIGHT / 200;
  course_check_begins(11);

  const verdict careless = ask(careless_scatter, false);
  const verdict mine = ask(picture_scatter, true);
  const char *why = reason(&mine);
  printf("rays from outside %u, from inside %u; wrong answers for rays from outside and inside:\n ",
      (unsigned)mine.cases[0], (unsigned)mine.cases[1]);

  static const char *const name[MISTAKES] = {
      "number of ways", "type", "reflected direction", "refracted direction", "Schlick's share", "share"};
  for (int k = 0; k < MISTAKES; k++)
    printf("%s %s %u, %u", k ? ";" : "", name[k], (unsigned)mine.wrong[k][0], (unsigned)mine.wrong[k][1]);
  printf("\ncontrol: an answer that takes every ray for one from outside is wrong for %u rays from inside\n",
      (unsigned)(careless.wrong[NUMBER][1] + careless.wrong[REFRACTED][1]));
  course_figure("cases", "%d", CASES);
  course_figure("shallow", "%u", (unsigned)shallow.depth);
  if (!reason(&careless)) return course_result(11, "the control passes");
  if (mine.too_many) return course_result(11, why);

  picture_scene scene = picture_make();
  pktrt_scene *library = picture_library(&scene);
  course_picture theirs = course_picture_make(WIDTH, HEIGHT);
  course_picture cut = course_picture_make(WIDTH, HEIGHT);
  const course_picture picture = make_picture(&scene, why ? shallow : usual);
  picture_render(&scene, library, &theirs, usual.cutoff, usual.depth, NULL);
  picture_render(&scene, library, &cut, usual.cutoff, shallow.depth, NULL);
  course_picture_write(&picture, "out/course/11_mine.png");
  pktrt_scene_destroy(library);

  const uint32_t apart = record_count_apart(&picture, why ? &cut : &theirs, 0.01f);
  const uint32_t control = record_count_apart(&cut, &theirs, 0.01f);
  printf("out/course/11_mine.png: %u of %u pixels differ from the library's picture by more than 0.01 (at most %u)\n",
      (unsigned)apart, WIDTH * HEIGHT, (unsigned)most);
  printf("control: %u pixels differ where rays end after %u surfaces\n", (unsigned)control, (unsigned)shallow.depth);
  if (!why && control <= most) why = "the control passes: too few pixels show deep rays";
  if (!why && apart > most) why = "single rays are right, but the picture is not the library's";
  return course_result(11, why);
}
