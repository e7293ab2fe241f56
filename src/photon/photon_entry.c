// SPDX-License-Identifier: Apache-2.0
// The disc of an entry of precomputed irradiance. It has the k nearest photons, or more where few
// of these are on the entry's surface, or fewer where they lie on one side of it.
#include "photon/photon_entry.h"

#include <math.h>

// The least fraction of the photons of an estimate that are on its surface. Thin walls have many
// more of them on a bright other side, and the entries of the dark side are farther from each other
// than the radius of such estimates: they fade, and walls of a room on a sunlit ground had .7 of
// the light of the first bounce. With 0, .08, .12, .18 and .25 the first pass has .978, .987,
// 1.002, 1.012 and 1.012 of that room's light. Entries with few photons are those whose estimates
// are low, so with .5 dark rooms behind a partition are .8 % too bright
// (docs/experiments/first-passes.md).
#define COUNTED_LEAST 0.125f

// The least number of photons of a disc that is made smaller, and the least fraction of these that
// are on its surface. In a room behind a folded curtain the image has a variance of .045 with 15
// and .041 with 7, and .049 where gather rays continue instead (docs/experiments/first-passes.md).
enum { NARROW_LEAST = 7 };
#define NARROW_COUNTED 0.5f

static struct photon_query query_of(const struct photon_precompute *what, size_t entry) {
    const size_t i = entry * what->stride;
    return (struct photon_query){what->map,
                                 what->scene,
                                 photon_position(what->map, i),
                                 photon_unpack(what->map->photon[i].n),
                                 what->k,
                                 what->kernel,
                                 AREA_WHOLE};
}

struct photon_clearing photon_entry_clearing(const struct photon_precompute *what, size_t entry,
                                             const int *row, const float *distance2) {
    const struct photon_query query = query_of(what, entry);
    struct photon_disc disc;
    photon_disc_make(&query, row, distance2, &disc);
    return photon_clearing_find(what->scene, query.p, query.n, what->area ? disc.r : 0.0f);
}

// The disc by the k nearest photons, whose area is measured unless it is in the clearing; NULL:
// there is none.
static void make_disc(const struct photon_precompute *what, size_t entry, int k,
                      const struct photon_clearing *clearing, int *row, float *distance2,
                      struct photon_disc *out) {
    struct photon_query query = query_of(what, entry);
    query.k = k;
    photon_disc_make(&query, row, distance2, out);
    const bool clear = clearing && photon_clearing_has(clearing, query.p, query.n, out->r);
    if (what->area && !clear) {
        query.correction = AREA_MEASURED;
        photon_disc_make(&query, row, distance2, out);
    }
    photon_disc_drop_hidden(what->scene, row, distance2, out);
}

// The estimate by another number of photons.
static void search_disc(const struct photon_precompute *what, size_t entry, int k,
                        struct photon_entry_rows *rows, struct photon_entry *out) {
    const struct photon_map *map = what->map;
    photon_index_nearest(map->index, map->position + 3 * entry * what->stride, 1, 2 * k,
                         photon_map_far2(map), rows->row, rows->distance2);
    out->ring = photon_ring_radius(rows->row, rows->distance2, k);
    make_disc(what, entry, k, NULL, rows->row, rows->distance2, &out->disc);
}

// If few of the photons of a disc are on its surface, makes it of more of them.
static void widen_disc(const struct photon_precompute *what, size_t entry,
                       struct photon_entry_rows *rows, struct photon_entry *out) {
    const float least = COUNTED_LEAST * (float)what->k;
    for (int k = what->k; out->disc.r > 0.0f && 2 * k < PHOTON_K_MAX;) {
        const float counted = photon_disc_counted(&out->disc, least);
        if (counted >= least) return;
        const float wider = (float)what->k / fmaxf(counted, 1.0f);
        k = (int)fminf((float)k * wider, 0.5f * PHOTON_K_MAX);
        search_disc(what, entry, k, rows, out);
    }
}

// If the photons of a disc lie on one side, makes it of fewer of them if these do not. Whether they
// still do.
static bool narrow_disc(const struct photon_precompute *what, size_t entry,
                        struct photon_entry_rows *rows, struct photon_entry *out) {
    if (!photon_disc_is_aside(&out->disc)) return false;
    for (int k = what->k / 2; what->narrows && k >= NARROW_LEAST; k /= 2) {
        const float least = NARROW_COUNTED * (float)k;
        struct photon_entry narrow;
        search_disc(what, entry, k, rows, &narrow);
        if (!(narrow.disc.r > 0.0f)) break;
        if (photon_disc_is_aside(&narrow.disc) || photon_disc_counted(&narrow.disc, least) < least)
            continue;
        *out = narrow;
        return false;
    }
    return true;
}

void photon_entry_estimate(const struct photon_precompute *what, size_t entry,
                           const struct photon_clearing *clearing, int *row, float *distance2,
                           struct photon_entry_rows rows[2], struct photon_entry *out) {
    make_disc(what, entry, what->k, clearing, row, distance2, &out->disc);
    widen_disc(what, entry, &rows[0], out);
    const bool aside = narrow_disc(what, entry, &rows[1], out);
    if (aside || photon_disc_has_few_paths(&out->disc)) out->ring = INFINITY;
}
