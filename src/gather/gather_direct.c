// SPDX-License-Identifier: Apache-2.0
// Direct light at the entries of the precomputed irradiance. A light sample at each gather hit
// costs a shadow ray and is noisier than the other light that the hit reflects, so all hits near an
// entry use the entry's samples instead [after Ward 1991 and Christensen 1999, whose photons
// include direct light]. This would blur the edge of a shadow or of a spot to the spacing of the
// entries: where neighbouring entries differ, hits sample the lights themselves.
#include <stdlib.h>

#include "base/array.h"
#include "gather/gather.h"

enum { LIT_ENTRIES_CHUNK = 64 };  // entries per chunk

// How much direct light may differ between neighbouring entries: as a fraction of all light there,
// and in standard deviations of the samples' noise. Without this test the mean of case `spot` is 25
// % off.
static const float DIFFERS = 0.5f, EVEN_DEVIATIONS = 2.0f;

// Direct photons show light between the entries: if the power of those around an entry is more than
// this factor times that expected from the direct light of its neighbours, and the difference is
// more than this many standard deviations. An entry's area is known to a factor of three. Without
// this test the mean of a room with a beam between the entries is 30 % off at 20,000 photons.
static const float BRIGHTER = 4.0f, BRIGHTER_DEVIATIONS = 2.0f;

struct direct_loop {
    const struct gather *g;
    struct gather_direct *direct;
    float *noise2;  // variance of the luminance of an entry's E
    struct gather_entry_samples samples;
    size_t step;  // one in so many entries is sampled
};

// A white diffuse surface at an entry.
static struct shading_point white_point(const struct brdf_model *diffuse, vec3 p, vec3 n) {
    struct shading_point point = {.ng = n, .lobes = BRDF_DIFFUSE, .wo_l = v3(0.0f, 0.0f, 1.0f)};
    point.interaction.p = p;
    point.interaction.ng = point.interaction.frame.n = n;
    point.frame = point.base = frame_from_normal(n);
    point.brdf.model = diffuse;
    point.brdf.diffuse = rgb_grey(1.0f);
    return point;
}

static int count_samples(const struct direct_loop *loop, const struct shading_point *point) {
    struct light_product product;
    return gather_visibility(loop->g, point, &product).product ? loop->samples.sky
                                                               : loop->samples.others;
}

static void sample_entries(void *ctx, size_t begin, size_t end, int worker) {
    const struct direct_loop *loop = ctx;
    const struct gather *g = loop->g;
    (void)worker;
    const struct brdf_model *diffuse = brdf_find("diffuse");
    const uint32_t seed = (uint32_t)rng_mix(g->options->seed + RNG_GATHER_HIT);
    for (size_t i = begin; i < end; i++) {
        vec3 p, n;
        const size_t entry = i * loop->step;
        photon_irradiance_position(g->maps, entry, &p, &n);
        const struct shading_point point = white_point(diffuse, p, n);
        const struct gather_mis alone = {2, {{BRDF_DIFFUSE, 0.0f}}};
        const int count = count_samples(loop, &point);
        const struct gather_light_samples light_samples = {count,
                                                           (uint32_t)entry * (uint32_t)count};
        const struct sampler sampler = {0, seed, 0};
        float variance;
        const rgb L = gather_sample_lights(g, &point, alone, light_samples, sampler, &variance);
        loop->direct->E[i] = rgb_scale(L, PI_F);
        loop->noise2[i] = sqrf(PI_F) * variance / (float)count;
    }
}

// Whether direct photons bring much more light to the surroundings of an entry than irradiance E.
static bool is_brighter(const struct direct_loop *loop, size_t i, float E) {
    const struct photon_direct direct = photon_direct_at(loop->g->maps, i);
    if (!(direct.power > 0.0f)) return false;
    const float photon = direct.power2 / direct.power;  // power of a typical photon
    const float most = BRIGHTER * E * photon_irradiance_area(loop->g->maps, i);
    return direct.power > most + BRIGHTER_DEVIATIONS * sqrtf(most * photon) + photon;
}

