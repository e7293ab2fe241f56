// SPDX-License-Identifier: Apache-2.0
// How an image is rendered, as a plain struct: copy satin_options_default, or let
// satin_options_preset fill one, and change fields. A single table (src/render/options_table.c)
// parses, prints and documents every field with its range, which satin_options_set and satin_render
// check: a zeroed struct to which no preset was applied is refused. Every call here is thread-safe:
// it accesses only what its pointers refer to. A struct that one thread writes must not be used by
// another at the same time.
#ifndef SATIN_OPTIONS_H
#define SATIN_OPTIONS_H

#include <stdbool.h>

#include "satin/types.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum satin_integrator {
    SATIN_TWO_PASS = 0,  // photon map, then cached final gathering
    SATIN_PATH,          // path tracing, the reference
    SATIN_DIRECT,        // emitted and direct light only, through ideal specular chains
    SATIN_PHOTONS,       // the radiance of the photon map itself
    SATIN_SPPM           // stochastic progressive photon mapping, which converges to the truth
} satin_integrator;

typedef enum satin_quality { SATIN_DRAFT = 0, SATIN_PREVIEW, SATIN_PRODUCTION } satin_quality;

// The first-pass radiance estimate that a gather ray reads at its hit.
typedef enum satin_first_pass {
    SATIN_FIRST_PRECOMPUTED = 0,  // irradiance precomputed at photons, one nearest-neighbour query
    SATIN_FIRST_PHOTONS,          // density estimate at every hit
    SATIN_FIRST_PATH,             // path tracing from the hit
    SATIN_FIRST_NONE,             // direct light at the hit only
    SATIN_FIRST_RECURSIVE,        // direct light, and records of the next bounce
    SATIN_FIRST_REVERSE           // as precomputed, with photons that are traced in batches
} satin_first_pass;

typedef enum satin_basis { SATIN_HSH = 0, SATIN_SH } satin_basis;

// Translational gradients of records. Irradiance records have all of them; radiance records have
// stratified gradients instead of the last.
typedef enum satin_gradients {
    SATIN_GRADIENTS_NONE = 0,     // interpolation without gradients
    SATIN_GRADIENTS_STRATIFIED,   // from light that crosses the boundaries of strata [K05 4.3]
    SATIN_GRADIENTS_SOLID_ANGLE,  // from the change of the solid angles of the hit surfaces [K05
                                  // 4.2]
    SATIN_GRADIENTS_DIFFERENCES,  // solid-angle gradients by finite differences
    SATIN_GRADIENTS_WARD_HECKBERT
} satin_gradients;

// How the radius R of a record is computed: from the distances of the hits of its rays, or from
// the second derivatives of its irradiance.
typedef enum satin_radius {
    SATIN_RADIUS_HARMONIC = 0,  // harmonic mean distance [Ward 1988]
    SATIN_RADIUS_LEAST,         // least distance
    SATIN_RADIUS_TABELLION,     // least distance without grazing rays
    SATIN_RADIUS_HESSIAN        // occlusion Hessian; elliptic records
} satin_radius;

// The largest values of two options.
enum { SATIN_GLOSSY_SAMPLES_MAX = 256, SATIN_RECURSIVE_BOUNCES_MAX = 8 };

// Cryptomatte layers of the image, by which other programs mask objects or materials. The values
// are bits.
typedef enum satin_cryptomatte {
    SATIN_CRYPTOMATTE_OFF = 0,
    SATIN_CRYPTOMATTE_OBJECT = 1,
    SATIN_CRYPTOMATTE_MATERIAL = 2,
    SATIN_CRYPTOMATTE_BOTH = 3
} satin_cryptomatte;

