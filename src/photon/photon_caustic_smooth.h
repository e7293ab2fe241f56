// SPDX-License-Identifier: Apache-2.0
// Private to photon/: values at sites on surfaces and the planes through them.
#ifndef PHOTON_CAUSTIC_SMOOTH_H
#define PHOTON_CAUSTIC_SMOOTH_H

#include "photon/photon_map.h"

// Values over positions on surfaces, and the planes through them.
struct photon_sites {
    size_t count;
    struct photon_positions position;
    rgb *value;    // first that of the position, then what its plane has there
    float *noise;  // variance of a value over its square
    struct slope {
        rgb u, v;       // of the plane along the frame of the normal
        float differs;  // mean square of the values' differences from it, in units of noise
        float kept;     // of such differences
    } * slope;
    struct photon_index *index;
};

static inline float rgb_square(rgb c) { return c.r * c.r + c.g * c.g + c.b * c.b; }

// The next three functions are chunk functions of parallel_for, to be run one after the other; the
// sites must have an index.

// Context of the first two.
struct photon_fitting {
    const struct satin_scene *scene;
    struct photon_sites *sites;  // of which `slope` is filled
    rgb *plane;                  // value of each site's plane at the site
};
// Fits a plane at each site.
void photon_fit_planes(void *fitting, size_t begin, size_t end, int worker);
// Decides at each site how much of the differences from its plane is kept.
void photon_evaluate_planes(void *fitting, size_t begin, size_t end, int worker);

// Context of photon_read_planes.
struct photon_reading {
    const struct satin_scene *scene;
    const struct photon_sites *sites;         // with their planes' values
    const struct photon_positions *position;  // of the values
    rgb *value;
};
// Replaces values by the mean of the planes around, and of the values themselves as far as they are
// no noise.
void photon_read_planes(void *reading, size_t begin, size_t end, int worker);

#endif
