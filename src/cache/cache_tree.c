// SPDX-License-Identifier: Apache-2.0
// The octree of records [Ward 1988], multiple references in place of a search of neighbouring
// cells.
#include "cache/cache_tree.h"

#include <stdlib.h>

#include "base/array.h"

enum { DEPTH_MAX = 24 };

// A record is not used at points that lie in front of it by more than this share of R: there it may
// be hidden from what the point sees [Ward 1988]. The slack lets curved surfaces and rounding pass.
static const float FRONT_SLACK = 0.05f;

void cache_tree_init(struct cache_tree *tree, vec3 lo, vec3 hi) {
    *tree = (struct cache_tree){0};
    vec3 extent = v3_sub(hi, lo);
    tree->size = fmaxf(v3_max_abs(extent) * 1.01f, 1e-30f);
    vec3 centre = v3_mul(v3_add(lo, hi), 0.5f);
    tree->lo = v3_sub(centre, v3(tree->size * 0.5f, tree->size * 0.5f, tree->size * 0.5f));
}

void cache_tree_free(struct cache_tree *tree) {
    free(tree->head);
    free(tree->node);
    free(tree->ref);
    *tree = (struct cache_tree){0};
}

static uint32_t node_new(struct cache_tree *tree) {
    struct cache_node *node = &tree->node[tree->node_count];
    *node = (struct cache_node){.first = 0};
    return (uint32_t)tree->node_count++;
}

// The child of the cell (lo, size) that holds p; moves lo and halves size to it.
static int descend(vec3 p, vec3 *lo, float *size) {
    *size *= 0.5f;
    int octant = 0;
    if (p.x >= lo->x + *size) octant |= 1, lo->x += *size;
    if (p.y >= lo->y + *size) octant |= 2, lo->y += *size;
    if (p.z >= lo->z + *size) octant |= 4, lo->z += *size;
    return octant;
}

// Depth of the level whose cells are at least twice as wide as `reach`.
static int level_of(const struct cache_tree *tree, float reach) {
    int depth = 0;
    for (float size = tree->size * 0.5f; size >= 2.0f * reach && depth < DEPTH_MAX; size *= 0.5f)
        depth++;
    return depth;
}

static void add_reference(struct cache_tree *tree, vec3 corner, int depth, uint32_t record) {
    vec3 lo = tree->lo;
    float size = tree->size;
    uint32_t at = 0;
    for (int i = 0; i < depth; i++) {
        int octant = descend(corner, &lo, &size);
        uint32_t next = tree->node[at].child[octant];
        if (!next) {
            next = node_new(tree);
            tree->node[at].child[octant] = next;
        }
        at = next;
    }
    // Corners that fall into one cell refer to it once.
    if (tree->node[at].first && tree->ref[tree->node[at].first - 1].record == record) return;
    tree->ref[tree->ref_count] = (struct cache_ref){record, tree->node[at].first};
    tree->node[at].first = (uint32_t)++tree->ref_count;
}

bool cache_tree_insert(struct cache_tree *tree, const struct cache_head *head) {
    if (!array_reserve((void **)&tree->head, &tree->head_capacity, tree->head_count + 1,
                       sizeof *tree->head) ||
        !array_reserve((void **)&tree->node, &tree->node_capacity,
                       tree->node_count + 8 * DEPTH_MAX + 1, sizeof *tree->node) ||
        !array_reserve((void **)&tree->ref, &tree->ref_capacity, tree->ref_count + 8,
                       sizeof *tree->ref))
        return false;
    if (tree->node_count == 0) node_new(tree);
    uint32_t record = (uint32_t)tree->head_count;
    tree->head[tree->head_count++] = *head;
    int depth = level_of(tree, head->reach);
    float r = head->reach;
    for (int corner = 0; corner < 8; corner++) {
        vec3 q = v3_add(head->p, v3(corner & 1 ? r : -r, corner & 2 ? r : -r, corner & 4 ? r : -r));
        add_reference(tree, q, depth, record);
    }
    return true;
}

// The record's weight at (p, n), 0 if it is not in S.
static float weight_at(const struct cache_head *h, vec3 p, vec3 n, float a) {
    vec3 d = v3_sub(p, h->p);
    float d2 = v3_len2(d), limit = a * h->R;
    if (d2 >= limit * limit) return 0.0f;
    float error = sqrtf(d2) / h->R + safe_sqrtf(1.0f - v3_dot(n, h->n));
    if (error >= a) return 0.0f;
    if (v3_dot(d, v3_add(n, h->n)) < -2.0f * FRONT_SLACK * h->R * a) return 0.0f;
    return 1.0f - error / a;
}

int cache_tree_find(const struct cache_tree *tree, vec3 p, vec3 n, float a,
                    struct cache_near near[CACHE_NEAR_MAX]) {
    if (tree->node_count == 0) return 0;
    vec3 lo = tree->lo;
    float size = tree->size;
    uint32_t at = 0;
    int count = 0;
    do {
        for (uint32_t i = tree->node[at].first; i; i = tree->ref[i - 1].next) {
            uint32_t record = tree->ref[i - 1].record;
            float w = weight_at(&tree->head[record], p, n, a);
            if (w > 0.0f && count < CACHE_NEAR_MAX) near[count++] = (struct cache_near){record, w};
        }
        at = tree->node[at].child[descend(p, &lo, &size)];
    } while (at);
    return count;
}

bool cache_tree_covered(const struct cache_tree *tree, vec3 p, vec3 n, float a) {
    if (tree->node_count == 0) return false;
    vec3 lo = tree->lo;
    float size = tree->size;
    uint32_t at = 0;
    do {
        for (uint32_t i = tree->node[at].first; i; i = tree->ref[i - 1].next)
            if (weight_at(&tree->head[tree->ref[i - 1].record], p, n, a) > 0.0f) return true;
        at = tree->node[at].child[descend(p, &lo, &size)];
    } while (at);
    return false;
}

static bool meets(vec3 lo, float size, vec3 p, float radius) {
    float dx = fmaxf(fmaxf(lo.x - p.x, p.x - lo.x - size), 0.0f);
    float dy = fmaxf(fmaxf(lo.y - p.y, p.y - lo.y - size), 0.0f);
    float dz = fmaxf(fmaxf(lo.z - p.z, p.z - lo.z - size), 0.0f);
    return dx * dx + dy * dy + dz * dz <= radius * radius;
}

void cache_tree_visit(const struct cache_tree *tree, vec3 p, float radius,
                      void (*fn)(void *ctx, uint32_t record), void *ctx) {
    struct visit {
        uint32_t node;
        vec3 lo;
        float size;
    } stack[8 * DEPTH_MAX + 1];
    if (tree->node_count == 0) return;
    int top = 0;
    stack[top++] = (struct visit){0, tree->lo, tree->size};
    while (top > 0) {
        struct visit v = stack[--top];
        const struct cache_node *node = &tree->node[v.node];
        for (uint32_t i = node->first; i; i = tree->ref[i - 1].next)
            fn(ctx, tree->ref[i - 1].record);
        float half = v.size * 0.5f;
        for (int octant = 0; octant < 8; octant++) {
            if (!node->child[octant]) continue;
            vec3 lo = v3_add(v.lo, v3(octant & 1 ? half : 0.0f, octant & 2 ? half : 0.0f,
                                      octant & 4 ? half : 0.0f));
            if (meets(lo, half, p, radius))
                stack[top++] = (struct visit){node->child[octant], lo, half};
        }
    }
}
