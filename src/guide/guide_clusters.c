// SPDX-License-Identifier: Apache-2.0
// Places where light comes down densely: photons of a fraction of all paths are split into leaves
// of equal numbers, and these are gathered into a hierarchy of spheres that keeps what is bright
// and small together. guide_cones.c looks at it.
#include <stdlib.h>

#include "base/array.h"
#include "base/median_split.h"
#include "guide/guide_clusters.h"

enum {
    LEAF = 32,  // photons of a leaf
    BINS = 16   // positions where a node may be split along an axis
};
#define CLEARLY 1.001f  // more than rounding

struct leaf {
    const struct split_point *point;
    size_t count;
    vec3 center, normal;  // mean normal times power
    float radius, power, area;
};

// ---- Leaves -----------------------------------------------------------------------------------

static struct leaf make_leaf(const struct guide_photon *photon, const struct split_point *point,
                             size_t count) {
    struct leaf leaf = {.point = point, .count = count};
    vec3 lo = point->p, hi = lo;
    for (size_t i = 0; i < count; i++) {
        const struct guide_photon *h = &photon[point[i].item];
        leaf.power += h->power;
        leaf.normal = v3_mad(leaf.normal, h->power, h->n);
        lo = v3_min(lo, point[i].p);
        hi = v3_max(hi, point[i].p);
    }
    const vec3 d = v3_sub(hi, lo);
    leaf.area = fmaxf(d.x * d.y, fmaxf(d.y * d.z, d.z * d.x));
    leaf.center = v3_mul(v3_add(lo, hi), 0.5f);
    for (size_t i = 0; i < count; i++)
        leaf.radius = fmaxf(leaf.radius, v3_dist2(point[i].p, leaf.center));
    leaf.radius = sqrtf(leaf.radius);
    return leaf;
}

// Splits the photons at the median until leaves are left; returns how many.
static size_t make_leaves(const struct guide_photon *photon, struct split_point *point,
                          size_t count, struct leaf *out) {
    if (count <= LEAF) {
        *out = make_leaf(photon, point, count);
        return 1;
    }
    median_split(point, count);
    const size_t left = count / 2, leaves = make_leaves(photon, point, left, out);
    return leaves + make_leaves(photon, point + left, count - left, out + leaves);
}

// ---- The hierarchy ----------------------------------------------------------------------------

