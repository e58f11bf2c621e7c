/* web.h - what the C files of the page share: its functions for JavaScript, and the scene that web.c holds. */
#ifndef WEB_H
#define WEB_H

#include "../../pktrt.h"

/* Stands before each function that JavaScript calls, as module._web_open(0, 1). */
#ifdef __EMSCRIPTEN__
#include <emscripten.h>
#define WEB_EXPORT EMSCRIPTEN_KEEPALIVE
#else
#define WEB_EXPORT
#endif

/* web.c: the scene as it stands, NULL before web_open; and how a picture of it is asked for, camera and size included. */
pktrt_scene *web_scene(void);
const pktrt_render_desc *web_view(void);

/* web.c: where a light of the scene is, the middle of the first one that is anywhere; else `at` stays. Tests choose an
   instruction set for the scenes that are opened next. */
void web_light(float at[3]);
void web_use_isa(pktrt_isa isa);

/* web.c, for web_filter.c: buffers of the next bands, as pktrt_render_desc has them, NULL for none; and keeps a sentence
   for web_error, and returns 1. */
void web_features(float *depth, float *normal, float *albedo);
int web_fail(const char *sentence);

/* web_file.c: a scene of the model that waits there, how it is looked at, and how many triangles it has, the floor apart.
   The model waits no more, whatever comes of it. NULL: there is not enough memory, or no model. */
pktrt_scene *web_model_scene(double light_size, pktrt_render_desc *view, double *triangles);
extern const double web_model_light[3]; /* its middle */
WEB_EXPORT float *web_model_room(unsigned triangles, unsigned materials, unsigned textured);
WEB_EXPORT uint32_t *web_image_room(unsigned width, unsigned height);

WEB_EXPORT int web_open(unsigned number, double light_size);
WEB_EXPORT int web_open_model(double light_size);
WEB_EXPORT int web_pose(double time, double shutter);
WEB_EXPORT int web_resize(unsigned width, unsigned height);
WEB_EXPORT void web_camera(double eye_x, double eye_y, double eye_z, double target_x, double target_y, double target_z,
    double aperture, double focus);
WEB_EXPORT void web_settings(unsigned mode, unsigned packet, unsigned cost, double attenuation);
WEB_EXPORT void web_path(unsigned path, unsigned steps, unsigned counted);
WEB_EXPORT int web_render_band(unsigned y, unsigned rows, unsigned samples, unsigned pass);
WEB_EXPORT float *web_filter_room(unsigned pixels);
WEB_EXPORT unsigned web_filter_margin(void);
WEB_EXPORT int web_render_halves(unsigned y, unsigned rows);
WEB_EXPORT int web_filter_rows(unsigned width, unsigned rows, unsigned y, unsigned count);
WEB_EXPORT const float *web_first_camera(void);
WEB_EXPORT const float *web_pixels(void);
WEB_EXPORT const float *web_cost(void);
WEB_EXPORT const double *web_work(void);
WEB_EXPORT const char *web_scene_name(unsigned number);
WEB_EXPORT double web_triangles(void);
WEB_EXPORT const char *web_checksum(void);
WEB_EXPORT const char *web_error(void);

#endif /* WEB_H */
