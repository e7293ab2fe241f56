// SPDX-License-Identifier: Apache-2.0
// Cryptomatte layers [Friedman and Jones 2015; the specification, version 1.2.0]: which objects or
// materials a pixel shows, and how much of it each of them covers, so that a compositor can mask
// them after the render. An id is the hash of a name, stored as a float. The channels of a layer,
// CryptoObject or CryptoMaterial, are pairs of an id and its coverage by rank: CryptoObject00.R is
// the id that covers most, .G its coverage, .B and .A the second pair, CryptoObject01.R the third
// id and so on. Attributes of the file have the name of the layer and the manifest, a JSON object
// from names to ids.
#include "render/render_cryptomatte.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/text.h"
#include "film/film.h"
#include "scene/scene.h"

static const char *const layer_names[CRYPTOMATTES] = {"CryptoObject", "CryptoMaterial"};

// ---- Names --------------------------------------------------------------------------------------

static uint32_t rotate_bits(uint32_t x, int bits) { return x << bits | x >> (32 - bits); }

static uint32_t mix_block(uint32_t block) {
    return rotate_bits(block * 0xcc9e2d51u, 15) * 0x1b873593u;
}

// MurmurHash3_x86_32 [Appleby], seed 0.
static uint32_t murmur3(const char *text) {
    const size_t size = strlen(text), whole = size / 4 * 4;
    const unsigned char *bytes = (const unsigned char *)text;
    uint32_t hash = 0, rest = 0;
    for (size_t i = 0; i < whole; i += 4) {
        const uint32_t block = (uint32_t)bytes[i] | (uint32_t)bytes[i + 1] << 8 |
                               (uint32_t)bytes[i + 2] << 16 | (uint32_t)bytes[i + 3] << 24;
        hash = rotate_bits(hash ^ mix_block(block), 13) * 5u + 0xe6546b64u;
    }
    for (size_t i = size; i-- > whole;) rest = rest << 8 | bytes[i];
    if (size > whole) hash ^= mix_block(rest);
    hash ^= (uint32_t)size;
    hash = (hash ^ hash >> 16) * 0x85ebca6bu;
    hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
    return hash ^ hash >> 16;
}

