// SPDX-License-Identifier: Apache-2.0
// Private to photon/: values at sites on surfaces, and planes fitted to them.
#ifndef PHOTON_CAUSTIC_SMOOTH_H
#define PHOTON_CAUSTIC_SMOOTH_H

#include "photon/photon_map.h"

// Values at positions on surfaces, and the planes fitted to them.
struct photon_sites {
    size_t count;
    struct photon_positions position;
    rgb *value;    // first that of the position, later that of its plane
    float *noise;  // variance of a value over its square
    struct slope {
        rgb u, v;         // slopes of the plane along u and v of the normal's frame
        float differs;    // mean squared difference of the values from it, in units of noise
        float preserved;  // fraction of such differences that is preserved
    } * slope;
    struct photon_index *index;
};

static inline float photon_rgb_square(rgb c) { return c.r * c.r + c.g * c.g + c.b * c.b; }

// ---- photon_plane.c
// The next three are chunk functions for parallel_for, to be run one after another. The sites must
// have an index.

// Context of photon_fit_planes and photon_evaluate_planes.
struct photon_fitting {
    const struct satin_scene *scene;
    struct photon_sites *sites;  // `slope` is set by these functions
    rgb *plane;                  // value of each site's plane at the site
};
// Fits a plane at each site.
void photon_fit_planes(void *fitting, size_t begin, size_t end, int worker);
// Computes at each site the fraction of the differences from its plane that is preserved.
void photon_evaluate_planes(void *fitting, size_t begin, size_t end, int worker);

// Context of photon_read_planes.
struct photon_reading {
    const struct satin_scene *scene;
    const struct photon_sites *sites;         // whose values are those of their planes
    const struct photon_positions *position;  // positions of the values
    rgb *value;
};
// Replaces values by the mean of the planes around them, plus the fraction of the difference that
// is not noise.
void photon_read_planes(void *reading, size_t begin, size_t end, int worker);

#endif
