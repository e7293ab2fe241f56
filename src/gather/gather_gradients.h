// SPDX-License-Identifier: Apache-2.0
// Private to gather/: translational gradients of what a stratified hemisphere of rays found, from
// the same rays. In local coordinates; z is 0.
#ifndef GATHER_GRADIENTS_H
#define GATHER_GRADIENTS_H

#include "gather/gather_layout.h"

// Stratification-based [K05 4.3], or as Ward and Heckbert [1992] have it: what crosses the
// boundaries between strata. Adds to `grad`, one vector per channel.
void gather_stratified_irradiance(const struct gather_hemisphere *h, bool ward_heckbert,
                                  vec3 grad[3]);
// Adds to dx and dy, [3 * order^2].
void gather_stratified_radiance(const struct gather_hemisphere *h, float *dx, float *dy);

// Solid-angle-based [K05 4.2]: how what each ray hit changes in direction, distance and solid
// angle. By differentiation, or by finite differences. Both add what the rays from `first` on
// contribute, the guided ones at the end included.
void gather_solid_angle_irradiance(const struct gather_hemisphere *h, bool differences,
                                   size_t first, vec3 grad[3]);
void gather_solid_angle_radiance(const struct gather_hemisphere *h, bool differences, size_t first,
                                 float *dx, float *dy);

#endif
