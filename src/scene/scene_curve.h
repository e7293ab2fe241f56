// SPDX-License-Identifier: Apache-2.0
// Private to scene/: curves as round tubes, read from Mitsuba's text files.
#ifndef SCENE_CURVE_H
#define SCENE_CURVE_H

#include "scene/scene_build.h"

// Reads lines `x y z radius`, one control point each; blank lines part curves. Points go to world
// space, radii stay as they are, as in Mitsuba. `linear`: segments between neighbours, two points
// or more to a curve; else cubic B-splines, four points or more.
satin_status scene_curves_read(const struct scene_source *source, const struct mat4 *to_world,
                               bool linear, struct curves *out);

// A box around tubes.
void scene_curves_bound(const struct curves *curves, vec3 *lo, vec3 *hi);

// Where a curve was hit.
struct curve_hit {
    uint32_t segment;
    float u;  // along the segment, 0 to 1
    vec3 p;   // as the ray tells
    vec3 n;   // normal, any length
    bool flip;
};
// Fills p, ng, frame, uv and dp_du, dp_dv. The point is put a little off the tube, to the outside:
// the tracer finds tubes with errors that grow with their radius.
void curve_surfel(const struct curves *curves, const struct curve_hit *hit, bool tangent,
                  struct surfel *out);

#endif
