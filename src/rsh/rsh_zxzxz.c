// SPDX-License-Identifier: Apache-2.0
// Rotation as z, x, z, x, z [Kautz et al. 2002; K05 5.2]: the turn about y is one about z between
// two quarter turns about x, whose matrices are constant and three quarters empty. Kept for
// comparison, in plain C: rsh_rotate does the same work without an index per entry.
#include <string.h>

#include "rsh/rsh_kernel.h"

// cos(m a) and sin(m a).
struct multiples {
    float cosine[RSH_MAX_ORDER], sine[RSH_MAX_ORDER];
};

static void multiples_of(float cosine, float sine, int order, struct multiples *a) {
    a->cosine[0] = 1.0f;
    a->sine[0] = 0.0f;
    for (int m = 1; m < order; m++) {
        a->cosine[m] = a->cosine[m - 1] * cosine - a->sine[m - 1] * sine;
        a->sine[m] = a->cosine[m - 1] * sine + a->sine[m - 1] * cosine;
    }
}

// [K05 D], with the sense of rsh.h.
static void turn_z(int order, const struct multiples *a, float *v) {
    for (int l = 1; l < order; l++) {
        float *middle = v + l * (l + 1);
        for (int m = 1; m <= l; m++) {
            float plus = middle[m], minus = middle[-m];
            middle[m] = a->cosine[m] * plus - a->sine[m] * minus;
            middle[-m] = a->sine[m] * plus + a->cosine[m] * minus;
        }
    }
}

// By the quarter turn about x, or back by its transpose.
static void quarter_turn(int order, const float *value, const float *in, float *out) {
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
    struct rsh_turn t = rsh_turn_of_matrix(r);
    if (t.method == RSH_METHOD_Z) {
        rsh_plain_turn(&t, order, channels, in, out);
        return true;
    }
    struct multiples alpha, beta, gamma;
    multiples_of(t.cos_alpha, t.sin_alpha, order, &alpha);
    multiples_of(t.cos_beta, t.sin_beta, order, &beta);
    multiples_of(t.cos_gamma, t.sin_gamma, order, &gamma);
    int n = order * order;
    for (int c = 0; c < channels; c++, in += n, out += n) {
        float v[RSH_MAX_COEFFICIENTS], u[RSH_MAX_COEFFICIENTS];
        memcpy(v, in, (size_t)n * sizeof *v);
        turn_z(order, &gamma, v);
        quarter_turn(order, rsh_quarter, v, u);
        turn_z(order, &beta, u);
        quarter_turn(order, rsh_quarter_back, u, v);
        turn_z(order, &alpha, v);
        memcpy(out, v, (size_t)n * sizeof *v);
    }
    return true;
}
