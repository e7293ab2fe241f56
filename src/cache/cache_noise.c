// SPDX-License-Identifier: Apache-2.0
// The noise of what records reflect at a point: each has that of its own gather rays, independent
// of the others, and they are averaged by their weights.
#include "cache/cache.h"

// The lobes of a point that records of a kind light, as in cache_add_reflected.
static void make_surface(const struct cache_plan *plan, const struct shading_point *y,
                         enum cache_kind kind, struct cache_surface *out) {
    const unsigned lobes = kind == CACHE_RADIANCE ? plan->cached : plan->diffuse;
    out->specular = rgb_grey(0.0f);
    out->diffuse = lobes & BRDF_DIFFUSE ? cache_diffuse_albedo(y) : rgb_grey(0.0f);
    out->lobe = (struct cache_lobe){.C = out->coefficients,
                                    .channels = plan->channels,
                                    .number = cache_lobe_number(y),
                                    .mirror = cache_mirror(&y->frame, y->wo_l)};
    if (!(lobes & BRDF_GLOSSY)) return;
    out->specular = rgb_scale(brdf_glossy_factor(&y->brdf), plan->bump);
    out->lobe.order = brdf_range_lookup(plan->table, &y->brdf, y->wo_l, out->coefficients);
}

// The variance by records of one kind; negative if none is near.
static float variance_by_kind(const struct cache_reader *reader, const struct cache_plan *plan,
                              const struct shading_point *y, enum cache_kind kind) {
    static cache_reflected_fn *const reflected[CACHE_KINDS] = {
        [CACHE_IRRADIANCE] = cache_irradiance_reflected,
        [CACHE_RADIANCE] = cache_radiance_reflected};
    const struct cache_lookup at = cache_lookup_at(y);
    const struct cache *cache = reader->cache;
    struct cache_near near[CACHE_NEAR_MAX];
    const int count = cache_find(cache, kind, at.p, at.n, reader->a[kind], near);
    struct cache_surface surface;
    float variance = 0.0f, weight = 0.0f;
    make_surface(plan, y, kind, &surface);
    for (int i = 0; i < count; i++) {
        float noise;
        reflected[kind](cache, near[i].record, &at, reader->a[kind], &surface, &noise);
        variance += sqrf(near[i].weight * noise);
        weight += near[i].weight;
    }
    return weight > 0.0f ? variance / sqrf(weight) : -1.0f;
}

float cache_reflected_variance(const struct cache_reader *reader, const struct shading_point *y) {
    struct cache_plan plan;
    cache_plan_make(reader, y, &plan);
    float variance = plan.cached ? variance_by_kind(reader, &plan, y, CACHE_RADIANCE) : -1.0f;
    if (variance < 0.0f && plan.diffuse)
        variance = variance_by_kind(reader, &plan, y, CACHE_IRRADIANCE);
    return fmaxf(variance, 0.0f);
}
