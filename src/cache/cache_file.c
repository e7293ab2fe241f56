// SPDX-License-Identifier: Apache-2.0
// Writes records to a file and reads them into a cache. They are inserted in the order in which
// they were made, with their search radii, so that the tree, and the result of every lookup, is
// that of the saved cache.
#include "cache/cache_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/fileio.h"

// ---- Rows of words ------------------------------------------------------------------------------

static float *put3(float *out, float a, float b, float c) {
    out[0] = a;
    out[1] = b;
    out[2] = c;
    return out + 3;
}

static float *put_vec3(float *out, vec3 v) { return put3(out, v.x, v.y, v.z); }

static void put_irradiance(const struct cache *cache, size_t i, float *out) {
    const struct cache_irradiance_record *record = &cache->store[CACHE_IRRADIANCE].irradiance[i];
    const struct cache_irradiance_value *v = &record->value;
    out = put3(out, v->E.r, v->E.g, v->E.b);
    for (int c = 0; c < 3; c++) out = put_vec3(out, v->grad_t[c]);
    for (int c = 0; c < 3; c++) out = put_vec3(out, v->grad_r[c]);
    *out++ = record->deviation;
    *out++ = record->gradient_deviation;
    *out++ = record->radius_ratio;
    memcpy(out, &v->rays, sizeof v->rays);
}

static bool get_irradiance(struct cache *cache, const struct cache_head *head, const float *in) {
    struct cache_irradiance_record r = {
        .deviation = in[21], .gradient_deviation = in[22], .radius_ratio = in[23]};
    r.value.E = rgb_make(in[0], in[1], in[2]);
    for (int c = 0; c < 3; c++) {
        r.value.grad_t[c] = v3(in[3 + 3 * c], in[4 + 3 * c], in[5 + 3 * c]);
        r.value.grad_r[c] = v3(in[12 + 3 * c], in[13 + 3 * c], in[14 + 3 * c]);
    }
    memcpy(&r.value.rays, &in[24], sizeof r.value.rays);
    return cache_insert_irradiance(cache, head, &r);
}

// In memory a gradient has four lanes per coefficient, of which the file has the three colours.
static void put_radiance(const struct cache *cache, size_t i, float *out) {
    const struct cache_radiance_record *record = &cache->store[CACHE_RADIANCE].radiance[i];
    const int order = cache->store[CACHE_RADIANCE].order;
    out = put_vec3(put_vec3(put_vec3(out, record->frame.u), record->frame.v), record->frame.n);
    *out++ = record->radius_ratio;
    const struct cache_residual *residual = &record->residual;
    out = put_vec3(out, residual->mirror);
    out = put3(out, residual->L.r, residual->L.g, residual->L.b);
    memcpy(out++, &record->rays, sizeof record->rays);
    memcpy(out++, &residual->lobe_number, sizeof residual->lobe_number);
    const float *value = record->value;
    for (int k = 0; k < order * order; k++, value += CACHE_LANES, out += COEFFICIENT_WORDS) {
        memcpy(out, value, 4 * sizeof *out);
        memcpy(out + 4, value + 4, 3 * sizeof *out);
        memcpy(out + 7, value + 8, 3 * sizeof *out);
    }
}

static bool get_radiance(struct cache *cache, const struct cache_head *head, const float *in) {
    const int n2 = cache->store[CACHE_RADIANCE].order * cache->store[CACHE_RADIANCE].order;
    float *value = cache_value_new(cache);
    struct cache_radiance_record r = {.value = value, .radius_ratio = in[9]};
    r.frame =
        (struct frame){v3(in[0], in[1], in[2]), v3(in[3], in[4], in[5]), v3(in[6], in[7], in[8])};
    r.residual.mirror = v3(in[10], in[11], in[12]);
    r.residual.L = rgb_make(in[13], in[14], in[15]);
    memcpy(&r.rays, &in[16], sizeof r.rays);
    memcpy(&r.residual.lobe_number, &in[17], sizeof r.residual.lobe_number);
    if (!value) return false;
    in += RADIANCE_WORDS;
    for (int k = 0; k < n2; k++, value += CACHE_LANES, in += COEFFICIENT_WORDS) {
        memcpy(value, in, 4 * sizeof *in);
        memcpy(value + 4, in + 4, 3 * sizeof *in);
        memcpy(value + 8, in + 7, 3 * sizeof *in);
    }
    return cache_insert_radiance(cache, head, &r);
}

// Converts a record to the words of a row, and inserts the record of a row with its head. False if
// there is no memory.
static const struct row_functions {
    void (*put)(const struct cache *cache, size_t i, float *out);
    bool (*get)(struct cache *cache, const struct cache_head *head, const float *in);
} row_of[CACHE_KINDS] = {
    [CACHE_IRRADIANCE] = {put_irradiance, get_irradiance},
    [CACHE_RADIANCE] = {put_radiance, get_radiance},
};

