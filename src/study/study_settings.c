// SPDX-License-Identifier: Apache-2.0
// The options of a render of a study: settings of the study, of a point and of the planner, which
// replace each other, checked against the scene.
#include <string.h>

#include "base/fileio.h"
#include "base/text.h"
#include "render/render.h"
#include "study/study_planner.h"

static bool has_prefix_of(const char *name, const char *const *list) {
    for (; *list; list++)
        if (strncmp(name, *list, strlen(*list)) == 0) return true;
    return false;
}

// Appends a setting, which replaces one of the same option.
static void append_setting(struct study_combined *out, struct study_setting setting) {
    size_t kept = 0;
    for (size_t i = 0; i < out->count; i++)
        if (!text_same_name(out->setting[i].name, setting.name))
            out->setting[kept++] = out->setting[i];
    out->count = kept;
    if (out->count < STUDY_SETTINGS_MAX) out->setting[out->count++] = setting;
}

void study_combine_one(struct study_combined *out, const char *name, const char *value) {
    append_setting(out, (struct study_setting){name, value, {0}});
}

void study_combine(struct study_combined *out, const struct study_settings *set,
                   const char *const *without, const char *const *prefix) {
    for (size_t i = 0; i < set->count; i++) {
        const char *name = set->setting[i].name;
        if (without && text_is_one_of(name, without)) continue;
        if (prefix && has_prefix_of(name, prefix)) continue;
        append_setting(out, set->setting[i]);
    }
}

void study_log_at_scene(void *user, satin_log_severity severity, const char *message) {
    const struct planner *p = user;
    const struct log_place at = p->plan->study.scene[p->at].at;
    if (severity == SATIN_LOG_ERROR) log_error_at(p->log, at, "%s", message);
}

// Where the error of settings is logged.
struct blamed {
    struct log log;
    struct log_place at;
};

static void log_at_setting(void *user, satin_log_severity severity, const char *message) {
    const struct blamed *blamed = user;
    if (severity == SATIN_LOG_ERROR) log_error_at(blamed->log, blamed->at, "%s", message);
}

// Resolves and checks the first `count` settings.
static satin_status resolve_first(struct planner *p, const struct study_combined *set, size_t count,
                                  struct log log, satin_options *out) {
    satin_setting setting[STUDY_SETTINGS_MAX];
    satin_options checked;
    for (size_t i = 0; i < count; i++)
        setting[i] = (satin_setting){set->setting[i].name, set->setting[i].value};
    satin_status status = satin_options_resolve(p->scene, setting, count, log.fn, log.user, out);
    if (status != SATIN_OK) return status;
    // Renders that need a denoiser which is not installed fail alone, so that others run.
    checked = *out;
    checked.denoise = out->denoise && p->lists;
    status = render_check(p->scene, &checked, log);
    // Once is enough: opening it takes a while.
    if (status == SATIN_OK && checked.denoise) p->lists = false;
    return status;
}

satin_status study_resolve(struct planner *p, const struct study_combined *set,
                           satin_options *out) {
    struct blamed blamed = {p->log, p->plan->study.scene[p->at].at};
    satin_options scratch;
    size_t count = 0;
    const satin_status status = resolve_first(p, set, set->count, (struct log){0}, out);
    if (status == SATIN_OK) return SATIN_OK;
    // The setting from which on no render can begin.
    while (count < set->count &&
           resolve_first(p, set, count, (struct log){0}, &scratch) == SATIN_OK)
        count++;
    if (count > 0 && set->setting[count - 1].at.file) blamed.at = set->setting[count - 1].at;
    resolve_first(p, set, set->count, (struct log){log_at_setting, &blamed}, &scratch);
    return status;
}

uint64_t study_hash_text(uint64_t hash, const char *text) {
    return fileio_hash(hash, text, strlen(text) + 1);
}

uint64_t study_hash_options(uint64_t hash, const satin_options *options) {
    satin_option_info info;
    for (int i = 0; satin_options_describe(options, i, &info); i++) {
        hash = study_hash_text(hash, info.name);
        hash = study_hash_text(hash, info.value);
    }
    return hash;
}
