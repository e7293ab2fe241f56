// SPDX-License-Identifier: Apache-2.0
// Private to render/: the image while it is rendered.
#ifndef RENDER_IMAGE_H
#define RENDER_IMAGE_H

#include <stdatomic.h>

#include "base/bytes.h"
#include "render/render_cryptomatte.h"
#include "render/render_state.h"

// What the emission layer of a pixel is made of: some of its samples, and additional eye rays for
// emitted light alone, a few in all pixels and more in those at rims (render_rims.c).
struct image_emission {
    rgb sum;       // weighted, of all
    float weight;  // of samples and first rays; 0: there are none so far
    uint32_t samples, rays;
    // For rays at a rim: their number, weight, and sums of luminance and its square; and the
    // probability that they are taken, by which they count.
    uint32_t rim_rays;
    float rim_weight, rim_Y, rim_squares, probability;
};

// Black if there is none so far.
static inline rgb render_emission_mean(const struct image_emission *e) {
    const float weight = e->weight + e->probability * e->rim_weight;
    return weight > 0.0f ? rgb_scale(e->sum, 1.0f / weight) : rgb_grey(0.0f);
}

// The weighted sums of a pixel's samples.
struct image_pixel {
    rgb beauty;
    rgb layer[SHADE_LAYERS];
    float depth, alpha, record;
    struct cache_used used;
    float weight;  // in the film's filter
    uint32_t samples, dropped;
    struct image_emission emission;
};

// The weight by which one more sample counts in a pixel that has `count` of them, of the summed
// weight `sum`. The mean weight is 1. A few samples of a filter with negative lobes may have almost
// no weight together, or less than none; a sample that would leave less than half of one per sample
// counts as one outside of the lobes. The mean over a surface of equal light is then exact for any
// number of samples, and edges become sharp as the number grows.
static inline float render_usable_weight(float sum, uint32_t count, float weight) {
    return weight < 0.0f && sum + weight < 0.5f * (float)(count + 1) ? -weight : weight;
}

// Sums over the samples of a pixel that gather because no record is near.
struct image_gathered {
    rgb light, albedo;  // of struct shade_gathered, weighted
    float most;         // luminance of the light of the brightest sample
    vec3 n;
    float rays;
    vec3 p;  // of the first of them, as `pixel`
    float pixel;
};

// The layers of which light is filtered: direct light, and glossy light that no record carries.
enum noisy_layer { NOISY_DIRECT, NOISY_GLOSSY, NOISY_LAYERS };

// Weighted sums over the samples of a pixel, and over those for which x + y + index is odd: of one
// sample per pixel, neighbours have different halves.
struct image_noisy {
    rgb glossy;                  // sampled gloss of all samples
    rgb odd[SHADE_EMISSION];     // layers of light before that
    rgb odd_glossy;              // sampled
    float weight;                // of the odd ones
    float sampled, odd_sampled;  // weight of those with sampled gloss, of all and of the odd ones
    struct shade_surface shown;  // weighted sum over all; `alpha` is not used
};

// What the filter of noise adds to the means of a pixel.
struct image_change {
    rgb layer[NOISY_LAYERS];
};

// Weighted sums for the denoiser over the samples of a pixel, and of features over more rays, up to
// as many as wanted (render_features.c).
struct image_uncached {
    rgb light;         // of shade_sample.uncached
    rgb odd;           // reflected light of every second sample
    float odd_weight;  // of these samples
    struct shade_features features;
    float weight;    // of features
    uint32_t count;  // number of samples and rays
    uint16_t rays, wanted;
};

static inline void render_features_add(struct image_uncached *sum,
                                       const struct shade_features *features, float weight) {
    if (!rgb_finite(features->albedo) || !rgb_finite(features->normal)) return;
    sum->features.albedo = rgb_mad(sum->features.albedo, features->albedo, weight);
    sum->features.normal = rgb_mad(sum->features.normal, features->normal, weight);
    sum->weight += weight;
    sum->count++;
}

// Black if there is none.
static inline struct shade_features render_features_mean(const struct image_uncached *sum) {
    const float scale = sum->weight > 0.0f ? 1.0f / sum->weight : 0.0f;
    return (struct shade_features){rgb_scale(sum->features.albedo, scale),
                                   rgb_scale(sum->features.normal, scale)};
}

