// SPDX-License-Identifier: Apache-2.0
// Renders a cell of the sweep and judges its pictures: every block of every layer (blocks.h), the
// sum of the layers, pixels without a finite value, and what the statistics count.
#include "cell.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "blocks.h"

enum { SEEDS_MOST = 64 };

// Least sigma of a block, as a fraction of its own brightness in the layer and in the beauty: what
// is off by less than eight times that is not seen, and where a layer is nearly free of noise the
// scales of blocks.h are too.
static const double own_floor = 0.005, beauty_floor = 0.0025;

// How far the beauty may be from the sum of its layers, over the largest of them: rounding of float
// sums over the samples of a pixel.
static const double sum_error = 1e-4;

struct layer {
    const char *name, *channel[3];
    bool light;  // a part of the beauty
};

static const struct layer layers[] = {
    {"beauty", {"R", "G", "B"}, false},
    {"direct", {"direct.R", "direct.G", "direct.B"}, true},
    {"caustic", {"caustic.R", "caustic.G", "caustic.B"}, true},
    {"indirect_diffuse", {"indirect_diffuse.R", "indirect_diffuse.G", "indirect_diffuse.B"}, true},
    {"indirect_glossy", {"indirect_glossy.R", "indirect_glossy.G", "indirect_glossy.B"}, true},
    {"emission", {"emission.R", "emission.G", "emission.B"}, true},
    {"albedo", {"albedo.R", "albedo.G", "albedo.B"}, false},
    {"normal", {"normal.X", "normal.Y", "normal.Z"}, false},
    {"depth", {"depth.Z", NULL, NULL}, false},
};
enum { LAYERS = sizeof layers / sizeof *layers };

struct work {
    const struct plan *plan;
    const struct cell *cell;
    struct tally *tally;
    FILE *out;
    int count;  // pictures
    int seed[SEEDS_MOST];
    satin_film *film[SEEDS_MOST];
    bool flagged[SEEDS_MOST];
    char message[512];  // the last one of level error
};

static void note(void *user, satin_log_level level, const char *message) {
    struct work *w = user;
    if (level == SATIN_LOG_ERROR) snprintf(w->message, sizeof w->message, "%s", message);
}

void cell_flag(const struct cell *cell, const char *kind, int seed, FILE *out) {
    fprintf(out, "flag %s %s %s %s seed %d", kind, cell->scene, cell->preset, cell->first_pass,
            seed);
}

void cell_command(const struct plan *plan, const struct cell *cell, int seed, FILE *out) {
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

// Begins a flag of picture `i`.
static void flag(struct work *w, const char *kind, int i) {
    cell_flag(w->cell, kind, w->seed[i], w->out);
    w->tally->flags++;
    w->flagged[i] = true;
}

// ---- One picture
// ---------------------------------------------------------------------------------

static bool ends_with(const char *text, size_t length, const char *end) {
    return length >= strlen(end) && strncmp(text + length - strlen(end), end, strlen(end)) == 0;
}

// Goes through `"name": number` pairs: what was refused or dropped must be 0, and the samples per
// pixel those of the budget to 1 %.
static void check_stats(struct work *w, int i, const satin_options *options) {
    static const int preset_spp[] = {9, 16, 36};
    const double budget = options->spp ? options->spp : preset_spp[options->quality];
    for (const char *at = satin_film_stats(w->film[i]); at && (at = strchr(at, '"')); at++) {
        const char *name = at + 1, *end = strchr(name, '"');
        if (!end) break;
        size_t length = (size_t)(end - name);
        double value = strtod(end + 2, NULL);
        bool refused = ends_with(name, length, ".refused") || ends_with(name, length, ".nonfinite");
        bool samples = ends_with(name, length, "image.spp");
        if (refused) w->tally->records += value;
        if ((refused && value != 0.0) || (samples && fabs(value / budget - 1.0) > 0.01)) {
            flag(w, refused ? "counter" : "samples", i);
            fprintf(w->out, " %.*s %g\n", (int)length, name, value);
        }
        at = end;
    }
}

// Counts pixels for which `wrong` holds and tells the first.
static void report_pixels(struct work *w, int i, const char *kind, const char *what, int count,
                          int first) {
    if (!count) return;
    flag(w, kind, i);
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
        const float *beauty = satin_film_channel(w->film[i], layers[0].channel[c]);
        int count = 0, first = 0;
        for (int p = w->plan->size * w->plan->size - 1; p >= 0; p--) {
            double sum = 0.0, largest = 0.0;
            for (int k = 0; k < LAYERS; k++) {
                const float *part =
                    layers[k].light ? satin_film_channel(w->film[i], layers[k].channel[c]) : NULL;
                if (!part) continue;
                sum += (double)part[p];
                largest = fmax(largest, fabs((double)part[p]));
            }
            if (fabs(sum - (double)beauty[p]) <= sum_error * largest) continue;
            count++;
            first = p;
        }
        report_pixels(w, i, "sum", layers[0].channel[c], count, first);
    }
}

