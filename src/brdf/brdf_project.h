// SPDX-License-Identifier: Apache-2.0
// Private to brdf/: the harmonics of a BRDF's glossy lobe for one outgoing direction.
#ifndef BRDF_PROJECT_H
#define BRDF_PROJECT_H

#include "brdf/brdf.h"
#include "brdf/brdf_quadrature.h"
#include "rsh/rsh.h"

enum {
    PROJECT_PANELS = 3,     // each is half as long as the next one; the shortest is at the mirror
                            // direction
    PROJECT_NODES = 12,     // nodes of Gauss' rule in each panel
    PROJECT_AZIMUTHS = 40,  // the most over 180 degrees
    PROJECT_POINTS = PROJECT_AZIMUTHS * PROJECT_PANELS * PROJECT_NODES
};

// A rule over [0, 1] for the angle from the mirror direction, in units of the angle to the horizon.
struct project_rule {
    float x[PROJECT_PANELS * PROJECT_NODES], weight[PROJECT_PANELS * PROJECT_NODES];
};

void brdf_project_rule_make(struct project_rule *rule);

// The harmonics onto which a lobe is projected.
struct project_target {
    rsh_basis basis;
    int order, channels;
    // The lobe is assumed to be even in y (wo.y = 0, and an isotropic model or one with its axes
    // along x and y), which takes half the time and leaves coefficients of m < 0 without meaning.
    bool half;
};

// Directions and values of at most half of the azimuths, for use as scratch.
struct project_points {
    size_t count;
    int channels;  // of the values
    float x[PROJECT_POINTS];
    float y[PROJECT_POINTS];
    float z[PROJECT_POINTS];
    float value[3][PROJECT_POINTS];
};

// Adds to c[channels * order^2] the integrals of f_r cos(theta_i) H over the hemisphere, for b's
// glossy lobe including `specular`. Returns the integral of (f_r cos(theta_i))^2, summed over
// channels. wo.z > 0.
double brdf_project_glossy(const struct brdf *b, vec3 wo, struct project_target target,
                           const struct project_rule *rule, struct project_points *points,
                           float *c);

#endif