// Neither a denormal number nor an infinity nor NaN, which programs might change.
uint32_t render_cryptomatte_id(const char *name) {
    const uint32_t hash = murmur3(name), exponent = hash >> 23 & 255u;
    return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

static const char *name_of(const struct satin_scene *scene, int matte, uint32_t shape) {
    const struct shape *s = &scene->shape[shape];
    return matte == 0 ? s->name : scene->material[s->material].name;
}

// An instance without an id is not an object; its shapes are.
static bool is_object(const struct satin_scene *scene, uint32_t shape) {
    const struct shape *s = &scene->shape[shape];
    return s->kind != SHAPE_INSTANCE || s->has_id;
}

// ---- Pixels -------------------------------------------------------------------------------------

void render_cryptomatte_pixel_add(struct cryptomatte_pixel *pixel, uint32_t id, float weight) {
    int at = 0, least = 0;
    while (at < CRYPTOMATTE_IDS && pixel->id[at] != id && pixel->id[at] != 0) at++;
    if (at < CRYPTOMATTE_IDS) {
        pixel->id[at] = id;
        pixel->weight[at] += weight;
        return;
    }
    for (int i = 1; i < CRYPTOMATTE_IDS; i++)
        if (pixel->weight[i] < pixel->weight[least]) least = i;
    if (pixel->weight[least] > weight) return;
    pixel->id[least] = id;
    pixel->weight[least] = weight;
}

void render_cryptomatte_ranks(const struct cryptomatte_pixel *pixel, float scale,
                              float out[CRYPTOMATTE_CHANNELS]) {
    bool used[CRYPTOMATTE_IDS] = {false};
    for (int rank = 0; rank < CRYPTOMATTE_RANKS; rank++) {
        int best = -1;
        for (int i = 0; i < CRYPTOMATTE_IDS; i++)
            if (!used[i] && pixel->id[i] && (best < 0 || pixel->weight[i] > pixel->weight[best]))
                best = i;
        out[2 * rank] = out[2 * rank + 1] = 0.0f;
        if (best < 0) continue;
        used[best] = true;
        // The weights of a filter with negative lobes may add up to less or more than the pixel.
        const float coverage = fminf(fmaxf(pixel->weight[best] * scale, 0.0f), 1.0f);
        if (!(coverage > 0.0f)) continue;
        memcpy(&out[2 * rank], &pixel->id[best], sizeof(float));
        out[2 * rank + 1] = coverage;
    }
}

// ---- The image ----------------------------------------------------------------------------------

static bool is_matte_wanted(const satin_options *options, int matte) {
    return (int)options->cryptomatte & 1 << matte;
}

bool render_cryptomatte_make(struct render_cryptomatte *mattes, const struct satin_scene *scene,
                             const satin_options *options) {
    const size_t pixels = (size_t)scene->film.crop_width * (size_t)scene->film.crop_height;
    for (int k = 0; k < CRYPTOMATTES; k++) {
        if (!is_matte_wanted(options, k)) continue;
        mattes->id[k] = array_new((size_t)scene->shape_count + 1, sizeof *mattes->id[k]);
        mattes->pixel[k] = calloc(pixels, sizeof *mattes->pixel[k]);
        if (!mattes->id[k] || !mattes->pixel[k]) return false;
        for (uint32_t i = 0; i < scene->shape_count; i++)
            mattes->id[k][i] =
                is_object(scene, i) ? render_cryptomatte_id(name_of(scene, k, i)) : 0;
    }
    return true;
}

void render_cryptomatte_destroy(struct render_cryptomatte *mattes) {
    for (int k = 0; k < CRYPTOMATTES; k++) {
        free(mattes->id[k]);
        free(mattes->pixel[k]);
    }
    *mattes = (struct render_cryptomatte){.id = {NULL}};
}

void render_cryptomatte_add(struct render_cryptomatte *mattes, size_t at,
                            const struct shade_sample *sample) {
    for (int k = 0; k < CRYPTOMATTES && sample->shape > 0; k++) {
        if (!mattes->pixel[k]) continue;
        uint32_t id = mattes->id[k][sample->shape - 1];
        // An instance with an id is an object; else its shapes are.
        if (k == 0 && sample->instance && mattes->id[k][sample->instance - 1])
            id = mattes->id[k][sample->instance - 1];
        render_cryptomatte_pixel_add(&mattes->pixel[k][at], id, sample->weight);
    }
}

// ---- The description ----------------------------------------------------------------------------

static int compare_names(const void *a, const void *b) {
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

// The manifest of all names of the scene, from malloc; NULL if there is no memory.
static char *make_manifest(const struct satin_scene *scene, int matte) {
    char *text = NULL;
    size_t size = 0;
    const char **name = array_new((size_t)scene->shape_count + 1, sizeof *name);
    FILE *out = name ? open_memstream(&text, &size) : NULL;
    if (out) {
        uint32_t count = 0;
        for (uint32_t i = 0; i < scene->shape_count; i++)
            if (is_object(scene, i)) name[count++] = name_of(scene, matte, i);
        qsort(name, count, sizeof *name, compare_names);
        fputc('{', out);
        for (uint32_t i = 0; i < count; i++) {
            if (i > 0 && strcmp(name[i], name[i - 1]) == 0) continue;
            if (i > 0) fputc(',', out);
            text_print_json(out, name[i]);
            fprintf(out, ":\"%08x\"", (unsigned)render_cryptomatte_id(name[i]));
        }
        fputc('}', out);
    }
    free(name);
    if (out && fclose(out) == 0) return text;
    free(text);
    return NULL;
}

static bool describe_matte(const struct satin_scene *scene, int matte, struct satin_film *film) {
    char *manifest = make_manifest(scene, matte);
    const struct film_attribute attribute[] = {{"name", (char *)layer_names[matte]},
                                               {"hash", "MurmurHash3_32"},
                                               {"conversion", "uint32_to_float32"},
                                               {"manifest", manifest}};
    bool ok = manifest != NULL;
    for (int i = 0; i < 4 && ok; i++) {
        char key[64];
        // By the specification, the first seven digits of the hash of the layer's name.
        snprintf(key, sizeof key, "cryptomatte/%07x/%s",
                 (unsigned)(murmur3(layer_names[matte]) >> 4), attribute[i].name);
        ok = film_attribute_set(film, key, attribute[i].value);
    }
    free(manifest);
    return ok;
}

bool render_cryptomatte_describe(const struct satin_scene *scene, const satin_options *options,
                                 struct satin_film *film) {
    for (int k = 0; k < CRYPTOMATTES; k++)
        if (is_matte_wanted(options, k) && !describe_matte(scene, k, film)) return false;
    return true;
}
