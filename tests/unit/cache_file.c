// SPDX-License-Identifier: Apache-2.0
// Files of records: the records that are loaded equal those that were saved, bit by bit, and give
// the same results; files that are cut, changed in any byte, of other sizes than they say, or of
// another provenance are refused in one line.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/fileio.h"
#include "base/rng.h"
#include "cache/cache_file.h"
#include "folder_case.h"
#include "message_case.h"

enum { ORDER = 3, RECORDS = 20, LOOKUPS = 200 };

static const struct cache_provenance provenance = {0x1234567890abcdef, 77,
                                                   "photons=9 irradiance-a=0.2"};

struct cache_file_fixture {
    satin_options options;
    struct cache cache;
};

static void cache_file_start(struct cache_file_fixture *f) {
    f->options = satin_options_default;
    f->options.leak_test = false;
    f->cache = (struct cache){
        .options = &f->options,
        .store = {{.filled = true, .record_bytes = sizeof(struct cache_irradiance_record)},
                  {.filled = true,
                   .order = ORDER,
                   .record_bytes = sizeof(struct cache_radiance_record)}}};
    cache_tree_init(&f->cache.store[CACHE_IRRADIANCE].tree, v3(-1, -1, -1), v3(1, 1, 1));
    cache_tree_init(&f->cache.store[CACHE_RADIANCE].tree, v3(-1, -1, -1), v3(1, 1, 1));
}

static void cache_file_stop(struct cache_file_fixture *f) {
    cache_tree_free(&f->cache.store[CACHE_IRRADIANCE].tree);
    cache_tree_free(&f->cache.store[CACHE_RADIANCE].tree);
    free(f->cache.store[CACHE_IRRADIANCE].record);
    free(f->cache.store[CACHE_RADIANCE].record);
    arena_free(&f->cache.radiance_arena);
}

static vec3 cache_file_draw(struct rng *rng) {
    float x = rng_float(rng), y = rng_float(rng);
    return v3(2.0f * x - 1.0f, 2.0f * y - 1.0f, 0.0f);
}

static struct cache_head head(struct rng *rng) {
    struct frame frame = frame_from_normal(v3(0, 0, 1));
    struct cache_head head = {.p = cache_file_draw(rng),
                              .R = 0.2f + rng_float(rng),
                              .n = frame.n,
                              .search_radius = 0.6f,
                              .anisotropy = cache_file_draw(rng),
                              .scale = 0.5f + 0.5f * rng_float(rng),
                              .u = frame.u};
    for (int s = 0; s < CACHE_SECTORS; s++) head.sector[s] = (uint8_t)rng_u32(rng);
    return head;
}

// A cache of records that hold any numbers.
static void cache_file_make(struct cache_file_fixture *f) {
    cache_file_start(f);
    struct cache *c = &f->cache;
    struct rng rng = rng_make(1, RNG_SITE, 0);
    c->rays = 1234;
    struct cache_store *irradiance = &c->store[CACHE_IRRADIANCE],
                       *radiance = &c->store[CACHE_RADIANCE];
    irradiance->irradiance = calloc(RECORDS, sizeof *irradiance->irradiance);
    radiance->radiance = calloc(RECORDS, sizeof *radiance->radiance);
    irradiance->capacity = radiance->capacity = RECORDS;
    for (uint32_t i = 0; i < RECORDS; i++) {
        struct cache_irradiance_record *e = &irradiance->irradiance[i];
        e->value.E = rgb_make(rng_float(&rng), rng_float(&rng), rng_float(&rng));
        for (int k = 0; k < 3; k++) e->value.grad_t[k] = cache_file_draw(&rng);
        for (int k = 0; k < 3; k++) e->value.grad_r[k] = cache_file_draw(&rng);
        e->value.rays = 100 + i;
        e->deviation = rng_float(&rng);
        e->gradient_deviation = rng_float(&rng);
        e->radius_ratio = rng_float(&rng);
        struct cache_head h = head(&rng);
        assert_true(cache_tree_insert(&c->store[CACHE_IRRADIANCE].tree, &h));
        float *value = arena_array(&c->radiance_arena, CACHE_LANES * ORDER * ORDER, sizeof *value);
        for (int k = 0; k < CACHE_LANES * ORDER * ORDER; k++)
            if (k % 4 != 3 || k % CACHE_LANES == 3) value[k] = rng_float(&rng);
        radiance->radiance[i] = (struct cache_radiance_record){
            .frame = frame_from_normal(v3(0, 0, 1)),
            .value = value,
            .radius_ratio = rng_float(&rng),
            .rays = 1000 + i,
            .residual = {i, cache_file_draw(&rng),
                         rgb_make(rng_float(&rng), -rng_float(&rng), 0.0f)}};
        h = head(&rng);
        assert_true(cache_tree_insert(&c->store[CACHE_RADIANCE].tree, &h));
    }
}

