// SPDX-License-Identifier: Apache-2.0
// Clusters of densely stored photons: the photons of a fraction of all paths are split into leaves
// of equal numbers, and these are combined into a hierarchy of spheres that keeps leaves together
// which are bright and small. guide_cones.c traverses it.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/bytes.h"
#include "base/median_split.h"
#include "guide/guide_clusters.h"

enum {
    LEAF = 32,  // largest number of photons of a leaf
    BINS = 16,  // positions along an axis at which a node may be split
    // Work of one thread: the least number of photons and of runs, and a number of leaves. Larger
    // nodes are split depth by depth, with all nodes of a depth at once.
    RUN_PHOTONS = 2048,
    RUNS = 64,
    TASK_LEAVES = 128,
    FEW_RUNS = 2,  // up to so many runs are split by all threads together, more by one thread each
    CLUSTER_CHUNK = 4096
};

struct leaf {
    const struct split_point *point;
    size_t count;
    vec3 centre, normal;  // mean normal times power
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
    leaf.centre = v3_mul(v3_add(lo, hi), 0.5f);
    for (size_t i = 0; i < count; i++)
        leaf.radius = fmaxf(leaf.radius, v3_dist2(point[i].p, leaf.centre));
    leaf.radius = sqrtf(leaf.radius);
    return leaf;
}

// Splits the photons at the median into leaves of at least LEAF / 2 photons, and returns the number
// of leaves.
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

// Photons that one thread splits into leaves, and these leaves.
struct leaf_run {
    size_t begin, count;
    struct leaf *leaf;
    size_t leaves;
};

struct tree_building {
    const struct guide_photon *photon;
    struct split_point *point;
    uint32_t *scratch;  // for splits by all threads
    struct leaf_run *run;
    struct leaf *leaf;
    struct task *task;  // of the current depth
    struct guide_clusters *out;
};

static void set_points(void *ctx, size_t begin, size_t end, int worker) {
    const struct tree_building *b = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        b->point[i] = (struct split_point){.p = b->photon[i].p, .item = (uint32_t)i};
}

static void split_runs(void *ctx, size_t begin, size_t end, int worker) {
    const struct tree_building *b = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) median_split(b->point + b->run[i].begin, b->run[i].count);
}

// Splits each run at its median. False if the pool was cancelled.
static bool split_all_runs(struct tree_building *b, size_t runs, struct parallel *pool) {
    if (runs > FEW_RUNS) return parallel_for(pool, runs, 1, split_runs, b);
    bool whole = true;
    for (const struct leaf_run *run = b->run; run < b->run + runs && whole; run++)
        whole = median_split_parallel(b->point + run->begin, run->count, b->scratch, pool);
    return whole;
}

static void make_leaves_of_runs(void *ctx, size_t begin, size_t end, int worker) {
    const struct tree_building *b = ctx;
    (void)worker;
    for (struct leaf_run *run = b->run + begin; run < b->run + end; run++)
        run->leaves = make_leaves(b->photon, b->point + run->begin, run->count, run->leaf);
}

// The leaves of runs as bytes, with the order of their photons.
static void pack_runs(void *ctx, size_t begin, size_t end, struct bytes *out) {
    const struct tree_building *b = ctx;
    for (const struct leaf_run *run = b->run + begin; run < b->run + end; run++) {
        bytes_put_u64(out, run->leaves);
        bytes_put(out, run->leaf, run->leaves * sizeof *run->leaf);
        for (size_t i = run->begin; i < run->begin + run->count; i++)
            bytes_put(out, &b->point[i].item, sizeof b->point[i].item);
    }
}

static bool unpack_runs(void *ctx, size_t begin, size_t end, struct bytes_reader *in) {
    const struct tree_building *b = ctx;
    for (struct leaf_run *run = b->run + begin; run < b->run + end; run++) {
        const uint64_t leaves = bytes_get_u64(in);
        if (leaves > 2 * run->count / LEAF + 1) return false;
        run->leaves = (size_t)leaves;
        bytes_get(in, run->leaf, run->leaves * sizeof *run->leaf);
        struct split_point *point = b->point + run->begin;
        for (size_t i = 0; i < run->leaves; point += run->leaf[i++].count)
            run->leaf[i].point = point;
        for (size_t i = run->begin; i < run->begin + run->count; i++) {
            bytes_get(in, &b->point[i].item, sizeof b->point[i].item);
            b->point[i].p = b->photon[b->point[i].item].p;
        }
    }
    return true;
}

static const struct parallel_results runs_results = {.pack = pack_runs, .unpack = unpack_runs};

