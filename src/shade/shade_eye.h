// SPDX-License-Identifier: Apache-2.0
// Private to shade/: eye rays through ideal specular surfaces.
#ifndef SHADE_EYE_H
#define SHADE_EYE_H

#include "shade/shade.h"

enum { SHADE_VERTICES = 12 };

// A surface point that is seen, directly or through ideal specular surfaces.
struct shade_vertex {
    struct shading_point point;
    rgb T;           // throughput to the eye
    float distance;  // along the path to the eye
    float pixel;     // width of a projected pixel there
    int depth;       // number of segments from the eye
};

// The random numbers and properties of an eye ray.
struct shade_camera_sample {
    float spread;  // width over distance
    float weight;  // weight of the sample in the film's filter
    vec2 film;     // position on the film, in pixels of the full film
    vec2 at;       // random numbers of the position on the lens
};

struct shade_eye {
    struct shade_vertex vertex[SHADE_VERTICES];
    int count;
    rgb emission;  // emitted light that is seen
    struct shade_camera_sample camera;
    // The first surface, for channels that are not light.
    bool hit;
    struct shading_point first;  // if it is a blend, of one component, drawn by its weight
};

// Follows the eye ray of a sample. At the first ideal specular surfaces both reflection and
// refraction are followed; at later ones, one of them is drawn.
void shade_eye_trace(const struct shade *shade, int x, int y, struct sampler *sampler,
                     struct shade_eye *out);
// Finds in a fraction of that time what shade_eye_trace would find of emitted light and of the
// camera's weight, if the ray meets a surface without ideal specular lobes; false if it does not.
bool shade_eye_emission(const struct shade *shade, int x, int y, struct sampler *sampler, rgb *Le,
                        float *weight);
// One of the surface points that are seen, drawn by its throughput; NULL if there is none.
// *probability, if not NULL, is set to that of the choice.
const struct shade_vertex *shade_eye_choose(const struct shade_eye *eye, float u,
                                            float *probability);
// Whether a surface that transmits no light faces this one within a few pixels (shade_gap.c).
bool shade_in_gap(const struct shade *shade, const struct shade_vertex *vertex);
// Draws the eye ray itself.
struct ray shade_eye_ray(const struct shade *shade, int x, int y, struct sampler *sampler,
                         struct shade_camera_sample *camera);
// The sampler of a sample. Its numbers depend only on the seed, the pixel and the index.
struct sampler shade_eye_sampler(const struct gather *g, int x, int y, uint32_t index,
                                 enum rng_stream stream);

// The normal of the surface there, on the side of the eye, as x y z.
static inline rgb shade_facing_normal(const struct shading_point *p) {
    const vec3 n = v3_dot(p->frame.n, p->ng) < 0.0f ? v3_neg(p->frame.n) : p->frame.n;
    return rgb_make(n.x, n.y, n.z);
}

// The alpha of an eye ray that hits a surface or not. As in Mitsuba, an environment that is seen
// covers the pixel, unless it is hidden (shade.c).
float shade_coverage(const struct shade *shade, bool hit);

// What is known of a first surface beside its light (shade_features.c).
struct shade_surface shade_surface_of(const struct shading_point *p);

// The features that an eye ray sees (shade_features.c). Where it first meets ideal specular
// surfaces alone, these are the sum over all surface points that are seen by them.
struct shade_features shade_features_of(const struct shade_eye *eye);
// Where the first surface is ideal specular alone, sets *out to the surface that shows the most
// through it: its albedo times the throughput, and the distance along the path.
void shade_find_shown(const struct shade_eye *eye, struct shade_surface *out);
// Adds those of a surface point that is seen with the throughput T.
void shade_features_add(const struct shading_point *p, rgb T, struct shade_features *sum);

// The site of a record at a point, where a pixel has the width `pixel` (shade_sites.c). `stream` is
// any number that no other site has, `kinds` a mask of those that the surface reads.
struct fill_site shade_site(const struct shading_point *p, float pixel, uint64_t stream,
                            unsigned kinds);

#endif
