// SPDX-License-Identifier: Apache-2.0
// Which density estimates gather rays do not read, however narrow they are: those by few light
// paths, and those whose photons lie on one side. Light that falls off so fast within a disc is
// spread over it: beside a bright strip at the edge of a curtain, floor and curtain were two to
// four times too bright.
#include <math.h>

#include "photon/photon_map.h"

// Least number of light paths of an estimate, over that of its photons. In living-room, with 1/8
// the light in a crack was as without this test, with 1/4 it was in one seed of three, and with a
// third it is that of path tracing in all of them (docs/experiments/rooms.md).
static const float FRACTION_OF_PATHS = 0.5f;

// The largest distance between the centroids of the photons and of the surface, over the radius of
// the disc; at a border of light it is .42. In docs/experiments/first-passes.md.
static const float OFF_CENTRE_MOST = 0.3f;

bool photon_disc_has_few_paths(const struct photon_disc *disc) {
    enum { HASHES = 64 };
    uint64_t found = 0;
    for (int i = 0; i < disc->count; i++) found |= 1ull << disc->map->photon[disc->row[i]].path;
    // Paths that have the same hash are counted by how full the hashes are [Whang et al. 1990].
    const float empty = 1.0f - (float)__builtin_popcountll(found) / HASHES;
    const float paths = empty > 0.0f ? -HASHES * logf(empty) : INFINITY;
    return paths < FRACTION_OF_PATHS * fminf((float)disc->count, HASHES);
}

// Whether the centroid of the photons, by power, is farther from that of the surface than it would
// be by their noise: in a disc of radius r, that of n photons has a mean square of r^2 / (2 n).
bool photon_disc_is_aside(const struct photon_disc *disc) {
    const struct frame frame = frame_from_normal(disc->n);
    float x = 0.0f, y = 0.0f, sum = 0.0f, squares = 0.0f;
    for (int i = 0; i < disc->count; i++) {
        const float weight = disc->corrected ? photon_disc_weight(disc, i) : 1.0f;
        if (!(weight > 0.0f)) continue;
        const size_t at = (size_t)disc->row[i];
        const vec3 d = v3_sub(photon_position(disc->map, at), disc->p);
        const float power = weight * rgb_luminance(disc->map->photon[at].power);
        x += power * v3_dot(d, frame.u);
        y += power * v3_dot(d, frame.v);
        sum += power;
        squares += power * power;
    }
    if (!(sum > 0.0f)) return false;
    const vec2 whole = disc->corrected ? photon_area_centroid(&disc->area) : (vec2){0.0f, 0.0f};
    const float u = x / (sum * disc->r) - whole.x, v = y / (sum * disc->r) - whole.y;
    return u * u + v * v - 0.5f * squares / (sum * sum) > sqrf(OFF_CENTRE_MOST);
}

bool photon_disc_reliable(const struct photon_disc *disc) {
    return !photon_disc_has_few_paths(disc) && !photon_disc_is_aside(disc);
}
