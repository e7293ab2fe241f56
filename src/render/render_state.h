// SPDX-License-Identifier: Apache-2.0
// Private to render/: the common state of all steps of a render.
#ifndef RENDER_STATE_H
#define RENDER_STATE_H

#include "film/film.h"
#include "render/render_adaptive_sampling.h"
#include "render/render_budget.h"
#include "render/render_memory.h"
#include "satin/render.h"
#include "shade/shade.h"

// The stages of a render, in the order of the light. The table in render_progress.c has what is
// reported of each.
enum render_stage {
    STAGE_SETUP,     // options, files and memory; like STAGE_FILM not reported, so not cancelled
    STAGE_FORECAST,  // a small render, which measures how long this one will take
    STAGE_PHOTONS,   // photons and the first-pass radiance estimate
    STAGE_TABLES,    // BRDFs in harmonics
    STAGE_BOUNCES,   // records at the surfaces of indirect bounces
    STAGE_RECORDS,   // records at the surfaces that are seen
    STAGE_IMAGE,
    STAGE_DENOISE,
    STAGE_FILM
};

// The course of a render: how it makes its image. It begins with that of the options and changes at
// most three times, by render_take_course; a table in render_progress.c has the steps of each.
enum render_course {
    // By the options:
    COURSE_TWO_PASS,     // photons, records and final gathering
    COURSE_SHORT_PATHS,  // as two passes, but paths are so short that there is no indirect light
    COURSE_FIRST_PASS,   // the first pass is seen directly, without final gathering
    COURSE_PHOTONS,      // photons are seen directly
    COURSE_DIRECT,       // direct light alone
    COURSE_PATHS,        // path tracing, also if there is no time for photons
    COURSE_SPPM,         // progressive photon mapping: photons in every pass of the image
    // From any course, if the caller cancels before the image has its first samples:
    COURSE_COARSE,        // a coarse image with the records so far
    COURSE_COARSE_DIRECT  // a coarse image with direct light alone
};

// What a course consists of.
struct course_steps {
    satin_integrator integrator;  // by which the image is sampled
    unsigned stages;              // a mask of 1u << render_stage: those before STAGE_IMAGE
    bool passes;                  // each pass of the image has new photons
    bool coarse;  // the image has only its first samples, and is completed after the cancellation
};

// The seconds that records and image are expected to take, by a small render; 0: there was none.
struct render_forecast {
    double records, image;
};

// The progress of the render, and what ends it: its deadline, or the caller, who may cancel it.
struct render_progress {
    enum render_stage stage;         // current stage
    enum render_stage cancelled_in;  // in which the caller cancelled; STAGE_SETUP: not cancelled
    enum render_course course;
    bool replaced;       // COURSE_PATHS is instead of another one
    double start;        // wall clock at the beginning of the render
    double covered;      // seconds after it at which the first round of records should be done
    double deadline;     // seconds after it at which the current loop is stopped; INFINITY: none
    double stage_start;  // wall clock at the beginning of the stage
    double items;        // units of work of the stage; 0: not counted
    double skipped;      // fraction of the stage that an earlier process has done
    double loop_done, loop_span;  // the current loops are [done, done + span] of the stage
    double range_start;           // wall clock at the beginning of that range
    double range_done;            // fraction of it that was reported
    double maps_done, map_at;     // of photons: before the current map, and before its current part
    double photons_end, caustics;  // seconds after the beginning until which photons take, by so
                                   // many photons of caustics; 0: not known
    double last_report;            // wall clock at the last report to the caller
    struct render_forecast forecast;
    // Seconds of one core for writing a pixel of the film, for filtering its noise, and for a ray
    // for emission alone, in all pixels and at rims; 0: there is no time limit, or they are not
    // known.
    double write_pixel_seconds, noise_pixel_seconds, rim_pixel_seconds, rim_ray_seconds;
};

