// SPDX-License-Identifier: Apache-2.0
// satin render: arguments -> scene and options -> film -> files. Errors in the arguments are found
// before the scene is read, and errors in the names of outputs before anything is rendered.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "apps/app.h"
#include "base/fileio.h"
#include "base/stats.h"
#include "film/film.h"
#include "scene/scene.h"

// The least fraction of a time limit that is left for the render if loading the scene takes long.
static const double LOAD_LEAVES = 0.2;

enum {
    FLAG_OUTPUT,
    FLAG_PNG,
    FLAG_STATS,
    FLAG_LOAD,
    FLAG_SAVE,
    FLAG_DEFINE,
    FLAG_SET,
    FLAG_EXPOSURE,
    FLAG_TONEMAP,
    FLAG_STRICT,
    FLAG_LENIENT,
    FLAG_QUIET,
    FLAG_HELP,
    FLAG_FIRST_OPTION  // from here on --name is the option of that name; a Boolean without a value
                       // is on
};

const struct app_flag app_render_flags[] = {
    {"--output", "-o", "OUT.exr",
     "The image, an OpenEXR file with all layers; or OUT.png, the beauty alone."},
    {"--png", NULL, "[FILE.png]", "The beauty as a PNG too, beside the image if no name is given."},
    {"--stats", NULL, "FILE.json", "Statistics as JSON; - for standard output."},
    {"--load-cache", NULL, "FILE",
     "Begins with the cache records of a render of the same scene, with any sensor."},
    {"--save-cache", NULL, "FILE",
     "Writes the cache records to FILE, which may be the file that is loaded."},
    {"--define", "-D", "NAME=VALUE", "Replaces a default of the scene file; may be repeated."},
    {"--set", NULL, "OPTION=VALUE", "Sets any option of `satin help options`; may be repeated."},
    {"--exposure", NULL, "STOPS|auto", APP_EXPOSURE_DOC},
    {"--tonemap", NULL, "clip|filmic", APP_TONEMAP_DOC},
    {"--strict", NULL, NULL, "Treats warnings about the scene as errors."},
    {"--lenient", NULL, NULL,
     "Renders a scene with missing files or unknown plugins, which are left out or become grey."},
    {"--quiet", "-q", NULL, "Prints errors only."},
    {"--help", "-h", NULL, "Prints this."},
    {"--quality", NULL, "draft|preview|production", "Preset; single options override it."},
    {"--integrator", NULL, "two-pass|path|direct|photons", "How light is computed."},
    {"--first-pass", NULL, "NAME",
     "What gather rays read: precomputed, photons, path, none, recursive."},
    {"--spp", NULL, "N", "Samples per pixel."},
    {"--width", NULL, "W", "Film width in pixels."},
    {"--height", NULL, "H", "Film height in pixels."},
    {"--seed", NULL, "S", "Seed of all random numbers."},
    {"--threads", NULL, "T", "The number of threads; 0 is one per core."},
    {"--time", NULL, "SECONDS", "Stops with the best image so far when the time is up."},
    {"--denoise", NULL, NULL,
     "Denoises the light that no record carries; needs Open Image Denoise."},
    {NULL, NULL, NULL, NULL},
};

struct request {
    const char *scene, *output, *png, *stats, *load, *save;
    bool want_png, quiet, help;
    satin_tonemap tonemap;
    unsigned scene_flags;
    satin_define *define;
    satin_setting *setting;
    size_t define_count, setting_count;
    char *png_beside;  // name of a PNG that was asked for without a name; owned
};

static int take_flag(struct request *r, int flag, char *value) {
    satin_define *define = &r->define[r->define_count];
    satin_setting *setting = &r->setting[r->setting_count];
    switch (flag) {
        case FLAG_OUTPUT:
            r->output = value;
            return APP_DONE;
        case FLAG_STATS:
            r->stats = value;
            return APP_DONE;
        case FLAG_LOAD:
            r->load = value;
            return APP_DONE;
        case FLAG_SAVE:
            r->save = value;
            return APP_DONE;
        case FLAG_EXPOSURE:
            return app_take_exposure(value, &r->tonemap);
        case FLAG_TONEMAP:
            return app_take_tonemap(value, &r->tonemap);
        case FLAG_STRICT:
            r->scene_flags |= SATIN_SCENE_STRICT;
            return APP_DONE;
        case FLAG_LENIENT:
            r->scene_flags |= SATIN_SCENE_LENIENT;
            return APP_DONE;
        case FLAG_QUIET:
            r->quiet = true;
            return APP_DONE;
        case FLAG_HELP:
            r->help = true;
            return APP_DONE;
        case FLAG_PNG:
            r->want_png = true;
            r->png = value;
            return APP_DONE;
        case FLAG_DEFINE:
            if (!app_args_split(value, &define->name, &define->value))
                return app_wrong("-D needs NAME=VALUE, not '%s'", value);
            r->define_count++;
            return APP_DONE;
        case FLAG_SET:
            if (!app_args_split(value, &setting->name, &setting->value))
                return app_wrong("--set needs OPTION=VALUE, not '%s'", value);
            r->setting_count++;
            return APP_DONE;
        default:
            *setting = (satin_setting){app_render_flags[flag].name + 2, value ? value : "on"};
            r->setting_count++;
            return APP_DONE;
    }
}