typedef struct satin_options {
    satin_integrator integrator;
    satin_quality quality;
    satin_first_pass first_pass;
    // Samples per pixel, of integrator sppm passes; 0: what fits in the time limit or, without one,
    // the scene's for path and sppm, the preset's for the others.
    int spp;
    bool adaptive_sampling;  // spp is a mean: noisy pixels get more samples; without effect with
                             // path
    bool denoise;            // denoises light that no record carries; needs Open Image Denoise
    // Size of the whole film in pixels; 0: the scene's, or by its aspect ratio if one is given. A
    // crop window of the scene is scaled with it.
    int width, height;
    // The part of the film that is rendered, in its pixels from the top left; it replaces the
    // scene's crop window. crop_width or crop_height 0: the scene's.
    int crop_x, crop_y, crop_width, crop_height;
    uint64_t seed;
    int threads;         // 0: one per core
    double time;         // wall seconds for the whole render; 0: no limit
    int64_t memory;      // bytes for the whole process, by which photons, records and threads are
                         // limited, and textures if the scene was loaded with it; 0: no limit
    int max_depth;       // in path segments, as in Mitsuba; -1: no limit; -2: the scene's or -1
    int rr_depth;        // path depth at which Russian roulette starts; 0: the scene's, else 5
    int hide_emitters;   // 1: emitters seen directly are black; 0: not; -1: the scene's, else 0
    int light_samples;   // light samples per pixel sample at the first hit
    int glossy_samples;  // gather rays per pixel sample for glossy lobes that are not cached

    // First pass.
    int64_t photons;          // photon paths emitted for the global map
    int64_t caustic_photons;  // photon paths emitted for the caustic map
    int64_t photon_batch;     // photon paths that first pass `reverse` traces at a time
    int photon_k;             // photons in a density estimate of the global map
    int caustic_k;            // photons in a density estimate of the caustic map
    bool caustic_smooth;      // removes the noise of photons from caustics
    int recursive_bounces;    // indirect bounces for which first pass `recursive` makes records;
                              // the first is at what gather rays from the image's surfaces hit
    bool photon_area;         // divides by the area of the surface in the disc

    // Gathering.
    bool final_gather;      // if off, the image shows what gather rays read, at what is seen
    bool gather_near;       // gather rays with hits nearer than the lookup radius continue for one
                            // bounce
    bool gather_direct;     // direct light at gather hits is from light samples instead of photons
    bool refine_lookups;    // the estimate is gathered anew where glossy lobes show its noise
    bool guide_clusters;    // additional gather rays towards clusters of photons
    bool guide_visibility;  // direct light is sampled by the visibility of the lights
    bool noise_filter;      // noisy light is averaged over pixels that look the same
    int edge_rays;          // eye rays that show what each pixel at an edge sees; 0: none
    bool texture_filter;    // bitmaps are averaged over a ray's footprint

    // Irradiance cache (diffuse surfaces).
    bool irradiance_cache;
    bool irradiance_filter;  // what samples gather where no record is near is averaged over pixels
    satin_gradients irradiance_gradients;
    int irradiance_rays;     // gather rays per record
    float irradiance_noise;  // target standard deviation of E over E, which decides the number of
                             // rays; 0: constant
    float irradiance_a;      // accuracy a at which the cache is filled
    float irradiance_widen;  // the image pass interpolates with a times this factor, 1 to 2
    satin_radius irradiance_radius;
    bool irradiance_gradient_clamp;   // E changes by at most itself within R [K05 6.5.1]
    bool irradiance_neighbour_clamp;  // R of two records differ by at most their distance [K05
                                      // 6.5.2]
    float irradiance_min_pixels;      // least influence radius a R in projected pixels, 0 to 1000
    float irradiance_max_pixels;  // largest influence radius a R in projected pixels, 1 to 100000

    // Radiance cache (glossy surfaces).
    bool radiance_cache;
    satin_gradients radiance_gradients;
    bool radiance_diffuse;  // diffuse surfaces use radiance records too, for comparison
    satin_basis radiance_basis;
    int radiance_order;       // largest order n, 1 to 14
    float radiance_error;     // largest relative error of radiance reflected by a BRDF in harmonics
    float radiance_rotation;  // largest angle [rad] between normals for the fast rotation, 0 to 4;
                              // 0: none
    int radiance_rays;        // gather rays per record, 4 to 1048576
    float radiance_noise;  // target standard deviation of the coefficient vector over its length, 0
                           // to 1
    float radiance_a;      // accuracy a at which the cache is filled, no unit, .01 to 2
    float radiance_widen;  // the image pass interpolates with a times this factor, 1 to 2
    satin_radius radiance_radius;   // not SATIN_RADIUS_HESSIAN
    bool radiance_gradient_clamp;   // R is limited to where the gradient is valid [K05 6.5.1]
    bool radiance_curvature_clamp;  // R is limited to where reflected light is almost linear
    bool radiance_neighbour_clamp;  // R of two records differ by at most their distance [K05 6.5.2]
    float radiance_min_pixels;      // least influence radius a R in projected pixels, 0 to 1000
    float radiance_max_pixels;      // largest influence radius a R in projected pixels, 1 to 100000

    // Both caches.
    bool adaptive_cache;      // shrinks records where they disagree perceptibly [K05 6.3]
    bool origin_shift;        // moves records off the edges of triangles [K05 6.5.3]
    float record_max_radius;  // largest R in scene units, overriding those in pixels; 0: no limit
    // The image pass gathers where R, as records should have it, is less than this fraction of the
    // least radius in pixels.
    float gather_radius_ratio;
    bool leak_test;    // records are not used at points from which a wall separates them
    bool record_maps;  // adds channels to the film that show the records

    satin_cryptomatte cryptomatte;  // adds masks of objects or materials

    // Layers of the image that are kept beside the beauty, "direct,albedo"; "": all; "none": none.
    char layers[256];

    // Materials, by the ids of their BRDFs, whose glossy lobes are always cached or always sampled,
    // whatever radiance_error is: "floor=on,vase=off". Ended by 0.
    char material_cache[256];
} satin_options;