// make_leaves of all photons, on all threads. `b->leaf` has space for 2 count / LEAF + 1, and
// `b->run` for 2 count / RUN_PHOTONS + 1. Returns 0 if the pool was cancelled.
static size_t make_all_leaves(struct tree_building *b, size_t count, struct parallel *pool) {
    size_t runs = 1, leaves = 0;
    b->run[0] = (struct leaf_run){.count = count};
    bool whole = parallel_for(pool, count, CLUSTER_CHUNK, set_points, b);
    for (; whole && runs < RUNS && b->run[runs - 1].count > RUN_PHOTONS; runs *= 2) {
        whole = split_all_runs(b, runs, pool);
        for (size_t i = runs; i-- > 0;) {
            const struct leaf_run run = b->run[i];
            const size_t left = run.count / 2;
            b->run[2 * i] = (struct leaf_run){.begin = run.begin, .count = left};
            b->run[2 * i + 1] =
                (struct leaf_run){.begin = run.begin + left, .count = run.count - left};
        }
    }
    for (size_t i = 0; i < runs; i++) b->run[i].leaf = b->leaf + 2 * b->run[i].begin / LEAF;
    if (!whole || !parallel_for_results(pool, runs, 1, make_leaves_of_runs, b, &runs_results))
        return 0;
    for (size_t i = 0; i < runs; i++) {
        memmove(b->leaf + leaves, b->run[i].leaf, b->run[i].leaves * sizeof *b->leaf);
        leaves += b->run[i].leaves;
    }
    return leaves;
}

// ---- The hierarchy ----------------------------------------------------------------------------

// The sum of some leaves.
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

// Power times squared extent, which is low for leaves that are bright and small.
static float span_cost(const struct span *span) {
    return span->power > 0.0f ? span->power * v3_dist2(span->lo, span->hi) : 0.0f;
}

static int bin_of(const struct leaf *leaf, int axis, vec3 lo, vec3 hi) {
    float from = v3_along(lo, axis), to = v3_along(hi, axis);
    int bin =
        to > from ? (int)((float)BINS * (v3_along(leaf->centre, axis) - from) / (to - from)) : 0;
    return bin < BINS ? bin : BINS - 1;
}

