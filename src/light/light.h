// SPDX-License-Identifier: Apache-2.0
// Emitters: what they are, how points on them and directions to them are drawn, how they emit
// photons. A scene is immutable after light_prepare, so every other function here may be called
// from any thread.
#ifndef LIGHT_LIGHT_H
#define LIGHT_LIGHT_H

#include "light/light_pane.h"
#include "light/light_sky.h"
#include "light/light_sun.h"
#include "light/light_visibility.h"
#include "scene/scene.h"

// ---- Kinds ------------------------------------------------------------------------------------

enum light_kind {
    LIGHT_AREA = 0,
    LIGHT_POINT,
    LIGHT_SPOT,
    LIGHT_PROJECTOR,
    LIGHT_BEAM,  // parallel light from a flat shape
    LIGHT_DIRECTIONAL,
    LIGHT_CONSTANT,
    LIGHT_ENVMAP
};

// Two triangles of a mesh that make a parallelogram: corner + s * edge_u + t * edge_v, s and t in
// [0, 1].
struct light_face {
    vec3 corner, edge_u, edge_v;
    vec3 x, y;  // unit, along the edges
    vec3 n;     // the side that emits
    float area, length_u, length_v;
    bool right_angled;
    uint32_t vertex[6];  // of the triangle s + t <= 1: corner, +u, +v; of the other: far, +v, +u
    float grid;          // fraction of the samples that is drawn by the texture; 0: none
    const float *row_cdf, *column_cdf;  // of its cells (light_texels.c)
};

struct light {
    enum light_kind kind;
    rgb value;                      // radiance, intensity or irradiance, by kind; envmap: scale
    const struct texture *texture;  // area: radiance over uv; spot, projector: their slide; or NULL
    uint32_t shape;                 // area, beam
    struct mat4 to_world, to_local;
    vec3 position, direction;    // point, spot; spot and directional: where the light goes
    float cos_cutoff, cos_beam;  // spot
    float tan_x, tan_y;          // projector: half extents of its slide at unit distance
    const struct image *image;   // envmap: latitude-longitude, 3 channels
    vec3 sun;                    // envmap: towards the middle of a disc of uniform light, unit
    rgb sun_value;               // its radiance; black: there is none
    float sun_chord;             // of the angle from its middle to its rim
    // The rest is filled by light_prepare.
    const float *row_cdf,
        *column_cdf;  // envmap, cells between texels: rows + 1; rows * (width + 1)
    const uint32_t *row_cut, *column_cut;  // envmap: by which they are searched
    uint32_t row_cuts, column_cuts;
    const float *row_weight;        // envmap: of the rows of texels in the density, rows + 1
    const struct light_face *face;  // area: set if all triangles pair into few faces, else NULL
    uint32_t face_count;
    vec3 center;         // area: of its bounds
    float strength;      // luminance of radiance * area, intensity or irradiance, by kind
    float sun_fraction;  // of the samples, for the disc
    float power;         // luminance of the emitted power [W], > 0
};

// ---- Sampling (light.c) -----------------------------------------------------------------------

struct light_sample {
    vec3 wi;      // from the point to the light
    vec3 p;       // point on the light (area, point, spot)
    vec3 n;       // its normal; zero if it has none
    float dist;   // INFINITY for directional light and environments
    rgb L;        // radiance, or for delta lights intensity / dist^2 or irradiance
    float pdf_w;  // solid angle; 1 for delta lights. Without the probability of choosing the light
    bool delta;
    uint32_t light;  // which light, drawn by which numbers
    float u, v;
};

// Fills light_cdf, powers, image distributions and the shapes' area_cdf. After scene_trace_build.
satin_status light_prepare(struct satin_scene *scene, struct log log);

// A direction towards light i; false if none contributes. Does not test visibility.
bool light_sample(const struct satin_scene *scene, uint32_t i, vec3 p, float u, float v,
                  struct light_sample *out);
// Density over solid angle at p with which light_sample of s's light draws s.
float light_pdf(const struct satin_scene *scene, vec3 p, vec3 wi, const struct interaction *s);
// Radiance that s emits towards w (world, away from the surface); black if s is no light.
rgb light_emitted(const struct satin_scene *scene, const struct interaction *s, vec3 w);
// Radiance of the environment along w (world, away from the eye); black without one.
rgb light_environment(const struct satin_scene *scene, vec3 w);
// Radiance that a ray along d brings from what it meets: emitted at `hit`, or by the environment if
// that is NULL; black if that emits nothing.
rgb light_met(const struct satin_scene *scene, const struct interaction *hit, vec3 d);
// Shadow ray of a light sample from a surface point.
struct ray light_shadow_ray(const struct satin_scene *scene, vec3 p, vec3 ng,
                            const struct light_sample *s);

// Draws a photon that leaves light i, in proportion to its power: position by u[0], u[1], direction
// by u[2], u[3], each in [0, 1). The light's power is the mean of `power` over uniform u; false:
// the photon carries none. Equal power for all u but on textured, environment and wide spot lights.
// `aim` says what matters; NULL: all does. The density of photons then is higher there, and their
// power lower, than elsewhere.
struct light_ray {
    struct ray ray;
    rgb power;  // [W]
};
struct light_target {
    vec3 lo, hi;
};
enum { LIGHT_SPOTS = 6 };
struct light_aim {
    struct light_target all;  // light from infinitely far that passes it by is left out
    int count;                // of the boxes in it, or before it, that matter most
    struct light_target spot[LIGHT_SPOTS];
};
#define LIGHT_UNAIMED 0.25f  // fraction of photons that are not aimed at a spot, if there is one
bool light_emit(const struct satin_scene *scene, uint32_t i, const struct light_aim *aim,
                const float u[4], struct light_ray *out);

#endif