// Whether direct light at the entries around one is equal except for noise. Its own value is not
// tested: otherwise the decision to read it would depend on it, and rare bright samples would be
// lost more often than others.
static bool entries_agree(const struct direct_loop *loop, size_t i) {
    const struct gather_direct *t = loop->direct;
    int around[PHOTON_AROUND];
    photon_irradiance_around(loop->g->maps, i, around);
    float least = INFINITY, most = 0.0f, sum = 0.0f, noise2 = 0.0f;
    int others = 0;
    for (int k = 0; k < PHOTON_AROUND; k++) {
        if (around[k] < 0 || (size_t)around[k] == i) continue;
        const float there = rgb_luminance(t->E[around[k]]);
        least = fminf(least, there);
        most = fmaxf(most, there);
        sum += there;
        others++;
        noise2 = fmaxf(noise2, loop->noise2[around[k]]);
    }
    const float indirect = rgb_luminance(photon_irradiance_of_entry(loop->g->maps, i));
    const float mean = 0.5f * (least + most) + indirect;
    if (is_brighter(loop, i, others > 0 ? sum / (float)others : 0.0f)) return false;
    return most - least <= DIFFERS * mean + EVEN_DEVIATIONS * sqrtf(2.0f * noise2);
}

static void compare_entries(void *ctx, size_t begin, size_t end, int worker) {
    const struct direct_loop *loop = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) loop->direct->similar[i] = entries_agree(loop, i);
}

static satin_status sample_all_entries(struct direct_loop *loop, struct parallel *pool,
                                       bool journaled) {
    struct gather_direct *direct = loop->direct;
    direct->count = photon_irradiance_count(loop->g->maps) / loop->step;
    direct->E = array_new(direct->count, sizeof *direct->E);
    loop->noise2 = array_new(direct->count, sizeof *loop->noise2);
    if (!direct->E || !loop->noise2) return SATIN_ERROR_MEMORY;
    const struct parallel_results lit = {
        .slot = {{direct->E, sizeof *direct->E}, {loop->noise2, sizeof *loop->noise2}},
        .journaled = journaled};
    return parallel_for_results(pool, direct->count, LIT_ENTRIES_CHUNK, sample_entries, loop, &lit)
               ? SATIN_OK
               : SATIN_CANCELLED;
}

static satin_status compare_with_neighbours(struct direct_loop *loop, struct parallel *pool) {
    struct gather_direct *direct = loop->direct;
    direct->similar = array_new(direct->count, sizeof *direct->similar);
    if (!direct->similar) return SATIN_ERROR_MEMORY;
    const struct parallel_results compared = {.slot = {{direct->similar, sizeof *direct->similar}}};
    return parallel_for_results(pool, direct->count, LIT_ENTRIES_CHUNK, compare_entries, loop,
                                &compared)
               ? SATIN_OK
               : SATIN_CANCELLED;
}

satin_status gather_direct_build(const struct gather *g, struct gather_entry_samples samples,
                                 struct parallel *pool, struct gather_direct *out) {
    struct gather_direct direct = {0};
    struct direct_loop loop = {g, &direct, NULL, samples, 1};
    satin_status status = sample_all_entries(&loop, pool, true);
    if (status == SATIN_OK) status = compare_with_neighbours(&loop, pool);
    free(loop.noise2);
    if (status == SATIN_OK)
        *out = direct;
    else
        gather_direct_free(&direct);
    return status;
}

satin_status gather_direct_try(const struct gather *g, struct gather_entry_samples samples,
                               size_t most, struct parallel *pool, double *fraction) {
    const size_t entries = photon_irradiance_count(g->maps);
    struct gather_direct direct = {0};
    const size_t step = entries > most ? (entries + most - 1) / most : 1;
    struct direct_loop loop = {g, &direct, NULL, samples, step};
    const satin_status status = sample_all_entries(&loop, pool, false);
    *fraction = direct.count > 0 ? (double)direct.count / (double)entries : 1.0;
    free(loop.noise2);
    gather_direct_free(&direct);
    return status;
}

size_t gather_direct_bytes(const struct gather_direct *direct) {
    return direct->count * (sizeof *direct->E + sizeof *direct->similar);
}

void gather_direct_free(struct gather_direct *direct) {
    free(direct->E);
    free(direct->similar);
    *direct = (struct gather_direct){0};
}