// What some of the leaves are together.
struct span {
    vec3 lo, hi;
    float power;
};
static const struct span NO_SPAN = {
    {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0.0f};

static void span_add(struct span *span, vec3 lo, vec3 hi, float power) {
    span->lo = v3_min(span->lo, lo);
    span->hi = v3_max(span->hi, hi);
    span->power += power;
}

// Power times the square of the extent: low for leaves that are bright and small.
static float span_cost(const struct span *span) {
    return span->power > 0.0f ? span->power * v3_dist2(span->lo, span->hi) : 0.0f;
}

static int bin_of(const struct leaf *leaf, int axis, vec3 lo, vec3 hi) {
    float from = v3_along(lo, axis), to = v3_along(hi, axis);
    int bin =
        to > from ? (int)((float)BINS * (v3_along(leaf->center, axis) - from) / (to - from)) : 0;
    return bin < BINS ? bin : BINS - 1;
}

// Splits the leaves where the cost of both sides is least; returns how many are on the first side.
static size_t split_leaves(struct leaf *leaf, size_t count) {
    struct span all = NO_SPAN;
    for (size_t i = 0; i < count; i++) span_add(&all, leaf[i].center, leaf[i].center, 0.0f);
    float best = INFINITY;
    int best_axis = -1, best_bin = 0;
    for (int axis = 0; axis < 3; axis++) {
        struct span bin[BINS], left[BINS], side = NO_SPAN;
        for (int b = 0; b < BINS; b++) bin[b] = NO_SPAN;
        for (size_t i = 0; i < count; i++) {
            const vec3 r = v3(leaf[i].radius, leaf[i].radius, leaf[i].radius);
            span_add(&bin[bin_of(&leaf[i], axis, all.lo, all.hi)], v3_sub(leaf[i].center, r),
                     v3_add(leaf[i].center, r), leaf[i].power);
        }
        for (int b = 0; b < BINS; b++) {
            span_add(&side, bin[b].lo, bin[b].hi, bin[b].power);
            left[b] = side;
        }
        side = NO_SPAN;
        for (int b = BINS - 1; b > 0; b--) {
            span_add(&side, bin[b].lo, bin[b].hi, bin[b].power);
            float cost = span_cost(&left[b - 1]) + span_cost(&side);
            if (!(side.power > 0.0f && left[b - 1].power > 0.0f && CLEARLY * cost < best)) continue;
            best = cost;
            best_axis = axis;
            best_bin = b;
        }
    }
    if (best_axis < 0) return count / 2;
    size_t first = 0;
    for (size_t i = 0; i < count; i++) {
        if (bin_of(&leaf[i], best_axis, all.lo, all.hi) >= best_bin) continue;
        struct leaf swap = leaf[i];
        leaf[i] = leaf[first];
        leaf[first++] = swap;
    }
    return first > 0 && first < count ? first : count / 2;
}

static void bound(const struct leaf *leaf, size_t count, struct guide_cluster *node) {
    struct span all = NO_SPAN;
    for (size_t i = 0; i < count; i++) {
        span_add(&all, leaf[i].center, leaf[i].center, leaf[i].power);
        node->area += leaf[i].area;
        const float E = leaf[i].power / fmaxf(leaf[i].area, 1e-30f);
        node->dense = fmaxf(node->dense, E);
        node->common += leaf[i].power * E;
        node->normal = v3_add(node->normal, leaf[i].normal);
    }
    node->power = all.power;
    node->normal = v3_mul(node->normal, 1.0f / all.power);
    node->common /= all.power;
    node->center = v3_mul(v3_add(all.lo, all.hi), 0.5f);
    for (size_t i = 0; i < count; i++)
        node->radius =
            fmaxf(node->radius, sqrtf(v3_dist2(leaf[i].center, node->center)) + leaf[i].radius);
}

// Appends the nodes of some leaves, whose positions go beside them.
static void add_nodes(struct guide_clusters *out, struct leaf *leaf, size_t count, size_t *placed) {
    struct guide_cluster *node = &out->node[out->node_count++];
    *node = (struct guide_cluster){.first = *placed};
    bound(leaf, count, node);
    if (count == 1) {
        for (size_t i = 0; i < leaf->count; i++) out->position[(*placed)++] = leaf->point[i].p;
    } else {
        size_t left = split_leaves(leaf, count);
        add_nodes(out, leaf, left, placed);
        node->right = (int32_t)out->node_count;
        add_nodes(out, leaf + left, count - left, placed);
    }
    node->count = *placed - node->first;
}

satin_status guide_clusters_build(const struct satin_scene *scene,
                                  const struct guide_photon *photon, size_t count, struct log log,
                                  struct guide_clusters **out) {
    *out = NULL;
    if (count < 2 * LEAF) return SATIN_OK;
    struct guide_clusters *clusters = calloc(1, sizeof *clusters);
    struct split_point *point = array_new(count, sizeof *point);
    struct leaf *leaf = array_new(2 * count / LEAF + 1, sizeof *leaf);
    if (clusters && point && leaf) {
        for (size_t i = 0; i < count; i++)
            point[i] = (struct split_point){.p = photon[i].p, .item = (uint32_t)i};
        const size_t leaves = make_leaves(photon, point, count, leaf);
        clusters->node = array_new(2 * leaves, sizeof *clusters->node);
        clusters->position = array_new(count, sizeof *clusters->position);
        if (clusters->node && clusters->position) {
            size_t placed = 0;
            add_nodes(clusters, leaf, leaves, &placed);
            clusters->spread = clusters->node->power / (4.0f * PI_F * sqrf(scene->radius));
            *out = clusters;
        }
    }
    free(leaf);
    free(point);
    if (*out) return SATIN_OK;
    guide_clusters_free(clusters);
    return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for photon clusters");
}

void guide_clusters_free(struct guide_clusters *clusters) {
    if (!clusters) return;
    free(clusters->node);
    free(clusters->position);
    free(clusters);
}

size_t guide_clusters_bytes(const struct guide_clusters *clusters) {
    if (!clusters) return 0;
    const struct guide_cluster *root = clusters->node;
    return clusters->node_count * sizeof *root + root->count * sizeof *clusters->position;
}
