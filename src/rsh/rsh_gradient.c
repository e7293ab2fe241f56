// SPDX-License-Identifier: Apache-2.0
// Derivatives of the harmonics by the angles of the direction [K05 A; errata 3], in a form without
// a singularity at the pole: along a meridian band l changes as under a rotation about y, which
// couples only neighbouring |m|.
#include <math.h>

#include "rsh/rsh_kernel.h"
#include "rsh/rsh_tables.h"

// Below this cosine the derivative of the stretched angle, sqrt((1 + c) / c), is constant.
#define RSH_LEAST_COSINE 1e-6

// sK P_l^m(cosine) for all l and m >= 0, indexed l (l + 1) + m. In double, as rsh_eval.
static void eval_meridian(int order, double cosine, double sine, double *f) {
    double power = 1.0;
    for (int m = 0; m < order; m++, power *= sine) {
        const float *norm = rsh_norm + m * RSH_MAX_ORDER;
        const double *b = rsh_recurrence_d + m * RSH_MAX_ORDER;
        double p = 1.0, p1 = 0.0;
        for (int l = m; l < order; l++) {
            if (l > m) {
                double next = cosine * p - b[l] * p1;
                p1 = p;
                p = next;
            }
            f[l * (l + 1) + m] = (double)norm[l] * p * power;
        }
    }
}

bool rsh_eval_derivatives(rsh_basis basis, int order, const float w[3], float *y, float *dtheta,
                          float *dphi) {
    if (!rsh_basis_ok(basis) || !rsh_order_ok(order)) return false;
    double d[3] = {(double)w[0], (double)w[1], (double)w[2]}, rate = 1.0;
    double cosine = d[2], sine = sqrt(d[0] * d[0] + d[1] * d[1]);
    double c1 = sine > 0.0 ? d[0] / sine : 1.0, s1 = sine > 0.0 ? d[1] / sine : 0.0;
    double square = sine * sine + cosine * cosine;
    if (fabs(square - 1.0) < 1e-5) {
        cosine *= 1.5 - 0.5 * square;
        sine *= 1.5 - 0.5 * square;
    }
    if (basis == RSH_HEMISPHERE) {
        double z = cosine > 0.0 ? fmin(cosine, 1.0) : 0.0, held = fmax(z, RSH_LEAST_COSINE);
        rate = sqrt((1.0 + held) / held);
        sine *= 2.0 * sqrt(z / (1.0 + z));
        cosine = 2.0 * z - 1.0;
    }
    double f[RSH_MAX_COEFFICIENTS], c = basis == RSH_HEMISPHERE ? sqrt(2.0) : 1.0, s = 0.0;
    eval_meridian(order, cosine, sine, f);
    for (int m = 0; m < order; m++) {
        for (int l = m; l < order; l++) {
            int plus = l * (l + 1) + m, minus = l * (l + 1) - m;
            double slope = m > 0 ? (double)rsh_slope[plus] * f[plus - 1] : 0.0;
            if (m < l) slope -= (double)rsh_slope[plus + 1] * f[plus + 1];
            slope *= rate;
            y[minus] = (float)(s * f[plus]);
            y[plus] = (float)(c * f[plus]);
            dtheta[minus] = (float)(s * slope);
            dtheta[plus] = (float)(c * slope);
            dphi[minus] = (float)(m * c * f[plus]);
            dphi[plus] = (float)(-m * s * f[plus]);
        }
        double t = c * c1 - s * s1;
        s = c * s1 + s * c1;
        c = t;
    }
    return true;
}
