// SPDX-License-Identifier: Apache-2.0
// Narrower radii for density estimates where light is curved [Kaplanyan and Dachsbacher 2013]. The
// bias of an estimate grows with the Laplacian of irradiance and r^2, its variance as r^-2, and the
// best radius makes the sum of squared bias and variance least. Over the passes of progressive
// photon mapping both fall at the same rate, so the best initial radius does not depend on their
// number.
//
// The Laplacian is that of the photons in the disc of the k nearest: of light that is
// E + g.x + L |x|^2 / 4, the sum of power (2 |x|^2 / R^2 - 1) over a disc of radius R is
// pi R^4 L / 24. It is used only where it is certain: elsewhere noise would narrow discs, and wider
// discs than those of k photons blur caustics whose lines lie close to each other.
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "base/array.h"
#include "photon/photon_map.h"

enum {
    BANDWIDTH_CHUNK = 256,  // photons of a chunk
    DISC_MOST = 8,  // photons in a disc at most, in units of k; more are where they coincide
    DISC_FEW = 15,  // photons below which a narrower disc shows no Laplacian
    DISCS = 2       // that are tried, the second one of half the radius
};

// Standard deviations from which a Laplacian is certain. With 1 the error of `pool` is 1.09 times
// that with 2; with 3, that of `caustic` is 1.01 times it (docs/experiments/caustics.md).
static const double CERTAIN = 2.0;

// The squared best radius over that of the disc, at which light may be too curved to say more.
static const double LEAST = 0.25;

struct bandwidth_loop {
    struct photon_map *map;
    int most;  // photons in a disc
    atomic_bool failed;
};

// Sums over the photons in a disc of radius R, the one in the middle left out: of power f, and of
// f m, where m = 2 |x|^2 / R^2 - 1.
struct disc_moments {
    int count;
    double f, ff, fm, ffmm;
};

static struct disc_moments sum_moments(const struct photon_map *map, size_t i, float r2,
                                       const int *row, const float *distance2, int count) {
    const vec3 p = photon_position(map, i), n = photon_unpack(map->photon[i].n);
    struct disc_moments sum = {0};
    for (int j = 0; j < count; j++) {
        const size_t at = (size_t)row[j];
        const float height = v3_dot(v3_sub(photon_position(map, at), p), n);
        if (at == i || !photon_is_on_surface(n, photon_unpack(map->photon[at].n), height, r2))
            continue;
        const double f = (double)rgb_luminance(map->photon[at].power),
                     m = 2.0 * (double)(distance2[j] / r2) - 1.0;
        sum.count++;
        sum.f += f;
        sum.ff += f * f;
        sum.fm += f * m;
        sum.ffmm += f * f * m * m;
    }
    return sum;
}

// The squared best radius over that of the disc of the moments, at most 1.
static double best_ratio2(const struct disc_moments *sum) {
    const double curved2 = sum->fm * sum->fm - CERTAIN * CERTAIN * sum->ffmm;
    if (!(curved2 > 0.0)) return 1.0;
    // Relative to the irradiance f / (pi R^2), with the kernel of a parabola and s = (r / R)^2:
    // bias = L r^2 / 12 = 2 fm s / f, variance = 4/3 ff / (f^2 s). The means over n passes whose
    // squared radii fall as n^(-1/3) are 3/2 and 3/4 of these, times n^(-1/3) and n^(-2/3).
    const double bias2 = 4.0 * curved2 * 9.0 / 4.0, variance = 4.0 / 3.0 * sum->ff * 3.0 / 4.0;
    return fmin(cbrt(variance / (2.0 * bias2)), 1.0);
}

static float find_bandwidth(const struct bandwidth_loop *loop, size_t i, int *row,
                            float *distance2) {
    const struct photon_map *map = loop->map;
    float disc2 = map->radius2[i], best2 = disc2;
    for (int disc = 0; disc < DISCS; disc++, disc2 *= (float)LEAST) {
        const int count = photon_index_within(map->index, map->position + 3 * i, loop->most, disc2,
                                              row, distance2);
        if (count == loop->most) break;
        const struct disc_moments sum = sum_moments(map, i, disc2, row, distance2, count);
        if (sum.count < DISC_FEW) break;
        const double ratio2 = best_ratio2(&sum);
        best2 = disc2 * (float)ratio2;
        if (ratio2 > LEAST) break;
    }
    return best2;
}

static void find_bandwidths(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    struct bandwidth_loop *loop = ctx;
    int *row = array_new_unset((size_t)loop->most, sizeof *row);
    float *distance2 = array_new_unset((size_t)loop->most, sizeof *distance2);
    if (row && distance2)
        for (size_t i = begin; i < end; i++)
            loop->map->radius2[i] = find_bandwidth(loop, i, row, distance2);
    else
        atomic_store(&loop->failed, true);
    free(row);
    free(distance2);
}

satin_status photon_map_narrow_radii(struct photon_map *map, int k, struct parallel *pool) {
    struct bandwidth_loop loop = {.map = map, .most = DISC_MOST * k};
    if (!parallel_for(pool, map->count, BANDWIDTH_CHUNK, find_bandwidths, &loop))
        return SATIN_CANCELLED;
    return atomic_load(&loop.failed) ? SATIN_ERROR_MEMORY : SATIN_OK;
}
