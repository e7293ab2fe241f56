// SPDX-License-Identifier: Apache-2.0
// Lights: their data, sampling of points on them and directions to them, and emission of photons. A
// scene is immutable after light_prepare, so every other function here may be called from any
// thread.
#ifndef LIGHT_LIGHT_H
#define LIGHT_LIGHT_H

#include "light/light_pane.h"
#include "light/light_sky.h"
#include "light/light_sun.h"
#include "light/light_visibility.h"
#include "scene/scene.h"

// ---- Kinds --------------------------------------------------------------------------------------

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

// Two triangles of a mesh that form a parallelogram: corner + s * edge_u + t * edge_v, s and t in
// [0, 1].
struct light_face {
    vec3 corner, edge_u, edge_v;
    vec3 x, y;  // unit, along the edges
    vec3 n;     // on the side that emits
    float area, length_u, length_v;
    bool right_angled;
    uint32_t vertex[6];  // of triangle s + t <= 1: corner, +u, +v; of the other one: far corner,
                         // +v, +u
    float grid;          // fraction of the samples that is drawn from the texture's grid; 0: none
    const float *row_cdf, *column_cdf;  // of the grid's cells (light_texels.c)
};

struct light {
    enum light_kind kind;
    rgb value;                      // radiance, intensity or irradiance, by kind; envmap: scale
    const struct texture *texture;  // area: radiance over uv; spot, projector: the slide; NULL:
                                    // none
    uint32_t shape;                 // area, beam
    const struct light_tube *tube;  // of a round cylinder; NULL: none
    struct mat4 to_world, to_local;
    vec3 position, direction;    // spot and directional: the direction in which light travels
    float cos_cutoff, cos_beam;  // spot
    float tan_x, tan_y;          // projector: half extents of its slide at unit distance
    const struct image *image;   // envmap: latitude-longitude, 3 channels
    int lit_rows;                // envmap: if not 0, it is black beyond this row of texels
    vec3 sun;                    // envmap: direction to the centre of the sun's uniform disc, unit
    rgb sun_value;               // radiance of the sun; black: there is none
    float sun_chord;             // chord of the angle between the sun's centre and edge
    // light_prepare fills the rest.
    const float *row_cdf,
        *column_cdf;  // envmap, cells between texels: rows + 1; rows * (width + 1)
    const uint32_t *row_cut, *column_cut;  // envmap: start indices of searches in the cdfs
    uint32_t row_cuts, column_cuts;
    const float *row_weight;  // envmap: factors of the rows of texels in the density, rows + 1
    float cell_mean;          // envmap: the mean weight of the cells
    const struct light_face *face;  // area: set if all triangles pair into a few faces, else NULL
    uint32_t face_count;
    const float *facing_cdf;  // area, many triangles: distributions over them (light_facing.c), or
                              // NULL
    const struct light_slabs *slabs;  // area, many triangles: parts along it; NULL: none
    vec3 centre;                      // area: centre of its bounds
    float radius;                     // area, mesh: half the diagonal of its bounds
    float strength;      // luminance of radiance * area, of intensity or of irradiance, by kind
    float sun_fraction;  // fraction of the samples that goes to the sun
    float power;         // luminance of the emitted power [W], > 0
};

// Whether the light arrives from a single direction at each point, so that only light samples find
// it.
static inline bool light_is_delta(const struct light *light) {
    return light->kind != LIGHT_AREA && light->kind != LIGHT_CONSTANT &&
           light->kind != LIGHT_ENVMAP;
}

// Whether its light comes from infinitely far away.
static inline bool light_is_far(const struct light *light) {
    return light->kind == LIGHT_DIRECTIONAL || light->kind == LIGHT_CONSTANT ||
           light->kind == LIGHT_ENVMAP;
}

// Whether its light comes from points at finite distances, rather than from one direction or from
// infinity.
static inline bool light_is_local(const struct light *light) {
    return light->kind == LIGHT_AREA || light->kind == LIGHT_POINT || light->kind == LIGHT_SPOT ||
           light->kind == LIGHT_PROJECTOR;
}

// ---- Sampling (light.c) -------------------------------------------------------------------------