// The first pass: photons, and the visibility of the lights.
struct render_first_pass {
    int64_t wanted;  // photons of the global map without a time limit
    // The numbers of photons and of those of caustics that the user has chosen are not increased.
    bool photons_chosen, caustics_chosen;
    double made;      // fraction of `wanted` that was traced; 0: none were wanted
    double fraction;  // of integrators photons and sppm, of the options' photons that fit; 0:
                      // not known yet
    struct photon_maps *maps;
    struct photon_sppm *sppm;             // of integrator sppm; it has no maps
    struct gather_direct direct;          // at the entries of the maps
    struct gather_entry_samples samples;  // for it
    struct guide_visibility *visibility;  // of the lights; NULL: all lights are assumed visible
    struct guide_emission *emission;      // where caustic paths start; NULL: there are none
};

// The second pass: final gathering, and its records.
struct render_second_pass {
    struct gather gather;
    struct cache_tables tables;
    struct render_bounce *bounces;  // records of the indirect bounces; [0] has those of bounce 1
    int bounce_count;
    struct cache *cache;
    struct fill *fill;  // makes the records of the cache
    struct shade shade;
    bool lights_chosen;       // whether the number of light samples was given
    char *file_bytes;         // contents of the caller's file of records, or NULL
    size_t file_size;         // number of its bytes
    struct cache_file *file;  // its records
};

// Results of those steps of the render that do not end it.
struct render_outcome {
    satin_status saved;         // whether the records could be written to a file
    satin_status checkpointed;  // whether the checkpoint could be written
    satin_status denoised;      // whether the image was denoised, if that was requested
    bool error_logged;          // whether an error was logged
};

// The frames of an animation.
struct render_frames {
    struct camera *view;  // of all of them; NULL: the render has one image
    double *records;      // number of records that were made for each view
    bool *complete;       // whether the caller has the image of a view already
    char *job;            // of this render, as satin:job in its films; from malloc
    int next;             // number of the next frame
    int wanted, begun;    // images that are to be made, and that were begun
    // Seconds from the beginning of the render to that of the present image, and of the first one.
    double start, images_start;
    struct stats common;  // statistics of what all frames have in common
};

// What is needed where objects move.
struct render_motion {
    const satin_options *options;  // of the caller, not resolved
    struct render_tests *tests;    // of the records of the scene at rest, or NULL
    // In the render of a frame:
    const struct render *at_rest;  // the render of the scene at rest
    const struct camera *camera;   // the camera of the frame
};

struct render {
    // Given by the caller. The scene has the film size and camera of this render and owns nothing;
    // the options are resolved: no field means "the scene's" any more. render_resolve sets both.
    // After it the camera is that of the present frame, the integrator that of the course, and a
    // limit of memory may lessen threads and photons, and one of time the photons of integrators
    // photons and sppm; where samples are added to a checkpoint, spp is its own until the image is
    // begun. Nothing else changes.
    struct satin_scene scene;
    satin_options options;
    satin_callbacks callbacks;
    // Used by all steps.
    struct log log;
    struct parallel *pool;
    struct stats stats;
    struct render_memory memory;  // the limit of the options, and estimates
    // Results of the steps.
    struct render_progress progress;
    struct render_first_pass first_pass;
    struct render_second_pass second_pass;
    struct render_frames frames;
    struct render_motion motion;
    struct render_image *image;
    struct render_snapshot *snapshot;      // NULL: there was none so far
    struct film_denoiser *denoiser;        // NULL: the image is not denoised
    struct render_checkpoint *checkpoint;  // NULL: there is none
    struct render_outcome outcome;
};

// Whether the caller cancelled.
static inline bool render_cancelled(const struct render *r) {
    return r->progress.cancelled_in != STAGE_SETUP;
}

// ---- render_state.c
// NULL if there is no memory. `callbacks` may be NULL.
struct render *render_new(const satin_callbacks *callbacks);
void render_free(struct render *r);  // NULL is allowed
// The status of a render that has ended: its own or, if its images are complete, that of writing
// its records and checkpoint. Logs that there is no memory, if nothing was logged. r may be NULL.
satin_status render_final_status(struct render *r, const satin_callbacks *callbacks,
                                 satin_status status);

