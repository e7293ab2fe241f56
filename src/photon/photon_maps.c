// SPDX-License-Identifier: Apache-2.0
// The first pass from beginning to end: traces photons, sorts them into the global and the caustic
// map, and precomputes irradiance.
//
// The classes that the global map stores depend on what reads it. Integrator photons shows it
// directly and needs all classes. A gather ray that samples direct light needs the caustic and the
// indirect photons; one that does not needs all. The caustic map is read at the first hit of eye
// rays; its photons are from a separate pass, which is aimed at surfaces that can cause caustics.
// The search for photon clusters needs all classes, but fewer photons, allocated by power so that
// they have equal power; they are from the pass of the global map too.
#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "photon/photon_map.h"

enum {
    CLASSES_ALL = 1 << PHOTON_DIRECT | 1 << PHOTON_CAUSTIC | 1 << PHOTON_INDIRECT,
    CLASSES_BOUNCED = 1 << PHOTON_CAUSTIC | 1 << PHOTON_INDIRECT,
    CONVERT_CHUNK = 4096  // photons per chunk
};

// Context of all steps of the first pass.
struct photon_pass {
    const struct satin_scene *scene;
    const satin_options *options;
    struct photon_paths paths;
    const struct photon_request *request;
    struct parallel *pool;
    struct log log;
    struct stats *stats;
    struct guide_seen boxes;  // of what the eye sees
    struct guide_allocation allocation;
    struct photon_tracing tracing;  // of the global map
    struct photon_reverse reverse;  // one batch: all photons are in the map
};

// The maximum lookup radius over the median length of gather rays: a wider lookup blurs a large
// part of the visible scene.
static const float LOOKUP_FRACTION = 0.25f;

// Caustics count as faint below this fraction of the mean irradiance.
static const float MAP_FAINT = 0.01f;

static satin_status precompute_map(const struct photon_pass *pass,
                                   const struct photon_precompute *what,
                                   struct photon_irradiance *out) {
    const double start = stats_wall();
    parallel_begin_part(pass->pool, "estimate");
    satin_status status = photon_irradiance_build(what, pass->pool, pass->log, out);
    stats_add(pass->stats, "photons.precompute_s", stats_wall() - start);
    if (status == SATIN_OK) stats_add(pass->stats, "estimates.refused", (double)out->refused);
    return status;
}

struct conversion {
    const struct photon_hit *hit;
    struct guide_photon *photon;
};

static void convert_photons(void *ctx, size_t begin, size_t end, int worker) {
    const struct conversion *c = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        c->photon[i] = (struct guide_photon){c->hit[i].p, photon_unpack(c->hit[i].n),
                                             rgb_luminance(c->hit[i].power)};
}

// Builds the clusters from the photons that were traced for them.
static satin_status build_clusters(const struct photon_pass *pass, const struct photon_trace *trace,
                                   struct photon_maps *maps) {
    struct guide_photon *photon = array_new_unset(trace->count, sizeof *photon);
    if (!photon)
        return log_fail(pass->log, SATIN_ERROR_MEMORY, "not enough memory for photon clusters");
    struct conversion conversion = {trace->hit, photon};
    satin_status status = SATIN_CANCELLED;
    if (parallel_for(pass->pool, trace->count, CONVERT_CHUNK, convert_photons, &conversion))
        status = guide_clusters_build(pass->scene, photon, trace->count, pass->pool, pass->log,
                                      &maps->clusters);
    free(photon);
    return status;
}

// Traces the photons of the global map and for what is made together with it.
static satin_status trace_paths(struct photon_pass *pass, struct photon_maps *maps,
                                struct photon_trace trace[PHOTON_CONSUMERS]) {
    const satin_options *o = pass->options;
    const bool whole = o->integrator == SATIN_PHOTONS, bounced = o->gather_direct && !whole;
    const uint64_t all = pass->paths.global, most = pass->paths.batch;
    pass->reverse = (struct photon_reverse){&pass->tracing, all,
                                            most > 0 && most < all ? (all - 1) / most + 1 : 1};
    pass->tracing = (struct photon_tracing){
        .scene = pass->scene,
        .seed = o->seed,
        .consumer = {{.paths = photon_reverse_paths(&pass->reverse, 0),
                      .classes = bounced ? CLASSES_BOUNCED : CLASSES_ALL,
                      .allocation = &pass->allocation},
                     {.paths = pass->paths.clusters, .classes = CLASSES_ALL},
                     {.paths = pass->paths.direct,
                      .classes = 1 << PHOTON_DIRECT,
                      .allocation = &pass->allocation}},
        .bounces = photon_bounces_left(o, photon_hit_depth(o)),
        .aim = pass->request->aim};
    return photon_map_trace(&pass->tracing, pass->pool, pass->log, pass->stats, &maps->global,
                            trace);
}

