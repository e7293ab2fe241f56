// SPDX-License-Identifier: Apache-2.0
// One eye ray: emitted light, direct light, ideal specular reflections, caustics, cached and
// importance-sampled indirect light [K05 3.5]; and the integrators `path`, `direct` and `photons`.
#ifndef SHADE_SHADE_H
#define SHADE_SHADE_H

#include "cache/cache.h"
#include "fill/fill.h"
#include "gather/gather.h"

// The layers of the image. Each light path is in one of them (see the path table in docs/tour.md).
enum shade_layer {
    SHADE_DIRECT = 0,
    SHADE_CAUSTIC,
    SHADE_INDIRECT_DIFFUSE,
    SHADE_INDIRECT_GLOSSY,
    SHADE_EMISSION,
    SHADE_ALBEDO,  // from here on they are not light
    SHADE_NORMAL,
    SHADE_LAYERS
};

// Diffuse light that is gathered because no record is near, and where that is.
struct shade_gathered {
    rgb light;    // that the diffuse lobe reflects, times the throughput to the eye
    rgb albedo;   // what it would reflect of irradiance 1, likewise
    vec3 p, n;    // position, and normal that faces the eye
    float pixel;  // width of a projected pixel there
    float rays;   // number of gather rays; 0: the sample did not gather
};

// What a denoiser reads of the first surface that is seen: through ideal specular surfaces, and
// times their throughput, so that it knows of edges in mirrors and behind glass.
struct shade_features {
    rgb albedo;
    rgb normal;  // x y z
};

// The first surface that is seen, with its ideal specular lobes; all 0 if there is none.
struct shade_surface {
    rgb albedo;
    rgb normal;   // x y z, on the side of the eye
    float depth;  // distance
    float alpha;  // of shade_sample
};

struct shade_sample {
    rgb beauty;               // the sum of the light layers; of `path`, all light
    rgb uncached;             // the reflected light in it that is from no record, which is noisy
    rgb uncached_glossy;      // that of SHADE_INDIRECT_GLOSSY
    bool sampled_glossy;      // whether some of that layer is from no record
    rgb layer[SHADE_LAYERS];  // of the first surface that is not ideal specular; the normal is x y
                              // z
    struct shade_features features;
    struct shade_surface shown;  // the first surface, or what it shows (shade_find_shown)
    float depth;                 // distance to the first surface; 0 if there is none
    float alpha;             // 1 if the eye ray meets a surface or a visible environment, else 0
    struct cache_used used;  // records that were interpolated at the point
    float record;            // 1: a record is within a pixel; only with record_maps
    float light_variance;    // variance of the luminance of direct light by one light sample
    float lobe_variance;     // the same by one BRDF sample of a glossy lobe
    float gather_variance;   // of indirect light by one gather ray, where no record is near
    uint32_t gathers;        // the number of these points
    uint32_t shape;          // index of the first surface's shape, counted from 1; 0: none
    uint32_t instance;       // of the instance that shows it, likewise
    float weight;            // weight of the sample in the film's filter
    struct shade_gathered gathered;  // at the first point that gathers
    float aov[AOV_VALUES];           // values that the scene's AOVs need, 0 if there is no surface
};

// Whether all light of a sample is finite; otherwise the sample is dropped.
static inline bool shade_sample_finite(const struct shade_sample *s) {
    bool finite = rgb_finite(s->beauty) && rgb_finite(s->uncached) &&
                  rgb_finite(s->features.albedo) && rgb_finite(s->features.normal);
    for (int i = 0; i < SHADE_LAYERS; i++) finite = finite && rgb_finite(s->layer[i]);
    return finite;
}

// Gathering by samples where no record is near, or where records are too large.
struct shade_missing {
    int hemisphere;   // rays of one sample over the whole hemisphere, where a cache is off
    float deviation;  // relative standard deviation of the mean of a pixel's samples
};

// Constants of an image pass, and what each worker gathers with.
struct shade {
    const struct gather *g;
    const struct camera *camera;  // of the scene of g, through which pixels are seen
    struct cache_reader records;  // how the image pass reads them
    struct shade_missing missing;
    struct scene_film_filter filter;
    float sharpness;               // width of a sample's footprint, in pixels; 0: a point
    struct gather_layout *gather;  // hemisphere for points where a cache is off
    struct gather_worker *worker;  // one for each worker of the pool
    int worker_count;
};

// Pixels are seen through the camera of the scene, until `camera` is set to another one. Samples
// interpolate between the records of the cache; without a cache each of them gathers.
satin_status shade_init(struct shade *shade, const struct gather *g, struct cache_reader records,
                        struct shade_missing missing, struct parallel *pool);