// ---- render_options.c: options and scene hints -> what is rendered
satin_status render_resolve(struct render *r, const struct satin_scene *scene,
                            const satin_options *options);

// ---- render_window.c: the film, of the scene's and of the options of its size and crop
// Sets the film of a copy of the scene. If a part of it is rendered, *o gets its window. Else, and
// after a failure, *o is unchanged.
satin_status render_window(struct satin_scene *scene, satin_options *o, struct log log);

// ---- render_animation.c: the frames of an animation
// Sets the cameras of all frames, and checks that the animation can be rendered. Does nothing if
// there is one image.
satin_status render_views(struct render *r);
void render_views_free(struct render *r);
// Asks the caller which frames are complete, when all options and files are known. If all are, the
// course has no steps but the images.
satin_status render_frames_ask(struct render *r);
// If all of them are, no photons and records are made.
void render_frames_skip(struct render *r);
// The number of frames whose images are made; 0 if there is one image.
int render_frames_count(const struct render *r);
// The seconds until all images are made, `elapsed` seconds after the render began, if the present
// one is made in `left`; INFINITY: that is not known.
double render_frames_left(const struct render *r, double left, double elapsed);
// A hash of the cameras of all frames; 0 if there is one image.
uint64_t render_views_hash(const struct render *r);
// To be called when all that the frames have in common is made.
void render_frames_begin(struct render *r);
// Makes an empty image for the next frame and sets its camera. False if there is no further frame,
// or if that failed: then *status is not SATIN_OK.
bool render_frame_next(struct render *r, satin_status *status);
// Passes the film to the caller, and returns the status of that on rank 0.
satin_status render_frame_done(struct render *r, struct satin_film *film);

// ---- render_motion.c: frames in which objects and lights have moved
// Traces the test rays of the records of the scene at rest. To be called when all of them are made.
satin_status render_tests_make(struct render *r);
void render_tests_free(struct render_tests *tests);  // NULL is allowed
// In the render of a frame, adds to its cache the records of the scene at rest that are still
// right.
satin_status render_keep_records(struct render *r);
// Makes the render of the next frame, with what its film says of the frame. NULL: no memory.
struct render *render_frame_new(const struct render *at_rest);
// Asks the caller for the scene of that frame, which the caller of this function frees.
satin_status render_frame_scene(struct render *at_rest, satin_scene **scene);

// ---- render_progress.c
// The course of the render's options.
enum render_course render_first_course(const satin_options *options);
// Changes the course, and with it the integrator of the options and whether samples read records.
void render_take_course(struct render *r, enum render_course course);
// The steps of the render's present course; static storage.
const struct course_steps *render_steps(const struct render *r);
// Whether a stage before STAGE_IMAGE is one of them.
static inline bool render_has_stage(const struct render *r, enum render_stage stage) {
    return render_steps(r)->stages >> stage & 1u;
}
// Begins a stage of `items` units, ends the one before it and stores its seconds under its name.
void render_stage_begin(struct render *r, enum render_stage stage, double items);
// The name of a reported stage; static storage.
const char *render_stage_name(enum render_stage stage);
// The stage begins after this fraction, which an earlier process has done.
void render_stage_skip(struct render *r, double done);
// The following loops are the range [done, done + span] of the stage.
void render_stage_range(struct render *r, double done, double span);
// Makes the pool report to the caller, and stop its loops on cancellation or at the deadline.
void render_progress_install(struct render *r);
// The seconds until the whole render ends, `elapsed` seconds after it began, when `done` of the
// stage is done; negative if that is not known.
double render_progress_left(const struct render *r, double done, double elapsed);
// Reports to the caller, if it is time to. False if the caller has cancelled now, and not before.
bool render_progress_report(struct render *r, double done);

// ---- render_forecast.c
// Whether a small render is to measure how long this one will take.
bool render_forecasts(const struct render *r);
// Begins the small render, whose options are set. NULL if there is no memory.
struct render *render_forecast_new(struct render *r, satin_options *small);
// Takes what the small render, which has ended, has measured.
void render_forecast_take(struct render *r, const struct render *small);

