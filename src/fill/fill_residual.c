// SPDX-License-Identifier: Apache-2.0
// The reflected light that a record's harmonics leave out. A series that is truncated at order n
// rings near bright surfaces, in every record alike: by 5 to 10 % around a ball that almost touches
// a wall of rough metal. The light that the BRDF at the record's own site reflects to the eye can
// be computed from the record's rays without harmonics. The difference, which has no noise except
// that of the rays, is stored and interpolated with the record (cache_residual.c).
#include "fill/fill_record.h"

struct cache_residual fill_residual(const struct gather_radiance *radiance, int order,
                                    const struct frame *frame, const struct fill_glossy *glossy,
                                    rgb whole) {
    float C[3 * RSH_MAX_COEFFICIENTS], sum[3] = {0};
    struct cache_residual residual = {.lobe_number = 0};
    const int n = brdf_range_lookup(glossy->table, &glossy->brdf, glossy->wo, C);
    if (n == 0) return residual;
    for (int c = 0; c < 3; c++) {
        const float *lobe = C + (glossy->channels == 1 ? 0 : c * n * n);
        const float *lambda = radiance->lambda + c * order * order;
        for (int k = 0; k < n * n; k++) sum[c] += lobe[k] * lambda[k];
    }
    residual.lobe_number = glossy->lobe_number;
    residual.mirror = cache_mirror(frame, glossy->wo);
    residual.L = rgb_sub(whole, rgb_make(sum[0], sum[1], sum[2]));
    return residual;
}
