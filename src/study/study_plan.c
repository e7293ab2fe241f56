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
#include "render/render.h"
#include "satin/film.h"
#include "study/study_work.h"

enum { PROGRAM_BYTES_MAX = 1 << 30 };

// The first seed of a piece of a reference: far from the usual ones of images.
static const uint64_t REFERENCE_SEED = 1000001;

// A setting of every option, and a few more.
enum { SETTINGS_MAX = 512 };

struct planner {
    struct log log;
    struct study_plan *plan;
    satin_scene *scene;  // that is loaded
    size_t at;           // its index
    bool lists;          // nothing is rendered, so that the denoiser must be there now
};

static satin_status fail_memory(struct log log) {
    return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for the study");
}

// ---- Options of a render ------------------------------------------------------------------------

struct combined {
    satin_setting setting[SETTINGS_MAX];
    size_t count;
};

static bool has_prefix_of(const char *name, const char *const *list) {
    for (; *list; list++)
        if (strncmp(name, *list, strlen(*list)) == 0) return true;
    return false;
}

// Appends a setting, which replaces one of the same option.
static void combine_one(struct combined *out, const char *name, const char *value) {
    size_t kept = 0;
    for (size_t i = 0; i < out->count; i++)
        if (!text_same_name(out->setting[i].name, name)) out->setting[kept++] = out->setting[i];
    out->count = kept;
    if (out->count < SETTINGS_MAX) out->setting[out->count++] = (satin_setting){name, value};
}

static void combine(struct combined *out, const struct study_settings *set,
                    const char *const *without, const char *const *prefix) {
    for (size_t i = 0; i < set->count; i++) {
        const char *name = set->setting[i].name;
        if (without && text_is_one_of(name, without)) continue;
        if (prefix && has_prefix_of(name, prefix)) continue;
        combine_one(out, name, set->setting[i].value);
    }
}

static void log_at_point(void *user, satin_log_severity severity, const char *message) {
    const struct planner *p = user;
    const struct log_place at = p->plan->study.scene[p->at].at;
    if (severity == SATIN_LOG_ERROR) log_error_at(p->log, at, "%s", message);
}

// The options that a render with these settings has in the loaded scene.
static satin_status resolve_settings(struct planner *p, const struct combined *set,
                                     satin_options *out) {
    satin_options checked;
    satin_status status =
        satin_options_resolve(p->scene, set->setting, set->count, log_at_point, p, out);
    if (status != SATIN_OK) return status;
    // Renders that need a denoiser which is not installed fail alone, so that others run.
    checked = *out;
    checked.denoise = out->denoise && p->lists;
    status = render_check(p->scene, &checked, (struct log){log_at_point, p});
    // Once is enough: opening it takes a while.
    if (status == SATIN_OK && checked.denoise) p->lists = false;
    return status;
}

static uint64_t hash_text(uint64_t hash, const char *text) {
    return fileio_hash(hash, text, strlen(text) + 1);
}

static uint64_t hash_options(uint64_t hash, const satin_options *options) {
    satin_option_info info;
    for (int i = 0; satin_options_describe(options, i, &info); i++) {
        hash = hash_text(hash, info.name);
        hash = hash_text(hash, info.value);
    }
    return hash;
}

// ---- Renders ------------------------------------------------------------------------------------

