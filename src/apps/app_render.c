// SPDX-License-Identifier: Apache-2.0
// satin render: request -> scene and options -> film -> files. Errors in the names of outputs are
// found before anything is rendered.
#include <malloc.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "apps/app_animation.h"
#include "apps/app_preview.h"
#include "apps/app_render.h"
#include "base/fileio.h"
#include "base/stats.h"
#include "film/film.h"
#include "scene/scene.h"

// The least fraction of a time limit that is left for the render if loading the scene takes long.
static const double LOAD_LEAVES = 0.2;

// With a limit of memory, arrays of this size are returned to the system when they are freed.
// Otherwise malloc raises it as they are, and later ones leave gaps: 30 passes of `sppm` took 1.3
// times the memory, and 18 textures of 9 million texels up to 24 MB more than 140 MB. It costs 2 %
// of the time of those passes.
enum { RETURNED_BYTES = 1 << 17 };

static void limit_gaps(int64_t memory) {
    if (memory > 0) mallopt(M_MMAP_THRESHOLD, RETURNED_BYTES);
}

// The ending of an output's name chooses its format.
static int check_format(const struct app_render_request *r) {
    if (!app_ends_in(r->output, ".exr") && !app_ends_in(r->output, ".png"))
        return app_wrong("%s: an image is written as .exr or .png, by the end of its name",
                         r->output);
    if (r->png && !app_ends_in(r->png, ".png")) return app_wrong("%s: --png writes a .png", r->png);
    if (r->preview && !app_ends_in(r->preview, ".png"))
        return app_wrong("%s: --preview writes a .png", r->preview);
    return APP_DONE;
}

// OUT.exr -> OUT and another ending; from malloc.
static char *name_beside(const char *output, const char *ending) {
    size_t n = strlen(output);
    if (app_ends_in(output, ".exr") || app_ends_in(output, ".png")) n -= 4;
    const size_t size = n + strlen(ending) + 1;
    char *name = malloc(size);
    if (name) snprintf(name, size, "%.*s%s", (int)n, output, ending);
    return name;
}

// Sets the names of outputs that were asked for without a name.
static int name_outputs(struct app_render_request *r) {
    if (r->want_png && !r->png && !app_ends_in(r->output, ".png")) {
        r->png = r->png_beside = name_beside(r->output, ".png");
        if (!r->png) return app_no_memory();
    }
    if (r->resume && !r->checkpoint) {
        r->checkpoint_beside =
            r->animation ? app_frame_checkpoint(r) : name_beside(r->output, ".checkpoint");
        r->checkpoint = r->checkpoint_beside;
        if (!r->checkpoint) return app_no_memory();
    }
    if (r->stats && strcmp(r->stats, "-") == 0) r->stats = APP_STDOUT;
    return APP_DONE;
}

// All outputs; the path of an output that was not asked for is NULL.
enum { OUTPUTS = 6 };
static void list_outputs(const struct app_render_request *r, struct app_output output[OUTPUTS]) {
    const bool png = app_ends_in(r->output, ".png");
    output[0] = (struct app_output){r->output, png ? FILEIO_APPEND : FILEIO_SEEK, NULL};
    output[1] = (struct app_output){r->png, FILEIO_APPEND, NULL};
    output[2] = (struct app_output){r->stats, FILEIO_APPEND, NULL};
    // A cache is read whole before anything is written, so it may be saved to the file it came
    // from.
    output[3] = (struct app_output){r->save, FILEIO_APPEND, r->load};
    // It is renamed again and again.
    output[4] = (struct app_output){r->preview, FILEIO_SEEK, NULL};
    output[5] = (struct app_output){r->checkpoint, FILEIO_SEEK, NULL};
}

static int check_files(const struct app_render_request *r,
                       const struct app_output output[OUTPUTS]) {
    const struct app_input input[] = {{r->scene, "the scene"},
                                      {r->animation, "the camera path"},
                                      {r->load, "the cache that is loaded"},
                                      {NULL, NULL}};
    return app_outputs_check(output, OUTPUTS, input);
}

// Checks the outputs. Those of an animation's frames are checked when the scene is there, which may
// decide how many there are.
static int check_outputs(const struct app_render_request *r) {
    if (!app_ranks_first(r->ranks)) return APP_DONE;
    struct app_output output[OUTPUTS];
    list_outputs(r, output);
    const int status = r->animation ? APP_DONE : check_files(r, output);
    return status == APP_DONE ? check_format(r) : status;
}

