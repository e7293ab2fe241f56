// SPDX-License-Identifier: Apache-2.0
// The photons whose own discs cover a point (photon_radii.c), by a hierarchy of boxes around the
// discs: the nodes of the map's index, in which a search goes on behind all nodes below one whose
// box is elsewhere, and needs no stack. If photons counted only where they are among the k nearest
// ones, those of wide discs would be left out in the denser light beside them, and light from lamps
// behind glass would be 1.3 % too dark (docs/experiments/caustics.md).
#include "photon/photon_cover.h"

#include <math.h>

#include "base/array.h"
#include "photon/photon_own_area.h"

enum {
    COVER_CHUNK = 1024,  // nodes of a chunk
    // Photons that are estimated together, neighbours in Morton order: the nodes and the photons
    // around them are read once.
    COVER_TOGETHER = 8
};

// ---- Boxes --------------------------------------------------------------------------------------

struct cover_loop {
    const struct photon_map *map;
    struct photon_cover *cover;
};

static void cover_leaf(const struct photon_map *map, const struct photon_index_node *leaf,
                       struct photon_cover *out) {
    for (int k = 0; k < 3; k++) {
        out->lo[k] = INFINITY;
        out->hi[k] = -INFINITY;
    }
    for (int i = leaf->begin; i < leaf->end; i++) {
        const size_t at = (size_t)map->index->row[i];
        const float r = sqrtf(map->radius2[at]);
        for (int k = 0; k < 3; k++) {
            out->lo[k] = fminf(out->lo[k], map->position[3 * at + (size_t)k] - r);
            out->hi[k] = fmaxf(out->hi[k], map->position[3 * at + (size_t)k] + r);
        }
    }
}

static void cover_leaves(void *ctx, size_t begin, size_t end, int worker) {
    const struct cover_loop *loop = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const struct photon_index_node *node = &loop->map->index->node[i];
        if (node->column < 0) cover_leaf(loop->map, node, &loop->cover[i]);
        loop->cover[i].end = (uint32_t)i + 1;
    }
}

// Children come after their parents, so they are known when these are joined.
static void cover_parents(const struct photon_index *index, struct photon_cover *cover) {
    for (size_t i = index->nodes; i-- > 0;) {
        if (index->node[i].column < 0) continue;
        const struct photon_cover *a = &cover[i + 1], *b = &cover[index->node[i].second];
        for (int k = 0; k < 3; k++) {
            cover[i].lo[k] = fminf(a->lo[k], b->lo[k]);
            cover[i].hi[k] = fmaxf(a->hi[k], b->hi[k]);
        }
        cover[i].end = b->end;
    }
}

satin_status photon_cover_build(struct photon_map *map, struct parallel *pool) {
    struct cover_loop loop = {.map = map};
    loop.cover = array_new_unset(map->index->nodes, sizeof *loop.cover);
    if (!loop.cover) return SATIN_ERROR_MEMORY;
    map->cover = loop.cover;
    if (!parallel_for(pool, map->index->nodes, COVER_CHUNK, cover_leaves, &loop))
        return SATIN_CANCELLED;
    cover_parents(map->index, loop.cover);
    return SATIN_OK;
}

size_t photon_cover_bytes(const struct photon_map *map) {
    return map->cover ? map->index->nodes * sizeof *map->cover : 0;
}

// The next leaf from *node on whose box and the box from lo to hi overlap; NULL: there is none.
static const struct photon_index_node *next_leaf(const struct photon_map *map, const float lo[3],
                                                 const float hi[3], uint32_t *node) {
    while (*node < map->index->nodes) {
        const struct photon_cover *box = &map->cover[*node];
        const bool apart = lo[0] > box->hi[0] || hi[0] < box->lo[0] || lo[1] > box->hi[1] ||
                           hi[1] < box->lo[1] || lo[2] > box->hi[2] || hi[2] < box->lo[2];
        if (apart) {
            *node = box->end;
            continue;
        }
        const struct photon_index_node *here = &map->index->node[(*node)++];
        if (here->column < 0) return here;
    }
    return NULL;
}

// ---- A point ------------------------------------------------------------------------------------

void photon_cover_begin(struct photon_cover_walk *walk, const struct photon_map *map, vec3 p,
                        vec3 n, enum photon_kernel kernel) {
    walk->node = 0;
    walk->disc = (struct photon_disc){.map = map,
                                      .p = p,
                                      .n = n,
                                      .kernel = kernel,
                                      .row = walk->row,
                                      .distance2 = walk->distance2,
                                      .own = true};
}

bool photon_cover_next(struct photon_cover_walk *walk) {
    struct photon_disc *disc = &walk->disc;
    const struct photon_map *map = disc->map;
    const float p[3] = {disc->p.x, disc->p.y, disc->p.z};
    disc->count = 0;
    const struct photon_index_node *leaf = next_leaf(map, p, p, &walk->node);
    if (!leaf) return false;
    for (int i = leaf->begin; i < leaf->end; i++) {
        const int row = map->index->row[i];
        const float d2 = v3_dist2(photon_position(map, (size_t)row), disc->p);
        if (!(d2 < map->radius2[row])) continue;
        walk->row[disc->count] = row;
        walk->distance2[disc->count++] = d2;
    }
    return true;
}

