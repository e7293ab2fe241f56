// SPDX-License-Identifier: Apache-2.0
// Private to cache/: an octree over records' discs of influence. A record is referred to from every
// cell that its disc touches on one level, where cells are about half as wide as the disc, so a
// query walks one path down. Lengths are in scene units, directions unit and in world space.
// Queries may run on any number of threads while none inserts.
#ifndef CACHE_TREE_H
#define CACHE_TREE_H

#include <stddef.h>
#include <stdint.h>

#include "base/vec.h"

// What a query tests of a record, apart from its value; a row of the file of records.
struct cache_head {
    vec3 p;
    float R;          // clamped radius; at accuracy a the record serves within a R
    vec3 n;           // shading normal
    float influence;  // influence radius: the tree refers to the record within it; at least a R
                      // for every a in use
    vec3 squeeze;     // makes the disc an ellipse: d^2 counts as d^2 + (d . squeeze)^2; 0: a disc
    float scale;      // its own accuracy is this times a [K05 6.3], in (0, 1]
    vec3 u;           // tangent; sectors are counted from it, about n
    uint32_t walls;   // mask of the sectors in which something stands within the influence radius
    float clear;      // nothing stands nearer than this
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
    float weight;  // in (0, 1]
};

enum { CACHE_NEAR_MAX = 64 };

// An empty tree over the box from lo to hi. It owns its arrays.
void cache_tree_init(struct cache_tree *tree, vec3 lo, vec3 hi);
void cache_tree_free(struct cache_tree *tree);  // leaves all zeros, which may be freed again
// Appends a record, whose number is the count before; false without memory (then the tree is
// unchanged but for its capacity).
bool cache_tree_insert(struct cache_tree *tree, const struct cache_head *head);
// A record's error at (p, n): d / R + sqrt(1 - n . n_i) [K05 (2.3)].
float cache_tree_error(const struct cache_head *head, vec3 p, vec3 n);
// The set S at (p, n): records with an error below a times their scale that do not lie in front of
// p. At most CACHE_NEAR_MAX, in a fixed order. Returns how many. A record's weight falls to 0 where
// it leaves S.
int cache_tree_find(const struct cache_tree *tree, vec3 p, vec3 n, float a,
                    struct cache_near near[CACHE_NEAR_MAX]);
// The record nearest to p on a surface that faces alike, at most `radius` away; -1: none. For
// slivers between pixels that the fill has missed.
int64_t cache_tree_nearest(const struct cache_tree *tree, vec3 p, vec3 n, float radius);
// Whether S is not empty.
bool cache_tree_covered(const struct cache_tree *tree, vec3 p, vec3 n, float a);
// Calls fn for every record whose cells meet the ball (p, radius), for some more than once. fn may
// change the heads.
void cache_tree_visit(const struct cache_tree *tree, vec3 p, float radius,
                      void (*fn)(void *ctx, uint32_t record), void *ctx);

#endif
