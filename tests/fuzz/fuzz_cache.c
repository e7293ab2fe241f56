// SPDX-License-Identifier: Apache-2.0
// Any bytes given to the reader of cache records: a file or one logged line, no crash. Records that
// it reads are added to a cache, and saved again they are the same bytes. The checksums of the
// input are corrected first, so that mutations get past them.
#include "cache/cache_file.h"

#include <stddef.h>

#include "base/fileio.h"
#include "fuzz_case.h"

enum { SIZE_TRIED = 1 << 16 };

static void repair(unsigned char *data, size_t size) {
    struct cache_file_header h;
    size_t at = sizeof h;
    memcpy(&h, data, sizeof h);
    for (int i = 0; i < SECTIONS; i++) {
        struct cache_file_section *s = &h.section[i];
        if (at > size || s->size > size - at) break;
        s->checksum = fileio_hash_large(FILEIO_HASH, data + at, s->size);
        at += cache_file_padded(s->size);
    }
    h.checksum = fileio_hash(FILEIO_HASH, &h, offsetof(struct cache_file_header, checksum));
    memcpy(data, &h, sizeof h);
}

// A cache in the box of (-1, -1, -1) and (1, 1, 1) takes the records or refuses them in one line.
static void fuzz_cache_load(const struct cache_file *file) {
    const satin_options options = satin_options_default;
    struct cache cache = {.options = &options,
                          .store = {{.record_bytes = sizeof(struct cache_irradiance_record)},
                                    {.record_bytes = sizeof(struct cache_radiance_record)}}};
    int lines = 0;
    cache.store[CACHE_RADIANCE].order = cache_file_summary(file).order;
    cache_tree_init(&cache.store[CACHE_IRRADIANCE].tree, v3(-1, -1, -1), v3(1, 1, 1));
    cache_tree_init(&cache.store[CACHE_RADIANCE].tree, v3(-1, -1, -1), v3(1, 1, 1));
    satin_status status = cache_load(&cache, file, "fuzz", (struct log){fuzz_count, &lines});
    FUZZ_REQUIRE(lines == (status != SATIN_OK));
    struct cache_near near[CACHE_NEAR_MAX];
    const vec3 p = v3(0.1f, 0.2f, 0.3f), n = v3(0, 0, 1);
    FUZZ_REQUIRE(cache_tree_find(&cache.store[CACHE_IRRADIANCE].tree, p, n, 0.2f, near) >= 0);
    FUZZ_REQUIRE(cache_tree_find(&cache.store[CACHE_RADIANCE].tree, p, n, 0.2f, near) >= 0);
    cache_tree_free(&cache.store[CACHE_IRRADIANCE].tree);
    cache_tree_free(&cache.store[CACHE_RADIANCE].tree);
    free(cache.store[CACHE_IRRADIANCE].record);
    free(cache.store[CACHE_RADIANCE].record);
    arena_free(&cache.radiance_arena);
}

static void fuzz_cache_parse(const void *data, size_t size) {
    struct cache_file *file = NULL;
    int lines = 0;
    satin_status status =
        cache_file_parse(data, size, "fuzz", (struct log){fuzz_count, &lines}, &file);
    FUZZ_REQUIRE((status == SATIN_OK) == (file != NULL) && lines == (status != SATIN_OK));
    if (file) fuzz_cache_load(file);
    cache_file_free(file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size > SIZE_TRIED) return 0;
    fuzz_cache_parse(data, size);
    unsigned char *copy = malloc(size + 1);
    if (!copy) abort();
    memcpy(copy, data, size);
    if (size >= sizeof(struct cache_file_header)) repair(copy, size);
    fuzz_cache_parse(copy, size);
    free(copy);
    return 0;
}
