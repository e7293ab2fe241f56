// SPDX-License-Identifier: Apache-2.0
// The metadata of a film: version, scene hash, all options with the integrator that sampled the
// image, statistics.
#include <stdio.h>
#include <stdlib.h>

#include "render/options_table.h"
#include "render/render_image.h"

// All options as options_print_words has them, from malloc.
static char *options_text(const satin_options *options) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    options_print_words(out, options, NULL);
    if (fclose(out) == 0) return text;
    free(text);
    return NULL;
}

static struct stats_span span_without(struct stats_span a, struct stats_span b) {
    return (struct stats_span){a.wall_s - b.wall_s, a.thread_s - b.thread_s,
                               a.process_s - b.process_s};
}

bool render_metadata(struct render *r, struct satin_film *film) {
    stats_set(&r->stats, "time.total_s", render_elapsed(r));
    stats_set(&r->stats, "memory.peak_bytes", stats_peak_memory());
    stats_set_span(&r->stats, "load", span_without(r->scene.load_span, r->scene.bvh_span));
    stats_set_span(&r->stats, "bvh", r->scene.bvh_span);
    stats_set_parts(&r->stats, r->pool);
    char hash[20];
    snprintf(hash, sizeof hash, "%016llx", (unsigned long long)r->scene.hash);
    satin_options used = r->second_pass.options;
    // With a crop, these two options are the size of the whole film, so that --set takes them back.
    if (used.crop_width > 0 && used.crop_height > 0) {
        used.width = r->scene.film.width;
        used.height = r->scene.film.height;
    }
    char *options = options_text(&used);
    free(film->stats);
    film->stats = stats_json(&r->stats);
    bool ok = options && film->stats && film_attribute_set(film, "satin:version", SATIN_VERSION) &&
              film_attribute_set(film, "satin:scene_hash", hash) &&
              film_attribute_set(film, "satin:options", options);
    if (ok && r->image->denoised)
        ok = film_attribute_set(film, "satin:denoiser", film_denoiser_name(r->denoiser));
    if (ok && render_cancelled(r))
        ok = film_attribute_set(film, "satin:cancelled",
                                render_stage_name(r->progress.cancelled_in));
    free(options);
    return ok;
}
