// SPDX-License-Identifier: Apache-2.0
// The options of a render of a study: settings of the study, of a point and of the planner, which
// replace each other, checked against the scene.
#include <stdio.h>
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

enum { SETTING_MESSAGE_BYTES = 1024 };

static void keep_setting_error(void *user, satin_log_severity severity, const char *message) {
    if (severity == SATIN_LOG_ERROR) snprintf(user, SETTING_MESSAGE_BYTES, "%s", message);
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

// The line of the setting from which on no render can begin, or that of the scene.
static struct log_place find_wrong(struct planner *p, const struct study_combined *set) {
    satin_options scratch;
    size_t count = 0;
    while (count < set->count &&
           resolve_first(p, set, count, (struct log){0}, &scratch) == SATIN_OK)
        count++;
    if (count > 0 && set->setting[count - 1].at.file) return set->setting[count - 1].at;
    return p->plan->study.scene[p->at].at;
}

satin_status study_resolve(struct planner *p, const struct study_combined *set,
                           satin_options *out) {
    char message[SETTING_MESSAGE_BYTES] = "";
    const satin_status status =
        resolve_first(p, set, set->count, (struct log){keep_setting_error, message}, out);
    if (status == SATIN_ERROR_MEMORY) return study_plan_no_memory(p->log);
    if (status != SATIN_OK) log_error_at(p->log, find_wrong(p, set), "%s", message);
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
