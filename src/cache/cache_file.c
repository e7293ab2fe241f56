// SPDX-License-Identifier: Apache-2.0
// Records to a file and from it into a cache. They are inserted in the order in which they were
// made and with their influence radii, so that the tree, and what it answers, is that which was
// saved.
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

static void put_irradiance(const struct cache_irradiance_record *record, float *out) {
    const struct gather_irradiance *v = &record->value;
    out = put3(out, v->E.r, v->E.g, v->E.b);
    for (int c = 0; c < 3; c++) out = put_vec3(out, v->grad_t[c]);
    for (int c = 0; c < 3; c++) out = put_vec3(out, v->grad_r[c]);
    *out++ = record->deviation;
    *out++ = record->room;
    memcpy(out, &v->rays, sizeof v->rays);
}

static struct cache_irradiance_record get_irradiance(const float *in) {
    struct cache_irradiance_record r = {.deviation = in[21], .room = in[22]};
    r.value.E = rgb_make(in[0], in[1], in[2]);
    for (int c = 0; c < 3; c++) {
        r.value.grad_t[c] = v3(in[3 + 3 * c], in[4 + 3 * c], in[5 + 3 * c]);
        r.value.grad_r[c] = v3(in[12 + 3 * c], in[13 + 3 * c], in[14 + 3 * c]);
    }
    memcpy(&r.value.rays, &in[23], sizeof r.value.rays);
    return r;
}

// In memory the gradients have four lanes too, of which a file holds the three of their colours.
static void put_radiance(const struct cache_radiance_record *record, int n2, float *out) {
    out = put_vec3(put_vec3(put_vec3(out, record->frame.u), record->frame.v), record->frame.n);
    *out++ = record->room;
    const struct cache_residual *residual = &record->residual;
    out = put_vec3(out, residual->mirror);
    out = put3(out, residual->L.r, residual->L.g, residual->L.b);
    memcpy(out++, &record->rays, sizeof record->rays);
    memcpy(out++, &residual->name, sizeof residual->name);
    const float *value = record->value;
    for (int k = 0; k < n2; k++, value += CACHE_LANES, out += COEFFICIENT_WORDS) {
        memcpy(out, value, 4 * sizeof *out);
        memcpy(out + 4, value + 4, 3 * sizeof *out);
        memcpy(out + 7, value + 8, 3 * sizeof *out);
    }
}

static struct cache_radiance_record get_radiance(const float *in, int n2, float *value) {
    struct cache_radiance_record r = {.value = value, .room = in[9]};
    r.frame =
        (struct frame){v3(in[0], in[1], in[2]), v3(in[3], in[4], in[5]), v3(in[6], in[7], in[8])};
    r.residual.mirror = v3(in[10], in[11], in[12]);
    r.residual.L = rgb_make(in[13], in[14], in[15]);
    memcpy(&r.rays, &in[16], sizeof r.rays);
    memcpy(&r.residual.name, &in[17], sizeof r.residual.name);
    in += RADIANCE_WORDS;
    for (int k = 0; k < n2; k++, value += CACHE_LANES, in += COEFFICIENT_WORDS) {
        memcpy(value, in, 4 * sizeof *in);
        memcpy(value + 4, in + 4, 3 * sizeof *in);
        memcpy(value + 8, in + 7, 3 * sizeof *in);
    }
    return r;
}

// ---- Writing ------------------------------------------------------------------------------------

static void put_section(const struct cache *c, const struct cache_origin *origin,
                        enum cache_section section, unsigned char *out) {
    const size_t row = cache_file_row(section, (uint32_t)c->order);
    const size_t irradiance = c->side[CACHE_IRRADIANCE].tree.head_count,
                 radiance = c->side[CACHE_RADIANCE].tree.head_count;
    switch (section) {
        case SECTION_OPTIONS:
            memcpy(out, origin->options, strlen(origin->options));
            break;
        case SECTION_IRRADIANCE_HEADS:
            if (irradiance) memcpy(out, c->side[CACHE_IRRADIANCE].tree.head, irradiance * row);
            break;
        case SECTION_RADIANCE_HEADS:
            if (radiance) memcpy(out, c->side[CACHE_RADIANCE].tree.head, radiance * row);
            break;
        case SECTION_IRRADIANCE:
            for (size_t i = 0; i < irradiance; i++)
                put_irradiance(&c->irradiance[i], (float *)(out + i * row));
            break;
        case SECTION_RADIANCE:
            for (size_t i = 0; i < radiance; i++)
                put_radiance(&c->radiance[i], c->order * c->order, (float *)(out + i * row));
            break;
        default:
            break;
    }
}