// Whether a name has the ending of an image format, even of one that is not written. Decides
// whether the argument after --png is its value.
static bool is_image(const char *name) {
    static const char *const ending[] = {".png", ".exr",  ".jpg", ".jpeg", ".tif", ".tiff",
                                         ".hdr", ".webp", ".bmp", ".pfm",  ".tga"};
    for (size_t i = 0; i < sizeof ending / sizeof *ending; i++)
        if (app_ends_in(name, ending[i])) return true;
    return false;
}

static int read_render_arguments(int argc, char **argv, struct request *r) {
    struct app_args args = {.argc = argc, .argv = argv};
    char *value;
    for (;;) {
        int flag = app_args_next(&args, app_render_flags, is_image, &value), status = APP_DONE;
        if (flag == APP_END) break;
        if (flag == APP_BAD) return APP_WRONG;
        if (flag != APP_POSITIONAL)
            status = take_flag(r, flag, value);
        else if (r->scene)
            status = app_wrong("one scene at a time: '%s' and '%s'", r->scene, value);
        else
            r->scene = value;
        if (status != APP_DONE) return status;
    }
    if (r->help) return APP_DONE;
    if (!r->scene) return app_wrong("no scene: satin render SCENE.xml -o OUT.exr");
    if (!r->output || !*r->output)
        return app_wrong("no output: satin render %s -o OUT.exr", r->scene);
    satin_options checked;
    return app_exit_of(
        satin_options_resolve(NULL, r->setting, r->setting_count, app_log, NULL, &checked));
}

// The ending of an output's name chooses its format.
static int check_format(const struct request *r) {
    if (!app_ends_in(r->output, ".exr") && !app_ends_in(r->output, ".png"))
        return app_wrong("%s: an image is written as .exr or .png, by the end of its name",
                         r->output);
    if (r->png && !app_ends_in(r->png, ".png")) return app_wrong("%s: --png writes a .png", r->png);
    return APP_DONE;
}

// OUT.exr -> OUT.png; from malloc.
static char *png_name(const char *output) {
    size_t n = strlen(output);
    if (app_ends_in(output, ".exr")) n -= 4;
    char *name = malloc(n + 5);
    if (name) snprintf(name, n + 5, "%.*s.png", (int)n, output);
    return name;
}

// All outputs; the path of an output that was not asked for is NULL.
enum { OUTPUTS = 4 };
static void list_outputs(const struct request *r, struct app_output output[OUTPUTS]) {
    const bool png = app_ends_in(r->output, ".png");
    output[0] = (struct app_output){r->output, png ? FILEIO_APPEND : FILEIO_SEEK, NULL};
    output[1] = (struct app_output){r->png, FILEIO_APPEND, NULL};
    output[2] = (struct app_output){r->stats, FILEIO_APPEND, NULL};
    // A cache is read whole before anything is written, so it may be saved to the file it came
    // from.
    output[3] = (struct app_output){r->save, FILEIO_APPEND, r->load};
}

static int check_outputs(struct request *r) {
    if (r->want_png && !r->png && !app_ends_in(r->output, ".png")) {
        r->png = r->png_beside = png_name(r->output);
        if (!r->png) return app_no_memory();
    }
    if (r->stats && strcmp(r->stats, "-") == 0) r->stats = APP_STDOUT;
    const struct app_input input[] = {
        {r->scene, "the scene"}, {r->load, "the cache that is loaded"}, {NULL, NULL}};
    struct app_output output[OUTPUTS];
    list_outputs(r, output);
    const int status = app_outputs_check(output, OUTPUTS, input);
    return status == APP_DONE ? check_format(r) : status;
}

