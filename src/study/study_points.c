// SPDX-License-Identifier: Apache-2.0
// The scenes and points of a study that is planned: loads scenes, checks references from files, and
// finds the options that points have, of which equal ones become one.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/fileio.h"
#include "base/text.h"
#include "render/render.h"
#include "satin/film.h"
#include "study/study_planner.h"
#include "study/study_work.h"

// ---- Scenes -------------------------------------------------------------------------------------

// Warns of pixels of a reference that no image is compared with, and of other colours than those of
// images.
static void warn_of_reference(const struct planner *p, const satin_film *reference) {
    const struct study_scene *scene = &p->plan->study.scene[p->at];
    const size_t count = study_reference_nonfinite(reference);
    if (count)
        log_warning_at(p->log, scene->at,
                       "%zu pixel%s of the reference %s %s not finite, and left out", count,
                       count == 1 ? "" : "s", scene->reference, count == 1 ? "is" : "are");
    if (!film_same_primaries(reference->chromaticities, film_srgb_chromaticities))
        log_warning_at(p->log, scene->at,
                       "the reference %s has other chromaticities than images, those of sRGB",
                       scene->reference);
}

// A reference from a file must have colours and the size that images will have.
static satin_status check_reference(struct planner *p) {
    const struct study *s = &p->plan->study;
    const struct study_scene *scene = &s->scene[p->at];
    struct study_combined set = {.count = 0};
    satin_options options;
    int width, height, w, h;
    satin_film *film = NULL;
    if (!scene->reference) return SATIN_OK;
    study_combine(&set, &s->set, NULL, NULL);
    satin_status status = study_resolve(p, &set, &options);
    if (status == SATIN_OK)
        status =
            render_size(p->scene, &options, (struct log){study_log_at_scene, p}, &width, &height);
    if (status == SATIN_OK)
        status = satin_film_read(scene->reference, study_log_at_scene, p, &film);
    if (status != SATIN_OK) return status;
    satin_film_size(film, &w, &h);
    if (!satin_film_channel(film, "R") || !satin_film_channel(film, "G") ||
        !satin_film_channel(film, "B")) {
        status = SATIN_ERROR_INPUT;
        log_error_at(p->log, scene->at, "the reference %s has no channels R, G and B",
                     scene->reference);
    } else if (w != width || h != height) {
        status = SATIN_ERROR_INPUT;
        log_error_at(p->log, scene->at, "the reference %s has %dx%d pixels, images have %dx%d",
                     scene->reference, w, h, width, height);
    } else {
        warn_of_reference(p, film);
    }
    satin_film_free(film);
    return status;
}

// Whether a warning of a scene, which may be read several times, has not been logged yet. Then it
// is noted.
static bool is_new_warning(struct planner *p, const char *message) {
    struct study_text line = {0};
    study_text_add(&line, "\n%s\n", message);
    const bool is_new = line.failed || !p->warnings.data || !strstr(p->warnings.data, line.data);
    if (is_new) study_text_add(&p->warnings, "\n%s\n", message);
    free(line.data);
    return is_new;
}

// Passes on what loading a scene logs. An error that names no line of the scene is at the line of
// the study that has the scene or, if the error names it, the definition.
static void log_load(void *user, satin_log_severity severity, const char *message) {
    struct planner *p = user;
    const struct study_scene *scene = &p->plan->study.scene[p->at];
    const size_t path = strlen(scene->path);
    const bool whole_scene =
        strncmp(message, scene->path, path) == 0 && strncmp(message + path, ": ", 2) == 0;
    for (size_t i = 0; i < scene->defines && whole_scene; i++) {
        char quoted[256];
        snprintf(quoted, sizeof quoted, "'%s'", scene->define[i].name);
        if (severity != SATIN_LOG_ERROR || !strstr(message, quoted)) continue;
        log_error_at(p->log, scene->define_at[i], "%s", message);
        return;
    }
    if (severity == SATIN_LOG_ERROR && whole_scene) {
        log_error_at(p->log, scene->at, "%s", message);
        return;
    }
    if (severity != SATIN_LOG_WARNING || is_new_warning(p, message))
        log_message(p->log, severity, "%s", message);
}

satin_status study_plan_read_scene(struct planner *p, size_t at) {
    struct study_scene *scene = &p->plan->study.scene[at];
    satin_scene_free(p->scene);
    p->scene = NULL;
    p->at = at;
    const satin_scene_request request = {
        .defines = scene->define, .define_count = scene->defines, .sensor = scene->sensor};
    const satin_status status =
        satin_scene_load_request(scene->path, &request, log_load, p, &p->scene);
    if (status == SATIN_OK) scene->hash = satin_scene_hash(p->scene);
    return status;
}

// ---- Points -------------------------------------------------------------------------------------