struct light_sample {
    vec3 wi;      // from the point to the light
    vec3 p;       // point on the light (area, point, spot)
    vec3 n;       // its normal; zero if it has none
    float dist;   // INFINITY for directional lights and environments
    rgb L;        // radiance, or for delta lights intensity / dist^2 or irradiance
    float pdf_w;  // density over solid angle, without the probability of choosing the light; delta
                  // lights: 1
    bool delta;
    bool unread, in_sun;  // environment: by light_sample_draw, L and pdf_w are not set yet; whether
                          // the sample is in the sun
    uint32_t light;       // index of the light, and the numbers by which it was drawn
    float u, v;
};

// Sets light_cdf, powers, distributions over images, and the shapes' area_cdf. To be called after
// scene_trace_build.
satin_status light_prepare(struct satin_scene *scene, struct log log);

// Draws a direction towards light i. False if the light cannot contribute. Visibility is not
// tested.
bool light_sample_wi(const struct satin_scene *scene, uint32_t i, vec3 p, float u, float v,
                     struct light_sample *out);
// The density over solid angle at p with which light_sample_wi of the light at s draws s.
float light_pdf(const struct satin_scene *scene, vec3 p, vec3 wi, const struct interaction *s);
// The radiance that s emits towards w (world, away from the surface); black if s is not on a light.
rgb light_emitted(const struct satin_scene *scene, const struct interaction *s, vec3 w);
// The radiance of the environment along w (world, away from the eye); black if there is none.
rgb light_environment(const struct satin_scene *scene, vec3 w);
// The emitted radiance at the end of a ray along d: that of `hit`, or that of the environment if
// `hit` is NULL.
rgb light_at_hit(const struct satin_scene *scene, const struct interaction *hit, vec3 d);
// The shadow ray of a light sample from a surface point.
struct ray light_shadow_ray(const struct satin_scene *scene, vec3 p, vec3 ng,
                            const struct light_sample *s);

// Draws a photon that leaves light i, in proportion to its power: its position by u[0] and u[1],
// its direction by u[2] and u[3], each in [0, 1). The light's power is the mean of `power` over
// uniform u. False if the photon carries no power. The power is the same for all u, except for
// textured, environment and wide spot lights. Towards the boxes of `aim` the density of photons is
// higher, and their power lower, than elsewhere; NULL: the only box is that of the scene.
struct light_ray {
    struct ray ray;
    rgb power;       // [W]
    float entering;  // the power of a photon along the same direction through the openings of the
                     // aim, as a fraction of this one's; in (0, 1], 1 if there are none
};
struct light_target {
    vec3 lo, hi;
};
float light_box_area(const struct light_target *box);  // of its surface
enum { LIGHT_COVERS = 8, LIGHT_SPOTS = 6, LIGHT_BOXES = LIGHT_COVERS + LIGHT_SPOTS };
// The openings of a box through which light from infinitely far enters it, as bins of its faces.
struct light_openings {
    struct light_box box;
    struct light_bins bins;  // the distribution of points on all faces
    float face[6];           // the probability of each face
    float area;              // of all bins [m^2], times their weights over the largest one
};
// Rays through bins are as dense as the weights of these, which are in the order of
// light_bins_build. The area is 0 if all of them are.
void light_openings_build(const struct light_box *box, const float weight[LIGHT_HISTOGRAM_BINS],
                          struct light_openings *out);
// Whether a point outside the box faces any of them; the direction from it to a point in those,
// uniform over their areas; and the density of a direction by that [sr^-1].
bool light_openings_faced(const struct light_openings *openings, vec3 p);
vec3 light_openings_direction(const struct light_openings *openings, vec3 p, float u, float v);
float light_openings_pdf(const struct light_openings *openings, vec3 p, vec3 w);
// Boxes to aim at: first some that cover everything that light can be useful for, so that light
// that misses them may be left out, then spots where it is more useful, in or in front of these.
struct light_aim {
    int covers, count;  // their number, and that of all boxes
    struct light_target box[LIGHT_BOXES];
    const struct light_openings *openings;  // for light from infinitely far; may be NULL
};
// Fraction of the photons from infinitely far that openings get. With more, the photons from
// outside that enter after a bounce are fewer and stronger: .35, .5 and .75 leave a variance of
// .00070, .00038 and .00071 of the indirect light in a room that the ground before it lights; in
// one with a slit, .35 and .5 leave .00173 and .00099.
#define LIGHT_ENTERING 0.5f
#define LIGHT_COVERED 0.25f  // fraction of photons that are aimed at covers, if there are spots
bool light_emit(const struct satin_scene *scene, uint32_t i, const struct light_aim *aim,
                const float u[4], struct light_ray *out);

#endif