// The arguments: the scene, its definitions, and the settings, as flags where there are some.
static const char *const *make_arguments(struct planner *p, const struct combined *set) {
    static const char *const flags[] = {"quality", "integrator", "first-pass", "spp",  "width",
                                        "height",  "seed",       "threads",    "time", NULL};
    struct arena *arena = &p->plan->study.arena;
    const struct study_scene *scene = &p->plan->study.scene[p->at];
    const char **out = arena_array(arena, 2 + 2 * (scene->defines + set->count), sizeof *out);
    size_t n = 0;
    if (!out) return NULL;
    out[n++] = scene->path;
    for (size_t i = 0; i < scene->defines + set->count; i++) {
        const bool define = i < scene->defines;
        const satin_setting *s = define ? NULL : &set->setting[i - scene->defines];
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
static size_t add_render(struct planner *p, enum study_what what, const struct combined *set,
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

static satin_status plan_render(struct planner *p, enum study_what what, struct combined *set,
                                uint64_t seed, size_t *out) {
    const struct study_scene *scene = &p->plan->study.scene[p->at];
    char text[24];
    satin_options options;
    snprintf(text, sizeof text, "%llu", (unsigned long long)seed);
    char *copy = arena_text(&p->plan->study.arena, text, strlen(text));
    if (!copy) return fail_memory(p->log);
    combine_one(set, "seed", copy);
    const satin_status status = resolve_settings(p, set, &options);
    if (status != SATIN_OK) return status;
    uint64_t key = hash_options(FILEIO_HASH, &options);
    key = fileio_hash(key, &scene->hash, sizeof scene->hash);
    key = hash_text(key, SATIN_VERSION);
    for (size_t i = 0; i < scene->defines; i++) {
        key = hash_text(key, scene->define[i].name);
        key = hash_text(key, scene->define[i].value);
    }
    // References take long and are compared with other programs' by tests of their own, so they
    // outlive a new build of the same version.
    if (what != STUDY_REFERENCE)
        key = fileio_hash(key, &p->plan->program_hash, sizeof p->plan->program_hash);
    *out = add_render(p, what, set, key);
    return *out == STUDY_NONE ? fail_memory(p->log) : SATIN_OK;
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
    if (!spp) return fail_memory(p->log);
    snprintf(spp, 24, "%llu", (unsigned long long)study_piece_spp(s));
    uint64_t seed = REFERENCE_SEED;
    for (size_t i = 0; i < s->reference_pieces; i++, seed++) {
        struct combined set = {.count = 0};
        // An image has the noise of a piece with its seed, and would seem too accurate.
        while (has_seed(s, seed)) seed++;
        combine_one(&set, "integrator", "path");
        combine_one(&set, "spp", spp);
        combine(&set, &s->set, without, NULL);
        combine(&set, &s->reference, NULL, NULL);
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
    struct combined whole = {.count = 0}, set = {.count = 0};
    satin_options options;
    combine(&whole, &s->set, NULL, NULL);
    combine(&whole, &point->set, NULL, NULL);
    const satin_status status = resolve_settings(p, &whole, &options);
    if (status != SATIN_OK) return status;
    *out = STUDY_NONE;
    if (!s->first_pass_view || options.integrator != SATIN_TWO_PASS || options.time > 0.0)
        return SATIN_OK;
    const bool records = options.first_pass == SATIN_FIRST_RECURSIVE;
    combine(&set, &s->set, records ? always : without, records ? NULL : prefix);
    combine(&set, &point->set, records ? always : without, records ? NULL : prefix);
    combine_one(&set, "final-gather", "off");
    return plan_render(p, STUDY_FIRST_PASS, &set, seed, out);
}

static satin_status plan_image(struct planner *p, const struct study_point *point, uint64_t seed,
                               size_t *out) {
    struct combined set = {.count = 0};
    combine(&set, &p->plan->study.set, NULL, NULL);
    combine(&set, &point->set, NULL, NULL);
    return plan_render(p, STUDY_IMAGE, &set, seed, out);
}

// ---- Scenes and points --------------------------------------------------------------------------

// Warns of pixels of a reference that no image is compared with.
static void warn_left_out(const struct planner *p, const satin_film *reference) {
    const struct study_scene *scene = &p->plan->study.scene[p->at];
    const size_t count = study_reference_nonfinite(reference);
    if (count)
        log_warning_at(p->log, scene->at,
                       "%zu pixel%s of the reference %s %s not finite, and left out", count,
                       count == 1 ? "" : "s", scene->reference, count == 1 ? "is" : "are");
}

// A reference from a file must have colours and the size that images will have.
static satin_status check_reference(struct planner *p) {
    const struct study *s = &p->plan->study;
    const struct study_scene *scene = &s->scene[p->at];
    struct combined set = {.count = 0};
    satin_options options;
    int width, height, w, h;
    satin_film *film = NULL;
    if (!scene->reference) return SATIN_OK;
    combine(&set, &s->set, NULL, NULL);
    satin_status status = resolve_settings(p, &set, &options);
    if (status == SATIN_OK)
        status = render_size(p->scene, &options, (struct log){log_at_point, p}, &width, &height);
    if (status == SATIN_OK) status = satin_film_read(scene->reference, log_at_point, p, &film);
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
        warn_left_out(p, film);
    }
    satin_film_free(film);
    return status;
}

// Passes on what loading a scene logs. An error that names no line of the scene is at the line of
// the study that has the scene or, if the error names it, the definition.
static void log_load(void *user, satin_log_severity severity, const char *message) {
    const struct planner *p = user;
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
    if (p->log.fn) p->log.fn(p->log.user, severity, message);
}

static satin_status read_scene(struct planner *p, size_t at) {
    struct study_scene *scene = &p->plan->study.scene[at];
    satin_scene_free(p->scene);
    p->scene = NULL;
    p->at = at;
    const satin_status status =
        satin_scene_load(scene->path, scene->define, scene->defines, log_load, p, &p->scene);
    if (status == SATIN_OK) scene->hash = satin_scene_hash(p->scene);
    return status;
}

// The value of an option as text in the study's arena; NULL if there is no such option or no
// memory.
static const char *option_text(struct arena *arena, const satin_options *options,
                               const char *name) {
    satin_option_info info;
    for (int i = 0; satin_options_describe(options, i, &info); i++)
        if (text_same_name(info.name, name))
            return arena_text(arena, info.value, strlen(info.value));
    return NULL;
}

// The options that a render has, with those that a scene or a quality decides.
static satin_status resolve_used(struct planner *p, const satin_options *options,
                                 satin_options *out) {
    return render_used_options(p->scene, options, (struct log){log_at_point, p}, out);
}

// Whether options are what settings would make of them.
static bool agree(struct planner *p, const satin_options *used, const struct study_settings *set) {
    satin_options changed = *used;
    for (size_t i = 0; i < set->count; i++)
        if (satin_options_set(&changed, set->setting[i].name, set->setting[i].value, NULL, NULL) !=
            SATIN_OK)
            return false;
    return resolve_used(p, &changed, &changed) == SATIN_OK &&
           hash_options(FILEIO_HASH, &changed) == hash_options(FILEIO_HASH, used);
}

// What the tables say of a point in a column: the value of the option or, if several options change
// together, the label of those that the point has. NULL if it has none.
static const char *cell_text(struct planner *p, const struct study_column *column,
                             const satin_options *used) {
    if (column->is_option) return option_text(&p->plan->study.arena, used, column->name);
    for (size_t i = 0; i < column->values; i++)
        if (agree(p, used, &column->value[i].set)) return column->value[i].label;
    return NULL;
}

// Sets what the tables say of a point. If another scene than the first decides another value, it is
// that which the option has before a scene decides, such as 0.
static void describe_cells(struct planner *p, struct study_point *point,
                           const satin_options *options, const satin_options *used) {
    struct study *s = &p->plan->study;
    for (size_t c = 0; c < s->columns; c++) {
        const struct study_column *column = &s->column[c];
        if (p->at == 0 && (column->is_option || !point->cell[c])) {
            const char *text = cell_text(p, column, used);
            if (text) point->cell[c] = text;
        } else if (p->at > 0 && column->is_option) {
            const char *text = option_text(&s->arena, used, column->name);
            if (text && point->cell[c] && strcmp(text, point->cell[c]) != 0)
                point->cell[c] = option_text(&s->arena, options, column->name);
        }
    }
}

// Continues the hashes of all points by the options that they have in the loaded scene.
static satin_status describe_points(struct planner *p, uint64_t *hash) {
    struct study *s = &p->plan->study;
    for (size_t i = 0; i < s->points; i++) {
        struct combined set = {.count = 0};
        satin_options options, used;
        combine(&set, &s->set, NULL, NULL);
        combine(&set, &s->point[i].set, NULL, NULL);
        satin_status status = resolve_settings(p, &set, &options);
        if (status == SATIN_OK) status = resolve_used(p, &options, &used);
        if (status != SATIN_OK) return status;
        hash[i] = hash_options(p->at == 0 ? FILEIO_HASH : hash[i], &used);
        describe_cells(p, &s->point[i], &options, &used);
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

static satin_status plan_points(struct planner *p) {
    struct study *s = &p->plan->study;
    uint64_t *hash = calloc(s->points, sizeof *hash);
    satin_status status = hash ? SATIN_OK : fail_memory(p->log);
    for (size_t i = 0; i < s->scenes && status == SATIN_OK; i++) {
        status = read_scene(p, i);
        if (status == SATIN_OK) status = check_reference(p);
        if (status == SATIN_OK) status = describe_points(p, hash);
    }
    if (status == SATIN_OK) merge_points(s, hash);
    free(hash);
    return status;
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
    satin_status status = plan_points(p);
    if (status != SATIN_OK) return status;
    const size_t images = s->scenes * s->points * s->seeds;
    const size_t pieces = s->scenes * s->reference_pieces;
    plan->reference = arena_array(&s->arena, pieces, sizeof *plan->reference);
    plan->image = arena_array(&s->arena, images, sizeof *plan->image);
    plan->first_pass = arena_array(&s->arena, images, sizeof *plan->first_pass);
    if (!plan->reference || !plan->image || !plan->first_pass) return fail_memory(p->log);
    for (size_t i = s->scenes; i-- > 0 && status == SATIN_OK;) {
        // The last scene is still loaded.
        if (p->at != i) status = read_scene(p, i);
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
    return status;
}

void study_plan_free(struct study_plan *plan) {
    for (size_t i = 0; i < plan->renders; i++) free(plan->render[i].result.message);
    free(plan->render);
    study_file_free(&plan->study);
    *plan = (struct study_plan){0};
}
