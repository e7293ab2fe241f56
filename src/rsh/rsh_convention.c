// SPDX-License-Identifier: Apache-2.0
// Conversion between this library's convention and others: phase, normalisation, and order of the
// coefficients.
#include <math.h>
#include <stdlib.h>

#include "rsh/rsh_kernel.h"

static const double PI_DOUBLE = 3.14159265358979323846;

static bool known(int order, const rsh_convention *c) {
    return rsh_order_ok(order) && (unsigned)c->norm <= RSH_UNNORMALISED &&
           (unsigned)c->layout <= RSH_COMPLEX;
}

// The factor of a coefficient in the other convention: the inverse of that of its harmonic.
static double factor_of(const rsh_convention *convention, int l, int m) {
    double factor = convention->phase && m % 2 ? -1.0 : 1.0;
    switch (convention->norm) {
        case RSH_ORTHONORMAL:
            break;
        case RSH_FOUR_PI:
            factor /= sqrt(4.0 * PI_DOUBLE);
            break;
        case RSH_SCHMIDT:
            factor *= sqrt((2 * l + 1) / (4.0 * PI_DOUBLE));
            break;
        case RSH_UNNORMALISED: {
            double ratio = 1.0;  // (l - |m|)! / (l + |m|)!
            for (int k = l - abs(m) + 1; k <= l + abs(m); k++) ratio /= k;
            factor *= sqrt((m ? 2.0 : 1.0) * (2 * l + 1) / (4.0 * PI_DOUBLE) * ratio);
        }
    }
    return factor;
}

int rsh_convention_size(int order, rsh_layout layout) {
    if (!rsh_order_ok(order)) return 0;
    return layout == RSH_BY_DEGREE ? order * order : 2 * order * order;
}

// The complex coefficient of m > 0 is the coefficient of cos minus i times that of sin, over sqrt
// 2. That of -m is its conjugate times the sign of the phase.
static void export_pair(const rsh_convention *convention, int order, int l, int m, double cosine,
                        double sine, float *out) {
    int n = order * order, i = l * (l + 1);
    if (convention->layout == RSH_BY_DEGREE) {
        if (m) out[i - m] = (float)sine;
        out[i + m] = (float)cosine;
    } else if (convention->layout == RSH_COSINE_SINE) {
        out[l * order + m] = (float)cosine;
        out[n + l * order + m] = (float)sine;
    } else {
        double root = m ? sqrt(0.5) : 1.0, sign = convention->phase && m % 2 ? -1.0 : 1.0;
        out[2 * (i - m)] = (float)(sign * root * cosine);
        out[2 * (i - m) + 1] = (float)(sign * root * sine);
        out[2 * (i + m)] = (float)(root * cosine);
        out[2 * (i + m) + 1] = (float)(m ? -root * sine : 0.0);
    }
}

static void import_pair(const rsh_convention *convention, int order, int l, int m, const float *in,
                        double *cosine, double *sine) {
    int n = order * order, i = l * (l + 1);
    if (convention->layout == RSH_BY_DEGREE) {
        *cosine = (double)in[i + m];
        *sine = m ? (double)in[i - m] : 0.0;
    } else if (convention->layout == RSH_COSINE_SINE) {
        *cosine = (double)in[l * order + m];
        *sine = m ? (double)in[n + l * order + m] : 0.0;
    } else {
        double root = m ? sqrt(2.0) : 1.0;
        *cosine = root * (double)in[2 * (i + m)];
        *sine = m ? -root * (double)in[2 * (i + m) + 1] : 0.0;
    }
}

bool rsh_export(const rsh_convention *convention, int order, int channels, const float *in,
                float *out) {
    if (!known(order, convention)) return false;
    int n = order * order, size = rsh_convention_size(order, convention->layout);
    for (int c = 0; c < channels; c++, in += n, out += size) {
        if (convention->layout == RSH_COSINE_SINE)
            for (int k = 0; k < size; k++) out[k] = 0.0f;
        for (int l = 0; l < order; l++)
            for (int m = 0; m <= l; m++) {
                double f = factor_of(convention, l, m);
                double sine = m ? f * (double)in[l * (l + 1) - m] : 0.0;
                export_pair(convention, order, l, m, f * (double)in[l * (l + 1) + m], sine, out);
            }
    }
    return true;
}

bool rsh_import(const rsh_convention *convention, int order, int channels, const float *in,
                float *out) {
    if (!known(order, convention)) return false;
    int n = order * order, size = rsh_convention_size(order, convention->layout);
    for (int c = 0; c < channels; c++, in += size, out += n)
        for (int l = 0; l < order; l++)
            for (int m = 0; m <= l; m++) {
                double f = factor_of(convention, l, m), cosine, sine;
                import_pair(convention, order, l, m, in, &cosine, &sine);
                out[l * (l + 1) - m] = (float)(sine / f);
                out[l * (l + 1) + m] = (float)(cosine / f);
            }
    return true;
}