satin_status cache_save(const struct cache *cache, const struct cache_origin *origin,
                        const char *path, struct log log) {
    const size_t irradiance = cache->side[CACHE_IRRADIANCE].tree.head_count;
    const size_t radiance = cache->side[CACHE_RADIANCE].tree.head_count;
    const size_t rows[SECTIONS] = {0, irradiance, irradiance, radiance, radiance};
    struct cache_file_header h = {.version = CACHE_FILE_VERSION,
                                  .sections = SECTIONS,
                                  .world = origin->world,
                                  .view = origin->view,
                                  .rays = cache->rays,
                                  .order = (uint32_t)cache->order};
    memcpy(h.magic, CACHE_FILE_MAGIC, sizeof h.magic);
    size_t size = sizeof h;
    for (int i = 0; i < SECTIONS; i++) {
        h.section[i].size = i == SECTION_OPTIONS
                                ? strlen(origin->options)
                                : rows[i] * cache_file_row((enum cache_section)i, h.order);
        size += cache_file_padded(h.section[i].size);
    }
    unsigned char *data = array_new(size, 1);
    if (!data) return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", path);
    size_t at = sizeof h;
    for (int i = 0; i < SECTIONS; i++) {
        put_section(cache, origin, (enum cache_section)i, data + at);
        h.section[i].checksum = fileio_hash_large(FILEIO_HASH, data + at, h.section[i].size);
        at += cache_file_padded(h.section[i].size);
    }
    h.checksum = fileio_hash(FILEIO_HASH, &h, offsetof(struct cache_file_header, checksum));
    memcpy(data, &h, sizeof h);
    satin_status status = fileio_write(log, path, data, size);
    free(data);
    return status;
}

// ---- Loading ------------------------------------------------------------------------------------

// Puts the next head into the tree. SATIN_ERROR_INPUT for one that the tree cannot hold, as it lies
// far from all surfaces.
static satin_status load_head(struct cache_tree *tree, const unsigned char *row) {
    struct cache_head head;
    memcpy(&head, row, sizeof head);
    const vec3 d = v3_sub(head.p, tree->lo);
    const float most = tree->size * (float)(1 << 24);  // cells are numbered by int
    if (!(fminf(fminf(d.x, d.y), d.z) >= 0.0f) || !(v3_max_abs(d) <= tree->size) ||
        !(head.influence <= most))
        return SATIN_ERROR_INPUT;
    return cache_tree_insert(tree, &head) ? SATIN_OK : SATIN_ERROR_MEMORY;
}

static satin_status load_irradiance(struct cache *c, const struct cache_file *f) {
    const size_t count = f->rows[SECTION_IRRADIANCE];
    float row[IRRADIANCE_WORDS];
    if (!array_reserve((void **)&c->irradiance, &c->irradiance_capacity, count,
                       sizeof *c->irradiance))
        return SATIN_ERROR_MEMORY;
    satin_status status = SATIN_OK;
    for (size_t i = 0; i < count && status == SATIN_OK; i++) {
        memcpy(row, f->section[SECTION_IRRADIANCE] + i * sizeof row, sizeof row);
        c->irradiance[i] = get_irradiance(row);
        status = load_head(&c->side[CACHE_IRRADIANCE].tree,
                           f->section[SECTION_IRRADIANCE_HEADS] + i * sizeof(struct cache_head));
    }
    return status;
}

static satin_status load_radiance(struct cache *c, const struct cache_file *f) {
    const size_t count = f->rows[SECTION_RADIANCE];
    const size_t bytes = cache_file_row(SECTION_RADIANCE, f->header.order);
    const int n2 = c->order * c->order;
    float row[RADIANCE_WORDS + COEFFICIENT_WORDS * RSH_MAX_COEFFICIENTS];
    if (!array_reserve((void **)&c->radiance, &c->radiance_capacity, count, sizeof *c->radiance))
        return SATIN_ERROR_MEMORY;
    satin_status status = SATIN_OK;
    for (size_t i = 0; i < count && status == SATIN_OK; i++) {
        float *value = arena_array(&c->radiance_arena, (size_t)(n2 * CACHE_LANES), sizeof *value);
        if (!value) return SATIN_ERROR_MEMORY;
        memcpy(row, f->section[SECTION_RADIANCE] + i * bytes, bytes);
        c->radiance[i] = get_radiance(row, n2, value);
        status = load_head(&c->side[CACHE_RADIANCE].tree,
                           f->section[SECTION_RADIANCE_HEADS] + i * sizeof(struct cache_head));
    }
    return status;
}

satin_status cache_load(struct cache *cache, const struct cache_file *file, const char *name,
                        struct log log) {
    if (file->rows[SECTION_RADIANCE] && (int)file->header.order != cache->order)
        return log_fail(log, SATIN_ERROR_INPUT, "%s: the radiance records are of order %u, not %d",
                        name, file->header.order, cache->order);
    satin_status status = load_irradiance(cache, file);
    if (status == SATIN_OK) status = load_radiance(cache, file);
    if (status == SATIN_ERROR_INPUT)
        return log_fail(log, status, "%s: a cache record lies far outside the scene", name);
    if (status == SATIN_OK) cache->rays = file->header.rays;
    return status;
}