// The square of what the denoiser has changed of a pixel's light, and the variance of that light,
// or -1 if it is not known; means over the channels.
struct image_denoised {
    float change, variance;
};

// Sums over blocks of a pixel's consecutive samples. The samples of a pixel are stratified, so the
// variance of their mean is far less than it would be by the differences of single samples; the
// means of whole blocks are stratified each, and differ by little more than the mean of all.
struct image_blocks {
    rgb begun;          // the sum of the samples of the block that is not complete
    rgb sums, squares;  // of the sums of complete blocks
};
// The least number of blocks of a pixel.
enum { IMAGE_BLOCKS = 4 };

// The channels of films, in the order of the table in render_film_channels.c.
enum {
    CHANNEL_LAYERS = 3,
    CHANNEL_DEPTH = CHANNEL_LAYERS + 3 * SHADE_LAYERS,
    CHANNEL_ALPHA,  // if the scene's film asks for it
    CHANNEL_DENSITY,
    CHANNEL_SAMPLES,
    CHANNEL_MAPS,                      // four channels of records, with option record-maps
    CHANNEL_NOISY = CHANNEL_MAPS + 4,  // with option denoise
    CHANNEL_UNCACHED = CHANNEL_NOISY + 3,
    CHANNEL_VARIANCE = CHANNEL_UNCACHED + 3,
    CHANNEL_CRYPTOMATTE = CHANNEL_VARIANCE + 3,  // with option cryptomatte
    FILM_CHANNELS = CHANNEL_CRYPTOMATTE + CRYPTOMATTES * CRYPTOMATTE_CHANNELS,
    NAMES_MAX = FILM_CHANNELS + AOV_CHANNELS_MAX  // of an image
};

// The planes of a film's channels, and of those of the scene's AOVs; NULL: the film does not have
// the channel.
struct channel_planes {
    float *of[FILM_CHANNELS];
    float *aov[AOV_CHANNELS_MAX];
};

// Whether the image has its first samples, and whether more are being taken.
enum image_state {
    IMAGE_EMPTY,      // some pixel of the coarsest grid has no sample
    IMAGE_BEGINNING,  // the first samples are being taken
    IMAGE_PAUSED,     // every pixel of the coarsest grid has a sample
    IMAGE_SAMPLING    // more samples are being taken
};

// The time of an edge: of its regression, and of each of its rays.
struct surface_seconds {
    double fixed, ray;
};

struct render_image {
    int width, height;
    struct image_pixel *pixel;
    const struct scene_aovs *aovs;
    // Weighted sums of each pixel's aovs->values, followed by those of their squares for `moment`,
    // pixel by pixel; NULL: there are none.
    float *aov;
    size_t sums;  // number of sums per pixel
    struct render_cryptomatte cryptomatte;
    struct image_gathered *gathered;  // pixel by pixel; NULL: irradiance is not filtered
    rgb *irradiance;                  // what its filter adds to the means of pixels; NULL before it
    struct adaptive_sampling adapt;
    struct image_blocks *blocks;  // of path, for its variance; else NULL
    uint32_t block;               // number of samples of a block, a power of two
    uint64_t taken;               // number of samples of all passes that have ended
    uint64_t begun;               // number of samples of the pass that has begun, else 0
    double sample_seconds;        // of one sample in the last pass; 0: none has ended
    struct shade_counts counts;   // of all samples
    atomic_bool progressed;       // a tile had samples and was not stopped since this was reset
    atomic_bool unwritten;        // the state has changed since it was written or restored
    struct surface_seconds edge_time;  // with a time limit; 0: not known
    double edge_seconds;      // that edges will take, or are expected to before all samples
    uint64_t edges_planned;   // `taken` when these were found; 0: never
    bool noise_fits;          // whether a time limit allows the filter of noise
    double unsampled;         // fraction of the pixels for whose first one a limit is too short
    uint64_t rims_taken;      // `taken` when rims were sampled last; 0: never
    bool rare_emission;       // whether many pixels had emission by chance then
    int coarsest;             // pixels between the first samples, a power of two
    struct satin_film *film;  // the film that is made from the image
    // For each tile, who uses its pixels at the moment; NULL: there are no snapshots, for which
    // alone it is needed (render_snapshot.c).
    _Atomic int *tile_user;
    atomic_bool tiles_wanted;  // whether a snapshot waits for tiles that workers have
    enum image_state state;
    struct image_pass *pass;  // that is running
    // Only if noise is filtered, else NULL:
    struct image_noisy *noisy_light;  // pixel by pixel
    struct image_change *change;
    // Only if the image is to be denoised, else NULL:
    struct image_uncached *uncached;   // pixel by pixel
    struct image_denoised *explained;  // pixel by pixel, once there is a result
    rgb *planes;              // four images: means of the light, albedo, normal, and the result
    struct film_noisy noisy;  // what the denoiser reads of these
    bool has_features;        // whether pixels know how many rays for features they want
    bool denoised;            // whether there is a result
    bool filled;              // whether pixels without a sample have features of their own
};

