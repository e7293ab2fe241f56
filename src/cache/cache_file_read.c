// SPDX-License-Identifier: Apache-2.0
// Reads a file of records. Sizes and checksums are verified first, and no allocation depends on an
// unverified number.
#include <stdlib.h>
#include <string.h>

#include "base/fileio.h"
#include "cache/cache_file.h"

static satin_status refuse_file(struct log log, const char *name, const char *why) {
    return log_fail(log, SATIN_ERROR_INPUT, "%s: %s", name, why);
}

static satin_status read_header(const unsigned char *data, size_t size, const char *name,
                                struct log log, struct cache_file_header *h) {
    const size_t magic = sizeof h->magic;
    if (size < magic || memcmp(data, CACHE_FILE_MAGIC, magic) != 0)
        return refuse_file(log, name, "it is not a file of cache records");
    if (size < sizeof *h) return refuse_file(log, name, "the file of cache records ends early");
    memcpy(h, data, sizeof *h);
    if (h->version != CACHE_FILE_VERSION)
        return log_fail(log, SATIN_ERROR_INPUT,
                        "%s: cache records of version %u, but this satin reads version %d", name,
                        h->version, CACHE_FILE_VERSION);
    if (h->sections != SECTIONS || h->order > RSH_MAX_ORDER ||
        fileio_hash(FILEIO_HASH, data, offsetof(struct cache_file_header, checksum)) != h->checksum)
        return refuse_file(log, name, "the header of the cache records is damaged");
    return SATIN_OK;
}

static satin_status find_sections(const unsigned char *data, size_t size, const char *name,
                                  struct log log, struct cache_file *f) {
    size_t at = sizeof f->header;
    for (int i = 0; i < SECTIONS; i++) {
        const struct cache_file_section *s = &f->header.section[i];
        if (at > size || s->size > size - at)
            return refuse_file(log, name, "the file of cache records ends early");
        f->section[i] = data + at;
        const size_t row = cache_file_row((enum cache_section)i, f->header.order);
        f->rows[i] = row ? s->size / row : 0;
        if ((row && s->size % row) ||
            fileio_hash_large(FILEIO_HASH, f->section[i], s->size) != s->checksum)
            return refuse_file(log, name, "the cache records are damaged");
        at += cache_file_padded(s->size);
    }
    if (at != size)
        return refuse_file(log, name, "the file of cache records has another size than it says");
    if (f->rows[SECTION_IRRADIANCE_HEADS] != f->rows[SECTION_IRRADIANCE] ||
        f->rows[SECTION_RADIANCE_HEADS] != f->rows[SECTION_RADIANCE] ||
        f->rows[SECTION_IRRADIANCE] > UINT32_MAX || f->rows[SECTION_RADIANCE] > UINT32_MAX ||
        (f->rows[SECTION_RADIANCE] && !f->header.order))
        return refuse_file(log, name, "the cache records do not fit together");
    return SATIN_OK;
}

static struct cache_head head_at(const struct cache_file *f, enum cache_section section, size_t i) {
    struct cache_head head;
    memcpy(&head, f->section[section] + i * sizeof head, sizeof head);
    return head;
}

static satin_status check_heads(const struct cache_file *f, const char *name, struct log log) {
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
        for (size_t i = 0; i < f->rows[cache_file_heads(k)]; i++) {
            const struct cache_head head = head_at(f, cache_file_heads(k), i);
            if (!cache_valid_head(&head))
                return refuse_file(log, name, "a cache record has an impossible position");
        }
    return SATIN_OK;
}

static bool is_irradiance(const float *row, uint32_t order) {
    (void)order;
    const float deviation = row[21], of_gradient = row[22], radius_ratio = row[23];
    return cache_valid_numbers(row, IRRADIANCE_WORDS - 1) &&
           fminf(row[0], fminf(row[1], row[2])) >= 0.0f && deviation >= 0.0f &&
           of_gradient >= 0.0f && radius_ratio >= 0.0f && radius_ratio <= 1.0f;
}

