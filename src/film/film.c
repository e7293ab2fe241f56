// SPDX-License-Identifier: Apache-2.0
// Films: named float channels of one size, with text attributes, made by the renderer or by the
// OpenEXR reader.
#include "film/film.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "satin/render.h"

enum { FILM_PIXELS_MAX = 0x7fffffff };

// The primaries and the white of sRGB (ITU-R BT.709), also those of a file that names none.
const float film_srgb_chromaticities[8] = {0.64f, 0.33f, 0.30f,   0.60f,
                                           0.15f, 0.06f, 0.3127f, 0.3290f};

struct satin_film *film_new(int width, int height, const char *const *channel_names,
                            int channel_count) {
    if (width < 1 || height < 1 || channel_count < 0 || width > FILM_PIXELS_MAX / height)
        return NULL;
    struct satin_film *film = calloc(1, sizeof *film);
    if (!film) return NULL;
    size_t count = (size_t)channel_count, pixels = (size_t)width * (size_t)height;
    film->width = film->full_width = width;
    film->height = film->full_height = height;
    memcpy(film->chromaticities, film_srgb_chromaticities, sizeof film_srgb_chromaticities);
    film->channel_name = calloc(count + 1, sizeof *film->channel_name);
    film->channel = calloc(count + 1, sizeof *film->channel);
    if (!film->channel_name || !film->channel) goto fail;
    for (size_t i = 0; i < count; i++) {
        film->channel_count++;
        film->channel_name[i] = strdup(channel_names[i]);
        film->channel[i] = calloc(pixels, sizeof(float));
        if (!film->channel_name[i] || !film->channel[i]) goto fail;
    }
    return film;
fail:
    satin_film_free(film);
    return NULL;
}

void satin_film_free(satin_film *film) {
    if (!film) return;
    for (int i = 0; i < film->channel_count; i++) {
        free(film->channel_name[i]);
        free(film->channel[i]);
    }
    for (int i = 0; i < film->attribute_count; i++) {
        free(film->attribute[i].name);
        free(film->attribute[i].value);
    }
    free(film->channel_name);
    free(film->channel);
    free(film->attribute);
    free(film->stats);
    free(film);
}

float *film_channel(struct satin_film *film, const char *name) {
    for (int i = 0; i < film->channel_count; i++)
        if (strcmp(film->channel_name[i], name) == 0) return film->channel[i];
    return NULL;
}

bool film_is_cryptomatte(const char *channel) {
    static const char *const layer[] = {"CryptoObject", "CryptoMaterial"};
    for (int i = 0; i < 2; i++) {
        const size_t n = strlen(layer[i]);
        if (strncmp(channel, layer[i], n) != 0) continue;
        const char *rest = channel + n;
        if (strlen(rest) == 4 && strspn(rest, "0123456789") == 2 && rest[2] == '.') return true;
    }
    return false;
}

static struct film_attribute *find_attribute(const struct satin_film *film, const char *name) {
    for (int i = 0; i < film->attribute_count; i++)
        if (strcmp(film->attribute[i].name, name) == 0) return &film->attribute[i];
    return NULL;
}

bool film_attribute_set(struct satin_film *film, const char *name, const char *value) {
    char *copy = strdup(value);
    if (!copy) return false;
    struct film_attribute *found = find_attribute(film, name);
    if (found) {
        free(found->value);
        found->value = copy;
        return true;
    }
    // There are few attributes, so the array grows by one.
    size_t count = (size_t)film->attribute_count;
    struct film_attribute *grown = realloc(film->attribute, (count + 1) * sizeof *grown);
    if (grown) film->attribute = grown;
    char *key = grown ? strdup(name) : NULL;
    if (!key) {
        free(copy);
        return false;
    }
    grown[count] = (struct film_attribute){key, copy};
    film->attribute_count++;
    return true;
}

void film_attribute_remove(struct satin_film *film, const char *name) {
    struct film_attribute *found = find_attribute(film, name);
    struct film_attribute *last = &film->attribute[film->attribute_count - 1];
    free(found->name);
    free(found->value);
    memmove(found, found + 1, (size_t)(last - found) * sizeof *found);
    film->attribute_count--;
}

const char *film_attribute_get(const struct satin_film *film, const char *name) {
    const struct film_attribute *found = find_attribute(film, name);
    return found ? found->value : NULL;
}

const float *film_variance(const struct satin_film *film, const char *channel) {
    const char *kind = film_attribute_get(film, FILM_VARIANCE_ATTRIBUTE);
    return kind && strcmp(kind, FILM_VARIANCE_BOUND) == 0 ? NULL
                                                          : satin_film_channel(film, channel);
}

void satin_film_size(const satin_film *film, int *width, int *height) {
    *width = film->width;
    *height = film->height;
}

void satin_film_window(const satin_film *film, int *x, int *y, int *full_width, int *full_height) {
    *x = film->x;
    *y = film->y;
    *full_width = film->full_width;
    *full_height = film->full_height;
}

const char *satin_film_channel_name(const satin_film *film, int index) {
    return index >= 0 && index < film->channel_count ? film->channel_name[index] : NULL;
}

const float *satin_film_channel(const satin_film *film, const char *name) {
    return film_channel((struct satin_film *)film, name);
}

const char *satin_film_stats(const satin_film *film) { return film->stats; }
