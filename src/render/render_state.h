// SPDX-License-Identifier: Apache-2.0
// Private to render/: what the steps of a render have in common.
#ifndef RENDER_STATE_H
#define RENDER_STATE_H

#include "film/film.h"
#include "render/render_adaptive_sampling.h"
#include "render/render_budget.h"
#include "satin/render.h"
#include "shade/shade.h"

// The stages of a render, in the order of the light. What a caller reads of each is in the table of
// render_progress.c.
enum render_stage {
    STAGE_SETUP,    // options, files and memory; nothing is reported, so it is never cancelled
    STAGE_PHOTONS,  // photons and the first-pass radiance estimate
    STAGE_TABLES,   // BRDFs in harmonics
    STAGE_BOUNCES,  // records of the indirect bounces beyond the first
    STAGE_RECORDS,  // records of the first indirect bounce
    STAGE_IMAGE,
    STAGE_DENOISE,
    STAGE_FILM
};

// What becomes of the image. A caller who cancels before it gets one coarse look.
enum render_look {
    LOOK_WHOLE,         // as many samples as the options ask for
    LOOK_WITH_RECORDS,  // a coarse look with the records that are there
    LOOK_DIRECT         // a coarse look with direct light alone
};

// Where the render stands, and what ends it: its deadline, or the caller, who may cancel it.
struct render_progress {
    enum render_stage stage;         // the stage under way
    enum render_stage cancelled_in;  // the stage that the caller cancelled; STAGE_SETUP: none
    enum render_look look;
    double start;        // wall clock at the beginning of the render
    double deadline;     // seconds after it that end the loop under way; INFINITY: nothing does
    double stage_start;  // wall clock at the beginning of the stage
    double items;        // units of work of the stage; 0: they are not counted
    double loop_done, loop_span;  // the loop under way is [done, done + span] of the stage
    double last_report;           // wall clock when the caller was last asked
};

// Photons, and what was found of the lights with them.
struct render_first_pass {
    int64_t wanted;       // photons of the global map without a time limit
    bool chosen_by_user;  // no more than these are made
    double made;          // fraction of `wanted` that was made; 0: none were wanted
    struct photon_maps *maps;
    struct gather_direct_table direct;    // at the entries of the maps
    struct guide_visibility *visibility;  // of the lights; NULL: every light is sampled everywhere
};

// Final gathering, and the records of what it found.
struct render_second_pass {
    struct gather gather;
    struct shade_tables tables;
    struct render_bounce *bounces;  // records of the indirect bounces beyond the first
    int bounce_count;
    struct cache *cache;
    struct shade shade;
    char *file_bytes;         // of the file of records that the caller named, or NULL
    struct cache_file *file;  // its records
    satin_options direct;     // options of a look at direct light alone
};

// How the parts of the render ended that do not stop it.
struct render_outcome {
    satin_status saved;     // whether the records could be written to a file
    satin_status denoised;  // whether the image is denoised, or was to stay as it is
    bool error_logged;      // an error message has gone to the caller
};

struct render {
    // What the caller gave. The scene has the film size and camera of this render and owns nothing;
    // the options are resolved: no field means "the scene's" any more.
    struct satin_scene scene;
    satin_options options;
    satin_callbacks callbacks;
    // What all steps use.
    struct log log;
    struct parallel *pool;
    struct stats stats;
    // What they have made.
    struct render_progress progress;
    struct render_first_pass first_pass;
    struct render_second_pass second_pass;
    struct render_image *image;
    struct film_denoiser *denoiser;  // NULL: the image stays as it is
    struct render_outcome outcome;
};

// Whether the caller cancelled.
static inline bool render_cancelled(const struct render *r) {
    return r->progress.cancelled_in != STAGE_SETUP;
}

// ---- render_options.c: options and scene hints -> what is rendered
satin_status render_resolve(struct render *r, const struct satin_scene *scene,
                            const satin_options *options);

// ---- render_progress.c
// Opens a stage of `items` units; closes the one before and notes its seconds under its name.
void render_stage_begin(struct render *r, enum render_stage stage, double items);
// The name of a stage that is reported; static storage.
const char *render_stage_name(enum render_stage stage);
// The next loops are the part [done, done + span] of the stage.
void render_stage_part(struct render *r, double done, double span);
// Makes the pool report to the caller, and stop its loops when that cancels or the time is up.
void render_progress_install(struct render *r);
// Reports to the caller, if it is time to; false if the caller cancelled now, and not before.
bool render_progress_report(struct render *r, double done);

// ---- render_photons.c
// Photons, as many as a time limit allows, and the first-pass radiance estimate by them.
satin_status render_photons(struct render *r);
// The constants of gathering. Photons that there was no time for are not missed.
struct gather render_gather(const struct render *r);
// Samples direct light where irradiance was precomputed, if gather rays read that.
satin_status render_direct(struct render *r);

// ---- render_bounces.c
// Records of the indirect bounces beyond the first, if the first pass is `recursive`; gather rays
// then read them.
satin_status render_bounces(struct render *r);
void render_bounces_free(struct render *r);

// ---- render_pilot.c
// Samples a few pixels with the records that are there; sets all of *pace but its rays.
// SATIN_CANCELLED if it was cut short.
satin_status render_pilot(struct render *r, struct render_pace *pace);

// ---- render_cache.c: files of records
// Reads the file that the caller named, if any, and refuses one that does not fit.
satin_status render_cache_open(struct render *r);
// Puts its records into the cache. *whole: the image needs no more.
satin_status render_cache_load(struct render *r, bool *whole);
satin_status render_cache_save(const struct render *r);  // if the caller named a file
void render_cache_free(struct render *r);

// ---- render_records.c
// Final gathering: fills the cache over the image's shading points, coarse to fine, or from the
// file that the caller named; then adapts it, and saves it if the caller wants that.
satin_status render_records(struct render *r);

// ---- render_sites.c: where records may be needed
// The pixels y * width + x of a grid of that stride, without those of the grid twice as coarse if
// `finer`, scrambled by Fisher and Yates; malloc, NULL without memory.
uint32_t *render_grid(const struct render *r, int stride, bool finer, size_t *count);
// An array of sites that grows; begins as all zeros.
struct render_sites {
    struct cache_site *site;
    size_t count, capacity;
};
// Replaces the sites by those that the eye sees in `count` pixels, in their order; `adaptive`: with
// what cache_adapt asks of them. SATIN_CANCELLED, SATIN_ERROR_MEMORY.
satin_status render_find_sites(struct render *r, const uint32_t *pixel, size_t count, bool adaptive,
                               struct render_sites *sites);
void render_sites_free(struct render_sites *sites);

// ---- render_adaptive_cache.c
// Adapts the records to the points that the eye sees [K05 6.3], for reading them at the accuracies
// that the options name.
satin_status render_adaptive_cache(struct render *r);

// ---- render_image.c
struct render_image *render_image_new(const struct satin_scene *scene,
                                      const satin_options *options);
void render_image_free(struct render_image *image);
// Adds samples until every pixel has options.spp, or the loop was stopped.
satin_status render_image_fill(struct render *r);

// ---- render_denoise.c
// Opens the denoiser, if the options want one.
satin_status render_denoiser(struct render *r);
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
