// SPDX-License-Identifier: Apache-2.0
// The reflected light that a record's harmonics leave out. A series that is truncated at order n
// rings near bright surfaces, in every record alike: by 5 to 10 % around a ball that almost touches
// a wall of rough metal. The light that the BRDF at the record's own site reflects to the eye can
// be computed from the record's rays without harmonics. The difference, which has no noise except
// that of the rays, is stored and interpolated with the record.
#include "cache/cache_records.h"

// The correction of another lobe of the same BRDF decreases with the distance between the unit
// vectors of their directions, and is 0 from this distance on, which is .28 of a wavelength of the
// first band beyond order 14. With .06, .12 and .25 the error of cornell-metal at preview is 1.20,
// 1.18 and 1.19, and 1.27 without residuals (relMSE x 10^4, 200x200).
static const float WIDTH = 0.12f;

struct cache_residual cache_residual_make(const struct gather_radiance *radiance, int order,
                                          const struct frame *frame, const struct cache_view *view,
                                          rgb whole) {
    float C[3 * RSH_MAX_COEFFICIENTS], sum[3] = {0};
    struct cache_residual residual = {.name = 0};
    const int n = brdf_range_lookup(view->table, &view->brdf, view->wo, C);
    if (n == 0) return residual;
    for (int c = 0; c < 3; c++) {
        const float *lobe = C + (view->channels == 1 ? 0 : c * n * n);
        const float *lambda = radiance->lambda + c * order * order;
        for (int k = 0; k < n * n; k++) sum[c] += lobe[k] * lambda[k];
    }
    residual.name = view->name;
    residual.mirror = cache_mirror(frame, view->wo);
    residual.L = rgb_sub(whole, rgb_make(sum[0], sum[1], sum[2]));
    return residual;
}

rgb cache_residual_read(const struct cache_residual *residual, const struct cache_lobe *lobe) {
    if (!residual->name || residual->name != lobe->name) return rgb_grey(0.0f);
    const float away = sqrtf(v3_dist2(residual->mirror, lobe->mirror)) / WIDTH;
    return rgb_scale(residual->L, at_least(1.0f - away, 0.0f));
}