static inline size_t render_pixel_count(const struct render_image *image) {
    return (size_t)image->width * (size_t)image->height;
}

// Pixels of an image, as y * width + x (render_pixel_list.c).
struct pixel_list {
    uint32_t *pixel;  // memory for all of the image
    uint32_t *found;  // number of those of each row
    size_t count;
};
// An empty list. False if there is no memory; either way it is to be destroyed.
bool render_pixels_make(struct pixel_list *list, const struct render_image *image);
void render_pixels_destroy(struct pixel_list *list);
typedef bool render_pixel_fn(const void *ctx, size_t pixel);
// Fills an empty list with the pixels of r->image of which it holds, row by row.
void render_pixels_find(struct pixel_list *list, const struct render *r, render_pixel_fn *holds,
                        const void *ctx);

// The sampled pixel whose values are used at (x, y): the pixel itself, or the nearest one in the
// grids of the first samples; NULL if there is none (render_film.c).
const struct image_pixel *render_image_source(const struct render_image *image, int x, int y);
// Whether the denoiser had features of a pixel's own although another one's values are used.
static inline bool render_is_filled(const struct render_image *image, size_t at,
                                    const struct image_pixel *source) {
    return image->filled && source != &image->pixel[at] && image->uncached[at].weight > 0.0f;
}
// The factor from a pixel's weighted sums to means.
float render_image_scale(const struct image_pixel *pixel);

// The film of snapshots, and when the next one is made (render_snapshot.c).
struct render_snapshot {
    struct satin_film *film;
    struct channel_planes planes;
    unsigned char *has;  // of each pixel, whether the film has a value of its own samples
    size_t pixels, missing;
    double next;  // wall clock before which no snapshot is made
};

// Tiles of IMAGE_TILE x IMAGE_TILE pixels, row by row.
enum { IMAGE_TILE = 16 };
// The worker samples a tile from the first call to the second one. It waits for a snapshot that
// reads the tile, which takes microseconds (render_snapshot.c).
void render_tile_begin(struct render_image *image, size_t tile, int worker);
void render_tile_end(struct render_image *image, size_t tile);
// Between two samples of the tile: leaves it to a snapshot that waits for it.
void render_tile_yield(struct render_image *image, size_t tile, int worker);

// The planes of a film that has some of the image's channels (render_film_channels.c).
struct channel_planes render_film_planes(const struct render_image *image, struct satin_film *film);
// Sets pixel `at` of all planes to the values of `source`, a sampled pixel of the image; if it is
// NULL, only the number of samples.
void render_film_put(const struct render_image *image, const struct channel_planes *planes,
                     size_t at, const struct image_pixel *source);

// ---- The filter of irradiance where no record is near (render_irradiance_filter.c)

// The number of rays from which on it averages no more; 0 if an image with these options is not
// filtered.
float render_irradiance_rays(const satin_options *options);
// The largest radius of a kernel, in pixels.
float render_irradiance_radius(const struct render_image *image, const satin_options *options);
// Adds what a sample has gathered.
void render_irradiance_gathered(struct image_gathered *sum, const struct shade_sample *sample);
// The change of the diffuse indirect light of pixel (x, y), which has a sample, by kernels up to
// this radius in pixels.
rgb render_irradiance_change(const struct render_image *image, const struct satin_scene *scene,
                             const satin_options *options, float radius, int x, int y);
// Sets image->irradiance, if there is what the filter needs, and the time. False if there is no
// memory.
bool render_irradiance_filter(struct render *r);

