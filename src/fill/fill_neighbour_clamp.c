// SPDX-License-Identifier: Apache-2.0
// Neighbour clamping: no two radii differ by more than the distance of the records [K05 6.5.2]. So
// what one record has found, such as a step that the rays of others have missed, limits the others
// too.
#include "fill/fill_record.h"

// Only records whose normals differ by less than about 25 degrees limit each other.
static const float CLAMP_ALIKE = 0.9f;

// Records farther away than this fraction of R limit it through the records in between.
static const float CLAMP_NEIGHBOURS = 0.4f;

struct neighbours {
    struct cache_tree *tree;
    vec3 p, n;
    float R;
    bool lower;  // second pass: limits the neighbours
};

static void clamp_one(void *ctx, uint32_t record) {
    struct neighbours *s = ctx;
    struct cache_head *h = &s->tree->head[record];
    if (v3_dot(h->n, s->n) < CLAMP_ALIKE) return;
    float d = sqrtf(v3_dist2(h->p, s->p));
    if (s->lower)
        h->R = fminf(h->R, s->R + d);
    else
        s->R = fminf(s->R, h->R + d);
}

float fill_neighbour_clamp(struct cache_tree *tree, vec3 p, vec3 n, float R) {
    struct neighbours s = {tree, p, n, R, false};
    cache_tree_visit(tree, p, CLAMP_NEIGHBOURS * R, clamp_one, &s);
    s.lower = true;
    cache_tree_visit(tree, p, CLAMP_NEIGHBOURS * s.R, clamp_one, &s);
    return s.R;
}