void shade_destroy(struct shade *shade);  // a zeroed one is allowed

// Counts of a chunk of samples, which the caller adds up.
struct shade_counts {
    uint64_t samples, points, interpolated, records_used, gathered, missing_rays, rays;
};

static inline void shade_counts_add(struct shade_counts *sum, const struct shade_counts *more) {
    sum->samples += more->samples;
    sum->points += more->points;
    sum->interpolated += more->interpolated;
    sum->records_used += more->records_used;
    sum->gathered += more->gathered;
    sum->missing_rays += more->missing_rays;
    sum->rays += more->rays;
}

// Values that the samples of a pixel have in common (shade_pixel_cache.h).
enum { SHADE_PIXEL_VALUES = 4 };
struct shade_pixel_cache {
    struct shade_pixel_value {
        vec3 p, n, wo;
        const struct material_side *side;
        float alpha, exponent;  // roughness
        // Means of what the records of each kind gave at `count` positions.
        struct shade_pixel_light {
            int count;
            struct cache_used used;  // at the last position
            rgb E;                   // indirect irradiance
            rgb glossy;              // reflected by the glossy lobes, without brdf_glossy_factor
            float E2, glossy2;       // means of the squared luminances
        } light[CACHE_KINDS];
    } value[SHADE_PIXEL_VALUES];
    int count, next;
};

// The data of a worker; zeroed at first except for `gather`.
struct shade_worker {
    struct gather_worker gather;           // of struct shade, which owns it
    struct shade_counts counts;            // the caller adds them up
    struct shade_pixel_cache pixel_cache;  // of the current pixel
};

// To be called before the first pixel of an image tile in each pass, as no other tile may influence
// its samples.
static inline void shade_tile_begin(struct shade_worker *worker) {
    gather_singles_begin(worker->gather.singles);
}
// Empties the per-pixel cache. To be called before the first sample of a pixel in each pass.
static inline void shade_pixel_begin(struct shade_worker *worker) {
    worker->pixel_cache.count = worker->pixel_cache.next = 0;
}
// What a sample takes at each point of an eye path: light samples, BRDF samples of a glossy lobe
// that find lights, and gather rays where no record is near (1 to SATIN_GLOSSY_SAMPLES_MAX).
struct shade_sample_counts {
    struct gather_light_samples light, lobe, gather;
};
// Computes sample number `index` of pixel (x, y) of the crop window; `path` uses one light sample
// at each point.
void shade_pixel(const struct shade *shade, struct shade_worker *worker, int x, int y,
                 uint32_t index, struct shade_sample_counts samples, struct shade_sample *out);

// The emitted light alone that is seen by eye ray number `index` of pixel (x, y), from a separate
// sequence of rays. *weight as of a sample.
rgb shade_emission(const struct shade *shade, int x, int y, uint32_t index, float *weight);

// The first surface that eye ray number `index` of pixel (x, y) sees, and unless NULL what it shows
// (shade_sample.shown), from a separate sequence of rays, as samples see them. Returns the weight
// as of a sample.
float shade_find_surface(const struct shade *shade, int x, int y, uint32_t index,
                         struct shade_surface *first, struct shade_surface *shown);

// The features seen by eye ray number `index` of pixel (x, y), from a separate sequence of rays
// (shade_features.c). Returns the weight as of a sample.
float shade_find_features(const struct shade *shade, int x, int y, uint32_t index,
                          struct shade_features *out);

// Finds the surface points at which an eye ray of pixel (x, y) may need records; if `adaptive`,
// with the members for fill_adapt. Returns their number, at most `max` (shade_sites.c).
int shade_sites(const struct shade *shade, int x, int y, bool adaptive, struct fill_site *out,
                int max);
// Finds a site of indirect bounce `bounce`: the end of a random walk of that many bounces from a
// surface that is seen in pixel (x, y). False if the walk ends before, or if its end needs no
// record.
bool shade_walk(const struct shade *shade, int x, int y, int bounce, struct fill_site *out);
// Draws a gather ray from a surface that is seen in pixel (x, y), as the first segment of such a
// walk. False if there is none.
bool shade_walk_ray(const struct shade *shade, int x, int y, struct ray *out);

// What sample `index` of pixel (x, y) reads of the first pass by one ray of a glossy lobe
// (shade_lookup.c).
struct shade_lookup {
    struct gather_lookup read;
    float Y;  // luminance that the pixel has by it, as an estimate of all such light
};
// False if it reads nothing.
bool shade_look_up(const struct shade *shade, int x, int y, uint32_t index,
                   struct shade_lookup *out);

#endif
