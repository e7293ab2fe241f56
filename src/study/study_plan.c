// SPDX-License-Identifier: Apache-2.0
// Lists the renders of a study. Each has a key, a hash of all that its result depends on: the scene
// as it was read, all options, the seed and the program. Results are stored under these keys, so a
// study that continues finds those that are still valid, and a change of the file, of a scene or of
// the program is noticed.
#include "study/study_plan.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/fileio.h"
#include "base/text.h"
#include "study/study_planner.h"

enum { PROGRAM_BYTES_MAX = 1 << 30 };

// The first seed of a piece of a reference: far from the usual ones of images.
static const uint64_t REFERENCE_SEED = 1000001;

satin_status study_plan_no_memory(struct log log) {
    return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for the study");
}

// ---- Renders ------------------------------------------------------------------------------------

// The arguments: the scene, its sensor, its definitions, and the settings, as flags where there are
// some.
static const char *const *make_arguments(struct planner *p, const struct study_combined *set) {
    static const char *const flags[] = {"quality", "integrator", "first-pass", "spp",  "width",
                                        "height",  "seed",       "threads",    "time", NULL};
    struct arena *arena = &p->plan->study.arena;
    const struct study_scene *scene = &p->plan->study.scene[p->at];
    const char **out = arena_array(arena, 4 + 2 * (scene->defines + set->count), sizeof *out);
    size_t n = 0;
    if (!out) return NULL;
    out[n++] = scene->path;
    if (scene->sensor) {
        out[n++] = "--sensor";
        out[n++] = scene->sensor;
    }
    for (size_t i = 0; i < scene->defines + set->count; i++) {
        const bool define = i < scene->defines;
        const struct study_setting *s = define ? NULL : &set->setting[i - scene->defines];
        const char *name = define ? scene->define[i].name : s->name;
        const char *value = define ? scene->define[i].value : s->value;
        const bool flag = !define && text_is_one_of(name, flags);
        const size_t bytes = strlen(name) + strlen(value) + 8;
        char *word = arena_alloc(arena, bytes), *joined = arena_alloc(arena, bytes);
        if (!word || !joined) return NULL;
        snprintf(word, bytes, "%s%s", define ? "-D" : flag ? "--" : "--set", flag ? name : "");
        snprintf(joined, bytes, flag ? "%s%s" : "%s=%s", flag ? "" : name, value);
        for (char *c = word; flag && *c; c++)
            if (*c == '_') *c = '-';
        out[n++] = word;
        out[n++] = joined;
    }
    return out;
}

// The index of a render with that key, which is appended if it is new; STUDY_NONE if there is no
// memory.
static size_t add_render(struct planner *p, enum study_what what, const struct study_combined *set,
                         uint64_t key) {
    struct study_plan *plan = p->plan;
    for (size_t i = plan->renders; i-- > 0;)
        if (plan->render[i].key == key) return i;
    void *grown = plan->render;
    if (!array_reserve(&grown, &plan->render_capacity, plan->renders + 1, sizeof *plan->render))
        return STUDY_NONE;
    plan->render = grown;
    struct study_render *render = &plan->render[plan->renders];
    *render = (struct study_render){what, p->at, key, make_arguments(p, set), {0}};
    return render->argument ? plan->renders++ : STUDY_NONE;
}

