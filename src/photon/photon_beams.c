// SPDX-License-Identifier: Apache-2.0
// Beams of indirect light at a point: narrow cones from which much of the power of the photons
// around it arrives, as where a sharp lobe reflects the light of a lamp to a wall. The photon
// clusters of guide_clusters.c do not show such light: what is bright is not the surface that
// reflects it, but the few directions in which it does. [Jensen 1995] guides rays by all photons
// around a point; here only those count that lie densely, as stratified rays sample the others
// well.
#include "photon/photon_map.h"

enum {
    BEAM_PHOTONS = 64,  // nearest photons that are searched for beams
    BEAM_LEAST = 8,     // least number of photons of equal power that make a beam
    BEAM_TRIED = 16,    // photons whose directions are tried as axes, at regular distances
    BEAM_PASSES = 2     // in which the mean direction and the width of a beam are found
};

// The 1 - cosine of the largest half angle of a beam, and the least; and the least fraction of all
// power. Of 64 photons of a diffuse environment, those of the widest cone are 2.5.
static const float BEAM_WIDE = 0.02f, BEAM_NARROW = 5e-5f, BEAM_FRACTION = 0.1f;
// The squared radius of a beam over the mean square of its photons' distances from the axis; it
// is 2 for a disc of equal radiance, larger for one that is brightest at its axis.
static const float BEAM_EXTENT = 3.0f;

struct arrivals {
    vec3 wi[BEAM_PHOTONS];  // directions to where the photons came from
    float power[BEAM_PHOTONS], all;
    int count;
};

static void find_arrivals(const struct photon_map *map, vec3 p, vec3 n, struct arrivals *out) {
    int row[BEAM_PHOTONS];
    float distance2[BEAM_PHOTONS];
    const float q[3] = {p.x, p.y, p.z};
    photon_index_nearest(map->index, q, 1, BEAM_PHOTONS, photon_map_far2(map), row, distance2);
    for (int i = 0; i < BEAM_PHOTONS; i++) {
        if (row[i] < 0) continue;
        const struct photon *photon = &map->photon[row[i]];
        const vec3 wi = photon_unpack(photon->wi);
        if (!photon->indirect || v3_dot(photon_unpack(photon->n), n) < PHOTON_FACING ||
            !(v3_dot(wi, n) > 0.0f))
            continue;
        out->wi[out->count] = wi;
        out->power[out->count] = rgb_luminance(photon->power);
        out->all += out->power[out->count++];
    }
}

// The photons within a cone: sums of their power, of its squares, of their directions, and of their
// squared distances from the axis, both times power.
struct beam_sum {
    float power, power2, distance2;
    vec3 direction;
};

static struct beam_sum sum_beam(const struct arrivals *a, vec3 axis, float versine) {
    struct beam_sum sum = {0};
    for (int i = 0; i < a->count; i++) {
        const float d2 = v3_dist2(a->wi[i], axis);
        if (d2 > 2.0f * versine) continue;
        sum.power += a->power[i];
        sum.power2 += sqrf(a->power[i]);
        sum.distance2 += a->power[i] * d2;
        sum.direction = v3_mad(sum.direction, a->power[i], a->wi[i]);
    }
    return sum;
}

// The photon's direction around which the widest cone holds the most power.
static vec3 densest(const struct arrivals *a) {
    float most = -1.0f;
    vec3 axis = v3(0.0f, 0.0f, 1.0f);
    const int step = a->count > BEAM_TRIED ? a->count / BEAM_TRIED : 1;
    for (int i = 0; i < a->count; i += step) {
        const float power = sum_beam(a, a->wi[i], BEAM_WIDE).power;
        if (!(power > most)) continue;
        most = power;
        axis = a->wi[i];
    }
    return axis;
}

static void remove_beam(struct arrivals *a, const struct photon_beam *beam) {
    int left = 0;
    for (int i = 0; i < a->count; i++) {
        if (v3_dist2(a->wi[i], beam->axis) <= 2.0f * beam->versine) continue;
        a->wi[left] = a->wi[i];
        a->power[left++] = a->power[i];
    }
    a->count = left;
}

int photon_beams(const struct photon_maps *maps, vec3 p, vec3 n,
                 struct photon_beam out[PHOTON_BEAMS]) {
    struct arrivals a = {.count = 0};
    if (maps->global.count < BEAM_PHOTONS) return 0;
    find_arrivals(&maps->global, p, n, &a);
    int count = 0;
    while (count < PHOTON_BEAMS && a.count >= BEAM_LEAST) {
        struct photon_beam beam = {densest(&a), BEAM_WIDE, 0.0f};
        for (int pass = 0; pass < BEAM_PASSES; pass++) {
            struct beam_sum sum = sum_beam(&a, beam.axis, beam.versine);
            beam.axis = v3_unit(sum.direction);
            sum = sum_beam(&a, beam.axis, beam.versine);
            beam.versine =
                clampf(0.5f * BEAM_EXTENT * sum.distance2 / sum.power, BEAM_NARROW, BEAM_WIDE);
        }
        const struct beam_sum sum = sum_beam(&a, beam.axis, beam.versine);
        beam.fraction = sum.power / a.all;
        if (!(beam.fraction > BEAM_FRACTION) || sqrf(sum.power) < BEAM_LEAST * sum.power2) break;
        out[count++] = beam;
        remove_beam(&a, &beam);
    }
    return count;
}
