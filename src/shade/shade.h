// SPDX-License-Identifier: Apache-2.0
// One eye ray: emitted light, direct light, ideal specular reflections, caustics, cached and
// importance-sampled indirect light [K05 3.5]; and the integrators `path`, `direct` and `photons`.
#ifndef SHADE_SHADE_H
#define SHADE_SHADE_H

#include "cache/cache.h"
#include "gather/gather.h"

// The harmonics of a scene's glossy BRDFs, by the index of a material_side; NULL for those without.
struct shade_tables {
    size_t count;
    struct brdf_range **table;
    bool *owned;    // false: the table is that of an equal BRDF before it
    int *channels;  // of each table: 1 or 3
    int order;      // largest order of all; 0: nothing glossy is cached
};

satin_status shade_tables_build(const struct satin_scene *scene, const satin_options *options,
                                struct parallel *pool, struct log log, struct shade_tables *out);
void shade_tables_free(struct shade_tables *tables);
// Whether textures change more of a side's glossy lobe than its factor.
bool shade_shape_textured(const struct material_side *side);

// The parts of the image, each carried once (the path table in docs/tour.md).
enum shade_layer {
    SHADE_DIRECT = 0,
    SHADE_CAUSTIC,
    SHADE_INDIRECT_DIFFUSE,
    SHADE_INDIRECT_GLOSSY,
    SHADE_EMISSION,
    SHADE_ALBEDO,  // this and the following are not light
    SHADE_NORMAL,
    SHADE_LAYERS
};

struct shade_sample {
    rgb beauty;               // the sum of the light layers; of `path`, more than its one layer
    rgb uncached;             // what of it is reflected, but by no record: the noisy light
    rgb layer[SHADE_LAYERS];  // of the first surface that is not ideal specular; normal as x y z
    float depth;              // distance to the first surface; 0 if there is none
    struct cache_used used;   // records interpolated at the point
    float record;             // 1: one stands there, within a pixel; only with record_maps
    float light_variance;     // of the luminance of direct light by one light sample
    float weight;             // that the film's filter gives to the sample
    float aov[AOV_VALUES];    // as the scene asks for them, 0 if there is no surface
};

// Whether all light of a sample is finite; one that is not is dropped.
static inline bool shade_sample_finite(const struct shade_sample *s) {
    bool finite = rgb_finite(s->beauty) && rgb_finite(s->uncached);
    for (int i = 0; i < SHADE_LAYERS; i++) finite = finite && rgb_finite(s->layer[i]);
    return finite;
}

// Constants of an image pass and a worker's scratch.
struct shade {
    const struct gather *g;
    const struct shade_tables *tables;
    const struct cache *cache;
    float a_irradiance, a_radiance;  // accuracies of the image pass
    struct film_filter filter;
    float sharpness;                  // width of a sample's footprint, in pixels; 0: a point
    struct gather_layout *gather;     // hemisphere where a cache is off
    struct gather_layout *fallback;   // hemisphere where no record is near
    struct gather_scratch **scratch;  // one per worker
    int scratch_count;
};

satin_status shade_init(struct shade *shade, const struct gather *g,
                        const struct shade_tables *tables, const struct cache *cache,
                        struct parallel *pool);
void shade_destroy(struct shade *shade);  // a zeroed one is allowed

// Counts of one chunk of samples, joined by the caller.
struct shade_counts {
    uint64_t samples, points, interpolated, records_used, gathered, rays;
};

// Values that the samples of a pixel have in common (shade_pixel_cache.h).
enum { SHADE_PIXEL_ENTRIES = 4 };
enum { PIXEL_IRRADIANCE = 1, PIXEL_RADIANCE = 2 };
struct shade_pixel_cache {
    struct shade_pixel_entry {
        vec3 p, n, wo;
        const struct material_side *side;
        float alpha, exponent;   // roughness
        unsigned knows;          // mask of PIXEL_...
        struct cache_used used;  // records behind E
        rgb E;                   // indirect irradiance by either cache
        rgb glossy;              // reflected by the glossy lobes, without the factor brdf.specular
    } entry[SHADE_PIXEL_ENTRIES];
    int count, next;
};

// A worker's own; zeroed at first but for `scratch`.
struct shade_worker {
    struct gather_scratch *scratch;
    struct shade_counts counts;            // joined by the caller
    struct shade_pixel_cache pixel_cache;  // of the pixel under way
};

// Empties the per-pixel cache; to be called before the first sample of a pixel in each pass.
static inline void shade_pixel_begin(struct shade_worker *worker) {
    worker->pixel_cache.count = worker->pixel_cache.next = 0;
}
// Sample number `index` of pixel (x, y) of the crop window. `lights` at each of its points; `path`
// takes one each.
void shade_pixel(const struct shade *shade, struct shade_worker *worker, int x, int y,
                 uint32_t index, struct gather_lights lights, struct shade_sample *out);

// Emitted light alone, seen by eye ray number `index` of pixel (x, y), of a series of its own;
// *weight as of a sample.
rgb shade_emission(const struct shade *shade, int x, int y, uint32_t index, float *weight);

// The surface points where an eye ray of pixel (x, y) may need records; `adaptive`: with what
// cache_adapt asks of them. Returns how many, at most `max`. (shade_sites.c)
int shade_sites(const struct shade *shade, int x, int y, bool adaptive, struct cache_site *out,
                int max);
// A site of indirect bounce `bounce`: the end of a walk of that many bounces from pixel (x, y).
// False if the walk ends before, or where no record is wanted.
bool shade_walk(const struct shade *shade, int x, int y, int bounce, struct cache_site *out);
// For struct gather_records; `records` is a struct shade whose scratch is not needed.
unsigned shade_known(const void *records, const struct gather_point *y, rgb *L);

#endif
