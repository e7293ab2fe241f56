// SPDX-License-Identifier: Apache-2.0
// Removes the noise of photons from caustics. Where the estimates around a position differ from a
// plane little more than their variance explains, they are replaced by the plane; where they differ
// much more, they stay; in between a fraction of the difference is preserved. Planes are fitted by
// least squares at sites. The values at sites are smoothed in the same way over ever wider
// surroundings, as long as these are a plane too.
//
// A site is at a random position beside a photon, so far that its estimate does not contain it:
// estimates at photons are too high, and without the photon they would be too low, as photons are
// distributed more uniformly than at random. The kernel of sites has the radius of their disc: on a
// plane this is unbiased, and has less noise than kernels of the photons' own radii.
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/rng.h"
#include "photon/photon_caustic_smooth.h"

enum {
    STRIDE = 16,       // entries per site
    STRIDE_WIDER = 4,  // sites per site of the next wider surroundings
    SITES_LEAST = 128,
    SMOOTH_CHUNK = 64
};
#define ASIDE 1.2f  // least distance of a site from its photon, in radii of its disc
#define ASIDE_MOST 1.7f
// Fraction of the variance left in a plane; small, but not 1 / n, as discs overlap.
#define NOISE_LEFT 0.16f

static void sites_free(struct photon_sites *sites) {
    photon_index_free(sites->index);
    free(sites->position.row);
    free(sites->position.clear);
    free(sites->value);
    free(sites->noise);
    free(sites->slope);
}

static bool sites_make(size_t count, float scale, struct photon_sites *out) {
    *out = (struct photon_sites){.count = count, .position.scale = scale};
    out->position.row = array_new(6 * count, sizeof *out->position.row);
    out->position.clear = array_new(count, sizeof *out->position.clear);
    out->value = array_new(count, sizeof *out->value);
    out->noise = array_new(count, sizeof *out->noise);
    out->slope = array_new(count, sizeof *out->slope);
    return out->position.row && out->position.clear && out->value && out->noise && out->slope;
}

// ---- Sites --------------------------------------------------------------------------------------

struct estimating {
    const struct photon_precompute *what;
    const struct photon_irradiance *irradiance;
    struct photon_sites *sites;
    atomic_bool failed;
};

// Finds a position on the surface around an entry and visible from it. False if there is none.
static bool find_position(const struct estimating *loop, size_t site, vec3 *p, vec3 *n) {
    const struct photon_irradiance *r = loop->irradiance;
    const struct satin_scene *scene = loop->what->scene;
    const size_t entry = site * STRIDE;
    *n = photon_unpack(loop->what->map->photon[entry * loop->what->stride].n);
    const struct frame frame = frame_from_normal(*n);
    struct rng rng = rng_make(0, RNG_SMOOTH, site);
    const float rotation = 2.0f * PI_F * rng_float(&rng);
    const float least2 = ASIDE * ASIDE, most2 = ASIDE_MOST * ASIDE_MOST;
    const float aside = r->radius[entry] * sqrtf(least2 + (most2 - least2) * rng_float(&rng));
    vec3 above =
        v3_mad(photon_entry_position(&r->position, entry), aside * cosf(rotation), frame.u);
    above =
        v3_mad(v3_mad(above, aside * sinf(rotation), frame.v), PHOTON_SURFACE_HEIGHT * aside, *n);
    if (!photon_surface_below(scene, above, *n, 2.0f * PHOTON_SURFACE_HEIGHT * aside, p, n))
        return false;
    return photon_irradiance_visible(r, scene, (int)entry, *p, *n);
}

// Computes the value of a site; its noise is negative if there is no site.
static void estimate_site(const struct estimating *loop, size_t site, int *row, float *distance2) {
    const struct photon_precompute *what = loop->what;
    struct photon_sites *sites = loop->sites;
    vec3 p, n;
    sites->noise[site] = -1.0f;
    if (!find_position(loop, site, &p, &n)) return;
    const struct photon_query query = {what->map,
                                       what->scene,
                                       p,
                                       n,
                                       what->k,
                                       what->kernel,
                                       what->area ? AREA_IF_NEEDED : AREA_WHOLE};
    const float at[3] = {p.x, p.y, p.z};
    struct photon_disc disc;
    photon_index_nearest(what->map->index, at, 1, what->k, photon_map_far2(what->map), row,
                         distance2);
    photon_disc_make(&query, row, distance2, &disc);
    photon_disc_drop_hidden(query.scene, row, distance2, &disc);
    const rgb E = photon_disc_irradiance(&disc);
    if (!(photon_rgb_square(E) > 0.0f)) return;
    sites->value[site] = E;
    sites->noise[site] = photon_disc_variance(&disc) / photon_rgb_square(E);
    sites->position.clear[site] = photon_disc_clear(&disc);
    photon_entry_position_set(&sites->position, site, p, n);
}

