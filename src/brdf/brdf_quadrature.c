// SPDX-License-Identifier: Apache-2.0
// Nodes of Gauss-Legendre rules by Newton's method on the Legendre polynomial.
#include "brdf/brdf_quadrature.h"

#include <math.h>

void brdf_quadrature_gauss(struct quadrature *rule, int count) {
    rule->count = count;
    for (int i = 0; i < (count + 1) / 2; i++) {
        double z = cos(M_PI * (i + 0.75) / (count + 0.5)), slope = 1.0, step;
        int round = 0;
        do {
            double p = 1.0, before = 0.0;
            for (int l = 1; l <= count; l++) {
                double older = before;
                before = p;
                p = ((2 * l - 1) * z * before - (l - 1) * older) / l;
            }
            slope = count * (z * p - before) / (z * z - 1.0);
            step = p / slope;
            z -= step;
        } while (fabs(step) > 1e-15 && ++round < 20);
        int mirror = count - 1 - i;
        rule->x[i] = 0.5 * (1.0 - z);
        rule->x[mirror] = 0.5 * (1.0 + z);
        rule->weight[i] = rule->weight[mirror] = 1.0 / ((1.0 - z * z) * slope * slope);
    }
}