// Writes the statistics of the film and those of writing it.
static satin_status write_stats(const struct app_render_request *r, const satin_film *film,
                                const struct stats *written, struct log log) {
    const char *stats = satin_film_stats(film);
    if (!stats) return SATIN_OK;
    char *text = stats_json_append(stats, written);
    if (!text) return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", r->stats);
    const satin_status status = fileio_write(log, r->stats, text, strlen(text));
    free(text);
    return status;
}

static satin_status write_outputs(const struct app_render_request *r, const satin_film *film,
                                  int threads, double start, struct log log) {
    struct stats written = {.count = 0};
    satin_status status;
    if (app_ends_in(r->output, ".png")) {
        status = film_write_png_as(film, r->output, &r->tonemap, &r->format, log);
    } else {
        struct parallel *pool = parallel_new(threads);
        if (pool) parallel_begin_part(pool, "write");
        status = film_write_exr_as(film, r->output, &r->format, pool, log);
        if (pool) stats_set_work(&written, pool, "write");
        parallel_free(pool);
    }
    stats_set(&written, "time.whole_s", stats_wall() - start);
    // Each output is written, even if another one failed.
    satin_status png = SATIN_OK, json = SATIN_OK;
    if (r->png) png = film_write_png_as(film, r->png, &r->tonemap, &r->format, log);
    if (r->stats) json = write_stats(r, film, &written, log);
    if (status != SATIN_OK) return status;
    return png != SATIN_OK ? png : json;
}

static void print_summary(const struct app_render_request *r, const satin_film *film,
                          satin_status rendered, double seconds) {
    int width, height;
    if (r->quiet) return;
    satin_film_size(film, &width, &height);
    fprintf(stderr, "%s: %dx%d, %.2f s%s\n", r->output, width, height, seconds,
            rendered == SATIN_CANCELLED ? ", cancelled: what was done so far" : "");
    if (r->png) fprintf(stderr, "%s\n", r->png);
}

// What the function for a frame needs.
struct frame_user {
    const struct app_render_request *request;
    struct app_progress *progress;
    int threads, count;  // of the render; of the frames
    int done;            // frames whose files are written
    double start;
    const struct app_animation *animation;
};

// A satin_frame_fn: writes the files of a frame.
static satin_status write_frame_files(void *user, int number, const satin_film *film) {
    struct frame_user *u = user;
    struct app_render_request frame;
    const struct log log = {app_log_file, u->progress};
    if (!app_ranks_first(u->request->ranks)) return SATIN_OK;
    app_progress_end(u->progress);
    satin_status status = SATIN_ERROR_MEMORY;
    if (app_frame_begin(u->request, number, &frame) == APP_DONE)
        status = write_outputs(&frame, film, u->threads, u->start, log);
    if (status == SATIN_OK) u->done++;
    if (status == SATIN_OK && !u->request->quiet)
        fprintf(stderr, "%s: frame %d of %d\n", frame.output, u->done, u->count);
    app_frame_end(&frame);
    return status;
}

// A satin_moved_fn: loads the scene of a frame.
static satin_status find_frame_scene(void *user, int number, satin_scene **scene) {
    const struct frame_user *u = user;
    return app_animation_scene(u->request, u->animation, number, scene);
}

// A satin_complete_fn: whether the files of a frame are there, for --resume.
static satin_status find_frame_files(void *user, int number, const char *job, bool *complete) {
    struct frame_user *u = user;
    struct app_render_request frame;
    const struct log log = {app_log_file, u->progress};
    satin_status status = SATIN_ERROR_MEMORY;
    if (app_frame_begin(u->request, number, &frame) == APP_DONE)
        status = app_frame_complete(&frame, number, job, log, complete);
    u->count -= status == SATIN_OK && *complete;
    app_frame_end(&frame);
    return status;
}

// What shows the image while it is rendered, and its progress.
struct shown_image {
    struct app_progress *progress;
    struct app_preview preview;
    struct app_display display;
};

// A satin_progress_fn.
static bool show_progress(void *user, const satin_progress *now) {
    struct shown_image *shown = user;
    app_display_send(&shown->display);
    return app_progress_update(shown->progress, now);
}

// A satin_snapshot_fn.
static void show_snapshot(void *user, const satin_film *snapshot) {
    struct shown_image *shown = user;
    app_display_show(&shown->display, snapshot);
    app_preview_write(&shown->preview, snapshot);
}

// Shows the finished image; NULL: there is none. The snapshots are not valid any more.
static void show_image(struct shown_image *shown, const satin_film *film) {
    app_preview_finish(&shown->preview, film);
    app_display_finish(&shown->display, film);
}

