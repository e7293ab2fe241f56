// SPDX-License-Identifier: Apache-2.0
// Channels of an `aov` integrator: pairs of a channel's name and its kind, in Mitsuba 3's notation.
// Also those that `moment` adds: the light, and the squares of all channels in it.
#include <stdio.h>
#include <string.h>

#include "base/text.h"
#include "load/load_state.h"

// Longest name of a channel: names in EXR files end at 255 bytes.
enum { NAME_MAX = 200 };

static const struct {
    const char *type, *letters;
} aov_kinds[AOV_KINDS] = {
    [AOV_ALBEDO] = {"albedo", "RGB"},
    [AOV_DEPTH] = {"depth", "T"},
    [AOV_POSITION] = {"position", "XYZ"},
    [AOV_UV] = {"uv", "UV"},
    [AOV_GEO_NORMAL] = {"geo_normal", "XYZ"},
    [AOV_SH_NORMAL] = {"sh_normal", "XYZ"},
    [AOV_DP_DU] = {"dp_du", "XYZ"},
    [AOV_DP_DV] = {"dp_dv", "XYZ"},
    [AOV_DUV_DX] = {"duv_dx", "UV"},
    [AOV_DUV_DY] = {"duv_dy", "UV"},
    [AOV_PRIM_INDEX] = {"prim_index", "I"},
    [AOV_SHAPE_INDEX] = {"shape_index", "I"},
    [AOV_LIGHT] = {"", "XYZ"},  // not available to `aov`
};

// Finds a kind by its name. If there is none, logs an error with the nearest name.
static bool find_aov_kind(struct log log, struct log_place place, const char *type,
                          enum aov_kind *kind) {
    struct text_nearest nearest = {.word = type};
    for (*kind = 0; *kind < AOV_LIGHT; (*kind)++) {
        if (strcmp(aov_kinds[*kind].type, type) == 0) return true;
        text_nearest_try(&nearest, aov_kinds[*kind].type);
    }
    if (nearest.best)
        log_error_at(log, place, "aovs: unknown type '%s' (did you mean '%s'?)", type,
                     nearest.best);
    else
        log_error_at(log, place, "aovs: type '%s' is not supported", type);
    return false;
}

// Allocates an empty list. False if there is no memory.
static bool aovs_new(struct load_state *loader, struct scene_aovs *aovs) {
    if (aovs->channel) return true;
    aovs->channel = arena_array(&loader->scene->arena, AOV_CHANNELS_MAX, sizeof *aovs->channel);
    for (int kind = 0; kind < AOV_KINDS; kind++) aovs->first[kind] = -1;
    return aovs->channel != NULL;
}

// Adds `channel` and copies its name. Logs failures.
static satin_status add_aov_channel(struct load_state *loader, struct log_place place,
                                    struct scene_aov channel, struct scene_aovs *aovs) {
    if (strlen(channel.name) > NAME_MAX + 2 || aovs->count == AOV_CHANNELS_MAX) {
        log_error_at(loader->log, place,
                     "aovs: names have at most %d letters, and there are %d channels", NAME_MAX,
                     AOV_CHANNELS_MAX);
        return SATIN_ERROR_INPUT;
    }
    for (int k = 0; k < aovs->count; k++)
        if (strcmp(aovs->channel[k].name, channel.name) == 0) {
            log_error_at(loader->log, place, "aovs: channel '%s' is given twice", channel.name);
            return SATIN_ERROR_INPUT;
        }
    channel.name = load_keep_text(loader, channel.name);
    aovs->channel[aovs->count++] = channel;
    return channel.name ? SATIN_OK : load_no_memory(loader);
}

