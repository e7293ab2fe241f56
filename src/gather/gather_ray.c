// SPDX-License-Identifier: Apache-2.0
// Gather rays: from x through ideal specular surfaces to y, the path table's E S* x S* y. They are
// the samples of the illumination integral at x [K05 (2.1)], whose incident radiance is what y
// reflects; direct light is left out of it [K05 2.1]. The option first-pass chooses what gives the
// light that y reflects: the estimate from photons, and where that is not reliable the path after y
// (gather_bounces.c), records, path tracing from y, or direct light at y alone. Emitted light is
// not added, as it is in direct light and caustics at x.
#include <stdlib.h>

#include "gather/gather_bounces.h"
#include "gather/gather_near.h"
#include "gather/gather_segment.h"

struct gather_scratch *gather_scratch_new(struct parallel *pool, int worker) {
    struct gather_scratch *scratch = calloc(1, sizeof *scratch);
    if (!scratch) return NULL;
    scratch->pool = pool;
    scratch->worker = worker;
    return scratch;
}

void gather_scratch_free(struct gather_scratch *scratch) { free(scratch); }

// The irradiance at y by a density estimate from what the diffuse lobe reflects. If there is no
// diffuse lobe, it is 0 and *radius is INFINITY.
static rgb density_irradiance(const struct gather *g, const struct gather_hit *hit, float *radius) {
    const struct shading_point *y = &hit->point;
    *radius = INFINITY;
    if (!(y->lobes & BRDF_DIFFUSE)) return rgb_grey(0.0f);
    const int bounces = photon_bounces_left(g->options, gather_hit_depth(g) + hit->specular);
    rgb L = photon_radiance(g->maps, g->scene, y, BRDF_DIFFUSE, bounces, radius);
    rgb a = brdf_albedo(&y->brdf, y->wo_l, BRDF_DIFFUSE);
    return rgb_make(a.r > 0.0f ? PI_F * L.r / a.r : 0.0f, a.g > 0.0f ? PI_F * L.g / a.g : 0.0f,
                    a.b > 0.0f ? PI_F * L.b / a.b : 0.0f);
}

// The estimate of hits where nothing is looked up.
static void clear_estimates(struct gather_hits *hits, size_t count) {
    for (size_t i = 0; i < count; i++) {
        hits->E[i] = rgb_grey(0.0f);
        hits->radius[i] = INFINITY;
        hits->entry[i] = -1;
    }
}

// Finds E and radius of `count` hits, by a common lookup or by an estimate for each.
static void look_up_hits(const struct gather *g, struct gather_hits *hits, size_t count,
                         bool strict) {
    const bool precomputed = photon_precomputes(g->options);
    for (size_t i = 0; i < count; i++) {
        const struct shading_point *y = &hits->hit[i].point;
        hits->p[i] = y->interaction.p;
        hits->n[i] = y->ng;
        hits->entry[i] = -1;
        hits->more[i] = hits->hit[i].specular + g->deeper;
        if (!precomputed) hits->E[i] = density_irradiance(g, &hits->hit[i], &hits->radius[i]);
    }
    const struct photon_lookups lookups = {count,   hits->p,      hits->n,     hits->more,
                                           hits->E, hits->radius, hits->entry, strict};
    if (precomputed) photon_irradiance_many(g->maps, g->scene, &lookups);
    for (size_t i = 0; i < count; i++)
        if (!gather_reads_photons(g, photon_hit_depth(g->options) + hits->more[i]))
            hits->E[i] = rgb_grey(0.0f);
}

// The rays of a lobe that hit within the disc of one lookup have its noise in common, which no
// number of samples removes, and no denoiser: it is a blotch. Their number of lookups is the area
// that they hit, t^2 / pdf, over that of the disc, and the relative error of the mean of n lookups
// of k photons is 1 / sqrt(k n). This is the largest error, the difference that is perceptible by
// Weber's law. Measured on the glossy floor of a room (docs/experiments/denoising.md).
static const float NOISE_MOST = 0.02f;