// Writes the statistics of the film and those of writing it.
static satin_status write_stats(const struct request *r, const satin_film *film,
                                const struct stats *written, struct log log) {
    const char *stats = satin_film_stats(film);
    if (!stats) return SATIN_OK;
    char *text = stats_json_append(stats, written);
    if (!text) return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", r->stats);
    const satin_status status = fileio_write(log, r->stats, text, strlen(text));
    free(text);
    return status;
}

static satin_status write_outputs(const struct request *r, const satin_film *film, int threads,
                                  struct log log) {
    struct stats written = {.count = 0};
    satin_status status;
    if (app_ends_in(r->output, ".png")) {
        status = satin_film_write_png(film, r->output, &r->tonemap, log.fn, log.user);
    } else {
        struct parallel *pool = parallel_new(threads);
        if (pool) parallel_begin_part(pool, PART_WRITE);
        status = film_write_exr(film, r->output, pool, log);
        if (pool) stats_set_parts(&written, pool);
        parallel_free(pool);
    }
    // Each output is written, even if another one failed.
    satin_status png = SATIN_OK, json = SATIN_OK;
    if (r->png) png = satin_film_write_png(film, r->png, &r->tonemap, log.fn, log.user);
    if (r->stats) json = write_stats(r, film, &written, log);
    if (status != SATIN_OK) return status;
    return png != SATIN_OK ? png : json;
}

static void print_summary(const struct request *r, const satin_film *film, satin_status rendered,
                          double seconds) {
    int width, height;
    if (r->quiet) return;
    satin_film_size(film, &width, &height);
    fprintf(stderr, "%s: %dx%d, %.2f s%s\n", r->output, width, height, seconds,
            rendered == SATIN_CANCELLED ? ", cancelled: what was done so far" : "");
    if (r->png) fprintf(stderr, "%s\n", r->png);
}

static satin_status render_scene(const struct request *r, const satin_scene *scene,
                                 struct app_progress *progress, double start) {
    struct log file_log = {app_log_file, progress};
    satin_options options;
    // The user's options were checked before, so an error here is in the scene's options.
    satin_status status = satin_options_resolve(scene, r->setting, r->setting_count, app_log_file,
                                                progress, &options);
    if (status != SATIN_OK) return status;
    // The time limit includes the time for reading the scene.
    if (options.time > 0.0)
        options.time = fmax(options.time - (stats_wall() - start), LOAD_LEAVES * options.time);
    satin_callbacks callbacks = {app_log,  progress, app_progress_update,
                                 progress, r->load,  r->save};
    satin_film *film = NULL;
    status = satin_render(scene, &options, &callbacks, &film);
    app_progress_end(progress);
    if (film) {
        satin_status written = write_outputs(r, film, options.threads, file_log);
        if (written == SATIN_OK) print_summary(r, film, status, stats_wall() - start);
        if (written != SATIN_OK) status = written;
    }
    satin_film_free(film);
    return status;
}

static int load_and_render(struct request *r) {
    struct app_progress progress;
    satin_scene *scene = NULL;
    double start = stats_wall();
    int result = check_outputs(r);
    if (result != APP_DONE) return result;
    app_progress_start(&progress, r->quiet);
    app_set_reading(true);
    app_catch_signals();
    satin_status status = satin_scene_load_with(r->scene, r->define, r->define_count,
                                                r->scene_flags, app_log_file, &progress, &scene);
    app_set_reading(false);
    if (status != SATIN_OK) return app_exit_of(status);
    struct app_output output[OUTPUTS];
    list_outputs(r, output);
    result = app_outputs_check_read(output, OUTPUTS, &scene->read);
    if (result == APP_DONE) result = app_exit_of(render_scene(r, scene, &progress, start));
    satin_scene_free(scene);
    return result;
}

int app_render(int argc, char **argv) {
    struct request r = {0};
    r.define = calloc((size_t)argc + 1, sizeof *r.define);
    r.setting = calloc((size_t)argc + 1, sizeof *r.setting);
    int result = r.define && r.setting ? read_render_arguments(argc, argv, &r) : app_no_memory();
    if (result == APP_DONE && r.help)
        result = app_help(1, (char *[]){"render"});
    else if (result == APP_DONE)
        result = load_and_render(&r);
    free(r.define);
    free(r.setting);
    free(r.png_beside);
    return result;
}
