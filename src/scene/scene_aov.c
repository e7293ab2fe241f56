// SPDX-License-Identifier: Apache-2.0
// What an `aov` integrator asks for: pairs of a channel's name and what it holds, as Mitsuba 3
// writes them.
#include <stdio.h>
#include <string.h>

#include "base/text.h"
#include "scene/scene_loader.h"

// Letters of a name: EXR files end names at 255.
enum { NAME_MAX = 200 };

static const struct {
    const char *type, *letters;
} kinds[AOV_KINDS] = {
    [AOV_ALBEDO] = {"albedo", "RGB"},         [AOV_DEPTH] = {"depth", "T"},
    [AOV_POSITION] = {"position", "XYZ"},     [AOV_UV] = {"uv", "UV"},
    [AOV_GEO_NORMAL] = {"geo_normal", "XYZ"}, [AOV_SH_NORMAL] = {"sh_normal", "XYZ"},
    [AOV_DP_DU] = {"dp_du", "XYZ"},           [AOV_DP_DV] = {"dp_dv", "XYZ"},
    [AOV_DUV_DX] = {"duv_dx", "UV"},          [AOV_DUV_DY] = {"duv_dy", "UV"},
    [AOV_PRIM_INDEX] = {"prim_index", "I"},   [AOV_SHAPE_INDEX] = {"shape_index", "I"},
};

// Logs what an item is not, and which kinds there are.
static bool find_kind(struct log log, struct log_place place, const char *type,
                      enum aov_kind *kind) {
    struct text_nearest nearest = {.word = type};
    for (*kind = 0; *kind < AOV_KINDS; (*kind)++) {
        if (strcmp(kinds[*kind].type, type) == 0) return true;
        text_nearest_try(&nearest, kinds[*kind].type);
    }
    if (nearest.best)
        log_error_at(log, place, "aovs: unknown type '%s' (did you mean '%s'?)", type,
                     nearest.best);
    else
        log_error_at(log, place, "aovs: type '%s' is not supported", type);
    return false;
}

// Adds the channels of a pair, which it cuts in two. Logs its failures.
static satin_status add_pair(struct scene_loader *loader, struct log_place place, char *pair,
                             struct scene_aovs *aovs) {
    const struct log log = loader->log;
    enum aov_kind kind;
    char name[NAME_MAX + 3], *colon = strchr(pair, ':');
    if (!colon || colon == pair || !colon[1] || strchr(colon + 1, ':')) {
        log_error_at(log, place, "aovs: '%s' is no pair name:type", pair);
        return SATIN_ERROR_INPUT;
    }
    *colon = '\0';
    if (!find_kind(log, place, colon + 1, &kind)) return SATIN_ERROR_INPUT;
    const char *letter = kinds[kind].letters;
    const int letters = (int)strlen(letter);
    if (colon - pair > NAME_MAX || aovs->count + letters > AOV_CHANNELS_MAX) {
        log_error_at(log, place, "aovs: names have at most %d letters, and there are %d channels",
                     NAME_MAX, AOV_CHANNELS_MAX);
        return SATIN_ERROR_INPUT;
    }
    if (aovs->first[kind] < 0) {
        aovs->first[kind] = aovs->values;
        aovs->values += letters;
    }
    for (int i = 0; i < letters; i++) {
        snprintf(name, sizeof name, "%s.%c", pair, letter[i]);
        for (int k = 0; k < aovs->count; k++)
            if (strcmp(aovs->channel[k].name, name) == 0) {
                log_error_at(log, place, "aovs: channel '%s' stands twice", name);
                return SATIN_ERROR_INPUT;
            }
        struct scene_aov *channel = &aovs->channel[aovs->count++];
        channel->name = scene_keep_text(loader, name);
        channel->value = aovs->first[kind] + i;
        if (!channel->name) return scene_no_memory(loader);
    }
    return SATIN_OK;
}

satin_status scene_aovs_read(struct scene_loader *loader, const struct param_value *text,
                             struct scene_aovs *out) {
    if (out->channel) {
        log_error_at(loader->log, text->place, "the scene has another integrator 'aov'");
        return SATIN_ERROR_INPUT;
    }
    struct arena *arena = &loader->scene->arena;
    char *rest = arena_text(arena, text->s, strlen(text->s));
    struct scene_aovs aovs = {.channel =
                                  arena_array(arena, AOV_CHANNELS_MAX, sizeof *aovs.channel)};
    if (!rest || !aovs.channel) return scene_no_memory(loader);
    for (int kind = 0; kind < AOV_KINDS; kind++) aovs.first[kind] = -1;
    satin_status status = SATIN_OK;
    for (char *pair; status == SATIN_OK && (pair = strtok_r(rest, ", \t\r\n", &rest));)
        status = add_pair(loader, text->place, pair, &aovs);
    if (status != SATIN_OK) return status;
    for (int kind = AOV_DP_DU; kind <= AOV_DUV_DY; kind++)
        aovs.partials = aovs.partials || aovs.first[kind] >= 0;
    *out = aovs;
    return SATIN_OK;
}
