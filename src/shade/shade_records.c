// SPDX-License-Identifier: Apache-2.0
// Selects the technique for each lobe of a point, and reads the records there [K05 3.5].
// Low-frequency glossy BRDFs use radiance records for all their smooth reflection; others use
// irradiance records for the diffuse lobe and importance sampling for the glossy one. Transmitted
// light is importance-sampled.
#include "shade/shade_records.h"

#include "rsh/rsh.h"
#include "shade/shade_eye.h"

// If bumps leave a smaller fraction of a lobe than this, its harmonics do not represent it.
static const float BUMP_LEAST = 0.8f;

void shade_plan_make(const struct shade *shade, const struct gather_point *p,
                     struct shade_plan *plan) {
    const satin_options *o = shade->g->options;
    plan->table = shade_table(shade, p, &plan->channels);
    plan->cached = 0;
    plan->sampled = p->lobes & BRDF_THROUGH;
    plan->diffuse = p->lobes & BRDF_DIFFUSE;
    if (plan->diffuse && o->radiance_cache && o->radiance_diffuse) plan->cached = plan->diffuse;
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

struct cache_used shade_radiance(const struct shade *shade, const struct shade_plan *plan,
                                 const struct gather_point *p, const struct cache_lookup *at,
                                 rgb *glossy, rgb *E) {
    float C[3 * RSH_MAX_COEFFICIENTS];
    struct cache_lobe lobe = {.C = C, .channels = plan->channels};
    shade_lobe_name(p, &lobe);
    const bool shiny = plan->cached & BRDF_GLOSSY;
    if (shiny) lobe.order = brdf_range_lookup(plan->table, &p->brdf, p->wo_l, C);
    return cache_radiance(shade->cache, at, shade->a_radiance, shiny ? &lobe : NULL, glossy,
                          p->lobes & BRDF_DIFFUSE ? E : NULL);
}

rgb shade_diffuse_albedo(const struct gather_point *p) {
    float scale = brdf_bump_diffuse(&p->brdf) * (1.0f / PI_F);
    return rgb_scale(brdf_albedo(&p->brdf, p->wo_l, BRDF_DIFFUSE), scale);
}

unsigned shade_record_kinds(const struct shade *shade, const struct gather_point *p) {
    struct shade_plan plan;
    shade_plan_make(shade, p, &plan);
    unsigned wants = plan.cached ? 1u << CACHE_RADIANCE : 0u;
    if (plan.diffuse && shade->g->options->irradiance_cache) wants |= 1u << CACHE_IRRADIANCE;
    return wants;
}

unsigned shade_known(const struct shade *s, const struct gather_point *y, rgb *L) {
    const struct cache_lookup at = shade_lookup(y, 0.0f);
    struct shade_plan plan;
    rgb glossy = rgb_grey(0.0f), E = glossy;
    shade_plan_make(s, y, &plan);
    unsigned known = 0;
    if (plan.cached && shade_radiance(s, &plan, y, &at, &glossy, &E).count) {
        known |= plan.cached;
        if (plan.cached & BRDF_GLOSSY)
            *L = rgb_fma(*L, rgb_scale(y->brdf.specular, plan.bump), glossy);
    } else if (plan.diffuse && cache_irradiance(s->cache, &at, s->a_irradiance, &E).count) {
        known |= plan.diffuse;
    }
    if (known & BRDF_DIFFUSE) *L = rgb_fma(*L, shade_diffuse_albedo(y), E);
    return known;
}
