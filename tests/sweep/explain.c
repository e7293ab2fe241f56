// SPDX-License-Identifier: Apache-2.0
// Renders images with flagged blocks again with more photons and more samples: see explain.h.
#include "explain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "blocks.h"

// The kd-tree of more photons than this takes gigabytes, so photons explain no block then.
static const int64_t PHOTONS_MOST = 50000000;

// A score that a twentieth of all blocks have by normal noise.
static const double UNNOTICED = 2.0;

enum { TIMES = 2 };
static const int times[TIMES] = {8, 64};

static bool more_photons(satin_options *options, int more) {
    options->caustic_photons *= more;
    return options->caustic_photons <= PHOTONS_MOST;
}

static bool more_samples(satin_options *options, int more) {
    options->spp = cell_spp(options) * more;
    return true;
}

const char *const explain_name[EXPLANATIONS] = {"photons", "samples"};

static const struct {
    bool (*more)(satin_options *options, int more);  // false: there would be too many
    bool all;  // whether all layers of light depend on it; else the caustics alone do
} explanation[EXPLANATIONS] = {{more_photons, false}, {more_samples, true}};

// Statistics that are the same if two renders have the same records.
static const char *const same_records[] = {
    "\"records.irradiance\":", "\"records.radiance\":", "\"records.rays\":", "\"cache.shrunk\":"};

static double statistic(const satin_film *film, const char *name) {
    const char *text = satin_film_stats(film), *at = text ? strstr(text, name) : NULL;
    return at ? strtod(at + strlen(name), NULL) : -1.0;
}

static bool has_same_records(const satin_film *a, const satin_film *b) {
    for (size_t i = 0; i < sizeof same_records / sizeof *same_records; i++)
        if (statistic(a, same_records[i]) != statistic(b, same_records[i])) return false;
    return true;
}

// The difference at the flagged block, with its sign; NAN if an image lacks the layer.
static double signed_difference(const struct work *w, const struct flagged *f, const satin_film *a,
                                const satin_film *b) {
    const char *name = evaluate_layer[f->layer].channel[f->channel];
    const float *first = satin_film_channel(a, name), *second = satin_film_channel(b, name);
    return first && second ? block_difference(first, second, w->plan->size, f->block) : NAN;
}

static double explain_difference(const struct work *w, const struct flagged *f, const satin_film *a,
                                 const satin_film *b) {
    return fabs(signed_difference(w, f, a, b));
}

// Image `i` with more photons or samples; NULL if it fails.
static satin_film *render_more(struct work *w, const satin_scene *scene,
                               const satin_options *options, int i, int more) {
    const satin_callbacks callbacks = {.log = NULL};
    satin_options own = *options;
    satin_film *film = NULL;
    own.seed = (uint64_t)w->seed[i];
    alarm((unsigned)(w->plan->limit * more));
    const satin_status status = satin_render(scene, &own, &callbacks, &film);
    alarm(0);
    if (status == SATIN_OK) return film;
    satin_film_free(film);
    return NULL;
}

// Whether more photons or samples could explain a block that is not explained yet.
static bool is_candidate(const struct flagged *f, int image, int e) {
    const struct test_evaluate_layer *layer = &evaluate_layer[f->layer];
    const bool light = layer->light || f->layer == 0;
    const bool caustic = f->layer == 0 || strcmp(layer->name, "caustic") == 0;
    return f->image == image && !f->few && (explanation[e].all ? light : caustic);
}

static bool has_candidates(const struct work *w, int image, int e) {
    for (int k = 0; k < w->blocks; k++)
        if (is_candidate(&w->block[k], image, e)) return true;
    return false;
}

// Renders of the flagged image and of one with which it is compared.
struct explain_pair {
    satin_film *flagged, *other;
};

