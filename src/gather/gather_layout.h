// SPDX-License-Identifier: Apache-2.0
// Private to gather/: fixed angles and tables of the stratified hemisphere.
#ifndef GATHER_LAYOUT_H
#define GATHER_LAYOUT_H

#include "gather/gather.h"

struct gather_layout {
    int order;  // 0: cosine-weighted for irradiance
    satin_basis basis;
    int M, N;              // rows of elevation, columns of azimuth
    float *cos_k, *sin_k;  // N each: azimuth of column centres
    float *cos_w, *sin_w;  // N each: azimuth of the stratum boundary before column k
    // Irradiance, per row j [Ward and Heckbert 1992; errata: weights at the fixed boundaries].
    float *boundary_u;  // M: d phi cos^2(theta_j-) sin(theta_j-), 0 for j = 0
    float *boundary_v;  // M: sin(theta_j+) - sin(theta_j-)
    float *boundary_h;  // M: (theta_j+ - theta_j-) cos(their mean), which [K05 4.3.2] has instead
    float *rotation;    // M: integral of sin^2(theta) over the stratum
    // Second derivatives xx, xy, yy of the cosine law over a boundary at distance 1
    // (gather_surroundings.c): of the boundary below row j around azimuth 0, and of that before a
    // column at azimuth 0.
    float (*hessian_u)[3], (*hessian_v)[3];  // M each
    // Radiance [K05 4.3.1, at the boundaries]: H(theta, phi) = P(theta) trig(phi), so the sums over
    // k are computed first, once per trigonometric function.
    int trig_count;          // 2 order - 1: m = -(order - 1) .. order - 1
    float *trig_u, *trig_v;  // N * trig_count: at column centres, at boundaries
    float *row_u, *row_v;    // M * order^2: the factors in theta, including weights
};

// ---- gather_hemisphere.c
// The hemisphere holds the stratified rays of a layout about frame.n from now on, which the caller
// fills.
void gather_hemisphere_begin(struct gather_hemisphere *h, const struct gather_layout *layout,
                             const struct frame *frame);
// The least roughness of lobes that the rays of a site hit, from the width over distance of a ray.
float gather_alpha_least(const struct gather_site *site, float spread);

#endif
