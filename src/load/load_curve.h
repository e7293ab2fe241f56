// SPDX-License-Identifier: Apache-2.0
// Private to load/: points that become curves, for the readers of their files.
#ifndef LOAD_CURVE_H
#define LOAD_CURVE_H

#include "load/load_build.h"

// Curves being read. All zeros at first but for the source; load_curve_free frees it.
struct curve_list {
    const struct load_source *source;
    float *point;  // 4 per point: x, y, z, radius
    uint32_t *first;
    size_t points, point_capacity, segments, first_capacity;
    size_t start;  // first point of the curve that is being read
};

// Whether a point in world space and its radius are in the range of curves.
bool load_curve_in_range(vec3 p, double radius);
// Adds a point to the last curve. Logs lack of memory.
satin_status load_curve_point(struct curve_list *list, vec3 p, float radius);
// Ends the last curve, which has as many points as a segment needs: one starts at every point that
// has enough points after it. Logs lack of memory.
satin_status load_curve_end(struct curve_list *list, size_t needed);
// Copies the curves, one segment at least, to the source's arena. Logs lack of memory.
satin_status load_curve_store(const struct curve_list *list, bool linear, struct curves *out);
void load_curve_free(struct curve_list *list);

#endif