// ---- The filter of noise (render_noise_filter.c, render_noise_sums.c)

// Whether an image with these options is filtered.
bool render_noise_filter_on(const satin_options *options);
// Allocates its memory, which is freed with the image. False if there is no memory.
bool render_noise_memory(struct render_image *image);
// Adds a sample to the half of `parity`, of which the last bit counts.
void render_noise_add(struct image_noisy *sum, int parity, const struct shade_sample *sample);
// Sets image->change, for an image with samples. False if there is no memory.
bool render_noise_change(struct render_image *image, struct parallel *pool);
// What a pixel takes of one core, measured at some of them that have no samples; 0 if there is no
// memory.
double render_noise_pixel_seconds(void);
// Filters the image, if each pixel has a sample and there is the time. False if there is no memory.
bool render_noise_filter(struct render *r);

// ---- Edges (render_edges.c, render_edges_plan.c)

// Whether an image with these options has rays at edges.
bool render_edges_on(const satin_options *options);
enum { RENDER_EDGES_BYTES = 88 };  // its memory per pixel, at most
// With a time limit, measures what the next function will take, and decides whether there is the
// time; there is none if there is no memory. To be called between passes, of which those count that
// add a quarter to the samples.
void render_edges_plan(struct render *r);
// If each pixel has a sample, changes the light of pixels at edges of surfaces, after the filter of
// noise, by eye rays that show what they see; and albedo, normal, depth and alpha. To be called if
// the image is whole. False if there is no memory.
bool render_edges(struct render *r);

// Allocates memory for denoising, which is freed with the image. False if there is no memory
// (render_denoise.c).
bool render_denoise_memory(struct render_image *image);
// If the image is to be denoised and all pixels have a sample, takes the rays for features that are
// missing (render_features.c). To be called before each pass.
satin_status render_features(struct render *r);
// After a time limit that was over before all pixels had a sample: one such ray in each of those
// without, unless these take too long. They are not in checkpoints.
satin_status render_features_late(struct render *r);

// ---- Passes (render_image_pass.c)

// What the workers of an image need.
struct image_pass {
    struct render *r;
    struct image_worker *worker;
    int columns;  // of tiles
};

// False if there is no memory.
bool render_pass_make(struct image_pass *pass, struct render *r);
void render_pass_destroy(struct image_pass *pass);
// Takes samples until every pixel has its target. False if that was stopped early.
bool render_pass_run(struct image_pass *pass);
// Adds the counts of this rank's samples to those of the image.
void render_pass_collect_own(struct image_pass *pass);

// ---- The state as bytes (render_image_state.c)

// A rectangle of pixels [x0, x1) x [y0, y1).
struct image_box {
    int x0, y0, x1, y1;
};
// Appends all that the samples of the pixels have changed.
void render_image_pack_box(const struct render_image *image, struct image_box box,
                           struct bytes *out);
void render_image_unpack_box(struct render_image *image, struct image_box box,
                             struct bytes_reader *in);
// Appends the whole state, from which sampling can go on.
void render_image_pack(const struct render_image *image, struct bytes *out);
// False if the bytes are not the state of such an image.
bool render_image_unpack(struct render_image *image, const struct bytes *in);

// Takes additional eye rays for emitted light after a pass, a few in each pixel and many where it
// varies. To be called when all samples that are distributed equally are taken; `late`: after a
// time limit that was over before. *whole is false if it was stopped early.
satin_status render_rims(struct render *r, bool late, bool *whole);
// The core time of a ray for emission alone, measured at some pixels by rays that do not count.
double render_rims_ray_seconds(struct render *r);
enum { RENDER_RIMS_BYTES = 29 };  // its memory per pixel, at most
// Whether the render takes such rays. Integrator `path` is for comparison, and takes nothing but
// its samples.
bool render_has_rims(const struct render *r);

// Checks that the image has each layer of option layers; else logs one line
// (render_film_channels.c).
satin_status render_film_check(const struct satin_scene *scene, const satin_options *options,
                               struct log log);
// The number of the channels of a film that has all layers of the options (render_film_channels.c).
int render_film_channels(const struct satin_scene *scene, const satin_options *options);
// Makes an empty film for an image; NULL if there is no memory (render_film_channels.c).
struct satin_film *render_film_new(const struct satin_scene *scene, const satin_options *options);

#endif
