// SPDX-License-Identifier: Apache-2.0
// Rotation as z, x, z, x, z [Kautz et al. 2002; K05 5.2]: the rotation about y is one about z
// between two rotations about x by 90 degrees, whose matrices are constant and have three zeros in
// four entries. It is kept for comparison, in plain C; rsh_rotate does the same without an index
// per entry.
#include <string.h>

#include "rsh/rsh_kernel.h"
#include "rsh/rsh_multiples.h"

// Rotates about x by 90 degrees, or back by the transpose.
static void rotate_about_x(int order, const float *value, const float *in, float *out) {
    for (int l = 0, k = 0; l < order; l++)
        for (int row = l * l; row < (l + 1) * (l + 1); row++) {
            float sum = 0.0f;
            for (; k < rsh_quarter_end[row]; k++)
                sum += value[k] * in[l * l + rsh_quarter_column[k]];
            out[row] = sum;
        }
}

bool rsh_rotate_zxzxz(int order, int channels, const float r[9], const float *in, float *out) {
    if (!rsh_order_ok(order) || !rsh_in_range(r, 9)) return false;
    struct rsh_rotation t = rsh_rotation_of_matrix(r);
    if (t.method == RSH_METHOD_Z) {
        rsh_plain_rotate(&t, order, channels, in, out);
        return true;
    }
    const struct rsh_multiples alpha = rsh_multiples_of(t.cos_alpha, t.sin_alpha, order),
                               beta = rsh_multiples_of(t.cos_beta, t.sin_beta, order),
                               gamma = rsh_multiples_of(t.cos_gamma, t.sin_gamma, order);
    int n = order * order;
    for (int c = 0; c < channels; c++, in += n, out += n) {
        float v[RSH_MAX_COEFFICIENTS], u[RSH_MAX_COEFFICIENTS];
        memcpy(v, in, (size_t)n * sizeof *v);
        rsh_rotate_multiples(order, &gamma, v);
        rotate_about_x(order, rsh_quarter, v, u);
        rsh_rotate_multiples(order, &beta, u);
        rotate_about_x(order, rsh_quarter_back, u, v);
        rsh_rotate_multiples(order, &alpha, v);
        memcpy(out, v, (size_t)n * sizeof *v);
    }
    return true;
}