// Whether the difference at a flagged block has fallen as noise does, or the other image has become
// equal to the flagged one.
static bool has_fallen(const struct work *w, const struct flagged *f, struct explain_pair before,
                       struct explain_pair now, int more) {
    const bool caustic = strcmp(evaluate_layer[f->layer].name, "caustic") == 0;
    if (!caustic && (!has_same_records(before.flagged, now.flagged) ||
                     !has_same_records(before.other, now.other)))
        return false;
    const double D = explain_difference(w, f, before.flagged, before.other);
    const double other = signed_difference(w, f, now.other, before.other);
    if (caustic && other * copysign(1.0, f->score) >= D) return true;
    const double unnoticed = UNNOTICED * D / fabs(f->score);
    return explain_difference(w, f, now.flagged, now.other) <=
           fmax(D / sqrt((double)more), unnoticed);
}

// Clears the mark of candidates whose difference does not fall. `good` has one mark per flagged
// block. Returns whether any is left.
static bool mark_fallen(const struct work *w, int image, int e, struct explain_pair before,
                        struct explain_pair now, int more, bool *good) {
    bool any = false;
    for (int k = 0; k < w->blocks; k++) {
        if (!is_candidate(&w->block[k], image, e)) continue;
        good[k] = good[k] && has_fallen(w, &w->block[k], before, now, more);
        any = any || good[k];
    }
    return any;
}

// One step of more photons or samples; false if no candidate is left.
static bool compare_more(struct work *w, const satin_scene *scene, const satin_options *options,
                         int image, int other, int e, int more, bool *good) {
    satin_options own = *options;
    if (!explanation[e].more(&own, more)) return false;
    const struct explain_pair before = {w->film[image], w->film[other]};
    struct explain_pair now = {render_more(w, scene, &own, image, more), NULL};
    if (now.flagged) now.other = render_more(w, scene, &own, other, more);
    const bool any = now.other && mark_fallen(w, image, e, before, now, more, good);
    satin_film_free(now.flagged);
    satin_film_free(now.other);
    return any;
}

static void explain_picture(struct work *w, const satin_scene *scene, const satin_options *options,
                            int image, int other, int e) {
    bool *good = malloc((size_t)w->blocks * sizeof *good), done = good;
    for (int k = 0; good && k < w->blocks; k++) good[k] = true;
    for (int i = 0; done && i < TIMES; i++)
        done = compare_more(w, scene, options, image, other, e, times[i], good);
    for (int k = 0; done && k < w->blocks; k++)
        if (good[k] && is_candidate(&w->block[k], image, e)) w->block[k].few = explain_name[e];
    free(good);
}

static bool is_clean(const struct work *w, int image) {
    for (int k = 0; k < w->blocks; k++)
        if (w->block[k].image == image) return false;
    return true;
}

// The flagged block of an image with the largest score.
static const struct flagged *find_worst(const struct work *w, int image) {
    const struct flagged *worst = NULL;
    for (const struct flagged *f = w->block; f < w->block + w->blocks; f++)
        if (f->image == image && (!worst || fabs(f->score) > fabs(worst->score))) worst = f;
    return worst;
}

// The image without flags from which the worst block of this one has the median difference; -1:
// there is none.
static int find_other(const struct work *w, int image) {
    const struct flagged *f = find_worst(w, image);
    double size[SEEDS_MOST];
    int index[SEEDS_MOST], count = 0;
    for (int i = 0; i < w->count; i++) {
        if (!is_clean(w, i)) continue;
        const double d = explain_difference(w, f, w->film[image], w->film[i]);
        int at = count++;
        for (; at > 0 && size[at - 1] > d; at--) {
            size[at] = size[at - 1];
            index[at] = index[at - 1];
        }
        size[at] = d;
        index[at] = i;
    }
    return count ? index[count / 2] : -1;
}

void explain_blocks(struct work *w, const satin_scene *scene, const satin_options *options) {
    for (int i = 0; i < w->count; i++) {
        if (is_clean(w, i)) continue;
        const int other = find_other(w, i);
        for (int e = 0; e < EXPLANATIONS && other >= 0; e++)
            if (has_candidates(w, i, e)) explain_picture(w, scene, options, i, other, e);
    }
}
