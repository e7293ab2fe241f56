// SPDX-License-Identifier: Apache-2.0
// Checks that the values of a record are finite and in range when it is made or read from a file. A
// record that fails is refused and counted, and its site is gathered again (cache_fill.c).
#include "cache/cache_records.h"

bool cache_valid_numbers(const float *value, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!isfinite(value[i])) return false;
    return true;
}

// Distances may be infinite, where nothing was hit.
static bool valid_around(const struct gather_around *around) {
    if (!(around->harmonic > 0.0f) || !(around->least > 0.0f) || !(around->least_upright > 0.0f))
        return false;
    for (int s = 0; s < GATHER_SECTORS; s++)
        if (!(around->sector[s] >= 0.0f)) return false;
    return around->deviation >= 0.0f && isfinite(around->deviation) &&
           cache_valid_numbers(around->hessian, 3);
}

bool cache_valid_irradiance(const struct gather_irradiance *value,
                            const struct gather_around *around) {
    if (!rgb_finite(value->E) || !(fminf(value->E.r, fminf(value->E.g, value->E.b)) >= 0.0f))
        return false;
    for (int c = 0; c < 3; c++)
        if (!v3_finite(value->grad_t[c]) || !v3_finite(value->grad_r[c])) return false;
    return valid_around(around);
}

bool cache_valid_radiance(const struct gather_radiance *value, int order,
                          const struct gather_around *around) {
    const size_t n2 = (size_t)(order * order);
    return cache_valid_numbers(value->lambda, 3 * n2) && cache_valid_numbers(value->dx, 3 * n2) &&
           cache_valid_numbers(value->dy, 3 * n2) && cache_valid_numbers(value->noise, n2) &&
           valid_around(around);
}

static bool is_unit(vec3 v) { return fabsf(v3_len2(v) - 1.0f) < 1e-3f; }

bool cache_valid_head(const struct cache_head *h) {
    return v3_finite(h->p) && is_unit(h->n) && is_unit(h->u) && v3_finite(h->anisotropy) &&
           h->R >= 0.0f && isfinite(h->R) && h->search_radius >= 0.0f &&
           isfinite(h->search_radius) && h->scale >= 0.0f && h->scale <= 1.0f && h->clear >= 0.0f;
}