// Builds the global map and the photon clusters; sets *direct to the direct photons, which the
// caller frees.
static satin_status trace_global(struct photon_pass *pass, struct photon_maps *maps,
                                 struct photon_trace *direct) {
    const struct photon_request *request = pass->request;
    const struct stats before = *pass->stats;
    struct photon_trace trace[PHOTON_CONSUMERS] = {0};
    satin_status status = trace_paths(pass, maps, trace);
    if (status == SATIN_OK && request->grow && request->grow(request->grow_ctx, &pass->paths)) {
        photon_map_free(&maps->global);
        for (int k = 1; k < PHOTON_CONSUMERS; k++) photon_trace_free(&trace[k]);
        *pass->stats = before;
        status = trace_paths(pass, maps, trace);
    }
    const double start = stats_wall();
    parallel_begin_part(pass->pool, "clusters");
    if (status == SATIN_OK) status = build_clusters(pass, &trace[1], maps);
    photon_trace_free(&trace[1]);
    *direct = trace[2];
    stats_add(pass->stats, "photons.clusters_s", stats_wall() - start);
    return status;
}

static satin_status build_irradiance(const struct photon_pass *pass, struct photon_maps *maps) {
    maps->global.radius_max = INFINITY;
    maps->global.limited = pass->options->max_depth >= 0;
    // Integrator photons needs only the flags of edges, which a few photons of each estimate have.
    size_t stride = PHOTON_STRIDE;
    if (pass->options->integrator == SATIN_PHOTONS && maps->photon_k > 8 * PHOTON_STRIDE)
        stride = (size_t)maps->photon_k / 8;
    return precompute_map(
        pass,
        &(struct photon_precompute){&maps->global, pass->scene, stride, maps->photon_k, KERNEL_FLAT,
                                    maps->area, false, false,
                                    maps->area && !photon_streams(pass->options)},
        &maps->irradiance);
}

// The mean luminance of the irradiance over lit surfaces: an entry represents an area in proportion
// to that of its estimate.
static float mean_irradiance(const struct photon_irradiance *r) {
    double sum = 0.0, area = 0.0;
    for (size_t i = 0; i < r->count; i++) {
        const double radius = (double)r->radius[i];
        if (!isfinite(radius)) continue;
        sum += radius * radius * (double)rgb_luminance(r->E[i]);
        area += radius * radius;
    }
    return area > 0.0 ? (float)(sum / area) : 0.0f;
}

static double photons_power(const struct photon_map *map) {
    double power = 0.0;
    for (size_t i = 0; i < map->count; i++) power += (double)rgb_luminance(map->photon[i].power);
    return power;
}

double photon_caustic_fraction(const struct photon_maps *maps) {
    const double caustic = photons_power(&maps->caustic);
    return caustic > 0.0 ? caustic / (caustic + photons_power(&maps->global)) : 0.0;
}

// The radius at which a caustic estimate from all its photons would be faint beside the mean
// irradiance: a wider search would take long for an invisible result.
static float faint_radius(const struct photon_maps *maps, float irradiance) {
    const double mean = photons_power(&maps->caustic) / (double)maps->caustic.count;
    const double least = (double)(MAP_FAINT * irradiance);
    return least > 0.0 ? (float)sqrt(maps->caustic_k * mean / (M_PI * least)) : INFINITY;
}

// The noise of the estimates. The discs of the first batch keep their radii, so the variance of all
// batches together falls as the number of their paths.
static satin_status find_noise(const struct photon_pass *pass, struct photon_maps *maps) {
    if (pass->options->integrator != SATIN_TWO_PASS) return SATIN_OK;
    const satin_status status = photon_noise_find(pass->scene, pass->pool, maps);
    const double all = (double)pass->reverse.paths;
    if (status == SATIN_ERROR_MEMORY)
        return log_fail(pass->log, status, "not enough memory for the noise of photons");
    if (status != SATIN_OK) return status;
    if (all > 0.0) maps->noise2 *= (float)((double)photon_reverse_paths(&pass->reverse, 0) / all);
    return SATIN_OK;
}

