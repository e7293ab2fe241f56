// SPDX-License-Identifier: Apache-2.0
// Facets that bump and normal maps tilt, and their irradiance by quadrature over the directions
// above the surface, whose normal is z, and the facet.
#ifndef TESTS_UNIT_FACET_H
#define TESTS_UNIT_FACET_H

#include "base/vec.h"

enum { FACET_STEPS = 400 };

static const float facet_degrees[] = {0.0f, 3.0f, 10.0f, 30.0f, 45.0f, 60.0f, 70.0f, 75.0f, 85.0f};
enum { FACETS = sizeof facet_degrees / sizeof *facet_degrees };

static inline vec3 facet_normal(float angle) { return v3(sinf(angle), 0.0f, cosf(angle)); }

// The irradiance of a facet by a radiance f(w).
static inline double facet_irradiance(vec3 facet, double (*f)(vec3 w, const void *ctx),
                                      const void *ctx) {
    double sum = 0.0;
    for (int i = 0; i < FACET_STEPS; i++)
        for (int k = 0; k < 2 * FACET_STEPS; k++) {
            const float z = ((float)i + 0.5f) / FACET_STEPS,
                        phi = ((float)k + 0.5f) * PI_F / FACET_STEPS;
            const float r = sqrtf(1.0f - z * z);
            const vec3 w = v3(r * cosf(phi), r * sinf(phi), z);
            sum += fmax(v3_dot(w, facet), 0.0) * f(w, ctx);
        }
    return sum * (double)PI_F / FACET_STEPS / FACET_STEPS;
}

#endif