// Renders, and shows the image meanwhile if that was asked for.
static satin_status run_shown(const struct app_render_request *r, const satin_scene *scene,
                              const satin_options *options, const satin_animation *animation,
                              struct shown_image *shown, satin_film **film) {
    const bool first = app_ranks_first(r->ranks), asked = r->preview || r->display.wanted;
    const satin_callbacks callbacks = {.log = app_log,
                                       .log_user = shown->progress,
                                       .ranks = r->ranks->ranks,
                                       .animation = animation,
                                       .progress = show_progress,
                                       .progress_user = shown,
                                       .forecast = first && app_progress_bar(shown->progress),
                                       .load_cache = r->load,
                                       .save_cache = r->save,
                                       .checkpoint = r->checkpoint,
                                       .resume = r->resume,
                                       .checkpoint_seconds = r->checkpoint_seconds,
                                       .snapshot = first && asked ? show_snapshot : NULL,
                                       .snapshot_user = shown,
                                       .full_float = r->format.full_float,
                                       .snapshot_beauty = !r->display.wanted};
    if (first) app_display_open(&shown->display, r->output, shown->progress);
    limit_gaps(options->memory);
    const satin_status status = satin_render(scene, options, &callbacks, film);
    app_progress_end(shown->progress);
    return status;
}

// Renders one image, and writes its files.
static satin_status run_image(const struct app_render_request *r, const satin_scene *scene,
                              const satin_options *options, struct shown_image *shown,
                              double start) {
    const struct log file_log = {app_log_file, shown->progress};
    satin_film *film = NULL;
    satin_status status = run_shown(r, scene, options, NULL, shown, &film);
    if (film && app_ranks_first(r->ranks)) {
        satin_status written = write_outputs(r, film, options->threads, start, file_log);
        if (written == SATIN_OK) print_summary(r, film, status, stats_wall() - start);
        if (written != SATIN_OK) status = written;
    }
    // Last, as it may wait for the viewer.
    if (app_ranks_first(r->ranks)) show_image(shown, film);
    satin_film_free(film);
    return status;
}

// Renders the frames of an animation, each of which is written when it is complete.
static satin_status run_animation(const struct app_render_request *r, const satin_scene *scene,
                                  const satin_options *options,
                                  const struct app_animation *animation, struct shown_image *shown,
                                  double start) {
    satin_animation frames = animation->frames;
    struct frame_user user = {.request = r,
                              .progress = shown->progress,
                              .threads = options->threads,
                              .count = frames.last - frames.first + 1,
                              .start = start,
                              .animation = animation};
    satin_film *none = NULL;
    frames.frame = write_frame_files;
    frames.complete = r->resume ? find_frame_files : NULL;
    frames.moved = animation->path.object_count ? find_frame_scene : NULL;
    frames.user = &user;
    const satin_status status = run_shown(r, scene, options, &frames, shown, &none);
    if (!app_ranks_first(r->ranks)) return status;
    const bool printed = !r->quiet && (status == SATIN_OK || status == SATIN_CANCELLED);
    const int left_out = frames.last - frames.first + 1 - user.count;
    if (printed && left_out > 0)
        fprintf(stderr, "%d frame%s complete before\n", left_out,
                left_out == 1 ? " was" : "s were");
    if (printed)
        fprintf(stderr, "%d frame%s, %.2f s%s\n", user.done, user.done == 1 ? "" : "s",
                stats_wall() - start, status == SATIN_CANCELLED ? ", cancelled" : "");
    show_image(shown, NULL);
    return status;
}

// The limit loses the time for reading the scene, which each rank takes otherwise.
static int check_time(const struct app_render_request *r, double time) {
    const satin_ranks *ranks = r->ranks->ranks;
    double first = time;
    if (ranks) ranks->broadcast(ranks->user, 0, &first, sizeof first);
    return first == time ? APP_DONE : app_wrong("not all processes have the same time limit");
}

static satin_status run_scene(const struct app_render_request *r, const satin_scene *scene,
                              const struct app_animation *animation, struct app_progress *progress,
                              double start) {
    satin_options options;
    // The user's options were checked before, so an error here is in the scene's options.
    satin_status status = satin_options_resolve(scene, r->setting, r->setting_count, app_log_file,
                                                progress, &options);
    // Ranks may have read other scenes, of which one has an error in its options.
    if (app_ranks_agree(r->ranks, app_exit_of(status)) != APP_DONE)
        return status != SATIN_OK ? status : SATIN_ERROR_INTERNAL;
    if (app_ranks_agree(r->ranks, check_time(r, options.time)) != APP_DONE)
        return SATIN_ERROR_INPUT;
    // The time limit includes the time for reading the scene.
    if (options.time > 0.0)
        options.time = fmax(options.time - (stats_wall() - start), LOAD_LEAVES * options.time);
    const satin_ranks *ranks = r->ranks->ranks;
    if (ranks) ranks->broadcast(ranks->user, 0, &options.time, sizeof options.time);
    struct shown_image shown = {
        progress, {r->preview, &r->tonemap, &r->format, progress, false}, r->display};
    return r->animation ? run_animation(r, scene, &options, animation, &shown, start)
                        : run_image(r, scene, &options, &shown, start);
}