static satin_status build_global(struct photon_pass *pass, struct photon_maps *maps) {
    struct photon_trace direct = {0};
    satin_status status = trace_global(pass, maps, &direct);
    if (status == SATIN_OK) status = build_irradiance(pass, maps);
    const double start = stats_wall();
    if (status == SATIN_OK) status = find_noise(pass, maps);
    if (status == SATIN_OK)
        status =
            photon_direct_build(maps, pass->scene, &direct, pass->pool, pass->log, &maps->direct);
    photon_trace_free(&direct);
    stats_add(pass->stats, "photons.precompute_s", stats_wall() - start);
    if (status == SATIN_OK && photon_streams(pass->options))
        status = photon_reverse_add(&pass->reverse, &maps->global, pass->pool, pass->log,
                                    pass->stats, &maps->irradiance);
    return status;
}

static satin_status build_caustic(const struct photon_pass *pass, struct photon_maps *maps) {
    const satin_options *o = pass->options;
    if (!pass->request->emission) return SATIN_OK;
    const struct photon_tracing tracing = {
        .scene = pass->scene,
        .seed = o->seed,
        .consumer = {{.paths = pass->paths.caustic, .classes = 1 << PHOTON_CAUSTIC}},
        .bounces = photon_bounces_left(o, 1),
        .emission = pass->request->emission};
    struct photon_trace trace[PHOTON_CONSUMERS] = {0};
    parallel_begin_part(pass->pool, "trace");
    satin_status status =
        photon_map_trace(&tracing, pass->pool, pass->log, pass->stats, &maps->caustic, trace);
    if (status != SATIN_OK) return status;
    const float irradiance = mean_irradiance(&maps->irradiance);
    if (maps->caustic.count > 0)
        maps->caustic.radius_max = fminf(maps->caustic.radius_max, faint_radius(maps, irradiance));
    const struct photon_divide divide = {o->seed, maps->caustic_k, irradiance, maps->lookup_max};
    status = photon_map_divide(&divide, pass->scene, pass->pool, pass->log, &maps->caustic);
    if (status != SATIN_OK) return status;
    maps->caustic.limited = o->max_depth >= 0;
    return precompute_map(pass,
                          &(struct photon_precompute){
                              &maps->caustic, pass->scene, PHOTON_CAUSTIC_STRIDE, maps->caustic_k,
                              KERNEL_PARABOLA, maps->area, o->caustic_smooth, true, false},
                          &maps->caustic_irradiance);
}

satin_status photon_maps_build(const struct photon_request *request, struct parallel *pool,
                               struct log log, struct stats *stats, struct photon_maps **out) {
    const struct satin_scene *scene = request->scene;
    const satin_options *options = request->options;
    struct photon_maps *maps = calloc(1, sizeof *maps);
    if (!maps) return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for the photon maps");
    maps->photon_k = photon_clamp_k(options->photon_k);
    maps->caustic_k = photon_clamp_k(options->caustic_k);
    maps->area = options->photon_area;
    maps->smooth = options->caustic_smooth;
    struct photon_pass pass = {.scene = scene,
                               .options = options,
                               .paths = request->paths,
                               .request = request,
                               .pool = pool,
                               .log = log,
                               .stats = stats};
    parallel_begin_part(pool, "seen");
    guide_seen_make(scene, options->seed, pass.paths.seen, pool, &pass.boxes);
    guide_allocation_make(scene, options->seed, pass.paths.seen, pool, &pass.allocation);
    maps->lookup_max = LOOKUP_FRACTION * pass.boxes.ray_length;
    satin_status status = build_global(&pass, maps);
    if (status == SATIN_OK) status = build_caustic(&pass, maps);
    if (status != SATIN_OK) {
        photon_maps_free(maps);
        return status;
    }
    double seconds = stats_get(stats, "photons.trace_s");
    stats_set(stats, "photons.per_second",
              seconds > 0.0 ? stats_get(stats, "photons.emitted") / seconds : 0.0);
    stats_set(stats, "photons.bytes",
              (double)(photon_map_bytes(&maps->global) + photon_map_bytes(&maps->caustic) +
                       photon_irradiance_bytes(&maps->irradiance) + photon_direct_bytes(maps) +
                       photon_irradiance_bytes(&maps->caustic_irradiance) +
                       guide_clusters_bytes(maps->clusters)));
    *out = maps;
    return SATIN_OK;
}

const struct guide_clusters *photon_clusters(const struct photon_maps *maps) {
    return maps ? maps->clusters : NULL;
}

float photon_lookup_max(const struct photon_maps *maps) { return maps->lookup_max; }

void photon_maps_free(struct photon_maps *maps) {
    if (!maps) return;
    photon_irradiance_free(&maps->irradiance);
    photon_irradiance_free(&maps->caustic_irradiance);
    photon_map_free(&maps->global);
    photon_map_free(&maps->caustic);
    guide_clusters_free(maps->clusters);
    free(maps->direct);
    free(maps);
}