// ---- Photons that are neighbours ----------------------------------------------------------------

// The photons of a leaf, and zeros after them.
struct cover_rows {
    int count;
    float x[PHOTON_INDEX_LEAF], y[PHOTON_INDEX_LEAF], z[PHOTON_INDEX_LEAF],
        radius2[PHOTON_INDEX_LEAF];
    vec3 n[PHOTON_INDEX_LEAF];
    size_t at[PHOTON_INDEX_LEAF];
};

static void read_leaf(const struct photon_map *map, const struct photon_index_node *leaf,
                      struct cover_rows *out) {
    out->count = leaf->end - leaf->begin;
    for (int i = 0; i < PHOTON_INDEX_LEAF; i++) {
        const bool there = i < out->count;
        const size_t at = (size_t)map->index->row[leaf->begin + (there ? i : 0)];
        const vec3 p = photon_position(map, at);
        out->x[i] = p.x;
        out->y[i] = p.y;
        out->z[i] = p.z;
        out->radius2[i] = there ? map->radius2[at] : 0.0f;
        if (!there) continue;
        out->n[i] = photon_unpack(map->photon[at].n);
        out->at[i] = at;
    }
}

// The photon at which irradiance is estimated.
struct cover_entry {
    vec3 p, n;
    rgb E;
    int bounces;
};

static void add_rows(const struct photon_map *map, const struct cover_rows *rows,
                     enum photon_kernel kernel, struct cover_entry *entry) {
    float distance2[PHOTON_INDEX_LEAF];
    for (int i = 0; i < PHOTON_INDEX_LEAF; i++) {
        const float x = rows->x[i] - entry->p.x, y = rows->y[i] - entry->p.y,
                    z = rows->z[i] - entry->p.z;
        distance2[i] = x * x + y * y + z * z;
    }
    for (int i = 0; i < rows->count; i++) {
        if (!(distance2[i] < rows->radius2[i])) continue;
        const vec3 at = v3(rows->x[i], rows->y[i], rows->z[i]);
        const float height = v3_dot(v3_sub(at, entry->p), entry->n);
        if (!photon_is_on_surface(entry->n, rows->n[i], height, rows->radius2[i])) continue;
        const float weight =
            photon_own_weight(map, rows->at[i], rows->n[i], entry->p, distance2[i], kernel);
        if (!(weight > 0.0f)) continue;
        const struct photon *photon = &map->photon[rows->at[i]];
        entry->E = rgb_mad(entry->E, photon->power, weight * photon_unpack_tilt(photon->tilt));
        if (photon->bounces > entry->bounces) entry->bounces = photon->bounces;
    }
}

// Estimates at `count` photons that are near each other.
static void estimate_together(const struct photon_map *map, size_t begin, size_t count,
                              enum photon_kernel kernel, struct cover_entry *entry) {
    vec3 lo = photon_position(map, begin), hi = lo;
    for (size_t i = 0; i < count; i++) {
        entry[i].p = photon_position(map, begin + i);
        entry[i].n = photon_unpack(map->photon[begin + i].n);
        entry[i].E = rgb_grey(0.0f);
        entry[i].bounces = 0;
        lo = v3_min(lo, entry[i].p);
        hi = v3_max(hi, entry[i].p);
    }
    // Photons on both sides of a border between cells of the order may be far from each other.
    if (count > 1 && v3_dist2(lo, hi) > map->radius2[begin]) {
        estimate_together(map, begin, count / 2, kernel, entry);
        estimate_together(map, begin + count / 2, count - count / 2, kernel, entry + count / 2);
        return;
    }
    const float from[3] = {lo.x, lo.y, lo.z}, to[3] = {hi.x, hi.y, hi.z};
    struct cover_rows rows;
    uint32_t node = 0;
    for (const struct photon_index_node *leaf; (leaf = next_leaf(map, from, to, &node));) {
        read_leaf(map, leaf, &rows);
        for (size_t i = 0; i < count; i++) add_rows(map, &rows, kernel, &entry[i]);
    }
}

void photon_cover_estimate(const struct photon_map *map, size_t begin, size_t end,
                           enum photon_kernel kernel, rgb *E, uint8_t *bounces) {
    struct cover_entry entry[COVER_TOGETHER];
    for (size_t at = begin; at < end; at += COVER_TOGETHER) {
        const size_t n = end - at < COVER_TOGETHER ? end - at : COVER_TOGETHER;
        estimate_together(map, at, n, kernel, entry);
        for (size_t i = 0; i < n; i++) {
            E[at + i] = entry[i].E;
            if (bounces) bounces[at + i] = (uint8_t)entry[i].bounces;
        }
    }
}
