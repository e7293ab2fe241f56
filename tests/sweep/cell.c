// SPDX-License-Identifier: Apache-2.0
// Renders a cell of the sweep and checks each image alone: pixels without a finite value, the sum
// of the layers, and what the statistics count. evaluate.c compares the images.

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "blocks.h"
#include "evaluate.h"
#include "explain.h"
#include "render/options_quality.h"

// The largest deviation of the beauty from the sum of its layers, over the largest of them:
// rounding of float sums over the samples of a pixel.
static const double sum_error = 1e-4;

static void cell_note(void *user, satin_log_severity severity, const char *message) {
    struct work *w = user;
    if (severity == SATIN_LOG_ERROR) snprintf(w->message, sizeof w->message, "%s", message);
}

void cell_line(const struct test_cell *cell, const char *what, const char *kind, int seed,
               FILE *out) {
    fprintf(out, "%s %s %s %s %s seed %d", what, kind, cell->scene, cell->preset, cell->first_pass,
            seed);
}

void cell_command(const struct plan *plan, const struct test_cell *cell, int seed, FILE *out) {
    fprintf(out,
            "    build/satin render %s --quality %s --first-pass %s --seed %d --width %d "
            "--height %d --threads 1",
            cell->scene, cell->preset, cell->first_pass, seed, plan->size, plan->size);
    for (size_t i = 0; i < plan->define_count; i++)
        fprintf(out, " -D %s=%s", plan->define[i].name, plan->define[i].value);
    for (size_t i = 0; i < plan->setting_count; i++)
        fprintf(out, " --set %s=%s", plan->setting[i].name, plan->setting[i].value);
    fprintf(out, " -o build/flag.exr --png\n");
}

void evaluate_flag(struct work *w, const char *kind, int i) {
    cell_line(w->cell, "flag", kind, w->seed[i], w->out);
    w->tally->flags++;
    w->flagged[i] = true;
}

// ---- One image ----------------------------------------------------------------------------------

static bool ends_with(const char *text, size_t length, const char *end) {
    return length >= strlen(end) && strncmp(text + length - strlen(end), end, strlen(end)) == 0;
}

int cell_spp(const satin_options *options) {
    return options->spp ? options->spp : options_quality_spp(options->quality);
}

// Goes through `"name": number` pairs: the counts of refused and dropped values must be 0, and the
// samples per pixel those of the options to 1 %.
static void check_stats(struct work *w, int i, const satin_options *options) {
    const double budget = cell_spp(options);
    for (const char *at = satin_film_stats(w->film[i]); at && (at = strchr(at, '"')); at++) {
        const char *name = at + 1, *end = strchr(name, '"');
        if (!end) break;
        size_t length = (size_t)(end - name);
        double value = strtod(end + 2, NULL);
        bool refused = ends_with(name, length, ".refused") || ends_with(name, length, ".nonfinite");
        bool samples = ends_with(name, length, "image.spp");
        if (refused) w->tally->records += value;
        if ((refused && value != 0.0) || (samples && fabs(value / budget - 1.0) > 0.01)) {
            evaluate_flag(w, refused ? "counter" : "samples", i);
            fprintf(w->out, " %.*s %g\n", (int)length, name, value);
        }
        at = end;
    }
}

// Counts pixels for which `wrong` holds and reports the first.
static void report_pixels(struct work *w, int i, const char *kind, const char *what, int count,
                          int first) {
    if (!count) return;
    evaluate_flag(w, kind, i);
    fprintf(w->out, " %s pixels %d first %d,%d\n", what, count, first % w->plan->size,
            first / w->plan->size);
}

static void check_finite(struct work *w, int i) {
    const char *name;
    for (int c = 0; (name = satin_film_channel_name(w->film[i], c)); c++) {
        const float *pixel = satin_film_channel(w->film[i], name);
        int count = 0, first = 0;
        for (int p = w->plan->size * w->plan->size - 1; p >= 0; p--)
            if (!isfinite(pixel[p])) {
                count++;
                first = p;
            }
        report_pixels(w, i, "nonfinite", name, count, first);
    }
}

