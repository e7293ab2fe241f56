// SPDX-License-Identifier: Apache-2.0
// Which channels a film has. There are none of quantities that the integrator does not compute, and
// the option layers may leave out others. A channel that the scene asks for replaces the channel of
// satin's of the same name.
#include <stdio.h>
#include <string.h>

#include "base/text.h"
#include "render/render_image.h"

// The integrators that compute a channel, as bits 1 << satin_integrator.
enum {
    BY_TWO_PASS = 1 << SATIN_TWO_PASS,
    BY_PATH = 1 << SATIN_PATH,
    BY_DIRECT = 1 << SATIN_DIRECT,
    BY_PHOTONS = 1 << SATIN_PHOTONS,
    BY_SPPM = 1 << SATIN_SPPM,
    ANY = BY_TWO_PASS | BY_PATH | BY_DIRECT | BY_PHOTONS | BY_SPPM
};

static const struct {
    const char *name;
    unsigned by;
} channels[FILM_CHANNELS] = {
    {"R", ANY},
    {"G", ANY},
    {"B", ANY},
    {"direct.R", BY_TWO_PASS | BY_DIRECT},
    {"direct.G", BY_TWO_PASS | BY_DIRECT},
    {"direct.B", BY_TWO_PASS | BY_DIRECT},
    {"caustic.R", BY_TWO_PASS},
    {"caustic.G", BY_TWO_PASS},
    {"caustic.B", BY_TWO_PASS},
    {"indirect_diffuse.R", BY_TWO_PASS | BY_PHOTONS},
    {"indirect_diffuse.G", BY_TWO_PASS | BY_PHOTONS},
    {"indirect_diffuse.B", BY_TWO_PASS | BY_PHOTONS},
    {"indirect_glossy.R", BY_TWO_PASS},
    {"indirect_glossy.G", BY_TWO_PASS},
    {"indirect_glossy.B", BY_TWO_PASS},
    {"emission.R", ANY},
    {"emission.G", ANY},
    {"emission.B", ANY},
    {"albedo.R", ANY},
    {"albedo.G", ANY},
    {"albedo.B", ANY},
    {"normal.X", ANY},
    {"normal.Y", ANY},
    {"normal.Z", ANY},
    {"depth.Z", ANY},
    {"A", ANY},
    {"density.Y", BY_TWO_PASS},
    {"samples.Y", ANY},
    {"records.position", BY_TWO_PASS},
    {"records.a", BY_TWO_PASS},
    {"records.weight", BY_TWO_PASS},
    {"records.rays", BY_TWO_PASS},
    {"noisy.R", ANY},
    {"noisy.G", ANY},
    {"noisy.B", ANY},
    {"uncached.R", ANY},
    {"uncached.G", ANY},
    {"uncached.B", ANY},
    {"variance.R", BY_PATH},
    {"variance.G", BY_PATH},
    {"variance.B", BY_PATH},
    {"CryptoObject00.R", ANY},
    {"CryptoObject00.G", ANY},
    {"CryptoObject00.B", ANY},
    {"CryptoObject00.A", ANY},
    {"CryptoObject01.R", ANY},
    {"CryptoObject01.G", ANY},
    {"CryptoObject01.B", ANY},
    {"CryptoObject01.A", ANY},
    {"CryptoObject02.R", ANY},
    {"CryptoObject02.G", ANY},
    {"CryptoObject02.B", ANY},
    {"CryptoObject02.A", ANY},
    {"CryptoMaterial00.R", ANY},
    {"CryptoMaterial00.G", ANY},
    {"CryptoMaterial00.B", ANY},
    {"CryptoMaterial00.A", ANY},
    {"CryptoMaterial01.R", ANY},
    {"CryptoMaterial01.G", ANY},
    {"CryptoMaterial01.B", ANY},
    {"CryptoMaterial01.A", ANY},
    {"CryptoMaterial02.R", ANY},
    {"CryptoMaterial02.G", ANY},
    {"CryptoMaterial02.B", ANY},
    {"CryptoMaterial02.A", ANY},
};

static bool is_aov(const struct scene_aovs *aovs, const char *name) {
    for (int i = 0; i < aovs->count; i++)
        if (strcmp(aovs->channel[i].name, name) == 0) return true;
    return false;
}

// The number of letters of a channel's layer: the name before its last point, or all of it.
static size_t layer_length(const char *channel) {
    const char *point = strrchr(channel, '.');
    return point ? (size_t)(point - channel) : strlen(channel);
}

static bool is_beauty(const char *channel) {
    return strlen(channel) == 1 && strchr("RGBA", channel[0]);
}

// Whether option layers has the channel's layer. It has the beauty always, and the mattes, which
// have an option of their own; and all if it is empty.
static bool is_wanted(const char *layers, const char *channel) {
    const size_t length = layer_length(channel);
    if (!*layers || is_beauty(channel) || film_is_cryptomatte(channel)) return true;
    for (const char *at = layers; *at;) {
        const size_t word = strcspn(at, ",");
        if (word == length && strncmp(at, channel, word) == 0) return true;
        at += word + (at[word] == ',');
    }
    return false;
}

// The integrator whose channels the image has: a first pass that is shown directly has those of a
// photon map that is.
static satin_integrator channels_of(const satin_options *options) {
    const bool shown = options->integrator == SATIN_TWO_PASS && !options->final_gather;
    return shown ? SATIN_PHOTONS : options->integrator;
}

