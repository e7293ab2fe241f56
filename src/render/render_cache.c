// SPDX-License-Identifier: Apache-2.0
// Files of cache records. A file is valid for a scene, with any sensor and integrator element, and
// for the options that affect records. A render of the same image uses the records unchanged; one
// of another image adds those that are missing.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/fileio.h"
#include "base/text.h"
#include "render/options_quality.h"
#include "render/options_table.h"
#include "render/render_state.h"

static const size_t BYTES_MAX = (size_t)1 << 38;

// Options that do not affect records, except for their positions.
static const char *const free_options[] = {
    "quality",
    "integrator",
    "spp",
    "adaptive-sampling",
    "width",
    "height",
    "seed",
    "threads",
    "crop-x",
    "crop-y",
    "crop-width",
    "crop-height",
    "layers",
    "time",
    "hide-emitters",
    "light-samples",
    "glossy-samples",
    "caustic-k",
    "caustic-photons",
    "record-maps",
    "cryptomatte",
    "denoise",
};

static bool affects_records(const char *option) {
    for (size_t i = 0; i < sizeof free_options / sizeof *free_options; i++)
        if (text_same_name(option, free_options[i])) return false;
    return true;
}

// The options that affect records as `name=value` words, from malloc.
static char *deciding_options(const struct render *r) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    options_print_words(out, &r->options, affects_records);
    fprintf(out, " widest=%g", (double)render_budget_largest_factor(&r->options));
    if (fclose(out) == 0) return text;
    free(text);
    return NULL;
}

// A hash of everything that determines the positions of records; 0 with a time limit, which affects
// them too.
static uint64_t image_hash(const struct render *r) {
    const satin_options *o = &r->options;
    if (o->time > 0.0) return 0;
    const uint64_t image[4] = {r->scene.hash, (uint64_t)o->width, (uint64_t)o->height, o->seed};
    uint64_t hash = fileio_hash(FILEIO_HASH, image, sizeof image);
    const uint64_t views = render_views_hash(r);
    if (views) hash = fileio_hash(hash, &views, sizeof views);
    if (o->crop_width < 1 || o->crop_height < 1) return hash;
    const struct scene_film *film = &r->scene.film;
    const int32_t window[4] = {film->width, film->height, film->crop_x, film->crop_y};
    return fileio_hash(hash, window, sizeof window);
}

// The provenance of this render's records; its options are NULL if there is no memory. The caller
// frees them.
static struct cache_provenance provenance_of(const struct render *r, char **options) {
    *options = deciding_options(r);
    return (struct cache_provenance){r->scene.world, image_hash(r), *options};
}

// A time limit chooses options by the time that loading the scene has left, which is never the same
// twice. So what it chose for the records of a file stays, unless the caller chose another value.
// False if there is no memory.
static bool take_options(struct render *r, const char *words) {
    char *copy = strdup(words), *rest = NULL;
    if (!copy) return false;
    for (char *word = strtok_r(copy, " ", &rest); word; word = strtok_r(NULL, " ", &rest)) {
        char *value = strchr(word, '=');
        if (!value) continue;
        *value++ = '\0';
        const struct option *o = options_find(word);
        if (o && options_quality_chooses(r->motion.options, o)) option_parse(o, value, &r->options);
    }
    free(copy);
    return true;
}

// Whether the records are those that this render would make.
static satin_status check_file(struct render *r, const char *path) {
    const char *words = cache_file_summary(r->second_pass.file).provenance.options;
    const bool timed = r->options.time > 0.0 && r->motion.options;
    if (timed && !take_options(r, words)) return SATIN_ERROR_MEMORY;
    char *options;
    const struct cache_provenance provenance = provenance_of(r, &options);
    const satin_status status =
        options ? cache_file_check(r->second_pass.file, &provenance, path, r->log)
                : SATIN_ERROR_MEMORY;
    free(options);
    return status;
}

satin_status render_cache_open(struct render *r) {
    const char *path = r->callbacks.load_cache;
    const bool records = r->options.integrator == SATIN_TWO_PASS && r->options.final_gather;
    if ((path || r->callbacks.save_cache) && !records)
        return log_fail(r->log, SATIN_ERROR_INPUT,
                        "only the integrator two-pass with final-gather has cache records");
    if (r->callbacks.save_cache && fileio_files_have(&r->scene.read, r->callbacks.save_cache))
        return log_fail(r->log, SATIN_ERROR_INPUT, "%s: the scene was read from this file",
                        r->callbacks.save_cache);
    if (!path) return SATIN_OK;
    satin_status status = fileio_read(r->log, (struct log_place){0}, path, BYTES_MAX,
                                      &r->second_pass.file_bytes, &r->second_pass.file_size);
    if (status == SATIN_OK)
        status = cache_file_parse(r->second_pass.file_bytes, r->second_pass.file_size, path, r->log,
                                  &r->second_pass.file);
    return status == SATIN_OK ? check_file(r, path) : status;
}

bool render_cache_whole(const struct render *r) {
    if (!r->second_pass.file) return false;
    const uint64_t image = cache_file_summary(r->second_pass.file).provenance.image;
    return image != 0 && image == image_hash(r);
}

satin_status render_cache_load(struct render *r, bool *whole) {
    *whole = false;
    if (!r->second_pass.file) return SATIN_OK;
    const struct cache_summary file = cache_file_summary(r->second_pass.file);
    satin_status status =
        cache_load(r->second_pass.cache, r->second_pass.file, r->callbacks.load_cache, r->log);
    *whole = render_cache_whole(r);
    stats_set(&r->stats, "records.loaded", (double)(file.irradiance + file.radiance));
    render_cache_free(r);
    return status;
}

satin_status render_cache_save(const struct render *r) {
    const char *path = r->callbacks.save_cache;
    if (!path || !render_is_first(r)) return SATIN_OK;
    char *options;
    const struct cache_provenance provenance = provenance_of(r, &options);
    satin_status status = SATIN_ERROR_MEMORY;
    if (options) status = cache_save(r->second_pass.cache, &provenance, path, r->log);
    free(options);
    return status;
}

void render_cache_free(struct render *r) {
    cache_file_free(r->second_pass.file);
    free(r->second_pass.file_bytes);
    r->second_pass.file = NULL;
    r->second_pass.file_bytes = NULL;
}