static satin_status plan_render(struct planner *p, enum study_what what, struct study_combined *set,
                                uint64_t seed, size_t *out) {
    const struct study_scene *scene = &p->plan->study.scene[p->at];
    char text[24];
    satin_options options;
    snprintf(text, sizeof text, "%llu", (unsigned long long)seed);
    char *copy = arena_text(&p->plan->study.arena, text, strlen(text));
    if (!copy) return study_plan_no_memory(p->log);
    study_combine_one(set, "seed", copy);
    const satin_status status = study_resolve(p, set, &options);
    if (status != SATIN_OK) return status;
    uint64_t key = study_hash_options(FILEIO_HASH, &options);
    key = fileio_hash(key, &scene->hash, sizeof scene->hash);
    key = study_hash_text(key, SATIN_VERSION);
    for (size_t i = 0; i < scene->defines; i++) {
        key = study_hash_text(key, scene->define[i].name);
        key = study_hash_text(key, scene->define[i].value);
    }
    // References take long and are compared with other programs' by tests of their own, so they
    // outlive a new build of the same version.
    if (what != STUDY_REFERENCE)
        key = fileio_hash(key, &p->plan->program_hash, sizeof p->plan->program_hash);
    *out = add_render(p, what, set, key);
    return *out == STUDY_NONE ? study_plan_no_memory(p->log) : SATIN_OK;
}

// ---- Kinds of renders ---------------------------------------------------------------------------

static bool has_seed(const struct study *s, uint64_t seed) {
    for (size_t i = 0; i < s->seeds; i++)
        if (s->seed[i] == seed) return true;
    return false;
}

static satin_status plan_reference(struct planner *p, size_t *out) {
    // These decide how an image is computed, not what it shows.
    static const char *const without[] = {"integrator", "first-pass",        "spp",     "time",
                                          "denoise",    "adaptive-sampling", "quality", NULL};
    struct study *s = &p->plan->study;
    if (s->scene[p->at].reference) return SATIN_OK;
    char *spp = arena_alloc(&s->arena, 24);
    if (!spp) return study_plan_no_memory(p->log);
    snprintf(spp, 24, "%llu", (unsigned long long)study_piece_spp(s));
    uint64_t seed = REFERENCE_SEED;
    for (size_t i = 0; i < s->reference_pieces; i++, seed++) {
        struct study_combined set = {.count = 0};
        // An image has the noise of a piece with its seed, and would seem too accurate.
        while (has_seed(s, seed)) seed++;
        study_combine_one(&set, "integrator", "path");
        study_combine_one(&set, "spp", spp);
        study_combine(&set, &s->set, without, NULL);
        study_combine(&set, &s->reference, NULL, NULL);
        const satin_status status = plan_render(p, STUDY_REFERENCE, &set, seed, &out[i]);
        if (status != SATIN_OK) return status;
    }
    return SATIN_OK;
}

// An image of the first pass, shown directly. Options of the second pass are left out, so that
// points which differ in these alone have one image of it; but `recursive` makes records by them.
// With a time limit the photons depend on the whole render, so that there is no such image.
static satin_status plan_first_pass(struct planner *p, const struct study_point *point,
                                    uint64_t seed, size_t *out) {
    static const char *const always[] = {"denoise", "record-maps", NULL};
    static const char *const without[] = {"denoise",
                                          "record-maps",
                                          "adaptive-cache",
                                          "origin-shift",
                                          "leak-test",
                                          "record-max-radius",
                                          "gather-radius-ratio",
                                          "glossy-samples",
                                          "recursive-bounces",
                                          "material-cache",
                                          NULL};
    static const char *const prefix[] = {"irradiance", "radiance", "material.", NULL};
    const struct study *s = &p->plan->study;
    struct study_combined whole = {.count = 0}, set = {.count = 0};
    satin_options options;
    study_combine(&whole, &s->set, NULL, NULL);
    study_combine(&whole, &point->set, NULL, NULL);
    const satin_status status = study_resolve(p, &whole, &options);
    if (status != SATIN_OK) return status;
    *out = STUDY_NONE;
    if (!s->first_pass_view || options.integrator != SATIN_TWO_PASS || options.time > 0.0)
        return SATIN_OK;
    const bool records = options.first_pass == SATIN_FIRST_RECURSIVE;
    study_combine(&set, &s->set, records ? always : without, records ? NULL : prefix);
    study_combine(&set, &point->set, records ? always : without, records ? NULL : prefix);
    study_combine_one(&set, "final-gather", "off");
    return plan_render(p, STUDY_FIRST_PASS, &set, seed, out);
}

