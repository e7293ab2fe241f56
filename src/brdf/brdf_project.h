// SPDX-License-Identifier: Apache-2.0
// The harmonics of a BRDF's glossy lobe for one outgoing direction. Private to brdf/.
#ifndef BRDF_PROJECT_H
#define BRDF_PROJECT_H

#include "brdf/brdf.h"
#include "brdf/brdf_quadrature.h"
#include "rsh/rsh.h"

enum {
    PROJECT_PANELS = 5,    // each half as long as the next, the shortest at the mirror direction
    PROJECT_NODES = 12,    // of Gauss' rule in each panel
    PROJECT_AZIMUTHS = 40  // over 180 degrees
};

// A rule over [0, 1] for the angle from the mirror direction, in units of the angle to the horizon.
struct project_rule {
    float x[PROJECT_PANELS * PROJECT_NODES], weight[PROJECT_PANELS * PROJECT_NODES];
};

void project_rule_make(struct project_rule *rule);

// Directions and values of one projection; scratch.
struct project_points {
    size_t count;
    float x[2 * PROJECT_AZIMUTHS * PROJECT_PANELS * PROJECT_NODES];
    float y[2 * PROJECT_AZIMUTHS * PROJECT_PANELS * PROJECT_NODES];
    float z[2 * PROJECT_AZIMUTHS * PROJECT_PANELS * PROJECT_NODES];
    float value[3][2 * PROJECT_AZIMUTHS * PROJECT_PANELS * PROJECT_NODES];
};

// Adds to c[channels * order^2] the integrals of f_r cos(theta_i) H over the hemisphere, for b's
// glossy lobe with `specular` as it stands, and returns the integral of (f_r cos(theta_i))^2,
// summed over channels. wo.z > 0. With `half`, the lobe is taken to be even in y (wo.y = 0, an
// isotropic model or one with its axes along x and y), which takes half the work and leaves c of m
// < 0 without meaning.
double project_glossy(const struct brdf *b, vec3 wo, bool half, rsh_basis basis, int order,
                      int channels, const struct project_rule *rule, struct project_points *points,
                      float *c);

#endif
