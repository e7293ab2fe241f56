// SPDX-License-Identifier: Apache-2.0
// The octree of records [Ward 1988]. Deviation: all cells that a record touches refer to it, so
// that a query need not search the neighbours of its cell.
#include "cache/cache_tree.h"

#include <stdlib.h>

#include "base/array.h"

enum { DEPTH_MAX = 24 };

// A record in front of a point is not used there, because it may receive light that the point does
// not [Ward 1988]. This fraction of the record's radius is tolerated, for curved surfaces and
// rounding.
static const float FRONT_SLACK = 0.05f;

// A record is not used at points farther from its tangent plane than this fraction of a R: normals
// in S differ by less than arccos(1 - a^2), and a surface whose normal changes by that much at a =
// .5 rises by .35 of the distance.
static const float SLAB = 0.4f;

// Where no record is accurate enough, the nearest one may be used if the cosine between the normals
// is above this.
static const float NEAREST_ALIKE = 0.9f;

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

// The child of the cell (lo, size) that contains p. Sets lo and size to those of the child.
static int descend(vec3 p, vec3 *lo, float *size) {
    *size *= 0.5f;
    int octant = 0;
    if (p.x >= lo->x + *size) octant |= 1, lo->x += *size;
    if (p.y >= lo->y + *size) octant |= 2, lo->y += *size;
    if (p.z >= lo->z + *size) octant |= 4, lo->z += *size;
    return octant;
}

// The depth of the level whose cells are between half as wide and as wide as the search radius.
static int depth_of(const struct cache_tree *tree, float radius) {
    int depth = 0;
    for (float size = tree->size * 0.5f; size >= 0.5f * radius && depth < DEPTH_MAX; size *= 0.5f)
        depth++;
    return depth;
}

static void add_reference(struct cache_tree *tree, vec3 centre, int depth, uint32_t record) {
    vec3 lo = tree->lo;
    float size = tree->size;
    uint32_t at = 0;
    for (int i = 0; i < depth; i++) {
        int octant = descend(centre, &lo, &size);
        uint32_t next = tree->node[at].child[octant];
        if (!next) {
            next = node_new(tree);
            tree->node[at].child[octant] = next;
        }
        at = next;
    }
    tree->ref[tree->ref_count] = (struct cache_ref){record, tree->node[at].first};
    tree->node[at].first = (uint32_t)++tree->ref_count;
}

// Whether the record may be used at a point of the cell: whether both the sphere of its search
// radius and the slab around its tangent plane intersect the cell.
static bool cell_meets(const struct cache_head *h, vec3 centre, float size) {
    vec3 d = v3_sub(centre, h->p);
    float half = 0.5f * size;
    float dx = fmaxf(fabsf(d.x) - half, 0.0f), dy = fmaxf(fabsf(d.y) - half, 0.0f),
          dz = fmaxf(fabsf(d.z) - half, 0.0f);
    if (dx * dx + dy * dy + dz * dz >= h->search_radius * h->search_radius) return false;
    float extent = half * (fabsf(h->n.x) + fabsf(h->n.y) + fabsf(h->n.z));
    return fabsf(v3_dot(d, h->n)) <= SLAB * h->search_radius + extent;
}

// Lets all cells that record number `record` touches refer to it. False if there is no memory.
static bool refer_to(struct cache_tree *tree, uint32_t record) {
    const struct cache_head *head = &tree->head[record];
    int depth = depth_of(tree, head->search_radius);
    float size = ldexpf(tree->size, -depth);
    // The cells of that level, numbered from the root's corner, that intersect the sphere's box.
    const float p[3] = {head->p.x - tree->lo.x, head->p.y - tree->lo.y, head->p.z - tree->lo.z};
    const int most = 1 << depth;
    int first[3], last[3];
    for (int k = 0; k < 3; k++) {
        first[k] = (int)fmaxf(floorf((p[k] - head->search_radius) / size), 0.0f);
        last[k] = (int)fminf(floorf((p[k] + head->search_radius) / size), (float)(most - 1));
    }
    enum { SPAN = 6 };  // 2 search_radius / size <= 4 except at the root, and a cell on either side
    if (!array_reserve((void **)&tree->node, &tree->node_capacity,
                       tree->node_count + SPAN * SPAN * SPAN * (size_t)(depth + 1) + 1,
                       sizeof *tree->node) ||
        !array_reserve((void **)&tree->ref, &tree->ref_capacity,
                       tree->ref_count + SPAN * SPAN * SPAN, sizeof *tree->ref))
        return false;
    if (tree->node_count == 0) node_new(tree);
    for (int z = first[2]; z <= last[2]; z++)
        for (int y = first[1]; y <= last[1]; y++)
            for (int x = first[0]; x <= last[0]; x++) {
                vec3 centre = v3_mul(v3((float)x + 0.5f, (float)y + 0.5f, (float)z + 0.5f), size);
                centre = v3_add(tree->lo, centre);
                if (cell_meets(head, centre, size)) add_reference(tree, centre, depth, record);
            }
    return true;
}