// Sets *out to the value of an option, in the study's arena. It stays for a name that adds to
// another option, as that of a material does.
static satin_status find_value(struct planner *p, const satin_options *options, const char *name,
                               const char **out) {
    satin_option_info info;
    for (int i = 0; satin_options_describe(options, i, &info); i++) {
        if (!text_same_name(info.name, name)) continue;
        const char *copy = arena_text(&p->plan->study.arena, info.value, strlen(info.value));
        if (!copy) return study_plan_no_memory(p->log);
        *out = copy;
    }
    return SATIN_OK;
}

// Finds whether options are what settings would make of them.
static satin_status agree(struct planner *p, const satin_options *used,
                          const struct study_settings *set, bool *out) {
    satin_options changed = *used;
    *out = false;
    for (size_t i = 0; i < set->count; i++)
        if (satin_options_set(&changed, set->setting[i].name, set->setting[i].value, NULL, NULL) !=
            SATIN_OK)
            return SATIN_OK;
    // Settings that are wrong in this scene are reported for the point that has them.
    const satin_status status = render_used_options(p->scene, &changed, (struct log){0}, &changed);
    if (status == SATIN_ERROR_MEMORY) return study_plan_no_memory(p->log);
    *out = status == SATIN_OK &&
           study_hash_options(FILEIO_HASH, &changed) == study_hash_options(FILEIO_HASH, used);
    return SATIN_OK;
}

// Finds what the tables say of a point in a column: the value of the option or, if several options
// change together, the label of those that the point has. *out stays if it has none.
static satin_status find_cell(struct planner *p, const struct study_column *column,
                              const satin_options *used, const char **out) {
    satin_status status = SATIN_OK;
    bool found = false;
    if (column->is_option) return find_value(p, used, column->name, out);
    for (size_t i = 0; i < column->values && status == SATIN_OK && !found; i++) {
        status = agree(p, used, &column->value[i].set, &found);
        if (found) *out = column->value[i].label;
    }
    return status;
}

// Sets what the tables say of a point. If another scene than the first decides another value, it is
// that which the option has before a scene decides, such as 0.
static satin_status describe_cells(struct planner *p, struct study_point *point,
                                   const satin_options *options, const satin_options *used) {
    struct study *s = &p->plan->study;
    satin_status status = SATIN_OK;
    for (size_t c = 0; c < s->columns && status == SATIN_OK; c++) {
        const struct study_column *column = &s->column[c];
        if (p->at == 0 && (column->is_option || !point->cell[c])) {
            status = find_cell(p, column, used, &point->cell[c]);
        } else if (p->at > 0 && column->is_option && point->cell[c]) {
            const char *value = point->cell[c];
            status = find_value(p, used, column->name, &value);
            if (status == SATIN_OK && strcmp(value, point->cell[c]) != 0)
                status = find_value(p, options, column->name, &point->cell[c]);
        }
    }
    return status;
}

// Continues the hashes of all points by the options that they have in the loaded scene.
static satin_status describe_points(struct planner *p, uint64_t *hash) {
    struct study *s = &p->plan->study;
    for (size_t i = 0; i < s->points; i++) {
        struct study_combined set = {.count = 0};
        satin_options options, used;
        study_combine(&set, &s->set, NULL, NULL);
        study_combine(&set, &s->point[i].set, NULL, NULL);
        satin_status status = study_resolve(p, &set, &options);
        if (status == SATIN_OK)
            status =
                render_used_options(p->scene, &options, (struct log){study_log_at_scene, p}, &used);
        if (status != SATIN_OK) return status;
        hash[i] = study_hash_options(p->at == 0 ? FILEIO_HASH : hash[i], &used);
        status = describe_cells(p, &s->point[i], &options, &used);
        if (status != SATIN_OK) return status;
    }
    return SATIN_OK;
}

// Removes points whose hash another one has; the first keeps its labels and takes others from them.
static void merge_points(struct study *s, uint64_t *hash) {
    size_t kept = 0;
    for (size_t i = 0; i < s->points; i++) {
        size_t k = 0;
        while (k < kept && hash[k] != hash[i]) k++;
        if (k == kept) {
            s->point[kept] = s->point[i];
            hash[kept++] = hash[i];
            continue;
        }
        if (!s->point[k].name) s->point[k].name = s->point[i].name;
        for (size_t c = 0; c < s->columns; c++)
            if (!s->point[k].cell[c]) s->point[k].cell[c] = s->point[i].cell[c];
    }
    s->points = kept;
}

satin_status study_plan_points(struct planner *p) {
    struct study *s = &p->plan->study;
    uint64_t *hash = calloc(s->points, sizeof *hash);
    satin_status status = hash ? SATIN_OK : study_plan_no_memory(p->log);
    for (size_t i = 0; i < s->scenes && status == SATIN_OK; i++) {
        status = study_plan_read_scene(p, i);
        if (status == SATIN_OK) status = check_reference(p);
        if (status == SATIN_OK) status = describe_points(p, hash);
    }
    if (status == SATIN_OK) merge_points(s, hash);
    free(hash);
    return status;
}