// The beauty is the sum of its layers.
static void check_sum(struct work *w, int i) {
    for (int c = 0; c < 3; c++) {
        const float *beauty = satin_film_channel(w->film[i], evaluate_layer[0].channel[c]);
        int count = 0, first = 0;
        for (int p = w->plan->size * w->plan->size - 1; p >= 0; p--) {
            double sum = 0.0, largest = 0.0;
            for (int k = 0; k < LAYERS; k++) {
                const float *part =
                    evaluate_layer[k].light
                        ? satin_film_channel(w->film[i], evaluate_layer[k].channel[c])
                        : NULL;
                if (!part) continue;
                sum += (double)part[p];
                largest = fmax(largest, fabs((double)part[p]));
            }
            if (fabs(sum - (double)beauty[p]) <= sum_error * largest) continue;
            count++;
            first = p;
        }
        report_pixels(w, i, "sum", evaluate_layer[0].channel[c], count, first);
    }
}

static void render_seed(struct work *w, const satin_scene *scene, const satin_options *base,
                        int seed) {
    satin_options options = *base;
    const satin_callbacks callbacks = {.log = cell_note, .log_user = w};
    options.seed = (uint64_t)seed;
    const int i = w->count;
    w->seed[i] = w->tally->seed = seed;
    alarm((unsigned)w->plan->limit);
    satin_status status = satin_render(scene, &options, &callbacks, &w->film[i]);
    alarm(0);
    if (status != SATIN_OK) {
        evaluate_flag(w, "failed", i);
        fprintf(w->out, " %s\n", w->message[0] ? w->message : satin_status_text(status));
        cell_command(w->plan, w->cell, seed, w->out);
        w->flagged[i] = false;  // the next image replaces it
        return;
    }
    w->count++;
    w->tally->renders++;
    check_stats(w, i, &options);
    check_finite(w, i);
    check_sum(w, i);
}

// ---- The cell -----------------------------------------------------------------------------------

static satin_status resolve(struct work *w, const satin_scene *scene, satin_options *options) {
    satin_setting setting[CELL_SETTINGS + 2] = {{"quality", w->cell->preset},
                                                {"first-pass", w->cell->first_pass}};
    memcpy(setting + 2, w->plan->setting, w->plan->setting_count * sizeof *setting);
    satin_status status =
        satin_options_resolve(scene, setting, w->plan->setting_count + 2, cell_note, w, options);
    if (status == SATIN_OK) {
        options->width = options->height = w->plan->size;
        options->threads = 1;
    }
    return status;
}

// Keeps the flagged images, and prints the command that makes each.
static void keep_flagged(struct work *w) {
    for (int i = 0; i < w->count; i++) {
        if (!w->flagged[i]) continue;
        cell_command(w->plan, w->cell, w->seed[i], w->out);
        if (!w->plan->folder) continue;
        const char *slash = strrchr(w->cell->scene, '/');
        char path[4096];
        snprintf(path, sizeof path, "%s/%s-%s-%s-%d.exr", w->plan->folder,
                 slash ? slash + 1 : w->cell->scene, w->cell->preset, w->cell->first_pass,
                 w->seed[i]);
        (void)satin_film_write_exr(w->film[i], path, cell_note, w);
        memcpy(path + strlen(path) - 3, "png", 3);
        (void)satin_film_write_png(w->film[i], path, NULL, cell_note, w);
    }
}

void cell_run(const struct plan *plan, const struct test_cell *cell, struct cell_tally *tally,
              FILE *out) {
    struct work w = {.plan = plan, .cell = cell, .tally = tally, .out = out};
    satin_scene *scene = NULL;
    satin_options options;
    if (satin_scene_load(cell->scene, plan->define, plan->define_count, cell_note, &w, &scene) !=
            SATIN_OK ||
        resolve(&w, scene, &options) != SATIN_OK) {
        evaluate_flag(&w, "failed", 0);
        fprintf(out, " %s\n", w.message);
    } else {
        for (int s = 0; s < plan->seed_count && s < SEEDS_MOST; s++)
            render_seed(&w, scene, &options, plan->seed_first + s);
        evaluate_layers(&w);
        explain_blocks(&w, scene, &options);
        evaluate_report(&w);
        if (plan->worst)
            fprintf(out, "worst %s %s %s %.1f cpu %.1f\n", cell->scene, cell->preset,
                    cell->first_pass, tally->worst, (double)clock() / CLOCKS_PER_SEC);
        keep_flagged(&w);
    }
    for (int i = 0; i < w.count; i++) satin_film_free(w.film[i]);
    free(w.block);
    satin_scene_free(scene);
}
