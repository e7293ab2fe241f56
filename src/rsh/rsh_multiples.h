// SPDX-License-Identifier: Apache-2.0
// Private to rsh/ and its benchmarks: rotations about z in plain C, for the forms that are kept for
// comparison.
#ifndef RSH_MULTIPLES_H
#define RSH_MULTIPLES_H

#include "rsh/rsh.h"

// cos(m a) and sin(m a).
struct rsh_multiples {
    float cosine[RSH_MAX_ORDER], sine[RSH_MAX_ORDER];
};

static inline struct rsh_multiples rsh_multiples_of(float cosine, float sine, int order) {
    struct rsh_multiples a;
    a.cosine[0] = 1.0f;
    a.sine[0] = 0.0f;
    for (int m = 1; m < order; m++) {
        a.cosine[m] = a.cosine[m - 1] * cosine - a.sine[m - 1] * sine;
        a.sine[m] = a.cosine[m - 1] * sine + a.sine[m - 1] * cosine;
    }
    return a;
}

// [K05 D], with the sense of rsh.h.
static inline void rsh_rotate_multiples(int order, const struct rsh_multiples *a, float *v) {
    for (int l = 1; l < order; l++) {
        float *middle = v + l * (l + 1);
        for (int m = 1; m <= l; m++) {
            float plus = middle[m], minus = middle[-m];
            middle[m] = a->cosine[m] * plus - a->sine[m] * minus;
            middle[-m] = a->sine[m] * plus + a->cosine[m] * minus;
        }
    }
}

#endif