// Returns the bytes of a saved file, from malloc.
static unsigned char *cache_file_save(const struct cache_file_fixture *f, size_t *size) {
    char *data = NULL;
    assert_int_equal(cache_save(&f->cache, &provenance, "c.cache", (struct log){0}), SATIN_OK);
    assert_int_equal(
        fileio_read((struct log){0}, (struct log_place){0}, "c.cache", 1 << 20, &data, size),
        SATIN_OK);
    unlink("c.cache");
    return (unsigned char *)data;
}

// The one line with which a file is refused.
static const char *cache_file_refusal(const void *data, size_t size) {
    static struct message seen;
    struct cache_file *file = NULL;
    seen = (struct message){0};
    assert_int_equal(cache_file_parse(data, size, "f", (struct log){keep, &seen}, &file),
                     SATIN_ERROR_INPUT);
    assert_null(file);
    assert_int_equal(seen.count, 1);
    return seen.text;
}

static void loading_returns_what_was_saved(void **state) {
    (void)state;
    struct cache_file_fixture a, b;
    size_t size, again_size;
    cache_file_make(&a);
    cache_file_start(&b);
    unsigned char *data = cache_file_save(&a, &size);
    struct cache_file *file = NULL;
    assert_int_equal(cache_file_parse(data, size, "f", (struct log){0}, &file), SATIN_OK);
    struct cache_summary summary = cache_file_summary(file);
    assert_int_equal(summary.irradiance, RECORDS);
    assert_int_equal(summary.radiance, RECORDS);
    assert_true(summary.order == ORDER && summary.rays == 1234 && summary.provenance.image == 77);
    assert_string_equal(summary.provenance.options, provenance.options);
    assert_int_equal(cache_file_check(file, &provenance, "f", (struct log){0}), SATIN_OK);
    assert_int_equal(cache_load(&b.cache, file, "f", (struct log){0}), SATIN_OK);
    cache_file_free(file);
    unsigned char *again = cache_file_save(&b, &again_size);
    assert_int_equal(again_size, size);
    assert_memory_equal(again, data, size);
    // The trees are the same, node by node, so that sums are taken in the same order.
    assert_int_equal(a.cache.store[CACHE_RADIANCE].tree.ref_count,
                     b.cache.store[CACHE_RADIANCE].tree.ref_count);
    assert_memory_equal(a.cache.store[CACHE_RADIANCE].tree.ref,
                        b.cache.store[CACHE_RADIANCE].tree.ref,
                        a.cache.store[CACHE_RADIANCE].tree.ref_count *
                            sizeof *a.cache.store[CACHE_RADIANCE].tree.ref);
    assert_int_equal(a.cache.store[CACHE_IRRADIANCE].tree.node_count,
                     b.cache.store[CACHE_IRRADIANCE].tree.node_count);
    struct rng rng = rng_make(2, RNG_SITE, 0);
    for (int i = 0; i < LOOKUPS; i++) {
        struct cache_lookup at = {cache_file_draw(&rng), v3(0, 0, 1),
                                  frame_from_normal(v3(0, 0, 1)), 0.0f};
        rgb x = rgb_grey(-1.0f), y = x;
        assert_int_equal(cache_irradiance(&a.cache, &at, 0.5f, &x).count,
                         cache_irradiance(&b.cache, &at, 0.5f, &y).count);
        assert_memory_equal(&x, &y, sizeof x);
    }
    free(data);
    free(again);
    cache_file_stop(&a);
    cache_file_stop(&b);
}

static void damaged_files_are_refused(void **state) {
    (void)state;
    struct cache_file_fixture f;
    size_t size;
    cache_file_make(&f);
    unsigned char *data = cache_file_save(&f, &size);
    for (size_t i = 0; i < size; i += i < 200 ? 1 : 97)
        assert_non_null(cache_file_refusal(data, i));
    const size_t options = sizeof(struct cache_file_header) + strlen(provenance.options);
    for (size_t i = 0; i < size; i += 1 + i / 200) {
        const bool filling = i >= options && i < cache_file_padded(options);
        if (filling) continue;
        data[i] ^= 0x10;
        assert_non_null(cache_file_refusal(data, size));
        data[i] ^= 0x10;
    }
    assert_non_null(strstr(cache_file_refusal("P6 1 1", 6), "it is not a file of cache records"));
    free(data);
    cache_file_stop(&f);
}

// Now the checksums are right.
static const char *refusal_of_header(const unsigned char *data, size_t size,
                                     struct cache_file_header h) {
    unsigned char *copy = malloc(size);
    h.checksum = fileio_hash(FILEIO_HASH, &h, offsetof(struct cache_file_header, checksum));
    memcpy(copy, data, size);
    memcpy(copy, &h, sizeof h);
    const char *text = cache_file_refusal(copy, size);
    free(copy);
    return text;
}