static void render_seed(struct work *w, const satin_scene *scene, const satin_options *base,
                        int seed) {
    satin_options options = *base;
    const satin_callbacks callbacks = {.log = note, .log_user = w};
    options.seed = (uint64_t)seed;
    const int i = w->count;
    w->seed[i] = w->tally->seed = seed;
    alarm((unsigned)w->plan->limit);
    satin_status status = satin_render(scene, &options, &callbacks, &w->film[i]);
    alarm(0);
    if (status != SATIN_OK) {
        flag(w, "failed", i);
        fprintf(w->out, " %s\n", w->message[0] ? w->message : satin_status_text(status));
        return;
    }
    w->count++;
    w->tally->renders++;
    check_stats(w, i, &options);
    check_finite(w, i);
    check_sum(w, i);
}

// ---- All pictures of the cell
// --------------------------------------------------------------------

// Scores of one channel; false if a picture lacks it or has values that are not finite, or if there
// are too few pictures.
static bool score_channel(const struct work *w, const char *name, const double *floor,
                          struct block_scores *out) {
    const float *pixel[SEEDS_MOST];
    if (!name || w->count < BLOCK_SEEDS_LEAST) return false;
    for (int s = 0; s < w->count; s++) {
        pixel[s] = satin_film_channel(w->film[s], name);
        if (!pixel[s]) return false;
        for (int p = 0; p < w->plan->size * w->plan->size; p++)
            if (!isfinite(pixel[s][p])) return false;
    }
    const struct block_stack stack = {w->plan->size, w->plan->size, w->count, pixel, floor};
    return block_scores_make(&stack, out);
}

// Where a score is beyond all others of its picture and layer.
struct peak {
    int channel, block, blocks;
    double score, ratio;
};

static void count_score(struct tally *tally, double score) {
    int at = score < CELL_HISTOGRAM - 1 ? (int)score : CELL_HISTOGRAM - 1;
    tally->histogram[at]++;
    tally->worst = fmax(tally->worst, score);
}

static void judge_channel(struct work *w, const struct block_scores *scores, int channel,
                          struct peak *peak) {
    for (int s = 0; s < w->count; s++)
        for (int b = 0; b < scores->count; b++) {
            const int at = s * scores->count + b;
            double size = fabs(scores->score[at]);
            count_score(w->tally, size);
            peak[s].blocks += size > w->plan->threshold;
            if (size <= fabs(peak[s].score)) continue;
            peak[s].channel = channel;
            peak[s].block = b;
            peak[s].score = scores->score[at];
            peak[s].ratio = scores->mean[at] / scores->usual[b];
        }
}