// The options at quality `preview`. A constant, which any thread may read.
extern SATIN_API const satin_options satin_options_default;

// Sets every field that quality decides; the others keep their values. Only if photon_k is 0, which
// no render takes, *options counts as a zeroed struct: then every other field that is 0 gets its
// default. `options` must not be NULL, and `quality` must be one of the enum. Thread-safe if no
// other thread uses *options.
SATIN_API void satin_options_preset(satin_options *options, satin_quality quality);

// Sets one option from text, by the name of its field (`-` and `_` are equal). `quality` applies
// its preset; `material.NAME.cache` = on or off adds to material_cache. If the name or the value is
// invalid, nothing changes, and SATIN_ERROR_INPUT is returned after one logged line, which has the
// nearest option, the current name of a renamed option, or the range. Units are those of the field;
// angles are in radians and times in seconds. The texts are read only during the call and must not
// be NULL. `log` may be NULL; it is called on this thread. Thread-safe if no other thread uses
// *options.
SATIN_API satin_status satin_options_set(satin_options *options, const char *name,
                                         const char *value, satin_log_fn log, void *log_user);

// A name and a value for satin_options_set; both texts are the caller's.
typedef struct satin_setting {
    const char *name, *value;
} satin_setting;

// Combines the options of a scene and its user; later ones override earlier ones: the preset of the
// quality (the last one in `settings`, else the scene's, else preview), the options of the scene's
// `<integrator type="satin">`, then `settings` in order (`count` of them, may be NULL). If `scene`
// is NULL, it only checks the settings. SATIN_ERROR_INPUT, with one logged line, if an option is
// invalid; then *out is unchanged. `out` must not be NULL; `log` may be NULL and is called on this
// thread. The texts are read only during the call. Thread-safe; other threads may use the scene.
SATIN_API satin_status satin_options_resolve(const satin_scene *scene,
                                             const satin_setting *settings, size_t count,
                                             satin_log_fn log, void *log_user, satin_options *out);

// An option: its name, its value as text, its range and documentation, with units where it has
// some. The texts are static, except for `value`, which is a copy.
typedef struct satin_option_info {
    const char *name, *range, *doc;
    char value[256];
} satin_option_info;
// Describes option `index` (from 0) and its value in `options`. False, with *out unchanged, if
// `index` is below 0 or beyond the last one. Neither pointer may be NULL. Thread-safe if no other
// thread changes *options.
SATIN_API bool satin_options_describe(const satin_options *options, int index,
                                      satin_option_info *out);

#ifdef __cplusplus
}
#endif
#endif