static bool is_radiance(const float *row, uint32_t order) {
    const float radius_ratio = row[9];
    const struct frame frame = {v3(row[0], row[1], row[2]), v3(row[3], row[4], row[5]),
                                v3(row[6], row[7], row[8])};
    return cache_valid_numbers(row, RADIANCE_WORDS - 2) && cache_valid_frame(&frame) &&
           radius_ratio >= 0.0f && radius_ratio <= 1.0f &&
           cache_valid_numbers(row + RADIANCE_WORDS, (size_t)COEFFICIENT_WORDS * order * order);
}

static bool (*const is_value[CACHE_KINDS])(const float *row, uint32_t order) = {
    [CACHE_IRRADIANCE] = is_irradiance,
    [CACHE_RADIANCE] = is_radiance,
};

static satin_status check_values(const struct cache_file *f, const char *name, struct log log) {
    float row[RADIANCE_WORDS + COEFFICIENT_WORDS * RSH_MAX_COEFFICIENTS];
    const uint32_t order = f->header.order;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) {
        const enum cache_section section = cache_file_values(k);
        const size_t size = cache_file_row(section, order);
        for (size_t i = 0; i < f->rows[section]; i++) {
            memcpy(row, f->section[section] + i * size, size);
            if (!is_value[k](row, order))
                return refuse_file(log, name, "a cache record has an impossible value");
        }
    }
    return SATIN_OK;
}

static satin_status keep_options(const char *name, struct log log, struct cache_file *f) {
    const size_t size = f->header.section[SECTION_OPTIONS].size;
    if (memchr(f->section[SECTION_OPTIONS], 0, size))
        return refuse_file(log, name, "the options of the cache records are no text");
    f->options = malloc(size + 1);
    if (!f->options) return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", name);
    memcpy(f->options, f->section[SECTION_OPTIONS], size);
    f->options[size] = 0;
    return SATIN_OK;
}

satin_status cache_file_parse(const void *data, size_t size, const char *name, struct log log,
                              struct cache_file **file) {
    struct cache_file *f = calloc(1, sizeof *f);
    if (!f) return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", name);
    satin_status status = read_header(data, size, name, log, &f->header);
    if (status == SATIN_OK) status = find_sections(data, size, name, log, f);
    if (status == SATIN_OK) status = check_heads(f, name, log);
    if (status == SATIN_OK) status = check_values(f, name, log);
    if (status == SATIN_OK) status = keep_options(name, log, f);
    if (status == SATIN_OK)
        *file = f;
    else
        cache_file_free(f);
    return status;
}

void cache_file_free(struct cache_file *file) {
    if (!file) return;
    free(file->options);
    free(file);
}

// The first word of `a` that differs from the word of `b` at the same position.
static const char *first_difference(const char *a, const char *b) {
    while (*a && *b) {
        const size_t n = strcspn(a, " "), m = strcspn(b, " ");
        if (n != m || memcmp(a, b, n) != 0) return a;
        a += n + (a[n] == ' ');
        b += m + (b[m] == ' ');
    }
    return a;
}

satin_status cache_file_check(const struct cache_file *file,
                              const struct cache_provenance *provenance, const char *name,
                              struct log log) {
    if (file->header.world != provenance->world)
        return refuse_file(log, name, "the cache records are of another scene");
    if (strcmp(file->options, provenance->options) == 0) return SATIN_OK;
    const char *theirs = first_difference(file->options, provenance->options);
    const char *ours = first_difference(provenance->options, file->options);
    return log_fail(log, SATIN_ERROR_INPUT,
                    "%s: the cache records were made with %.*s, not with %.*s", name,
                    (int)strcspn(theirs, " "), theirs, (int)strcspn(ours, " "), ours);
}

struct cache_summary cache_file_summary(const struct cache_file *f) {
    return (struct cache_summary){.provenance = {f->header.world, f->header.image, f->options},
                                  .rays = f->header.rays,
                                  .order = (int)f->header.order,
                                  .irradiance = f->rows[SECTION_IRRADIANCE],
                                  .radiance = f->rows[SECTION_RADIANCE]};
}

void cache_file_record(const struct cache_file *file, enum cache_kind kind, size_t i, float *R,
                       float *scale) {
    const struct cache_head head = head_at(file, cache_file_heads(kind), i);
    *R = head.R;
    *scale = head.scale;
}
