// SPDX-License-Identifier: Apache-2.0
// Checks that the values of a new record are finite and in range. A record that fails is refused
// and counted, and its site is gathered again (fill_batch.c).
#include "fill/fill_record.h"

// Distances may be infinite, where nothing was hit.
static bool valid_around(const struct gather_surroundings *around) {
    if (!(around->harmonic > 0.0f) || !(around->least > 0.0f) || !(around->least_upright > 0.0f))
        return false;
    for (int s = 0; s < CACHE_SECTORS; s++)
        if (!(around->sector[s] >= 0.0f)) return false;
    return around->deviation >= 0.0f && isfinite(around->deviation) &&
           around->gradient_deviation >= 0.0f && isfinite(around->gradient_deviation) &&
           cache_valid_numbers(around->hessian, 3);
}

bool fill_valid_irradiance(const struct cache_irradiance_value *value,
                           const struct gather_surroundings *around) {
    if (!rgb_finite(value->E) || !(fminf(value->E.r, fminf(value->E.g, value->E.b)) >= 0.0f))
        return false;
    for (int c = 0; c < 3; c++)
        if (!v3_finite(value->grad_t[c]) || !v3_finite(value->grad_r[c])) return false;
    return valid_around(around);
}

bool fill_valid_radiance(const struct gather_radiance *value, int order,
                         const struct gather_surroundings *around) {
    const size_t n2 = (size_t)(order * order);
    return cache_valid_numbers(value->lambda, 3 * n2) && cache_valid_numbers(value->dx, 3 * n2) &&
           cache_valid_numbers(value->dy, 3 * n2) && cache_valid_numbers(value->noise, n2) &&
           valid_around(around);
}
