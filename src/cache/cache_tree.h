// SPDX-License-Identifier: Apache-2.0
// Private to cache/: an octree over records' discs of influence. A record is referred to from every
// cell that its disc touches on one level, where cells are about half as wide as the disc, so a
// query walks one path down.
#ifndef CACHE_TREE_H
#define CACHE_TREE_H

#include <stddef.h>
#include <stdint.h>

#include "base/vec.h"

// What a query tests of a record, apart from its value.
struct cache_head {
    vec3 p;
    float R;  // clamped; influence at accuracy a reaches a R
    vec3 n;
    float reach;     // radius at which the tree refers to it, >= a R for every a in use
    vec3 squeeze;    // an elliptic record is nearer by this: d^2 counts as d^2 + (d . squeeze)^2
    float scale;     // its own accuracy is this times a [K05 6.3], in (0, 1]
    vec3 u;          // azimuth 0 of
    uint32_t walls;  // the sectors, from bit 0, where something stands within reach,
    float clear;     // none of it nearer than this
};

struct cache_node {
    uint32_t child[8];  // 0: none
    uint32_t first;     // reference + 1, 0: none
};

struct cache_ref {
    uint32_t record, next;  // next reference + 1, 0: end
};

struct cache_tree {
    vec3 lo;
    float size;  // edge of the root cube
    struct cache_head *head;
    size_t head_count, head_capacity;
    struct cache_node *node;
    size_t node_count, node_capacity;
    struct cache_ref *ref;
    size_t ref_count, ref_capacity;
};

// A record that may be used at a point.
struct cache_near {
    uint32_t record;
    float weight;
};

enum { CACHE_NEAR_MAX = 64 };

void cache_tree_init(struct cache_tree *tree, vec3 lo, vec3 hi);
void cache_tree_free(struct cache_tree *tree);
// Appends a record; false without memory (then the tree is unchanged but for its capacity).
bool cache_tree_insert(struct cache_tree *tree, const struct cache_head *head);
// A record's error at (p, n): d / R + sqrt(1 - n . n_i).
float cache_tree_error(const struct cache_head *head, vec3 p, vec3 n);
// The set S at (p, n): records with an error below a times their scale that do not lie behind p.
// At most CACHE_NEAR_MAX, in a fixed order. Weights are positive and reach 0 where a record drops
// out.
int cache_tree_find(const struct cache_tree *tree, vec3 p, vec3 n, float a,
                    struct cache_near near[CACHE_NEAR_MAX]);
// The record nearest to p on a surface of like facing, at most `reach` away; -1: none. Where
// slivers between pixels have been missed by the fill, it is better than none.
int64_t cache_tree_nearest(const struct cache_tree *tree, vec3 p, vec3 n, float reach);
// Whether S is not empty.
bool cache_tree_covered(const struct cache_tree *tree, vec3 p, vec3 n, float a);
// Calls fn for every record whose sphere's cells meet the ball (p, radius), some more than once.
void cache_tree_visit(const struct cache_tree *tree, vec3 p, float radius,
                      void (*fn)(void *ctx, uint32_t record), void *ctx);

#endif
