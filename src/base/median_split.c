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

// A range of points that contains the middle, both ends included.
struct select_range {
    ptrdiff_t lo, hi;
};

// The range after a partition by which all up to j are not above the pivot, and all from i on are
// not below it.
static struct select_range narrow(struct select_range range, ptrdiff_t middle, ptrdiff_t i,
                                  ptrdiff_t j) {
    if (middle <= j) return (struct select_range){range.lo, j};
    if (middle >= i) return (struct select_range){i, range.hi};
    return (struct select_range){middle, middle};
}

static float pivot_of(const struct split_point *points, struct select_range range) {
    return points[range.lo + (range.hi - range.lo) / 2].key;
}

// Quickselect: moves the point with the median key to the middle, with lesser keys before it [Hoare
// 1961].
static void select_middle(struct split_point *points, struct select_range range, ptrdiff_t middle) {
    while (range.lo < range.hi) {
        const float pivot = pivot_of(points, range);
        ptrdiff_t i = range.lo, j = range.hi;
        while (i <= j) {
            while (points[i].key < pivot) i++;
            while (points[j].key > pivot) j--;
            if (i > j) break;
            const struct split_point swap = points[i];
            points[i++] = points[j];
            points[j--] = swap;
        }
        range = narrow(range, middle, i, j);
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
    const struct select_range all = {0, (ptrdiff_t)count - 1};
    select_middle(points, all, (ptrdiff_t)(count / 2));
    return (struct split_plane){n, points[count / 2].key};
}

// ---- On all threads -----------------------------------------------------------------------------

enum {
    SPLIT_CHUNK = 4096,
    SPLIT_SERIAL =
        32768,  // points that one thread partitions in the time that threads need to begin
    SPLIT_CHUNKS_MAX = 1024
};

// A partition of points[range.lo .. range.hi] as select_middle makes it. Its k-th swap is that of
// the k-th point from the left that is not below the pivot, and of the k-th from the right that is
// not above it, as long as the first is not behind the second.
struct partition {
    struct split_point *points;
    struct select_range range;
    vec3 n;
    float pivot;
    ptrdiff_t chunk;                    // points of a chunk
    uint32_t *left, *right;             // those points, in this order
    size_t first[2][SPLIT_CHUNKS_MAX];  // of a chunk's points: the first entry of each array
    vec3 lo[SPLIT_CHUNKS_MAX], hi[SPLIT_CHUNKS_MAX];  // boxes of chunks
};

static struct select_range chunk_range(const struct partition *p, size_t chunk) {
    const ptrdiff_t lo = p->range.lo + (ptrdiff_t)chunk * p->chunk, hi = lo + p->chunk - 1;
    return (struct select_range){lo, hi < p->range.hi ? hi : p->range.hi};
}

static void bound_chunks(void *ctx, size_t begin, size_t end, int worker) {
    struct partition *p = ctx;
    (void)worker;
    for (size_t chunk = begin; chunk < end; chunk++) {
        const struct select_range range = chunk_range(p, chunk);
        vec3 lo = p->points[range.lo].p, hi = lo;
        for (ptrdiff_t i = range.lo + 1; i <= range.hi; i++) {
            lo = v3_min(lo, p->points[i].p);
            hi = v3_max(hi, p->points[i].p);
        }
        p->lo[chunk] = lo;
        p->hi[chunk] = hi;
    }
}

static void set_keys(void *ctx, size_t begin, size_t end, int worker) {
    const struct partition *p = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) p->points[i].key = v3_dot(p->n, p->points[i].p);
}

static void count_sides(void *ctx, size_t begin, size_t end, int worker) {
    struct partition *p = ctx;
    (void)worker;
    for (size_t chunk = begin; chunk < end; chunk++) {
        const struct select_range range = chunk_range(p, chunk);
        size_t count[2] = {0, 0};
        for (ptrdiff_t i = range.lo; i <= range.hi; i++) {
            count[0] += p->points[i].key >= p->pivot;
            count[1] += p->points[i].key <= p->pivot;
        }
        for (int side = 0; side < 2; side++) p->first[side][chunk] = count[side];
    }
}

