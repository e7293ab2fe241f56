// SPDX-License-Identifier: Apache-2.0
// An octree over discs around records, for the folders that read and make them. A record is
// referred to by every cell that its disc, of its search radius, touches on one level, where cells
// are about half as wide as the disc, so a query descends a single path. Lengths are in scene
// units, directions are unit vectors in world space. Any number of threads may query while none
// inserts.
#ifndef CACHE_TREE_H
#define CACHE_TREE_H

#include <stddef.h>
#include <stdint.h>

#include "base/vec.h"

// The equal angles into which the directions around a record's normal are divided.
enum { CACHE_SECTORS = 32 };

// The data of a record that a query tests, without its value; a row of the file of records.
struct cache_head {
    vec3 p;
    float R;              // radius, as clamped; at accuracy a the record is used within a R, its
                          // influence radius
    vec3 n;               // shading normal
    float search_radius;  // the tree finds the record within it, and it is not used beyond: a R at
                          // the largest a in use
    vec3 anisotropy;  // makes the disc an ellipse: d^2 becomes d^2 + (d . anisotropy)^2; 0: a disc
    float scale;      // its own accuracy is this times a [K05 6.3], in (0, 1]
    vec3 u;           // tangent from which sectors are counted, about n
    float clear;      // no surface is nearer than this
    // For each sector, 255ths of the search radius up to which the record serves points; those
    // beyond are close to a surface. 255: there is none within it.
    uint8_t sector[CACHE_SECTORS];
};

struct cache_node {
    uint32_t child[8];  // 0: none
    uint32_t first;     // index of the first reference + 1; 0: none
};

struct cache_ref {
    uint32_t record, next;  // index of the next reference + 1; 0: end
};

struct cache_tree {
    vec3 lo;
    float size;  // edge length of the root cube
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

// Makes an empty tree over the box from lo to hi, which owns its arrays.
void cache_tree_init(struct cache_tree *tree, vec3 lo, vec3 hi);
void cache_tree_free(struct cache_tree *tree);  // leaves all members zero, which may be freed again
// Appends a record, whose index is the count before. False if there is no memory; then only the
// capacity of the tree has changed.
bool cache_tree_insert(struct cache_tree *tree, const struct cache_head *head);
// Lowers the search radii to a R, so that queries at accuracies up to a find the same and take less
// time. False if there is no memory: then the tree may only be freed.
bool cache_tree_limit(struct cache_tree *tree, float a);
// The error of a record at (p, n): d / R + sqrt(1 - n . n_i) [K05 (2.3)].
float cache_tree_error(const struct cache_head *head, vec3 p, vec3 n);
// The weight of a record at (p, n) [K05 (2.3)], in [0, 1], 0 if it is not in S. Deviation: 1 -
// error / a instead of 1 / error, so that it decreases to 0 where the record leaves S.
float cache_tree_weight(const struct cache_head *head, vec3 p, vec3 n, float a);
// The set S at (p, n): records with an error below a times their scale that are not in front of p.
// Finds at most CACHE_NEAR_MAX, in a fixed order, and returns their number. The weight of a record
// decreases to 0 where it leaves S.
int cache_tree_find(const struct cache_tree *tree, vec3 p, vec3 n, float a,
                    struct cache_near near[CACHE_NEAR_MAX]);
// The record nearest to p on a surface of the same orientation, at most `radius` away; -1: none.
// For slivers between pixels in which no record was made.
int64_t cache_tree_nearest(const struct cache_tree *tree, vec3 p, vec3 n, float radius);
// Whether S is not empty.
bool cache_tree_covered(const struct cache_tree *tree, vec3 p, vec3 n, float a);
// Calls fn for every record whose cells intersect the ball (p, radius), for some more than once. fn
// may change the heads.
void cache_tree_visit(const struct cache_tree *tree, vec3 p, float radius,
                      void (*fn)(void *ctx, uint32_t record), void *ctx);

#endif