bool cache_tree_insert(struct cache_tree *tree, const struct cache_head *head) {
    if (!array_reserve((void **)&tree->head, &tree->head_capacity, tree->head_count + 1,
                       sizeof *tree->head))
        return false;
    tree->head[tree->head_count] = *head;
    if (!refer_to(tree, (uint32_t)tree->head_count)) return false;
    tree->head_count++;
    return true;
}

// Lowers a record's search radius, and expresses its sectors by the new one.
static void limit_search(struct cache_head *head, float radius) {
    if (!(radius < head->search_radius)) return;
    const float scale = head->search_radius / radius;
    for (int i = 0; i < CACHE_SECTORS; i++)
        head->sector[i] = (uint8_t)fminf(scale * head->sector[i], UINT8_MAX);
    head->search_radius = radius;
}

bool cache_tree_limit(struct cache_tree *tree, float a) {
    tree->node_count = tree->ref_count = 0;
    for (size_t i = 0; i < tree->head_count; i++) {
        limit_search(&tree->head[i], a * tree->head[i].R);
        if (!refer_to(tree, (uint32_t)i)) return false;
    }
    return true;
}

static float distance(const struct cache_head *h, vec3 d) {
    float across = v3_dot(d, h->anisotropy);
    return sqrtf(v3_len2(d) + across * across);
}

float cache_tree_error(const struct cache_head *h, vec3 p, vec3 n) {
    return distance(h, v3_sub(p, h->p)) / h->R + safe_sqrtf(1.0f - v3_dot(n, h->n));
}

float cache_tree_weight(const struct cache_head *h, vec3 p, vec3 n, float a) {
    vec3 d = v3_sub(p, h->p);
    float own = a * h->scale, limit = own * h->R;
    if (v3_len2(d) >= limit * limit) return 0.0f;
    float error = distance(h, d) / h->R + safe_sqrtf(1.0f - v3_dot(n, h->n));
    if (error >= own) return 0.0f;
    if (fabsf(v3_dot(d, h->n)) > SLAB * limit) return 0.0f;
    if (v3_dot(d, v3_add(n, h->n)) < -2.0f * FRONT_SLACK * h->R * own) return 0.0f;
    return 1.0f - error / own;
}

// The weight of a record that the tree finds, which ends at its search radius at the latest.
static float found_weight(const struct cache_head *h, vec3 p, vec3 n, float a) {
    const float R = h->scale * h->R;
    return cache_tree_weight(h, p, n, a * R > h->search_radius ? h->search_radius / R : a);
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
            float w = found_weight(&tree->head[record], p, n, a);
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
            if (found_weight(&tree->head[tree->ref[i - 1].record], p, n, a) > 0.0f) return true;
        at = tree->node[at].child[descend(p, &lo, &size)];
    } while (at);
    return false;
}

static bool cell_meets_ball(vec3 lo, float size, vec3 p, float radius) {
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
            if (cell_meets_ball(lo, half, p, radius))
                stack[top++] = (struct visit){node->child[octant], lo, half};
        }
    }
}

struct nearest {
    const struct cache_tree *tree;
    vec3 p, n;
    float radius, distance2;
    int64_t record;
};

static void compare_one(void *ctx, uint32_t record) {
    struct nearest *s = ctx;
    const struct cache_head *h = &s->tree->head[record];
    vec3 d = v3_sub(s->p, h->p);
    float d2 = v3_len2(d);
    bool nearer = d2 < s->distance2 || (d2 == s->distance2 && record < s->record);
    if (!nearer || v3_dot(h->n, s->n) < NEAREST_ALIKE) return;
    if (fabsf(v3_dot(d, h->n)) > SLAB * s->radius) return;
    s->distance2 = d2;
    s->record = record;
}

int64_t cache_tree_nearest(const struct cache_tree *tree, vec3 p, vec3 n, float radius) {
    struct nearest s = {tree, p, n, radius, radius * radius, -1};
    cache_tree_visit(tree, p, radius, compare_one, &s);
    return s.record;
}