static void estimate_sites(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    struct estimating *loop = ctx;
    const size_t k = (size_t)loop->what->k;
    int *row = malloc(k * sizeof *row);
    float *distance2 = malloc(k * sizeof *distance2);
    if (!row || !distance2) atomic_store(&loop->failed, true);
    for (size_t i = begin; i < end && !atomic_load(&loop->failed); i++)
        estimate_site(loop, i, row, distance2);
    free(row);
    free(distance2);
}

// Removes invalid sites.
static void remove_invalid_sites(struct photon_sites *sites) {
    size_t valid = 0;
    for (size_t i = 0; i < sites->count; i++) {
        if (sites->noise[i] < 0.0f) continue;
        memcpy(sites->position.row + 6 * valid, sites->position.row + 6 * i,
               6 * sizeof *sites->position.row);
        sites->position.clear[valid] = sites->position.clear[i];
        sites->value[valid] = sites->value[i];
        sites->noise[valid++] = sites->noise[i];
    }
    sites->count = valid;
}

// Selects every STRIDE_WIDER-th of the sites that have planes.
static bool select_sites(const struct photon_sites *sites, struct photon_sites *out) {
    if (!sites_make((sites->count + STRIDE_WIDER - 1) / STRIDE_WIDER, sites->position.scale, out))
        return false;
    for (size_t i = 0; i < out->count; i++) {
        const size_t from = i * STRIDE_WIDER;
        memcpy(out->position.row + 6 * i, sites->position.row + 6 * from,
               6 * sizeof *sites->position.row);
        out->position.clear[i] = sites->position.clear[from];
        out->value[i] = sites->value[from];
        out->noise[i] = NOISE_LEFT * sites->noise[from];
    }
    return true;
}

// ---- Smoothing ----------------------------------------------------------------------------------

// Replaces `count` values by those that the sites, one for every few of their positions, give.
static satin_status smooth(const struct satin_scene *scene, struct parallel *pool,
                           struct photon_sites *sites, const struct photon_positions *position,
                           size_t count, rgb *value) {
    satin_status status = SATIN_ERROR_MEMORY;
    rgb *plane = array_new(sites->count, sizeof *plane);
    sites->index = photon_index_new(sites->position.row, sites->count, 6, NULL, pool);
    if (plane && (sites->index || parallel_stopped(pool))) status = SATIN_CANCELLED;
    if (!plane || !sites->index) goto end;
    struct photon_fitting fitting = {scene, sites, plane};
    const struct parallel_results planes = {
        .slot = {{plane, sizeof *plane}, {sites->slope, sizeof *sites->slope}}};
    if (!parallel_for_results(pool, sites->count, SMOOTH_CHUNK, photon_fit_planes, &fitting,
                              &planes))
        goto end;
    const struct parallel_results slopes = {.slot = {{sites->slope, sizeof *sites->slope}}};
    if (!parallel_for_results(pool, sites->count, SMOOTH_CHUNK, photon_evaluate_planes, &fitting,
                              &slopes))
        goto end;
    memcpy(sites->value, plane, sites->count * sizeof *plane);
    if (sites->count / STRIDE_WIDER >= SITES_LEAST) {
        struct photon_sites wider;
        status = SATIN_ERROR_MEMORY;
        if (select_sites(sites, &wider))
            status = smooth(scene, pool, &wider, &sites->position, sites->count, sites->value);
        sites_free(&wider);
        if (status != SATIN_OK) goto end;
    }
    struct photon_reading reading = {scene, sites, position, value};
    const struct parallel_results values = {.slot = {{value, sizeof *value}}};
    status = parallel_for_results(pool, count, SMOOTH_CHUNK, photon_read_planes, &reading, &values)
                 ? SATIN_OK
                 : SATIN_CANCELLED;
end:
    free(plane);
    return status;
}

satin_status photon_caustic_smooth(const struct photon_precompute *what, struct parallel *pool,
                                   struct photon_irradiance *irradiance) {
    const size_t count = irradiance->count / STRIDE;
    if (count < SITES_LEAST) return SATIN_OK;
    struct photon_sites sites;
    satin_status status = SATIN_ERROR_MEMORY;
    if (sites_make(count, irradiance->position.scale, &sites)) {
        struct estimating loop = {.what = what, .irradiance = irradiance, .sites = &sites};
        atomic_init(&loop.failed, false);
        const struct parallel_results found = {
            .slot = {{sites.position.row, 6 * sizeof *sites.position.row},
                     {sites.position.clear, sizeof *sites.position.clear},
                     {sites.value, sizeof *sites.value},
                     {sites.noise, sizeof *sites.noise}}};
        if (!parallel_for_results(pool, count, SMOOTH_CHUNK, estimate_sites, &loop, &found))
            status = SATIN_CANCELLED;
        else if (!atomic_load(&loop.failed))
            status = SATIN_OK;
    }
    if (status == SATIN_OK) {
        remove_invalid_sites(&sites);
        if (sites.count >= SITES_LEAST)
            status = smooth(what->scene, pool, &sites, &irradiance->position, irradiance->count,
                            irradiance->E);
    }
    sites_free(&sites);
    return status;
}