// Checks that no output is a file of the scene, and of an animation that all frames can be written.
static int check_read(const struct app_render_request *r, const satin_scene *scene,
                      const struct app_animation *animation) {
    struct app_output output[OUTPUTS];
    list_outputs(r, output);
    if (!app_ranks_first(r->ranks)) return APP_DONE;
    if (!r->animation) return app_outputs_check_read(output, OUTPUTS, &scene->read);
    int status = APP_DONE;
    for (int i = animation->frames.first; i <= animation->frames.last && status == APP_DONE; i++) {
        struct app_render_request frame;
        status = app_frame_begin(r, i, &frame);
        if (status == APP_DONE) list_outputs(&frame, output);
        if (status == APP_DONE) status = check_files(r, output);
        if (status == APP_DONE) status = app_outputs_check_read(output, OUTPUTS, &scene->read);
        if (status == APP_DONE)
            status = app_frame_check_names(r, i, &frame, animation->frames.first,
                                           animation->frames.last);
        app_frame_end(&frame);
    }
    return status;
}

// Loads the scene and checks that no output is one of its files.
static int read_checked(struct app_render_request *r, struct app_animation *animation,
                        struct app_progress *progress, satin_scene **scene) {
    limit_gaps(app_animation_memory(r));
    app_set_reading(true);
    const satin_status status = app_animation_load(r, animation, progress, scene);
    app_set_reading(false);
    if (status != SATIN_OK) return app_exit_of(status);
    const int chosen = app_animation_choose(r, *scene, animation);
    return chosen == APP_DONE ? check_read(r, *scene, animation) : chosen;
}

static int run_request(struct app_render_request *r) {
    struct app_progress progress;
    satin_scene *scene = NULL;
    double start = stats_wall();
    app_ignore_closed_pipes();
    app_progress_start(&progress, r->quiet || !app_ranks_first(r->ranks));
    struct app_animation animation = {.path = {.count = 0}};
    int result = name_outputs(r);
    if (result == APP_DONE) result = app_animation_read(r, &animation);
    result = app_ranks_agree(r->ranks, result);
    if (result == APP_DONE) result = app_ranks_agree(r->ranks, check_outputs(r));
    if (result == APP_DONE)
        result = app_ranks_agree(r->ranks, read_checked(r, &animation, &progress, &scene));
    if (result == APP_DONE) result = app_exit_of(run_scene(r, scene, &animation, &progress, start));
    app_animation_free(&animation);
    satin_scene_free(scene);
    return result;
}

// All ranks show help or none does.
static int check_help(const struct app_render_request *r) {
    const satin_ranks *ranks = r->ranks->ranks;
    bool first = r->help;
    if (ranks) ranks->broadcast(ranks->user, 0, &first, sizeof first);
    return first == r->help ? APP_DONE : app_wrong("not all processes have --help");
}

int app_render(int argc, char **argv) {
    struct app_ranks ranks;
    struct app_render_request r = {.ranks = &ranks};
    app_catch_signals();
    if (!app_ranks_begin(&ranks)) return APP_WRONG;
    r.define = calloc((size_t)argc + 1, sizeof *r.define);
    // An argument sets at most four options.
    r.setting = calloc(4 * (size_t)argc + 1, sizeof *r.setting);
    int result = r.define && r.setting ? app_render_read(argc, argv, &r) : app_no_memory();
    result = app_ranks_agree(&ranks, result);
    if (result == APP_DONE) result = app_ranks_agree(&ranks, check_help(&r));
    if (result == APP_DONE && r.help)
        result = app_ranks_first(&ranks) ? app_help(1, (char *[]){"render"}) : APP_DONE;
    else if (result == APP_DONE && ranks.ranks && strcmp(r.scene, APP_STDIN) == 0)
        result = app_wrong("several processes cannot read a scene from standard input");
    else if (result == APP_DONE)
        result = run_request(&r);
    free(r.define);
    free(r.setting);
    free(r.png_beside);
    free(r.checkpoint_beside);
    app_ranks_end(&ranks, result);
    return result;
}
