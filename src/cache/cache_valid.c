// SPDX-License-Identifier: Apache-2.0
// Checks that the values of a record are finite and in range when it is made or read from a file. A
// new record that fails is refused and counted, and its site is gathered again (fill_batch.c). A
// file with a record that fails is refused as a whole (cache_file_read.c).
#include "cache/cache_records.h"

bool cache_valid_numbers(const float *value, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!isfinite(value[i])) return false;
    return true;
}

static bool is_unit(vec3 v) { return fabsf(v3_len2(v) - 1.0f) < 1e-3f; }

bool cache_valid_frame(const struct frame *f) {
    return is_unit(f->u) && is_unit(f->v) && is_unit(f->n) && fabsf(v3_dot(f->u, f->v)) < 1e-3f &&
           fabsf(v3_dot(f->u, f->n)) < 1e-3f && fabsf(v3_dot(f->v, f->n)) < 1e-3f;
}

bool cache_valid_head(const struct cache_head *h) {
    return v3_finite(h->p) && is_unit(h->n) && is_unit(h->u) && v3_finite(h->anisotropy) &&
           h->R >= 0.0f && isfinite(h->R) && h->search_radius >= 0.0f &&
           isfinite(h->search_radius) && h->scale >= 0.0f && h->scale <= 1.0f && h->clear >= 0.0f;
}