static bool averages_few(const struct gather *g, const struct gather_hit *hit, float radius) {
    const float pdf = hit->ray->pdf_w, t = hit->point.interaction.t;
    // The given radius is that of twice the photons of the lookup.
    const float disc = 0.5f * PI_F * sqrf(radius);
    return pdf > 0.0f && sqrf(NOISE_MOST * t) * (float)g->options->photon_k < disc * pdf;
}

// Approximates the luminance that each hit contributes. Returns the mean.
static float hit_weights(const struct gather *g, struct gather_hits *hits, size_t count) {
    float sum = 0.0f;
    for (size_t i = 0; i < count; i++) {
        const struct shading_point *y = &hits->hit[i].point;
        rgb E = hits->E[i];
        if (g->direct && hits->entry[i] >= 0) E = rgb_add(E, g->direct->E[hits->entry[i]]);
        const rgb albedo = brdf_albedo(&y->brdf, y->wo_l, BRDF_SMOOTH);
        hits->bright[i] = rgb_luminance(rgb_mul(hits->hit[i].T, rgb_mul(albedo, E)));
        sum += hits->bright[i];
    }
    return count > 0 ? sum / (float)count : 0.0f;
}

// The number of light samples at a hit, if its direct light is not known: in proportion to what it
// contributes, which gives the least variance, so that a bright hit with a single sample does not
// outweigh all others. All hits together have at most twice as many samples as hits.
static int samples_of_hit(float bright, float mean) {
    return bright > 1.5f * mean ? (int)(bright / mean + 0.5f) : 1;
}

// First passes `photons` and `precomputed`: computes the reflected radiance of the hits. Bounces
// from those whose rays continue are guided to the clusters of `near`, which the hits complete.
static void reflect_hits(const struct gather *g, struct gather_hits *hits, size_t count,
                         struct gather_near *near) {
    const float discs = near ? near->discs : GATHER_NEAR_DISCS;
    if (gather_looks_up(g))
        look_up_hits(g, hits, count, gather_near_of_record(near));
    else
        clear_estimates(hits, count);
    for (size_t i = 0; i < count; i++) {
        const struct gather_hit *hit = &hits->hit[i];
        const float radius = hits->radius[i];
        const bool close = gather_is_near(g, hit->point.interaction.t, radius, discs);
        hits->reliable[i] =
            gather_is_reliable(g, &hit->point, radius, close) && !averages_few(g, hit, radius);
    }
    if (near) gather_near_probe(g, hits, count, near);
    const float mean = hit_weights(g, hits, count);
    for (size_t i = 0; i < count; i++) {
        const struct gather_hit *hit = &hits->hit[i];
        const struct gather_estimate estimate = {
            hits->E[i], hits->reliable[i], gather_direct_known(g, &hit->point, hits->entry[i]),
            samples_of_hit(hits->bright[i], mean)};
        const rgb L = gather_bounces(g, &hit->point, gather_hit_depth(g) + hit->specular, estimate,
                                     near, hit->sampler);
        hit->ray->L = rgb_mul(hit->T, L);
    }
}

// Whether the first segment of a ray is traced by itself. Path tracing from x traces it too, so it
// is only needed if the ray is to find lights.
static bool traces_segment(const struct gather *g, const struct gather_ray *ray) {
    return g->options->first_pass != SATIN_FIRST_PATH || ray->lit;
}