static void list_sides(void *ctx, size_t begin, size_t end, int worker) {
    struct partition *p = ctx;
    (void)worker;
    for (size_t chunk = begin; chunk < end; chunk++) {
        const struct select_range range = chunk_range(p, chunk);
        uint32_t *left = p->left + p->first[0][chunk], *right = p->right + p->first[1][chunk];
        for (ptrdiff_t i = range.lo; i <= range.hi; i++)
            if (p->points[i].key >= p->pivot) *left++ = (uint32_t)i;
        for (ptrdiff_t i = range.hi; i >= range.lo; i--)
            if (p->points[i].key <= p->pivot) *right++ = (uint32_t)i;
    }
}

static void swap_sides(void *ctx, size_t begin, size_t end, int worker) {
    const struct partition *p = ctx;
    (void)worker;
    for (size_t k = begin; k < end; k++) {
        const struct split_point swap = p->points[p->left[k]];
        p->points[p->left[k]] = p->points[p->right[k]];
        p->points[p->right[k]] = swap;
    }
}

// Replaces the counts of the chunks by sums of those before them, from the left or from the right.
// Sets the sums of all.
static void sum_counts(struct partition *p, size_t chunks, size_t all[2]) {
    all[0] = all[1] = 0;
    for (size_t i = 0; i < chunks; i++) {
        const size_t at[2] = {i, chunks - 1 - i};
        for (int side = 0; side < 2; side++) {
            const size_t count = p->first[side][at[side]];
            p->first[side][at[side]] = all[side];
            all[side] += count;
        }
    }
}

// The number of swaps: of pairs of which the left point is not behind the right one.
static size_t count_swaps(const struct partition *p, const size_t all[2]) {
    size_t lo = 0, hi = all[0] < all[1] ? all[0] : all[1];
    while (lo < hi) {
        const size_t k = lo + (hi - lo) / 2;
        if (p->left[k] <= p->right[k])
            lo = k + 1;
        else
            hi = k;
    }
    return lo;
}

// One step of select_middle. False if the pool was cancelled.
static bool partition_step(struct partition *p, ptrdiff_t middle, struct parallel *pool) {
    const size_t chunks = (size_t)((p->range.hi - p->range.lo) / p->chunk + 1);
    size_t all[2];
    p->pivot = pivot_of(p->points, p->range);
    if (!parallel_for(pool, chunks, 1, count_sides, p)) return false;
    sum_counts(p, chunks, all);
    if (!parallel_for(pool, chunks, 1, list_sides, p)) return false;
    const size_t swaps = count_swaps(p, all);
    if (!parallel_for(pool, swaps, SPLIT_CHUNK, swap_sides, p)) return false;
    // There is a swap, of the pivot if no other. After the last one the search goes on from both
    // sides, up to the points that it has swapped.
    const ptrdiff_t left = p->left[swaps - 1], right = p->right[swaps - 1];
    ptrdiff_t i = left + 1, j = right - 1;
    if (i <= j) {
        i = swaps < all[0] && p->left[swaps] < right ? (ptrdiff_t)p->left[swaps] : right;
        j = swaps < all[1] && p->right[swaps] > left ? (ptrdiff_t)p->right[swaps] : left;
    }
    p->range = narrow(p->range, middle, i, j);
    return true;
}

bool median_split_parallel(struct split_point *points, size_t count, uint32_t *scratch,
                           struct parallel *pool) {
    const ptrdiff_t middle = (ptrdiff_t)(count / 2), most = (ptrdiff_t)(count / SPLIT_CHUNKS_MAX);
    struct partition p = {.points = points,
                          .range = {0, (ptrdiff_t)count - 1},
                          .chunk = most < SPLIT_CHUNK ? SPLIT_CHUNK : most + 1,
                          .left = scratch,
                          .right = scratch + count};
    const size_t chunks = (count - 1) / (size_t)p.chunk + 1;
    if (!parallel_for(pool, chunks, 1, bound_chunks, &p)) return false;
    vec3 lo = p.lo[0], hi = p.hi[0];
    for (size_t i = 1; i < chunks; i++) {
        lo = v3_min(lo, p.lo[i]);
        hi = v3_max(hi, p.hi[i]);
    }
    p.n = leaning_axis(v3_sub(hi, lo));
    if (!parallel_for(pool, count, SPLIT_CHUNK, set_keys, &p)) return false;
    while (p.range.hi - p.range.lo >= SPLIT_SERIAL)
        if (!partition_step(&p, middle, pool)) return false;
    select_middle(points, p.range, middle);
    return true;
}