// ---- render_photons.c
// Finds where the lights are visible, once. Without time for that, the course becomes COURSE_PATHS.
satin_status render_visibility(struct render *r);
// Reduces the photons that a quality has chosen if their paths have very many bounces.
satin_status render_reduce_photons(struct render *r);
// Traces as many photons as a time limit allows, and makes the first-pass radiance estimate. If
// there is no time for that of two passes, makes nothing, and the course becomes COURSE_PATHS.
satin_status render_photons(struct render *r);
// Finds where caustic paths start, for the request, unless it is known.
satin_status render_photon_emission(struct render *r, struct photon_request *request);
// Builds the photon maps from so many photons.
satin_status render_photon_maps(struct render *r, const struct render_photon_counts *counts);
// The time of the steps that grow with the number of photons.
double render_photon_seconds(const struct render *r);
// Frees the photons, so that others replace them. The statistics are those before them again; what
// is known of the lights is kept.
void render_drop_photons(struct render *r, struct stats before);
// The constants of gathering. The photon maps may be missing if there was no time for them.
struct gather render_gather(const struct render *r);
// Samples direct light at the entries of the precomputed irradiance, if gather rays read it.
satin_status render_direct(struct render *r);
// If each pass of the image has new photons, traces those of the next pass.
satin_status render_pass_photons(struct render *r);
// If each pass has new photons, skips those of the passes that a restored image has.
void render_skip_photons(struct render *r);

// ---- render_fit_photons.c
// The fraction of a number of photons, rounded up.
static inline int64_t render_fraction(int64_t photons, double fraction) {
    return (int64_t)ceil((double)photons * fraction);
}
// Traces the photons of integrators photons and sppm, as many as a time limit allows, and sets the
// options to them.
satin_status render_fit_photons(struct render *r);

// ---- render_paths.c
// Whether path tracing can replace two passes.
bool render_can_trace_paths(const struct render *r);
// Goes over to COURSE_PATHS, with a new image, which has the channels of that integrator.
// SATIN_ERROR_MEMORY, logged if it is that of the image.
satin_status render_trace_paths(struct render *r);

// ---- render_recursive_bounces.c
// If the first pass is `recursive`, makes the records of the indirect bounces, which gather rays
// then read.
satin_status render_recursive_bounces(struct render *r);
void render_recursive_bounces_free(struct render *r);

// ---- render_lookups.c
// Measures the cost and the noise of what single gather rays read of the first pass, as statistics
// first_pass.*; does nothing if there are no gather rays. SATIN_ERROR_MEMORY.
satin_status render_lookup_noise(struct render *r);

// ---- render_refine.c
// Gathers the entries of irradiance anew whose noise glossy lobes would show, if the options
// include that. SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status render_refine(struct render *r);

// ---- render_image_pilot.c
// Sample a few pixels with the records so far, the first pilot fewer ones; set all members of *pace
// except its rays. SATIN_CANCELLED if they were stopped early.
satin_status render_first_pilot(struct render *r, struct render_pace *pace);
satin_status render_image_pilot(struct render *r, struct render_pace *pace);

// ---- render_cache.c: files of records
// Reads the caller's file of records, if there is one, and refuses it if it does not fit.
satin_status render_cache_open(struct render *r);
// Adds the records of the file to the cache. *whole: the image needs no more.
satin_status render_cache_load(struct render *r, bool *whole);
// Whether the records of the file are all that this render would make.
bool render_cache_whole(const struct render *r);
satin_status render_cache_save(const struct render *r);  // if the caller has named a file
void render_cache_free(struct render *r);

