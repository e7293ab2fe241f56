// SPDX-License-Identifier: Apache-2.0
// Private to gather/: translational gradients from the rays of a stratified hemisphere. In local
// coordinates; z is 0.
#ifndef GATHER_GRADIENTS_H
#define GATHER_GRADIENTS_H

#include "gather/gather_layout.h"

// Adds `change` along `direction` to the gradient of each channel.
static inline void gather_gradient_add(vec3 grad[3], rgb change, vec3 direction) {
    grad[0] = v3_mad(grad[0], change.r, direction);
    grad[1] = v3_mad(grad[1], change.g, direction);
    grad[2] = v3_mad(grad[2], change.b, direction);
}

// Stratified gradients [K05 4.3], or those of Ward and Heckbert [1992]: the light that crosses the
// boundaries between strata. Adds to `grad`, one vector per channel.
void gather_stratified_irradiance(const struct gather_hemisphere *h, bool ward_heckbert,
                                  vec3 grad[3]);
// The variance of the luminance of the former in any direction, as the strata are sampled by
// chance.
float gather_stratified_variance(const struct gather_hemisphere *h);
// Adds stratified gradients to dx and dy, [3 * order^2].
void gather_stratified_radiance(const struct gather_hemisphere *h, float *dx, float *dy);

// Solid-angle-based gradients [K05 4.2]: from the change of the direction, distance and solid angle
// of each hit, in closed form or by finite differences. Both add the contributions of the rays from
// `first` on, including the guided ones at the end.
void gather_solid_angle_irradiance(const struct gather_hemisphere *h, bool differences,
                                   size_t first, vec3 grad[3]);
void gather_solid_angle_radiance(const struct gather_hemisphere *h, bool differences, size_t first,
                                 float *dx, float *dy);
// The variance of the luminance of the former in any direction.
float gather_solid_angle_variance(const struct gather_hemisphere *h, size_t first);

#endif