// ---- Writing ------------------------------------------------------------------------------------

// Writes the two sections of a kind of records, which begin at `heads` and `values`.
static void put_records(const struct cache *c, enum cache_kind kind, unsigned char *heads,
                        unsigned char *values) {
    const struct cache_tree *tree = &c->store[kind].tree;
    const size_t row = cache_file_row(cache_file_values(kind), (uint32_t)c->store[kind].order);
    if (tree->head_count) memcpy(heads, tree->head, tree->head_count * sizeof *tree->head);
    for (size_t i = 0; i < tree->head_count; i++)
        row_of[kind].put(c, i, (float *)(values + i * row));
}

satin_status cache_save(const struct cache *cache, const struct cache_provenance *provenance,
                        const char *path, struct log log) {
    const uint32_t order = (uint32_t)cache->store[CACHE_RADIANCE].order;
    struct cache_file_header h = {.version = CACHE_FILE_VERSION,
                                  .sections = SECTIONS,
                                  .world = provenance->world,
                                  .image = provenance->image,
                                  .rays = cache->rays,
                                  .order = order};
    memcpy(h.magic, CACHE_FILE_MAGIC, sizeof h.magic);
    h.section[SECTION_OPTIONS].size = strlen(provenance->options);
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
        for (int s = cache_file_heads(k); s <= (int)cache_file_values(k); s++)
            h.section[s].size =
                cache_count(cache, k) * cache_file_row((enum cache_section)s, order);
    size_t at[SECTIONS], size = sizeof h;
    for (int i = 0; i < SECTIONS; i++) {
        at[i] = size;
        size += cache_file_padded(h.section[i].size);
    }
    unsigned char *data = array_new(size, 1);
    if (!data) return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", path);
    memcpy(data + at[SECTION_OPTIONS], provenance->options, h.section[SECTION_OPTIONS].size);
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
        put_records(cache, k, data + at[cache_file_heads(k)], data + at[cache_file_values(k)]);
    for (int i = 0; i < SECTIONS; i++)
        h.section[i].checksum = fileio_hash_large(FILEIO_HASH, data + at[i], h.section[i].size);
    h.checksum = fileio_hash(FILEIO_HASH, &h, offsetof(struct cache_file_header, checksum));
    memcpy(data, &h, sizeof h);
    satin_status status = fileio_write(log, path, data, size);
    free(data);
    return status;
}

// ---- Loading ------------------------------------------------------------------------------------

// Whether the tree can hold a head. It cannot if that is far from all surfaces.
static bool tree_has(const struct cache_tree *tree, const struct cache_head *head) {
    const vec3 d = v3_sub(head->p, tree->lo);
    const float most = tree->size * (float)(1 << 24);  // cells are numbered by int
    return fminf(fminf(d.x, d.y), d.z) >= 0.0f && v3_max_abs(d) <= tree->size &&
           head->search_radius <= most;
}

static satin_status read_records(struct cache *c, enum cache_kind kind,
                                 const struct cache_file *f) {
    const enum cache_section heads = cache_file_heads(kind), values = cache_file_values(kind);
    const size_t bytes = cache_file_row(values, f->header.order);
    float row[RADIANCE_WORDS + COEFFICIENT_WORDS * RSH_MAX_COEFFICIENTS];
    for (size_t i = 0; i < f->rows[values]; i++) {
        struct cache_head head;
        memcpy(&head, f->section[heads] + i * sizeof head, sizeof head);
        memcpy(row, f->section[values] + i * bytes, bytes);
        if (!tree_has(&c->store[kind].tree, &head)) return SATIN_ERROR_INPUT;
        if (!row_of[kind].get(c, &head, row)) return SATIN_ERROR_MEMORY;
    }
    return SATIN_OK;
}

satin_status cache_load(struct cache *cache, const struct cache_file *file, const char *name,
                        struct log log) {
    if (file->rows[SECTION_RADIANCE] &&
        (int)file->header.order != cache->store[CACHE_RADIANCE].order)
        return log_fail(log, SATIN_ERROR_INPUT, "%s: the radiance records are of order %u, not %d",
                        name, file->header.order, cache->store[CACHE_RADIANCE].order);
    satin_status status = SATIN_OK;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS && status == SATIN_OK; k++)
        status = read_records(cache, k, file);
    if (status == SATIN_ERROR_INPUT)
        return log_fail(log, status, "%s: a cache record lies far outside the scene", name);
    if (status == SATIN_OK) cache->rays = file->header.rays;
    return status;
}
