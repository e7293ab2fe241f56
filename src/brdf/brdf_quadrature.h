// SPDX-License-Identifier: Apache-2.0
// Private to brdf/: Gauss-Legendre rules over [0, 1].
#ifndef BRDF_QUADRATURE_H
#define BRDF_QUADRATURE_H

enum { QUADRATURE_MAX = 128 };

struct quadrature {
    int count;
    double x[QUADRATURE_MAX], weight[QUADRATURE_MAX];  // ascending; the weights sum to 1
};

// Computes the rule of `count` nodes, 1 to QUADRATURE_MAX, which is exact for polynomials of degree
// 2 count - 1.
void brdf_quadrature_gauss(struct quadrature *rule, int count);

#endif