// Adds the channels of a kind: `name` with each of the kind's letters. Logs failures.
static satin_status add_kind(struct load_state *loader, struct log_place place, const char *name,
                             enum aov_kind kind, struct scene_aovs *aovs) {
    const char *letter = aov_kinds[kind].letters;
    const int letters = (int)strlen(letter);
    char text[NAME_MAX + 4];
    if (aovs->first[kind] < 0) {
        aovs->first[kind] = aovs->values;
        aovs->values += letters;
    }
    satin_status status = SATIN_OK;
    for (int i = 0; i < letters && status == SATIN_OK; i++) {
        snprintf(text, sizeof text, "%.*s.%c", NAME_MAX + 1, name, letter[i]);
        struct scene_aov channel = {.name = text, .value = aovs->first[kind] + i};
        status = add_aov_channel(loader, place, channel, aovs);
    }
    return status;
}

// Adds the channels of a pair `name:type`, which is split in place. Logs failures.
static satin_status add_aov(struct load_state *loader, struct log_place place, char *pair,
                            struct scene_aovs *aovs) {
    const struct log log = loader->log;
    enum aov_kind kind;
    char *colon = strchr(pair, ':');
    if (!colon || colon == pair || !colon[1] || strchr(colon + 1, ':')) {
        log_error_at(log, place, "aovs: '%s' is not a pair name:type", pair);
        return SATIN_ERROR_INPUT;
    }
    *colon = '\0';
    if (!find_aov_kind(log, place, colon + 1, &kind)) return SATIN_ERROR_INPUT;
    return add_kind(loader, place, pair, kind, aovs);
}

satin_status load_aovs(struct load_state *loader, const struct param_value *text,
                       struct scene_aovs *out) {
    if (out->aov) {
        log_error_at(loader->log, text->place, "the scene has another integrator 'aov'");
        return SATIN_ERROR_INPUT;
    }
    struct arena *arena = &loader->scene->arena;
    char *rest = arena_text(arena, text->s, strlen(text->s));
    struct scene_aovs aovs = *out;
    if (!rest || !aovs_new(loader, &aovs)) return load_no_memory(loader);
    aovs.aov = true;
    satin_status status = SATIN_OK;
    for (char *pair; status == SATIN_OK && (pair = strtok_r(rest, ", \t\r\n", &rest));)
        status = add_aov(loader, text->place, pair, &aovs);
    if (status != SATIN_OK) return status;
    for (int kind = AOV_DP_DU; kind <= AOV_DUV_DY; kind++)
        aovs.partials = aovs.partials || aovs.first[kind] >= 0;
    *out = aovs;
    return SATIN_OK;
}

satin_status load_aovs_moment(struct load_state *loader, const struct xml_node *inner, int first,
                              struct scene_aovs *out) {
    struct scene_aovs aovs = *out;
    const char *prefix = inner->name && inner->name[0] ? inner->name : "_arg_0";
    char name[2 * NAME_MAX];
    if (aovs.moment) {
        log_error_at(loader->log, inner->place, "the scene has another integrator 'moment'");
        return SATIN_ERROR_INPUT;
    }
    if (!aovs_new(loader, &aovs)) return load_no_memory(loader);
    aovs.moment = true;
    // The channels inside of `moment` get its name as a prefix.
    const int end = aovs.count;
    satin_status status = SATIN_OK;
    aovs.count = first;
    for (int i = first; i < end && status == SATIN_OK; i++) {
        struct scene_aov channel = aovs.channel[i];
        snprintf(name, sizeof name, "%.*s.%s", NAME_MAX, prefix, channel.name);
        channel.name = name;
        status = add_aov_channel(loader, inner->place, channel, &aovs);
    }
    if (status == SATIN_OK) status = add_kind(loader, inner->place, prefix, AOV_LIGHT, &aovs);
    for (int i = first, n = aovs.count; i < n && status == SATIN_OK; i++) {
        struct scene_aov channel = aovs.channel[i];
        snprintf(name, sizeof name, "m2_%.*s", NAME_MAX + 3, channel.name);
        channel.name = name;
        channel.squared = true;
        status = add_aov_channel(loader, inner->place, channel, &aovs);
    }
    if (status == SATIN_OK) *out = aovs;
    return status;
}
