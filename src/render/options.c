// SPDX-License-Identifier: Apache-2.0
// Options: the defaults, the quality presets, setting by name, description. Later steps override
// earlier ones: preset, then the scene's integrator element, then the caller.
#include "satin/options.h"

#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "base/text.h"
#include "render/options_quality.h"
#include "render/options_table.h"
#include "scene/scene.h"

const satin_options satin_options_default = {
    .quality = SATIN_PREVIEW,
    OPTIONS_QUALITY_PREVIEW,
    .adaptive_sampling = true,
    .max_depth = -2,
    .hide_emitters = -1,
    .photon_batch = 1000000,
    .photon_k = 50,
    .caustic_k = 60,
    .caustic_smooth = true,
    .photon_area = true,
    .recursive_bounces = 3,
    .final_gather = true,
    .texture_filter = true,
    .gather_near = true,
    .gather_direct = true,
    .refine_lookups = true,
    .guide_clusters = true,
    .guide_visibility = true,
    .irradiance_cache = true,
    .irradiance_filter = true,
    .noise_filter = true,
    .edge_rays = 64,
    .irradiance_gradients = SATIN_GRADIENTS_STRATIFIED,
    .irradiance_gradient_clamp = true,
    .irradiance_neighbour_clamp = true,
    .irradiance_max_pixels = 100000.0f,
    .radiance_cache = true,
    .radiance_gradients = SATIN_GRADIENTS_STRATIFIED,
    .radiance_basis = SATIN_HSH,
    .radiance_error = 0.01f,
    .radiance_rotation = 0.0f,
    .radiance_gradient_clamp = true,
    .radiance_curvature_clamp = true,
    .radiance_max_pixels = 12.0f,
    .adaptive_cache = true,
    .origin_shift = true,
    .gather_radius_ratio = 0.3f,
    .leak_test = true,
};

// Sets the fields that are 0 to their defaults.
static void set_zeroed(satin_options *options) {
    static const satin_options zero;
    char of_zero[OPTION_TEXT_SIZE], value[OPTION_TEXT_SIZE];
    for (int i = 0; i < options_table_count; i++) {
        const struct option *option = &options_table[i];
        option_print(option, options, value, sizeof value);
        option_print(option, &zero, of_zero, sizeof of_zero);
        if (strcmp(value, of_zero) != 0) continue;
        option_print(option, &satin_options_default, value, sizeof value);
        option_parse(option, value, options);
    }
}

void satin_options_preset(satin_options *options, satin_quality quality) {
    if (options->photon_k == 0) set_zeroed(options);
    options_quality_preset(options, quality);
    options->quality = quality;
}

// Reports an error in an option at its place in a scene, or without a place.
static satin_status refuse_option(struct log log, struct log_place place, const char *text) {
    if (place.file)
        log_error_at(log, place, "%s", text);
    else
        log_message(log, SATIN_LOG_ERROR, "%s", text);
    return SATIN_ERROR_INPUT;
}

static satin_status refuse_option_name(struct log log, struct log_place place, const char *name) {
    struct text_nearest search = {.word = name};
    char text[256];
    const char *now = options_renamed(name);
    if (now) {
        snprintf(text, sizeof text, "option '%.80s' is now called '%s'", name, now);
        return refuse_option(log, place, text);
    }
    for (int i = 0; i < options_table_count; i++) text_nearest_try(&search, options_table[i].name);
    int n = snprintf(text, sizeof text, "unknown option '%.80s'", name);
    if (search.best)
        snprintf(text + n, sizeof text - (size_t)n, " (did you mean '%s'?)", search.best);
    return refuse_option(log, place, text);
}

// Sets `out` to the value of material_cache with material.NAME.cache=value added in front. False if
// the name or the value has another form.
static bool material_value(const satin_options *options, const char *name, const char *value,
                           char *out, size_t size) {
    static const char first[] = "material.", last[] = ".cache";
    size_t length = strlen(name), head = sizeof first - 1, tail = sizeof last - 1;
    if (length <= head + tail || strncmp(name, first, head) != 0 ||
        strcmp(name + length - tail, last) != 0)
        return false;
    const char *list = options->material_cache;
    snprintf(out, size, "%.*s=%s%s%s", (int)(length - head - tail), name + head, value,
             *list ? "," : "", list);
    return true;
}