static void report_peak(struct work *w, const struct layer *layer, int i, const struct peak *peak) {
    const int columns = w->plan->size / BLOCK_SIZE;
    flag(w, "block", i);
    w->tally->blocks += peak->blocks;
    fprintf(w->out, " %s %s pixel %d,%d ratio %.3f sigmas %.1f blocks %d\n", layer->name,
            layer->channel[peak->channel], peak->block % columns * BLOCK_SIZE,
            peak->block / columns * BLOCK_SIZE, peak->ratio, peak->score, peak->blocks);
}

// The floor of each block of a layer's channel, from the brightness there; normals have length 1.
static void fill_floor(const struct layer *layer, const struct block_scores *plain,
                       const struct block_scores *beauty, double *floor) {
    for (int b = 0; b < plain->count; b++) {
        floor[b] = own_floor * (strcmp(layer->name, "normal") == 0 ? 1.0 : plain->level[b]);
        if (layer->light) floor[b] = fmax(floor[b], beauty_floor * beauty->level[b]);
    }
}

static void judge_layer(struct work *w, const struct layer *layer, double *floor) {
    struct peak peak[SEEDS_MOST] = {0};
    for (int c = 0; c < 3; c++) {
        struct block_scores plain, beauty, scores;
        if (!score_channel(w, layer->channel[c], NULL, &plain)) continue;
        if (score_channel(w, layers[0].channel[c], NULL, &beauty)) {
            fill_floor(layer, &plain, &beauty, floor);
            block_scores_free(&beauty);
            if (score_channel(w, layer->channel[c], floor, &scores)) {
                judge_channel(w, &scores, c, peak);
                block_scores_free(&scores);
            }
        }
        block_scores_free(&plain);
    }
    for (int i = 0; i < w->count; i++)
        if (peak[i].blocks) report_peak(w, layer, i, &peak[i]);
}

// ---- The cell
// ------------------------------------------------------------------------------------

static satin_status resolve(struct work *w, const satin_scene *scene, satin_options *options) {
    satin_setting setting[CELL_SETTINGS + 2] = {{"quality", w->cell->preset},
                                                {"first-pass", w->cell->first_pass}};
    memcpy(setting + 2, w->plan->setting, w->plan->setting_count * sizeof *setting);
    satin_status status =
        satin_options_resolve(scene, setting, w->plan->setting_count + 2, note, w, options);
    if (status == SATIN_OK) {
        options->width = options->height = w->plan->size;
        options->threads = 1;
    }
    return status;
}

// Keeps the flagged pictures, and prints how each is made.
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
        (void)satin_film_write_exr(w->film[i], path, note, w);
        memcpy(path + strlen(path) - 3, "png", 3);
        (void)satin_film_write_png(w->film[i], path, note, w);
    }
}

void cell_run(const struct plan *plan, const struct cell *cell, struct tally *tally, FILE *out) {
    struct work w = {.plan = plan, .cell = cell, .tally = tally, .out = out};
    satin_scene *scene = NULL;
    satin_options options;
    const int blocks = (plan->size / BLOCK_SIZE) * (plan->size / BLOCK_SIZE);
    double *floor = calloc((size_t)blocks, sizeof *floor);
    if (!floor ||
        satin_scene_load(cell->scene, plan->define, plan->define_count, note, &w, &scene) !=
            SATIN_OK ||
        resolve(&w, scene, &options) != SATIN_OK) {
        flag(&w, "failed", 0);
        fprintf(out, " %s\n", w.message);
    } else {
        for (int s = 0; s < plan->seed_count && s < SEEDS_MOST; s++)
            render_seed(&w, scene, &options, plan->seed_first + s);
        for (int k = 0; k < LAYERS; k++) judge_layer(&w, &layers[k], floor);
        if (plan->worst)
            fprintf(out, "worst %s %s %s %.1f cpu %.1f\n", cell->scene, cell->preset,
                    cell->first_pass, tally->worst, (double)clock() / CLOCKS_PER_SEC);
        keep_flagged(&w);
    }
    for (int i = 0; i < w.count; i++) satin_film_free(w.film[i]);
    satin_scene_free(scene);
    free(floor);
}