static bool has_channel(const struct satin_scene *scene, const satin_options *options, int i) {
    if (i >= CHANNEL_MAPS && i < CHANNEL_NOISY && !options->record_maps) return false;
    if (i >= CHANNEL_NOISY && i < CHANNEL_VARIANCE && !options->denoise) return false;
    // A denoised image has another variance, and weights of both signs have none by this estimate.
    if (i >= CHANNEL_VARIANCE && i < CHANNEL_CRYPTOMATTE &&
        (options->denoise || scene_film_filter_has_lobes(&scene->film)))
        return false;
    if (i == CHANNEL_ALPHA && !scene->film.alpha) return false;
    if (i >= CHANNEL_CRYPTOMATTE &&
        !((int)options->cryptomatte & 1 << (i - CHANNEL_CRYPTOMATTE) / CRYPTOMATTE_CHANNELS))
        return false;
    return channels[i].by & 1u << channels_of(options) &&
           !is_aov(&scene->hints.aovs, channels[i].name);
}

// Sets the names of all channels that the integrator computes, whether or not the option layers has
// them. Returns their number.
static int all_channels(const struct satin_scene *scene, const satin_options *options,
                        const char *name[NAMES_MAX]) {
    const struct scene_aovs *aovs = &scene->hints.aovs;
    int count = 0;
    for (int i = 0; i < FILM_CHANNELS; i++)
        if (has_channel(scene, options, i)) name[count++] = channels[i].name;
    for (int i = 0; i < aovs->count; i++) name[count++] = aovs->channel[i].name;
    return count;
}

// Whether a word of option layers is the only one, if it is `none`, and is not there before.
static bool word_is_alone(const char *layers, const char *at, size_t word, const char *wanted,
                          struct log log) {
    if (strcmp(wanted, "none") == 0 && strlen(layers) > word) {
        log_message(log, SATIN_LOG_ERROR, "option layers: 'none' stands alone, not in '%s'",
                    layers);
        return false;
    }
    for (const char *other = layers; other < at; other += strcspn(other, ",") + 1)
        if (strcspn(other, ",") == word && strncmp(other, at, word) == 0) {
            log_message(log, SATIN_LOG_ERROR, "option layers: '%s' is there twice", wanted);
            return false;
        }
    return true;
}

satin_status render_film_check(const struct satin_scene *scene, const satin_options *options,
                               struct log log) {
    enum { LAYER_NAME = 128 };
    const char *name[NAMES_MAX];
    char layer[NAMES_MAX][LAYER_NAME], wanted[LAYER_NAME];
    const int count = all_channels(scene, options, name);
    for (int i = 0; i < count; i++)
        snprintf(layer[i], LAYER_NAME, "%.*s", (int)layer_length(name[i]), name[i]);
    for (const char *at = options->layers; *at;) {
        const size_t word = strcspn(at, ",");
        snprintf(wanted, sizeof wanted, "%.*s", (int)word, at);
        if (!word_is_alone(options->layers, at, word, wanted, log)) return SATIN_ERROR_INPUT;
        struct text_nearest search = {.word = wanted};
        bool known = strcmp(wanted, "none") == 0;
        for (int i = 0; i < count && !known; i++) {
            if (is_beauty(name[i])) continue;
            known = strcmp(layer[i], wanted) == 0;
            text_nearest_try(&search, layer[i]);
        }
        if (!known && search.best)
            return log_fail(log, SATIN_ERROR_INPUT,
                            "option layers: the image has no layer '%s' (did you mean '%s'?)",
                            wanted, search.best);
        if (!known)
            return log_fail(log, SATIN_ERROR_INPUT, "option layers: the image has no layer '%s'",
                            wanted);
        at += word + (at[word] == ',');
    }
    return SATIN_OK;
}

// Sets the names of the channels that the film has. Returns their number.
static int wanted_channels(const struct satin_scene *scene, const satin_options *options,
                           const char *name[NAMES_MAX]) {
    const int count = all_channels(scene, options, name);
    int wanted = 0;
    for (int i = 0; i < count; i++)
        if (is_wanted(options->layers, name[i])) name[wanted++] = name[i];
    return wanted;
}

int render_film_channels(const struct satin_scene *scene, const satin_options *options) {
    const char *name[NAMES_MAX];
    return wanted_channels(scene, options, name);
}

struct satin_film *render_film_new(const struct satin_scene *scene, const satin_options *options) {
    const char *name[NAMES_MAX];
    const struct scene_film *spec = &scene->film;
    const int wanted = wanted_channels(scene, options, name);
    struct satin_film *film = film_new(spec->crop_width, spec->crop_height, name, wanted);
    if (!film) return NULL;
    film->x = spec->crop_x;
    film->y = spec->crop_y;
    film->full_width = spec->width;
    film->full_height = spec->height;
    film->full_float = spec->full_float;
    return film;
}

struct channel_planes render_film_planes(const struct render_image *image,
                                         struct satin_film *film) {
    struct channel_planes planes;
    for (int i = 0; i < FILM_CHANNELS; i++)
        planes.of[i] =
            is_aov(image->aovs, channels[i].name) ? NULL : film_channel(film, channels[i].name);
    for (int i = 0; i < image->aovs->count; i++)
        planes.aov[i] = film_channel(film, image->aovs->channel[i].name);
    return planes;
}