// ---- render_identity.c
// All that the image depends on, as `name=value` words. From malloc; NULL if there is no memory.
char *render_identity(const struct render *r);
// A word `name=value` of such a text, without the blank after it.
struct identity_word {
    const char *at;
    size_t length, name;  // bytes of the whole word and of its name
};
// Goes behind the next word. False, and a word of no length, if there is none.
bool render_identity_next(const char **text, struct identity_word *word);
// Whether the word has this name.
bool render_identity_is(const struct identity_word *word, const char *name);
// Goes behind the next words that differ in two identities: *a is that of *here. Where the size of
// the image differs by its crop, these are the words of the crop. False if there are none.
bool render_identity_differ(const char **here, const char **there, struct identity_word *a,
                            struct identity_word *b);

// ---- render_checkpoint.c: results that a later process need not compute again
// Opens the caller's checkpoint, or makes a new one. From here on the pool writes to it what loops
// have computed, or takes it from there.
satin_status render_checkpoint_open(struct render *r);
// The status of the render, whose loops may have been cancelled because their results could not be
// taken from the checkpoint or from other ranks; logged.
satin_status render_checkpoint_check(const struct render *r, satin_status status);
void render_checkpoint_free(struct render *r);
// Whether the caller has a checkpoint, on any rank.
bool render_has_checkpoint(const struct render *r);
// The frames of an animation are begun; their images are not in the checkpoint.
void render_checkpoint_end_loops(struct render *r);
// All frames of the animation are complete, and the checkpoint serves no more.
void render_checkpoint_remove(struct render *r);
// To be called when all before the image is done. If this process adds samples to those of another
// one, the options have as many from now on, and the shading is made for them.
satin_status render_checkpoint_add_samples(struct render *r);
// To be called then. *restored: the image is as it was when its state
// was written. SATIN_ERROR_INPUT, logged, if that is damaged.
satin_status render_checkpoint_begin_image(struct render *r, bool *restored);
// Whether the running pass of the image should stop, so that the state of the image is written.
bool render_checkpoint_due(struct render *r);
// To be called after a pass has stopped. If that was for the checkpoint, writes the state of the
// image and returns true: the pass is to go on.
bool render_checkpoint_pause(struct render *r);
// To be called when a pass has ended, whose photons serve no more.
void render_checkpoint_end_pass(struct render *r);
// To be called between passes: writes the state of the image, if it is time to.
void render_checkpoint_between(struct render *r);
// Writes the state of the image, if there is a checkpoint that does not have it. If ranks are
// cancelled, this is the last one, and a copy of this process writes it.
void render_checkpoint_write(struct render *r);
// To be called when ranks are cancelled, before they exchange their samples: begins to write the
// state with those of this rank, lest this process is killed before the others' are there.
void render_checkpoint_interrupt(struct render *r);
// Waits for the copy of this process, and sets r->outcome.checkpointed.
void render_checkpoint_end(struct render *r);

// ---- render_checkpoint_timed.c: checkpoints of renders with a time limit
// Whether the render can have one: all but two passes, which decide by measured times what each
// record is.
bool render_timed_resumes(const struct render *r);
// Makes the options, but for the time limit itself, those that do not depend on measured times.
void render_timed_identity(const struct render *r, satin_options *options);
// Appends the seconds that the render has taken, and what it has decided by measured times:
// `chosen` are its options, as words, when its first pass began.
void render_timed_pack(const struct render *r, const char *chosen, struct bytes *out);
// Takes these over: the options and photons, and a beginning of the render that many seconds ago.
// False if the bytes are not what render_timed_pack has appended.
bool render_timed_unpack(struct render *r, struct bytes_reader *in);

// ---- render_ranks.c: several processes
// Whether this process writes files and messages: it is alone, or rank 0.
bool render_is_first(const struct render *r);
// Makes the pool divide its loops between the caller's ranks.
void render_ranks_install(struct render *r);
// The value of rank 0 on all ranks, such as a time on which a decision depends.
double render_agreed(const struct render *r, double value);
// The status of rank 0 on all ranks.
satin_status render_ranks_status(const struct render *r, satin_status status);
// The status of the first rank whose status is not SATIN_OK, if there is one. To be called once, by
// all ranks, when a rank has done all that can fail on it alone.
satin_status render_ranks_agree(const struct render *r, satin_status status);
// To be called by all ranks: SATIN_ERROR_INPUT on all, logged, if they have not all the same scene,
// options and version, and a checkpoint or none.
satin_status render_ranks_compare(const struct render *r);

