// SPDX-License-Identifier: Apache-2.0
// Operations on a function in harmonics: its value, its convolution, and conversion to the
// convention with the Condon-Shortley phase.
#include <math.h>

#include "rsh/rsh_kernel.h"

bool rsh_value(rsh_basis basis, int order, int channels, const float *in, const float w[3],
               float *out) {
    float y[RSH_MAX_COEFFICIENTS];
    if (!rsh_eval(basis, order, w, y)) return false;
    int n = order * order;
    for (int c = 0; c < channels; c++) {
        float sum = 0.0f;
        for (int k = 0; k < n; k++) sum += in[c * n + k] * y[k];
        out[c] = sum;
    }
    return true;
}

bool rsh_convolve(int order, int channels, const float *zonal, const float *in, float *out) {
    if (!rsh_order_ok(order)) return false;
    for (int c = 0; c < channels; c++)
        for (int l = 0; l < order; l++) {
            // Funk and Hecke: band l is scaled by sqrt(4 pi / (2 l + 1)) times the kernel's z_l.
            float factor = sqrtf(12.56637061f / (float)(2 * l + 1)) * zonal[l];
            for (int m = -l; m <= l; m++, in++, out++) *out = factor * *in;
        }
    return true;
}

bool rsh_flip_phase(int order, int channels, const float *in, float *out) {
    if (!rsh_order_ok(order)) return false;
    for (int c = 0; c < channels; c++)
        for (int l = 0; l < order; l++)
            for (int m = -l; m <= l; m++, in++, out++) *out = m & 1 ? -*in : *in;
    return true;
}
