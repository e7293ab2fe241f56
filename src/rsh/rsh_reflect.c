// SPDX-License-Identifier: Apache-2.0
// Reflected radiance of one record: the dot product of its vector, displaced along its derivatives,
// with a BRDF in another frame [K05 (3.2), (3.3)].
//
// As only the product is needed, the BRDF is rotated into the record's frame. It has one channel or
// three, while the record has nine with its derivatives.
#include "rsh/rsh_kernel.h"

bool rsh_reflect(const rsh_reflection *r, float out[3]) {
    float rotated[3 * RSH_MAX_COEFFICIENTS], sum[3], slope[3];
    if (r->brdf_channels != 1 && r->brdf_channels != 3) return false;
    if (!rsh_align_transposed(&r->alignment, r->order, r->brdf_channels, r->brdf, rotated))
        return false;
    int n = r->order * r->order, step = r->brdf_channels == 1 ? 0 : n;
    const struct rsh_kernels *k = rsh_kernels_best();
    const float *const derivative[2] = {r->d_dx, r->d_dy}, move[2] = {r->x, r->y};
    k->dot3(n, step, rotated, r->value, sum);
    for (int i = 0; i < 2; i++) {
        if (!derivative[i]) continue;
        k->dot3(n, step, rotated, derivative[i], slope);
        for (int c = 0; c < 3; c++) sum[c] += move[i] * slope[c];
    }
    for (int c = 0; c < 3; c++) out[c] = sum[c];
    return true;
}
