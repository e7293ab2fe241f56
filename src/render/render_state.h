// SPDX-License-Identifier: Apache-2.0
// Private to render/: what the steps of a render share.
#ifndef RENDER_STATE_H
#define RENDER_STATE_H

#include "film/film.h"
#include "render/render_adapt.h"
#include "satin/render.h"
#include "shade/shade.h"

struct render {
    struct satin_scene
        scene;  // the caller's scene with the film size and camera of this render; owns nothing
    satin_options options;  // resolved: no field means "the scene's" any more
    satin_callbacks callbacks;
    struct log log;
    struct parallel *pool;
    struct stats stats;
    double start;  // wall clock at the beginning

    // Progress of the stage under way.
    const char *stage, *unit;
    double stage_start, stage_items;
    double share_done, share_span;  // the part of the stage that the loop under way is
    double told;                    // when the caller was last told
    double stop_at;                 // elapsed seconds that end the loop under way; INFINITY: none
    bool cancelled;
    // Cancelled before the image, in the stage of that name: a first look is taken all the same.
    const char *sketch;
    bool sketch_direct;  // at direct light alone
    satin_options sketch_options;
    bool error_told;

    int64_t photons_wanted;  // of the global map, without a time limit
    bool photons_chosen;     // by the user: no more than these
    double photons_share;    // that were made of them; 0: none were wanted
    struct photon_maps *maps;
    struct guide_visibility *visibility;  // of the lights; NULL: all is seen
    struct gather gather;
    struct shade_tables tables;
    struct render_level *levels;  // records of each bounce behind the image, see render_levels.c
    int level_count;
    struct cache *cache;
    char *cache_bytes;              // of the file that was read, or NULL
    struct cache_file *cache_file;  // the same
    satin_status saved;             // whether the records could be written to a file
    struct shade shade;
    struct render_image *image;
    bool image_begun;
    struct film_denoiser *denoiser;  // NULL: the image stays as it is
    satin_status denoised;           // what became of it
};

// ---- render_options.c: options and scene hints -> what is rendered
satin_status render_resolve(struct render *r, const struct satin_scene *scene,
                            const satin_options *options);

// ---- render_progress.c
// Opens a stage of `items` units; closes the one before and notes its seconds under its name.
void render_stage(struct render *r, const char *stage, const char *unit, double items);
// The next loops are the part [done, done + span] of the stage.
void render_stage_part(struct render *r, double done, double span);
void render_progress_install(struct render *r);  // makes the pool tell the caller
// Tells the caller, if it is time to; false if that cancelled the render.
bool render_progress_tell(struct render *r, double done);
double render_elapsed(const struct render *r);
// Seconds that are left of options.time; INFINITY without a limit.
double render_time_left(const struct render *r);
// What denoising, making and writing the film is going to take.
double render_write_seconds(const struct render *r);

// ---- render_photons.c
// Photons and the rough solution, as many as a time limit allows.
satin_status render_photons(struct render *r);
// The constants of gathering. Photons that there was no time for are not missed.
struct gather render_gather(const struct render *r);

// ---- render_levels.c
// Records of deeper bounces, if the first pass is `recursive`; gather then reads them.
satin_status render_levels(struct render *r);
void render_levels_free(struct render *r);

// ---- render_share.c
// *share: the records' share of the time that is left, judged by sampling a few pixels; it stays as
// it is if that was cut short. `rays_per_second` is the pace at which records were gathered so far.
satin_status render_share(struct render *r, double rays_per_second, double *share);

// ---- render_cache.c: files of records
// Reads the file that the caller named, if any, and refuses one that does not fit.
satin_status render_cache_open(struct render *r);
// Puts its records into the cache. *whole: the image needs no more.
satin_status render_cache_load(struct render *r, bool *whole);
satin_status render_cache_save(const struct render *r);  // if the caller named a file
void render_cache_free(struct render *r);

// ---- render_records.c
// Fills the cache over the image's shading points, coarse to fine.
satin_status render_records(struct render *r);
// The pixels y * width + x of a grid of that stride, without those of the grid twice as coarse if
// `finer`, scrambled by Fisher and Yates; malloc, NULL without memory.
uint32_t *render_grid(const struct render *r, int stride, bool finer, size_t *count);
bool render_time_remains(void *render);  // until stop_at
// For cache_fill: what the eye sees at a site.
bool render_view(void *render, const struct cache_site *site, struct cache_view *out);
// The factor of a over which no record is read: what the image pass may use.
float render_widest(const struct render *r);

// ---- render_converge.c
// Adapts the records to the eye's points [K05 6.3]; they were filled at `widen` times a and will be
// read at `read` times the options' a, irradiance and radiance.
satin_status render_converge(struct render *r, float widen, const float read[2]);

// ---- render_image.c
struct render_image *render_image_new(const struct satin_scene *scene,
                                      const satin_options *options);
void render_image_free(struct render_image *image);
// Adds samples until every pixel has options.spp, or the loop was stopped.
satin_status render_image_fill(struct render *r);

// ---- render_denoise.c
// Opens the denoiser, if the options want one.
satin_status render_denoiser(struct render *r);
// What denoising is going to take [s], or half of a time limit if it is going to take more.
double render_denoise_seconds(const struct render *r);
// Denoises the image, if more of it is there than a first look; r->denoised says what became of it.
// SATIN_CANCELLED: the caller did not want to wait.
void render_denoise(struct render *r);

// ---- render_film.c
// Fills the image's film with what is there. *any: some pixel has a sample.
void render_image_film(struct render *r, bool *any);

// ---- render_metadata.c
// Attributes and statistics of a finished film; false without memory.
bool render_metadata(struct render *r, struct satin_film *film);

#endif