static satin_status set(satin_options *options, const char *name, const char *value, struct log log,
                        struct log_place place) {
    char list[2 * OPTION_TEXT_SIZE];
    if (material_value(options, name, value, list, sizeof list))
        name = "material-cache", value = list;
    const struct option *option = options_find(name);
    if (!option) return refuse_option_name(log, place, name);
    if (!option_parse(option, value, options)) {
        char text[256];
        snprintf(text, sizeof text, "option %s: '%.80s' is not in %s", option->name, value,
                 option->range);
        return refuse_option(log, place, text);
    }
    if (option->offset == offsetof(satin_options, quality))
        satin_options_preset(options, options->quality);
    return SATIN_OK;
}

satin_status satin_options_set(satin_options *options, const char *name, const char *value,
                               satin_log_fn log, void *log_user) {
    return set(options, name, value, (struct log){log, log_user}, (struct log_place){0});
}

static bool is_quality(const char *name) { return text_same_name(name, "quality"); }

satin_status satin_options_resolve(const satin_scene *scene, const satin_setting *settings,
                                   size_t count, satin_log_fn log_fn, void *log_user,
                                   satin_options *out) {
    struct log log = {log_fn, log_user};
    satin_options made = satin_options_default;
    satin_status status = SATIN_OK;
    size_t scene_count = scene ? scene->hints.option_count : 0;
    // Pass 0 sets only the quality, because a preset would overwrite the options set before it.
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < scene_count && status == SATIN_OK; i++) {
            const struct scene_option *o = &scene->hints.option[i];
            if (is_quality(o->name) == (pass == 0))
                status = set(&made, o->name, o->value, log, o->place);
        }
        for (size_t i = 0; i < count && status == SATIN_OK; i++)
            if (is_quality(settings[i].name) == (pass == 0))
                status =
                    set(&made, settings[i].name, settings[i].value, log, (struct log_place){0});
    }
    if (status == SATIN_OK) *out = made;
    return status;
}

void options_print_words(FILE *out, const satin_options *options,
                         bool (*chosen)(const char *name)) {
    satin_option_info info;
    const char *space = "";
    for (int i = 0; satin_options_describe(options, i, &info); i++) {
        if (chosen && !chosen(info.name)) continue;
        fprintf(out, "%s%s=%s", space, info.name, info.value);
        space = " ";
    }
}

// Whether a field has a value that satin_options_set takes: its text is parsed again, which shows
// neither an enum below 0 nor a text without an end. *value gets the text.
static bool is_in_range(const struct option *option, const satin_options *options, char *value,
                        size_t size) {
    satin_options parsed = {0};
    const char *in = (const char *)options + option->offset;
    if (option->kind == OPTION_TEXT && !memchr(in, 0, OPTION_TEXT_SIZE)) {
        snprintf(value, size, "%.80s", in);
        return false;
    }
    option_print(option, options, value, size);
    bool ok = option_parse(option, value, &parsed);
    if (option->kind != OPTION_CHOICE) return ok;
    ok = ok && memcmp(in, (const char *)&parsed + option->offset, sizeof(int)) == 0;
    int number;
    memcpy(&number, in, sizeof number);
    if (!ok) snprintf(value, size, "%d", number);
    return ok;
}

satin_status options_check(const satin_options *options, struct log log) {
    char value[OPTION_TEXT_SIZE];
    if (options->photon_k == 0)
        return log_fail(log, SATIN_ERROR_INPUT,
                        "photon_k is 0, as in options that were not initialized: copy "
                        "satin_options_default, or call satin_options_preset");
    for (int i = 0; i < options_table_count; i++) {
        const struct option *option = &options_table[i];
        if (!is_in_range(option, options, value, sizeof value))
            return log_fail(log, SATIN_ERROR_INPUT, "option %s: '%.80s' is not in %s", option->name,
                            value, option->range);
    }
    return SATIN_OK;
}

bool satin_options_describe(const satin_options *options, int index, satin_option_info *out) {
    if (index < 0 || index >= options_table_count) return false;
    const struct option *option = &options_table[index];
    out->name = option->name;
    out->range = option->range;
    out->doc = option->doc;
    option_print(option, options, out->value, sizeof out->value);
    return true;
}
