// SPDX-License-Identifier: Apache-2.0
// Selects the technique for each lobe of a point, and reads the records there [K05 3.5].
// Low-frequency glossy BRDFs use radiance records for all their smooth reflection; others use
// irradiance records for the diffuse lobe and importance sampling for the glossy one. Transmitted
// light is importance-sampled.
#include "cache/cache.h"

// If bumps leave a smaller fraction of a lobe than this, its harmonics do not represent it.
static const float BUMP_LEAST = 0.8f;

struct cache_reader cache_reader_make(const struct cache *cache, const struct cache_tables *tables,
                                      const satin_options *o) {
    struct cache_reader reader = {.cache = cache, .tables = tables};
    cache_options_of(o, reader.options);
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++)
        reader.a[k] = reader.options[k].a * reader.options[k].widen;
    return reader;
}

void cache_plan_make(const struct cache_reader *reader, const struct shading_point *p,
                     struct cache_plan *plan) {
    plan->table = cache_table(reader->tables, p->side, &plan->channels);
    plan->cached = 0;
    plan->sampled = p->lobes & BRDF_THROUGH;
    plan->diffuse = p->lobes & BRDF_DIFFUSE;
    if (reader->options[CACHE_RADIANCE].diffuse) plan->cached = plan->diffuse;
    if (!(p->lobes & BRDF_GLOSSY)) {
        plan->diffuse &= ~plan->cached;
        return;
    }
    plan->bump = brdf_bump_glossy(&p->brdf, p->wo_l);
    if (plan->table && plan->bump > BUMP_LEAST &&
        brdf_range_order(plan->table, &p->brdf, p->wo_l) > 0) {
        plan->cached = p->lobes & BRDF_REFLECT;
    } else {
        plan->sampled |= BRDF_GLOSSY;
    }
    plan->diffuse &= ~plan->cached;
}

struct cache_used cache_plan_radiance(const struct cache_reader *reader,
                                      const struct cache_plan *plan, const struct shading_point *p,
                                      const struct cache_lookup *at, rgb *glossy, rgb *E) {
    float C[3 * RSH_MAX_COEFFICIENTS];
    struct cache_lobe lobe = {.C = C,
                              .channels = plan->channels,
                              .number = cache_lobe_number(p),
                              .mirror = cache_mirror(&p->frame, p->wo_l)};
    const bool shiny = plan->cached & BRDF_GLOSSY;
    if (shiny) lobe.order = brdf_range_lookup(plan->table, &p->brdf, p->wo_l, C);
    return cache_radiance(reader->cache, at, reader->a[CACHE_RADIANCE], shiny ? &lobe : NULL,
                          glossy, p->lobes & BRDF_DIFFUSE ? E : NULL);
}

rgb cache_diffuse_albedo(const struct shading_point *p) {
    float scale = brdf_bump_diffuse(&p->brdf) * (1.0f / PI_F);
    return rgb_scale(brdf_albedo(&p->brdf, p->wo_l, BRDF_DIFFUSE), scale);
}

unsigned cache_plan_kinds(const struct cache_reader *reader, const struct shading_point *p) {
    struct cache_plan plan;
    cache_plan_make(reader, p, &plan);
    unsigned kinds = plan.cached ? 1u << CACHE_RADIANCE : 0u;
    if (plan.diffuse && reader->options[CACHE_IRRADIANCE].cache) kinds |= 1u << CACHE_IRRADIANCE;
    return kinds;
}

unsigned cache_add_reflected(const struct cache_reader *reader, const struct shading_point *y,
                             rgb *L) {
    const struct cache_lookup at = cache_lookup_at(y);
    struct cache_plan plan;
    rgb glossy = rgb_grey(0.0f), E = glossy;
    cache_plan_make(reader, y, &plan);
    unsigned known = 0;
    if (plan.cached && cache_plan_radiance(reader, &plan, y, &at, &glossy, &E).count) {
        known |= plan.cached;
        if (plan.cached & BRDF_GLOSSY)
            *L = rgb_fma(*L, rgb_scale(brdf_glossy_factor(&y->brdf), plan.bump), glossy);
    } else if (plan.diffuse &&
               cache_irradiance(reader->cache, &at, reader->a[CACHE_IRRADIANCE], &E).count) {
        known |= plan.diffuse;
    }
    if (known & BRDF_DIFFUSE) *L = rgb_fma(*L, cache_diffuse_albedo(y), E);
    return known;
}