// Stores what a ray's first segment has found: emitted light, and the radiance that the hit, if one
// was `found`, reflects. True if that radiance is left to reflect_hits.
static bool store_segment(const struct gather *g, struct gather_ray *ray, uint32_t seed,
                          const struct gather_segment *segment, bool found,
                          struct gather_hit *hit) {
    const satin_first_pass first_pass = g->options->first_pass;
    const int depth = gather_hit_depth(g) + segment->specular;
    hit->T = segment->T;
    hit->specular = segment->specular;
    hit->ray = ray;
    ray->first = segment->first;
    ray->Le = segment->Le;
    ray->light_pdf = segment->light_pdf;
    ray->Le_specular = segment->Le_specular;
    ray->L = rgb_grey(0.0f);
    found = found && gather_within_depth(g, depth, 1);
    if (first_pass == SATIN_FIRST_PATH) {
        struct sampler again = {ray->item, seed, 0};
        ray->L = gather_path(g, ray->ray, &again, &ray->first);
    } else if (found && first_pass == SATIN_FIRST_NONE) {
        const struct gather_mis lights_alone = {depth, {{BRDF_SMOOTH, 0.0f}}};
        const struct gather_light_samples one = {1, hit->sampler.index};
        ray->L = rgb_mul(
            hit->T, gather_sample_lights(g, &hit->point, lights_alone, one, hit->sampler, NULL));
    } else if (found && first_pass == SATIN_FIRST_RECURSIVE) {
        const struct gather_estimate none = {rgb_grey(0.0f), false, NULL, 1};
        ray->L = rgb_mul(hit->T, gather_bounces(g, &hit->point, depth, none, NULL, hit->sampler));
    } else {
        return found;
    }
    return false;
}

rgb gather_first_pass(const struct gather *g, struct gather_scratch *scratch,
                      const struct shading_point *p, int depth, struct sampler sampler) {
    if (g->options->first_pass == SATIN_FIRST_RECURSIVE) {
        const struct gather_estimate none = {rgb_grey(0.0f), false, NULL, 1};
        return gather_bounces(g, p, depth, none, NULL, sampler);
    }
    struct gather_ray ray = {.pdf_w = 0.0f};
    scratch->hits.hit[0] =
        (struct gather_hit){*p, rgb_grey(1.0f), depth - gather_hit_depth(g), &ray, sampler};
    reflect_hits(g, &scratch->hits, 1, NULL);
    return ray.L;
}

// Sets rays that were not traced to misses.
static void clear_rays(struct gather_ray *rays, size_t count) {
    for (size_t i = 0; i < count; i++) {
        rays[i].L = rays[i].Le = rays[i].Le_specular = rgb_grey(0.0f);
        rays[i].light_pdf = 0.0f;
        rays[i].first = GATHER_NOTHING;
    }
}

void gather_rays_guided(const struct gather *g, struct gather_scratch *scratch,
                        struct gather_ray *rays, size_t count, uint64_t stream,
                        struct gather_near *near) {
    struct gather_hits *hits = &scratch->hits;
    const uint32_t seed = (uint32_t)rng_mix(stream ^ rng_mix(g->options->seed + RNG_GATHER_HIT));
    for (size_t begin = 0; begin < count; begin += GATHER_HITS_MOST) {
        const size_t end = count - begin > GATHER_HITS_MOST ? begin + GATHER_HITS_MOST : count;
        // A million rays would take seconds, so cancellation is checked.
        if (begin > 0 && scratch->pool && parallel_cancelled(scratch->pool, scratch->worker)) {
            clear_rays(rays + begin, count - begin);
            break;
        }
        size_t found = 0;
        for (size_t i = begin; i < end; i++) {
            struct gather_ray *ray = &rays[i];
            struct gather_hit *hit = &hits->hit[found];
            const struct gather_segment_start start = {ray->ray, ray->spread, ray->alpha_least,
                                                       ray->lit, gather_hit_depth(g) - 1};
            struct gather_segment segment = {.first = GATHER_NOTHING};
            hit->sampler = (struct sampler){ray->item, seed, 0};
            const bool hits_surface =
                traces_segment(g, ray) &&
                gather_segment_trace(g, &start, &hit->sampler, &segment, &hit->point);
            found += store_segment(g, ray, seed, &segment, hits_surface, hit);
        }
        reflect_hits(g, hits, found, near);
    }
}

void gather_rays(const struct gather *g, struct gather_scratch *scratch, struct gather_ray *rays,
                 size_t count, uint64_t stream) {
    gather_rays_guided(g, scratch, rays, count, stream, NULL);
}