// ---- render_records.c
// Fills the cache over the image's shading points, coarse to fine, or from the caller's file; then
// adapts it, and saves it if the caller has named a file. If a time limit leaves too little time,
// the course becomes COURSE_PATHS.
satin_status render_records(struct render *r);

// ---- render_sites.c: where records may be needed
// The pixels y * width + x of a grid of that stride, without those of the grid twice as coarse if
// `finer`, shuffled by Fisher and Yates. From malloc; NULL if there is no memory.
uint32_t *render_grid(const struct render *r, int stride, bool finer, size_t *count);
// A growing array of sites; all zeros at first.
struct render_sites {
    struct fill_site *site;
    size_t count, capacity;
};
// Replaces the sites by those that are seen by camera number `view` of the scene in `count` pixels,
// in the order of the pixels; if `adaptive`, with the members for fill_adapt. When there are `most`
// sites, it ends within RENDER_TRACED_PIXELS, and sets `count` to those that were searched.
// SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status render_find_sites(struct render *r, uint32_t view, const uint32_t *pixel,
                               size_t *count, size_t most, bool adaptive,
                               struct render_sites *sites);
void render_sites_free(struct render_sites *sites);

// ---- render_adaptive_cache.c
// Adapts the records to the points that are seen [K05 6.3], for reading them at the accuracies of
// the options.
satin_status render_adaptive_cache(struct render *r);

// ---- render_coarse.c
// If the render was cancelled before the image had its first samples, gives it coarse ones within a
// moment: with the records so far or, if that takes too long or there are none, with direct light
// alone. SATIN_CANCELLED, or SATIN_ERROR_MEMORY.
satin_status render_coarse(struct render *r);

// ---- render_image.c
// Makes what the image and the search for sites need. Samples interpolate between the records of
// the cache; NULL: they gather. SATIN_ERROR_MEMORY.
satin_status render_shading(struct render *r, const struct cache *cache);
// The most bytes of an image and its film, with the snapshots of the callbacks.
double render_image_bytes(const struct satin_scene *scene, const satin_options *options,
                          const satin_callbacks *callbacks);
struct render_image *render_image_new(const struct satin_scene *scene,
                                      const satin_options *options);
void render_image_free(struct render_image *image);  // NULL is allowed
// Replaces the image by an empty one, for the options as they are now. SATIN_ERROR_MEMORY, logged.
satin_status render_image_renew(struct render *r);
// Adds samples until every pixel has options.spp, or until the loop is stopped.
satin_status render_image_fill(struct render *r);

// ---- render_denoise.c
// Opens the denoiser, if the options include it.
satin_status render_denoiser(struct render *r);
// Denoises the image unless it is coarse, and sets the status r->outcome.denoised, which is
// SATIN_CANCELLED if the caller has cancelled.
void render_denoise(struct render *r);

// ---- render_film.c
// Fills the film from the image so far, whose pixels are lost. *any: some pixel has a sample.
void render_image_film(struct render *r, bool *any);

// ---- render_snapshot.c: the image while it is sampled, if the caller has asked for it
// Allocates what workers need for snapshots of the image, once. False if there is no memory.
bool render_snapshot_memory(const struct render *r, struct render_image *image);
// Passes a snapshot to the caller, if it is time to. Called on the calling thread when it is in the
// middle of no sample.
void render_snapshot_send(struct render *r);
void render_snapshot_free(struct render_snapshot *snapshot);  // NULL is allowed

// ---- render_metadata.c
// All options as options_print_words has them. From malloc; NULL if there is no memory.
char *render_options_text(const satin_options *options);
// Sets attributes and statistics of a finished film. False if there is no memory.
bool render_metadata(struct render *r, struct satin_film *film);

#endif