static void wrong_sizes_and_counts_are_refused(void **state) {
    (void)state;
    struct cache_file_fixture f;
    size_t size;
    cache_file_make(&f);
    unsigned char *data = cache_file_save(&f, &size);
    struct cache_file_header right, h;
    memcpy(&right, data, sizeof right);
    h = right;
    h.version = 9;
    assert_non_null(strstr(refusal_of_header(data, size, h), "version 9"));
    h = right;
    h.order = 1000000;
    assert_non_null(refusal_of_header(data, size, h));
    for (int i = 0; i < SECTIONS; i++) {
        h = right;
        h.section[i].size = UINT64_MAX - 7;
        assert_non_null(strstr(refusal_of_header(data, size, h), "ends early"));
    }
    free(data);
    // These records are outside of everything, without a direction, and not finite.
    const size_t at[] = {0, 4, 3};
    const float wrong[] = {NAN, 5.0f, INFINITY};
    for (int i = 0; i < 3; i++) {
        float *word = (float *)&f.cache.store[CACHE_IRRADIANCE].tree.head[3] + at[i], kept = *word;
        *word = wrong[i];
        data = cache_file_save(&f, &size);
        assert_non_null(strstr(cache_file_refusal(data, size), "impossible position"));
        *word = kept;
        free(data);
    }
    cache_file_stop(&f);
}

// Checks that a file with `wrong` instead of *word is refused for its values.
static void refuse_value(struct cache_file_fixture *f, float *word, float wrong) {
    size_t size;
    const float kept = *word;
    *word = wrong;
    unsigned char *data = cache_file_save(f, &size);
    assert_non_null(strstr(cache_file_refusal(data, size), "impossible value"));
    *word = kept;
    free(data);
}

static void values_that_are_not_finite_are_refused(void **state) {
    (void)state;
    struct cache_file_fixture f;
    cache_file_make(&f);
    struct cache_irradiance_record *E = &f.cache.store[CACHE_IRRADIANCE].irradiance[4];
    refuse_value(&f, &E->value.E.g, NAN);
    refuse_value(&f, &E->value.E.b, -0.5f);
    refuse_value(&f, &E->value.grad_t[2].y, INFINITY);
    refuse_value(&f, &E->value.grad_r[1].x, NAN);
    refuse_value(&f, &E->deviation, -1.0f);
    refuse_value(&f, &E->gradient_deviation, -1.0f);
    refuse_value(&f, &E->radius_ratio, 1.5f);
    struct cache_radiance_record *Lambda = &f.cache.store[CACHE_RADIANCE].radiance[7];
    refuse_value(&f, &Lambda->radius_ratio, NAN);
    refuse_value(&f, &Lambda->frame.u.x, NAN);
    refuse_value(&f, &Lambda->frame.v.y, 1e20f);
    for (int i = 0; i < ORDER * ORDER * CACHE_LANES; i++)
        if (i % CACHE_LANES % 4 != 3 || i % CACHE_LANES == 3)
            refuse_value(&f, &Lambda->value[i], i % 2 ? NAN : INFINITY);
    cache_file_stop(&f);
}

static void records_of_other_provenance_are_refused(void **state) {
    (void)state;
    struct cache_file_fixture f, g;
    size_t size;
    cache_file_make(&f);
    cache_file_start(&g);
    f.cache.store[CACHE_IRRADIANCE].tree.head[3].p.x = 50.0f;
    unsigned char *data = cache_file_save(&f, &size);
    struct cache_file *file = NULL;
    struct message seen = {0};
    assert_int_equal(cache_file_parse(data, size, "f", (struct log){0}, &file), SATIN_OK);
    struct cache_provenance other = provenance;
    other.options = "photons=9 irradiance-a=0.3";
    assert_int_equal(cache_file_check(file, &other, "f", (struct log){keep, &seen}),
                     SATIN_ERROR_INPUT);
    assert_string_equal(seen.text,
                        "f: the cache records were made with irradiance-a=0.2, not with "
                        "irradiance-a=0.3");
    other = provenance;
    other.world++;
    assert_int_equal(cache_file_check(file, &other, "f", (struct log){keep, &seen}),
                     SATIN_ERROR_INPUT);
    other = provenance;
    other.image = 0;  // another image has the same provenance
    assert_int_equal(cache_file_check(file, &other, "f", (struct log){0}), SATIN_OK);
    assert_int_equal(cache_load(&g.cache, file, "f", (struct log){keep, &seen}), SATIN_ERROR_INPUT);
    assert_int_equal(seen.count, 3);
    cache_file_free(file);
    free(data);
    cache_file_stop(&f);
    cache_file_stop(&g);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loading_returns_what_was_saved),
        cmocka_unit_test(damaged_files_are_refused),
        cmocka_unit_test(wrong_sizes_and_counts_are_refused),
        cmocka_unit_test(values_that_are_not_finite_are_refused),
        cmocka_unit_test(records_of_other_provenance_are_refused),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
