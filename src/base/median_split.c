// SPDX-License-Identifier: Apache-2.0
// Splits points at the median along the longest axis of their box. If many points lie in one plane
// across that axis, rounding would decide their order. Therefore the axis is tilted a little
// towards the second longest axis, which separates these points.
#include "base/median_split.h"

#define LEAN (1.0f / 1024.0f)  // much larger than rounding errors

// The longer of the axes a and b of a box with sides d. a if they differ by rounding alone.
static int longer(vec3 d, int a, int b) {
    return v3_along(d, b) > SPLIT_CLEARLY * v3_along(d, a) ? b : a;
}

static vec3 leaning_axis(vec3 d) {
    const int first = longer(d, longer(d, 0, 1), 2), other = first == 0 ? 1 : 0;
    float n[3] = {0.0f, 0.0f, 0.0f};
    n[first] = 1.0f;
    n[longer(d, other, 3 - first - other)] = LEAN;
    return v3(n[0], n[1], n[2]);
}

// Quickselect: moves the point with the median key to the middle, with lesser keys before it [Hoare
// 1961].
static void select_middle(struct split_point *points, size_t count) {
    const ptrdiff_t middle = (ptrdiff_t)(count / 2);
    ptrdiff_t lo = 0, hi = (ptrdiff_t)count - 1;
    while (lo < hi) {
        const float pivot = points[lo + (hi - lo) / 2].key;
        ptrdiff_t i = lo, j = hi;
        while (i <= j) {
            while (points[i].key < pivot) i++;
            while (points[j].key > pivot) j--;
            if (i > j) break;
            const struct split_point swap = points[i];
            points[i++] = points[j];
            points[j--] = swap;
        }
        if (middle <= j)
            hi = j;
        else if (middle >= i)
            lo = i;
        else
            break;
    }
}

struct split_plane median_split(struct split_point *points, size_t count) {
    vec3 lo = points->p, hi = lo;
    for (size_t i = 1; i < count; i++) {
        lo = v3_min(lo, points[i].p);
        hi = v3_max(hi, points[i].p);
    }
    const vec3 n = leaning_axis(v3_sub(hi, lo));
    for (size_t i = 0; i < count; i++) points[i].key = v3_dot(n, points[i].p);
    select_middle(points, count);
    return (struct split_plane){n, points[count / 2].key};
}
