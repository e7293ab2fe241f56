// SPDX-License-Identifier: Apache-2.0
// Product quadrature over the sphere or the upper hemisphere for the tests of the harmonics: Gauss
// and Legendre in cos theta, equal steps in phi. Exact for polynomials of degree < 2 * rings.
#ifndef RSH_QUADRATURE_H
#define RSH_QUADRATURE_H

#include <math.h>

enum { QUADRATURE_MAX = 48 * 96 };

struct rsh_quadrature_quadrature {
    int count;
    float w[QUADRATURE_MAX][3];
    double weight[QUADRATURE_MAX];
};

// `rings` <= 48. Nodes by Newton's iteration from the usual cosine guess.
static inline struct rsh_quadrature_quadrature quadrature_make(int hemisphere, int rings) {
    static struct rsh_quadrature_quadrature q;
    const double pi = acos(-1.0);
    q.count = 0;
    for (int i = 0; i < rings; i++) {
        double x = cos(pi * (i + 0.75) / (rings + 0.5)), slope = 1.0;
        for (int step = 0; step < 20; step++) {
            double p = 1.0, p1 = 0.0;
            for (int l = 1; l <= rings; l++) {
                double next = ((2 * l - 1) * x * p - (l - 1) * p1) / l;
                p1 = p;
                p = next;
            }
            slope = rings * (x * p - p1) / (x * x - 1.0);
            x -= p / slope;
        }
        double weight = 2.0 / ((1.0 - x * x) * slope * slope), z = x;
        if (hemisphere) {
            z = 0.5 * (x + 1.0);
            weight *= 0.5;
        }
        for (int k = 0; k < 2 * rings; k++) {
            double phi = pi * (k + 0.5) / rings, s = sqrt(1.0 - z * z);
            q.w[q.count][0] = (float)(s * cos(phi));
            q.w[q.count][1] = (float)(s * sin(phi));
            q.w[q.count][2] = (float)z;
            q.weight[q.count++] = weight * pi / rings;
        }
    }
    return q;
}

#endif
