// SPDX-License-Identifier: Apache-2.0
// Derivatives of the harmonics by the angles of the direction [K05 A; errata 3], in a form without
// singularity at the pole: along a meridian band l changes as under rotation about y, which couples
// |m| with its neighbours only.
#include <math.h>

#include "rsh/rsh_kernel.h"
#include "rsh/rsh_tables.h"

// Below this cosine the derivative of the stretched angle, sqrt((1 + c) / c), is held.
#define RSH_LEAST_COSINE 1e-6f

// sK P_l^m(cosine) for all l and m >= 0, indexed l (l + 1) + m.
static void eval_meridian(int order, float cosine, float sine, float *f) {
    float power = 1.0f;
    for (int m = 0; m < order; m++, power *= sine) {
        const float *norm = rsh_norm + m * RSH_MAX_ORDER, *b = rsh_recurrence + m * RSH_MAX_ORDER;
        float p = 1.0f, p1 = 0.0f;
        for (int l = m; l < order; l++) {
            if (l > m) {
                float next = cosine * p - b[l] * p1;
                p1 = p;
                p = next;
            }
            f[l * (l + 1) + m] = norm[l] * p * power;
        }
    }
}

bool rsh_eval_derivatives(rsh_basis basis, int order, const float w[3], float *y, float *dtheta,
                          float *dphi) {
    if (!rsh_order_ok(order)) return false;
    float cosine = w[2], sine = sqrtf(w[0] * w[0] + w[1] * w[1]), rate = 1.0f;
    float c1 = sine > 0.0f ? w[0] / sine : 1.0f, s1 = sine > 0.0f ? w[1] / sine : 0.0f;
    if (basis == RSH_HEMISPHERE) {
        float z = cosine > 0.0f ? fminf(cosine, 1.0f) : 0.0f, held = fmaxf(z, RSH_LEAST_COSINE);
        rate = sqrtf((1.0f + held) / held);
        sine *= 2.0f * sqrtf(z / (1.0f + z));
        cosine = 2.0f * z - 1.0f;
    }
    float f[RSH_MAX_COEFFICIENTS];
    eval_meridian(order, cosine, sine, f);
    float c = basis == RSH_HEMISPHERE ? sqrtf(2.0f) : 1.0f, s = 0.0f;
    for (int m = 0; m < order; m++) {
        for (int l = m; l < order; l++) {
            int plus = l * (l + 1) + m, minus = l * (l + 1) - m;
            float slope = m > 0 ? rsh_slope[plus] * f[plus - 1] : 0.0f;
            if (m < l) slope -= rsh_slope[plus + 1] * f[plus + 1];
            slope *= rate;
            y[minus] = s * f[plus];
            y[plus] = c * f[plus];
            dtheta[minus] = s * slope;
            dtheta[plus] = c * slope;
            dphi[minus] = (float)m * c * f[plus];
            dphi[plus] = (float)-m * s * f[plus];
        }
        float t = c * c1 - s * s1;
        s = c * s1 + s * c1;
        c = t;
    }
    return true;
}