// Splits the leaves where the sum of both costs is least. Returns the number on the first side.
static size_t split_leaves(struct leaf *leaf, size_t count) {
    struct span all = NO_SPAN;
    for (size_t i = 0; i < count; i++) span_add(&all, leaf[i].centre, leaf[i].centre, 0.0f);
    float best = INFINITY;
    int best_axis = -1, best_bin = 0;
    for (int axis = 0; axis < 3; axis++) {
        struct span bin[BINS], left[BINS], side = NO_SPAN;
        for (int b = 0; b < BINS; b++) bin[b] = NO_SPAN;
        for (size_t i = 0; i < count; i++) {
            const vec3 r = v3(leaf[i].radius, leaf[i].radius, leaf[i].radius);
            span_add(&bin[bin_of(&leaf[i], axis, all.lo, all.hi)], v3_sub(leaf[i].centre, r),
                     v3_add(leaf[i].centre, r), leaf[i].power);
        }
        for (int b = 0; b < BINS; b++) {
            span_add(&side, bin[b].lo, bin[b].hi, bin[b].power);
            left[b] = side;
        }
        side = NO_SPAN;
        for (int b = BINS - 1; b > 0; b--) {
            span_add(&side, bin[b].lo, bin[b].hi, bin[b].power);
            float cost = span_cost(&left[b - 1]) + span_cost(&side);
            if (!(side.power > 0.0f && left[b - 1].power > 0.0f && SPLIT_CLEARLY * cost < best))
                continue;
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
        span_add(&all, leaf[i].centre, leaf[i].centre, leaf[i].power);
        node->area += leaf[i].area;
        const float E = leaf[i].power / fmaxf(leaf[i].area, 1e-30f);
        node->dense = fmaxf(node->dense, E);
        node->common += leaf[i].power * E;
        node->normal = v3_add(node->normal, leaf[i].normal);
    }
    node->power = all.power;
    node->normal = v3_mul(node->normal, 1.0f / all.power);
    node->common /= all.power;
    node->centre = v3_mul(v3_add(all.lo, all.hi), 0.5f);
    for (size_t i = 0; i < count; i++)
        node->radius =
            fmaxf(node->radius, sqrtf(v3_dist2(leaf[i].centre, node->centre)) + leaf[i].radius);
}

// A node and its whole subtree: 2 count - 1 nodes from index `node` on.
struct task {
    size_t node;
    size_t leaf, count;
    size_t before;  // number of points of the leaves before
    size_t left;    // leaves of the first child, which is the next node; 0: the node is a leaf
};

static size_t count_points(const struct leaf *leaf, size_t count) {
    size_t points = 0;
    for (size_t i = 0; i < count; i++) points += leaf[i].count;
    return points;
}

// Makes the node without its subtree.
static void make_node(const struct tree_building *b, struct task *t) {
    struct guide_clusters *out = b->out;
    struct guide_cluster *node = &out->node[t->node];
    struct leaf *leaf = b->leaf + t->leaf;
    *node = (struct guide_cluster){.first = t->before, .count = count_points(leaf, t->count)};
    bound(leaf, t->count, node);
    t->left = t->count > 1 ? split_leaves(leaf, t->count) : 0;
    if (t->left)
        node->right = (int32_t)(t->node + 2 * t->left);
    else
        for (size_t i = 0; i < leaf->count; i++) out->position[t->before + i] = leaf->point[i].p;
}

static void children_of(const struct tree_building *b, const struct task *t, struct task child[2]) {
    child[0] = (struct task){t->node + 1, t->leaf, t->left, t->before, 0};
    child[1] = (struct task){t->node + 2 * t->left, t->leaf + t->left, t->count - t->left,
                             t->before + count_points(b->leaf + t->leaf, t->left), 0};
}

static void make_nodes(const struct tree_building *b, struct task *t) {
    make_node(b, t);
    if (!t->left) return;
    struct task child[2];
    children_of(b, t, child);
    make_nodes(b, &child[0]);
    make_nodes(b, &child[1]);
}

static void run_tasks(void *ctx, size_t begin, size_t end, int worker) {
    const struct tree_building *b = ctx;
    (void)worker;
    for (struct task *t = b->task + begin; t < b->task + end; t++)
        if (t->count > TASK_LEAVES)
            make_node(b, t);
        else
            make_nodes(b, t);
}

// Makes all nodes on all threads, large ones depth by depth, each in a run of the 2 leaves - 1
// tasks of `task`. False if the pool was cancelled.
static bool make_all_nodes(struct tree_building *b, struct task *task, size_t leaves,
                           struct parallel *pool) {
    size_t tasks = 1;
    b->task = task;
    b->task[0] = (struct task){.count = leaves};
    b->out->node_count = 2 * leaves - 1;
    while (tasks > 0) {
        if (!parallel_for(pool, tasks, 1, run_tasks, b)) return false;
        const struct task *done = b->task;
        struct task *next = b->task + tasks;
        size_t more = 0;
        for (size_t i = 0; i < tasks; i++) {
            if (done[i].count <= TASK_LEAVES) continue;
            children_of(b, &done[i], next + more);
            more += 2;
        }
        b->task = next;
        tasks = more;
    }
    return true;
}

// Makes the leaves and the nodes. SATIN_CANCELLED or SATIN_ERROR_MEMORY.
static satin_status make_tree(struct tree_building *b, size_t count, struct parallel *pool) {
    const size_t leaves = make_all_leaves(b, count, pool);
    if (leaves == 0) return SATIN_CANCELLED;
    b->out->node = array_new(2 * leaves, sizeof *b->out->node);
    b->out->position = array_new_unset(count, sizeof *b->out->position);
    struct task *task = array_new(2 * leaves, sizeof *task);
    satin_status status = SATIN_ERROR_MEMORY;
    if (b->out->node && b->out->position && task)
        status = make_all_nodes(b, task, leaves, pool) ? SATIN_OK : SATIN_CANCELLED;
    free(task);
    return status;
}

satin_status guide_clusters_build(const struct satin_scene *scene,
                                  const struct guide_photon *photon, size_t count,
                                  struct parallel *pool, struct log log,
                                  struct guide_clusters **out) {
    *out = NULL;
    if (count < 2 * LEAF) return SATIN_OK;
    struct guide_clusters *clusters = calloc(1, sizeof *clusters);
    struct tree_building b = {.photon = photon, .out = clusters};
    b.point = array_new_unset(count, sizeof *b.point);
    b.scratch = array_new_unset(2 * count, sizeof *b.scratch);
    b.leaf = array_new_unset(2 * count / LEAF + 1, sizeof *b.leaf);
    b.run = array_new(2 * count / RUN_PHOTONS + 2, sizeof *b.run);
    satin_status status = SATIN_ERROR_MEMORY;
    if (clusters && b.point && b.scratch && b.leaf && b.run) status = make_tree(&b, count, pool);
    free(b.run);
    free(b.leaf);
    free(b.scratch);
    free(b.point);
    if (status == SATIN_OK) {
        clusters->uniform = clusters->node->power / (4.0f * PI_F * sqrf(scene->radius));
        *out = clusters;
        return SATIN_OK;
    }
    guide_clusters_free(clusters);
    if (status == SATIN_CANCELLED) return status;
    return log_fail(log, status, "not enough memory for photon clusters");
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
