/* Small stages for pictures: quads, materials, lights and a camera on one spot; means of pictures with their standard
   errors; the closed forms that several suites compare with. */
#ifndef PKTRT_TEST_PICTURES_H
#define PKTRT_TEST_PICTURES_H
#include "meshes.h"

#define PI 3.14159265358979323846

/* --- vectors in double --- */
typedef struct vec {
  double x, y, z;
} vec;
static inline vec vec_of(double x, double y, double z) { return (vec){x, y, z}; }
static inline vec vec_from(const float f[3]) { return (vec){(double)f[0], (double)f[1], (double)f[2]}; }
static inline vec vec_add(vec a, vec b) { return (vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline vec vec_sub(vec a, vec b) { return (vec){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline vec vec_mul(vec a, double f) { return (vec){a.x * f, a.y * f, a.z * f}; }
static inline double vec_dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline double vec_length(vec a) { return sqrt(vec_dot(a, a)); }
static inline vec vec_unit(vec a) { return vec_mul(a, 1 / vec_length(a)); }
static inline vec vec_cross(vec a, vec b) {
  return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline void vec_put(vec a, float out[3]) { out[0] = (float)a.x, out[1] = (float)a.y, out[2] = (float)a.z; }

/* --- stages --- */
typedef struct quad { /* a parallelogram, counter-clockwise from the side of cross(edge[0], edge[1]) */
  vec corner, edge[2];
} quad;
quad quad_of(vec middle, vec half0, vec half1);
quad quad_flipped(quad);
vec quad_at(const quad *, double a, double b);

pktrt_scene *stage_open(void);
void stage_commit(pktrt_scene *);
uint32_t stage_material(pktrt_scene *, const pktrt_material *);
uint32_t stage_mesh(pktrt_scene *, const mesh *, uint32_t material);
uint32_t stage_quad(pktrt_scene *, const quad *, uint32_t material);
void stage_light(pktrt_scene *, const pktrt_light *);
pktrt_material material_of(double albedo, pktrt_specular, double reflectance);
pktrt_material lamp_of(double emission);
pktrt_light light_of(pktrt_light_kind, double intensity);
pktrt_light quad_light(const quad *, double intensity);
/* A picture of w x h pixels, WRT, one sample, nothing cut off but by depth. */
pktrt_render_desc stage_view(pktrt_mode, uint32_t w, uint32_t h, float *pixels, vec eye, vec target);
void stage_render(pktrt_scene *, const pktrt_render_desc *);
float *stage_pixels(size_t floats); /* filled with -7 */
vec stage_through(
    const pktrt_camera *, double x, double y, double width, double height); /* unit; pixels from the upper left */

/* The radiance of a spot seen from eye: DRT by a camera so narrow that the spot counts as a point. By channel. */
typedef struct estimate {
  double mean[3], error[3]; /* error: standard error of the mean, from pictures of different seeds */
} estimate;
estimate stage_estimate(pktrt_scene *, const pktrt_render_desc *, int seeds); /* of the whole picture */
pktrt_render_desc stage_spot(vec eye, vec target);       /* pixels: NULL, stage_estimate brings its own */
bool agrees(const estimate *, int channel, double want); /* within 4 standard errors + 1e-5 */
/* CHECKs that it agrees with want, that it is precise to `precision` of want, and that it excludes `control`. */
void check_estimate(const char *name, const estimate *, double want, double control, double precision);

/* --- closed forms --- */
double fresnel_exact(double cosine, double eta);
double conductor_exact(double cosine, double eta, double k);
vec reflected(vec d, vec normal);
bool refracted(vec d, vec normal, double eta, vec *out); /* unit d against the normal; eta: behind over before */
/* Form factor of a polygon for a patch at p with unit normal n: Lambert 1760. All of it above the horizon. */
double form_factor(vec p, vec n, const vec *corner, int count);
double quad_form_factor(vec p, vec n, const quad *);
/* Phong lobe at an angle to the normal: its share above the surface (power 0), or the integral of its cosine there
   (1). */
double lobe_moment(double exponent, double angle, int power);

#endif