static satin_status plan_image(struct planner *p, const struct study_point *point, uint64_t seed,
                               size_t *out) {
    struct study_combined set = {.count = 0};
    study_combine(&set, &p->plan->study.set, NULL, NULL);
    study_combine(&set, &point->set, NULL, NULL);
    return plan_render(p, STUDY_IMAGE, &set, seed, out);
}

// Renders of one scene, in the order in which they run: every point by the first seed, then by the
// next, so that a change of the machine's speed affects all points.
static satin_status plan_scene(struct planner *p) {
    struct study_plan *plan = p->plan;
    const struct study *s = &plan->study;
    satin_status status = plan_reference(p, &plan->reference[p->at * s->reference_pieces]);
    for (size_t k = 0; k < s->seeds; k++)
        for (size_t i = 0; i < s->points; i++) {
            const size_t at = (p->at * s->points + i) * s->seeds + k;
            if (status == SATIN_OK)
                status = plan_image(p, &s->point[i], s->seed[k], &plan->image[at]);
            if (status == SATIN_OK)
                status = plan_first_pass(p, &s->point[i], s->seed[k], &plan->first_pass[at]);
        }
    return status;
}

static satin_status plan_all(struct planner *p) {
    struct study_plan *plan = p->plan;
    struct study *s = &plan->study;
    satin_status status = study_plan_points(p);
    if (status != SATIN_OK) return status;
    const size_t images = s->scenes * s->points * s->seeds;
    const size_t pieces = s->scenes * s->reference_pieces;
    plan->reference = arena_array(&s->arena, pieces, sizeof *plan->reference);
    plan->image = arena_array(&s->arena, images, sizeof *plan->image);
    plan->first_pass = arena_array(&s->arena, images, sizeof *plan->first_pass);
    if (!plan->reference || !plan->image || !plan->first_pass) return study_plan_no_memory(p->log);
    for (size_t i = 0; i < s->scenes && status == SATIN_OK; i++) {
        // The only scene is still loaded.
        if (p->at != i) status = study_plan_read_scene(p, i);
        if (status == SATIN_OK) status = plan_scene(p);
    }
    return status;
}

satin_status study_plan_make(struct log log, const struct study_request *request,
                             struct study_plan *out) {
    char *bytes = NULL;
    size_t size = 0;
    struct planner p = {.log = log, .plan = out, .lists = request->dry};
    *out = (struct study_plan){0};
    satin_status status = study_file_read(log, request->file, &out->study);
    if (status == SATIN_OK)
        status = fileio_read(log, (struct log_place){0}, request->program, PROGRAM_BYTES_MAX,
                             &bytes, &size);
    if (status != SATIN_OK) return status;
    out->program_hash = fileio_hash_large(FILEIO_HASH, bytes, size);
    free(bytes);
    status = plan_all(&p);
    satin_scene_free(p.scene);
    free(p.warnings.data);
    return status;
}

void study_plan_free(struct study_plan *plan) {
    for (size_t i = 0; i < plan->renders; i++) free(plan->render[i].result.message);
    free(plan->render);
    study_file_free(&plan->study);
    *plan = (struct study_plan){0};
}

// Removes the entries of a scene from an array that has `each` of every scene.
static void remove_entries(size_t *array, size_t scenes, size_t scene, size_t each) {
    memmove(array + scene * each, array + (scene + 1) * each,
            (scenes - scene - 1) * each * sizeof *array);
}

void study_plan_leave_scene(struct study_plan *plan, size_t scene) {
    struct study *s = &plan->study;
    remove_entries(plan->reference, s->scenes, scene, s->reference_pieces);
    remove_entries(plan->image, s->scenes, scene, s->points * s->seeds);
    remove_entries(plan->first_pass, s->scenes, scene, s->points * s->seeds);
    memmove(s->scene + scene, s->scene + scene + 1, (s->scenes - scene - 1) * sizeof *s->scene);
    s->scenes--;
}
