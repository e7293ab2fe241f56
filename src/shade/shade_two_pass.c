// SPDX-License-Identifier: Apache-2.0
// The second pass at one point [K05 3.5]: the light that a point reflects, with each class of the
// path table once, and its lobes by the techniques of cache_plan.c.
#include "shade/shade_two_pass.h"

#include "shade/shade_pixel_cache.h"

static struct gather_site site_of(const struct shade_lighting *lighting) {
    const struct shading_point *p = &lighting->vertex->point;
    return (struct gather_site){.p = p->interaction.p,
                                .ng = p->interaction.ng,
                                .frame = p->base,
                                .stream = lighting->stream};
}

static void note_records(struct shade_lighting *lighting, struct cache_used used) {
    lighting->worker->counts.interpolated++;
    lighting->worker->counts.records_used += (uint64_t)used.count;
    lighting->out->used = cache_used_add(lighting->out->used, used);
}

// Adds indirect light by a hemisphere of gather rays, if irradiance is not cached.
static void sample_diffuse(struct shade_lighting *lighting) {
    const struct shade *s = lighting->shade;
    const struct shading_point *p = &lighting->vertex->point;
    const struct gather_worker *w = &lighting->worker->gather;
    const struct gather_site site = site_of(lighting);
    struct cache_irradiance_value value;
    gather_hemisphere_trace(s->g, s->gather, &site, w->scratch, w->hemisphere);
    gather_hemisphere_irradiance(w->hemisphere, SATIN_GRADIENTS_NONE, &value);
    lighting->worker->counts.rays += value.rays;
    lighting->worker->counts.gathered++;
    const rgb E = cache_rotate_irradiance(&value, p->base.n, p->frame.n);
    shade_add_uncached(lighting, SHADE_INDIRECT_DIFFUSE, rgb_mul(cache_diffuse_albedo(p), E));
}

// What is asked of the records at the vertex.
static struct cache_lookup records_lookup(const struct shade_lighting *lighting) {
    struct cache_lookup at = cache_lookup_at(&lighting->vertex->point);
    at.gather_deviation = lighting->shade->missing.deviation;
    return at;
}

// Adds indirect light from irradiance records. False if none is near, or in a gap.
static bool diffuse_cached(struct shade_lighting *lighting, struct shade_pixel_value *value) {
    const struct shade *s = lighting->shade;
    const struct shading_point *p = &lighting->vertex->point;
    struct shade_pixel_light *light = &value->light[CACHE_IRRADIANCE];
    if (!s->records.cache || shade_in_gap(s, lighting->vertex)) return false;
    if (shade_pixel_light_wanted(value, CACHE_IRRADIANCE)) {
        const struct cache_lookup at = records_lookup(lighting);
        rgb E;
        const struct cache_used used =
            cache_irradiance(s->records.cache, &at, s->records.a[CACHE_IRRADIANCE], &E);
        if (!used.count) return false;
        shade_pixel_light_add(light, used, rgb_grey(0.0f), E);
    }
    note_records(lighting, light->used);
    shade_add_cached(lighting, SHADE_INDIRECT_DIFFUSE, rgb_mul(cache_diffuse_albedo(p), light->E));
    return true;
}

// Adds indirect light from radiance records. False if none is near, or in a gap.
static bool indirect_cached(struct shade_lighting *lighting, const struct cache_plan *plan,
                            struct shade_pixel_value *value) {
    const struct shade *s = lighting->shade;
    const struct shading_point *p = &lighting->vertex->point;
    const bool diffuse = p->lobes & BRDF_DIFFUSE, shiny = plan->cached & BRDF_GLOSSY;
    struct shade_pixel_light *light = &value->light[CACHE_RADIANCE];
    if (!s->records.cache || shade_in_gap(s, lighting->vertex)) return false;
    if (shade_pixel_light_wanted(value, CACHE_RADIANCE)) {
        const struct cache_lookup at = records_lookup(lighting);
        rgb glossy = rgb_grey(0.0f), E = glossy;
        const struct cache_used used = cache_plan_radiance(&s->records, plan, p, &at, &glossy, &E);
        if (used.count) shade_pixel_light_add(light, used, glossy, E);
        if (!light->count) return false;
    }
    note_records(lighting, light->used);
    rgb factor = rgb_scale(brdf_glossy_factor(&p->brdf), plan->bump);
    if (shiny) shade_add_cached(lighting, SHADE_INDIRECT_GLOSSY, rgb_mul(factor, light->glossy));
    if (diffuse)
        shade_add_cached(lighting, SHADE_INDIRECT_DIFFUSE,
                         rgb_mul(cache_diffuse_albedo(p), light->E));
    return true;
}

// The largest width over distance of a drawn ray's footprint.
#define SPREAD_MAX 0.2f

enum { MISSING_DIMENSION = 16 };  // of the sampler, beyond those of sampled lobes

// How lobes are sampled by gather rays.
struct lobe_sampling {
    struct gather_single_clusters *clusters;  // at which rays and bounces are aimed, or NULL
    unsigned lobes;
    int count;       // number of rays
    int finding;     // number of BRDF samples of the lobes that find lights, these rays and others;
                     // 0: rays do not find lights
    uint32_t first;  // index of the first ray among those of the pixel
    uint32_t dimension;  // of the sampler, added to that of the lighting
    uint64_t stream;     // of random decisions at the hits
};

// Rays that are drawn, and for each the factor of its light, that of the diffuse lobe alone, that
// of what caustic photons leave out, and its density.
struct drawn_rays {
    struct light_receiver from;
    struct gather_ray ray[SATIN_GLOSSY_SAMPLES_MAX];
    rgb weight[SATIN_GLOSSY_SAMPLES_MAX], diffuse[SATIN_GLOSSY_SAMPLES_MAX],
        caustic[SATIN_GLOSSY_SAMPLES_MAX];
    float pdf[SATIN_GLOSSY_SAMPLES_MAX];
};

// The fraction of a sample's weight that is the diffuse lobe's.
static rgb diffuse_weight(const struct shading_point *p, const struct brdf_sample *b,
                          unsigned lobes) {
    if (!(lobes & BRDF_DIFFUSE)) return rgb_grey(0.0f);
    if (lobes == BRDF_DIFFUSE) return b->weight;
    const rgb f = brdf_eval(&p->brdf, p->wo_l, b->wi, BRDF_DIFFUSE);
    return rgb_scale(f, fabsf(b->wi.z) / b->pdf_w);
}

// Draws the sample of this index at the point.
static bool draw_sample(const struct shade_lighting *lighting, const struct lobe_sampling *by,
                        uint32_t index, struct brdf_sample *out) {
    const struct shading_point *p = &lighting->vertex->point;
    struct sampler u = {index, lighting->sampler.seed, lighting->sampler.dimension + by->dimension};
    const vec2 uv = sampler_2d(&u);
    const float u_lobe = sampler_1d(&u);
    if (!by->clusters)
        return brdf_sample_wi(&p->brdf, p->wo_l, u_lobe, uv, by->lobes, BRDF_RADIANCE, out);
    return gather_single_sample(by->clusters, p, by->lobes, u_lobe, uv, out);
}

// Draws gather rays. Returns the number of those that did not fail.
static int draw_rays(const struct shade_lighting *lighting, const struct lobe_sampling *by,
                     struct drawn_rays *out) {
    const struct shading_point *p = &lighting->vertex->point;
    const satin_options *o = lighting->shade->g->options;
    int rays = 0;
    out->from = gather_receiver(p);
    for (int i = 0; i < by->count; i++) {
        const uint32_t index = by->first + (uint32_t)i;
        struct brdf_sample b;
        if (!draw_sample(lighting, by, index, &b)) continue;
        const vec3 d = frame_to_world(&p->frame, b.wi);
        const float width = fminf(1.0f / sqrtf(b.pdf_w * (float)by->count), SPREAD_MAX);
        out->ray[rays] = (struct gather_ray){
            .ray = scene_spawn(lighting->shade->g->scene, p->interaction.p, p->interaction.ng, d),
            .item = index,
            .spread = o->texture_filter ? width : 0.0f,
            .pdf_w = o->denoise ? b.pdf_w : 0.0f,
            .lit = &out->from};
        out->weight[rays] = b.weight;
        out->diffuse[rays] = diffuse_weight(p, &b, by->lobes);
        const rgb glossy = rgb_sub(b.weight, out->diffuse[rays]);
        out->caustic[rays] = gather_has_caustic_photons(p, b.wi) ? rgb_grey(0.0f) : glossy;
        out->pdf[rays++] = b.pdf_w;
    }
    return rays;
}

// The variance of the luminance of indirect light by one of `count` rays, of which `rays` have not
// failed.
static float ray_variance(const struct drawn_rays *drawn, int rays, int count) {
    float sum = 0.0f, squares = 0.0f;
    for (int i = 0; i < rays; i++) {
        const float y = rgb_luminance(rgb_mul(drawn->weight[i], drawn->ray[i].L));
        sum += y;
        squares += y * y;
    }
    const float n = (float)count;
    return count > 1 ? fmaxf(squares - sqrf(sum) / n, 0.0f) / (n - 1.0f) : 0.0f;
}

// Importance sampling by gather rays. If by->finding > 0 they also find lights, weighted against
// light samples, and emitted light through specular surfaces that caustic photons leave out.
// Returns the indirect light that the diffuse lobe reflects. *variance, if not NULL, is set to the
// variance of the luminance of indirect light by one ray; 0 if there is only one.
static rgb sample_lobes(struct shade_lighting *lighting, const struct lobe_sampling *by,
                        float *variance) {
    const struct gather *g = lighting->shade->g;
    struct drawn_rays drawn;  // not initialised as a whole, as few are used
    const int rays = draw_rays(lighting, by, &drawn);
    lighting->worker->counts.rays += (uint64_t)rays;
    struct gather_scratch *scratch = lighting->worker->gather.scratch;
    if (!by->clusters)
        gather_rays(g, scratch, drawn.ray, (size_t)rays, by->stream);
    else
        gather_single_rays(g, scratch, by->clusters, drawn.ray, (size_t)rays, by->stream);
    const float ratio = (float)by->finding / (float)lighting->samples.light.count;
    rgb direct = rgb_grey(0.0f), caustic = direct, diffuse = direct, glossy = direct;
    for (int i = 0; i < rays; i++) {
        const struct gather_ray *ray = &drawn.ray[i];
        const rgb weight = drawn.weight[i], of_diffuse = drawn.diffuse[i];
        if (ray->light_pdf > 0.0f)
            direct = rgb_fma(direct, weight,
                             rgb_scale(ray->Le, mis_power(ratio * drawn.pdf[i], ray->light_pdf)));
        caustic = rgb_fma(caustic, drawn.caustic[i], ray->Le_specular);
        diffuse = rgb_fma(diffuse, of_diffuse, ray->L);
        glossy = rgb_fma(glossy, rgb_sub(weight, of_diffuse), ray->L);
    }
    if (variance) *variance = ray_variance(&drawn, rays, by->count);
    const float each = 1.0f / (float)by->count;
    diffuse = rgb_scale(diffuse, each);
    if (by->lobes & BRDF_DIFFUSE) shade_add_uncached(lighting, SHADE_INDIRECT_DIFFUSE, diffuse);
    if (by->lobes & ~(unsigned)BRDF_DIFFUSE)
        shade_add_uncached(lighting, SHADE_INDIRECT_GLOSSY, rgb_scale(glossy, each));
    if (by->finding > 0) {
        shade_add_uncached(lighting, SHADE_DIRECT, rgb_scale(direct, 1.0f / (float)by->finding));
        shade_add_uncached(lighting, SHADE_CAUSTIC, rgb_scale(caustic, each));
    }
    return diffuse;
}

// Notes diffuse light that was gathered, for the filter of irradiance.
static void note_gathered(const struct shade_lighting *lighting, rgb light) {
    const struct shade_vertex *v = lighting->vertex;
    struct shade_gathered *out = &lighting->out->gathered;
    if (out->rays > 0.0f) return;
    *out = (struct shade_gathered){.light = rgb_mul(v->T, light),
                                   .albedo = rgb_mul(v->T, cache_diffuse_albedo(&v->point)),
                                   .p = v->point.interaction.p,
                                   .n = v->point.frame.n,
                                   .pixel = v->pixel,
                                   .rays = (float)lighting->samples.gather.count};
}

// Adds indirect light where no record is read.
static void sample_missing(struct shade_lighting *lighting, unsigned lobes) {
    const struct shade_vertex *v = lighting->vertex;
    const struct lobe_sampling by = {
        .clusters = gather_single_find(lighting->shade->g, &v->point, v->pixel,
                                       lighting->worker->gather.singles),
        .lobes = lobes,
        .count = lighting->samples.gather.count,
        .first = lighting->samples.gather.first,
        .dimension = MISSING_DIMENSION,
        .stream = rng_mix(lighting->pixel_stream + 1)};
    struct shade_counts *counts = &lighting->worker->counts;
    const uint64_t before = counts->rays;
    float variance;
    const rgb diffuse = sample_lobes(lighting, &by, &variance);
    if (lobes & BRDF_DIFFUSE) note_gathered(lighting, diffuse);
    lighting->out->gather_variance += sqrf(rgb_luminance(v->T)) * variance;
    lighting->out->gathers++;
    counts->gathered++;
    counts->missing_rays += counts->rays - before;
}

// The luminance of direct and indirect light so far.
static float added_luminance(const struct shade_lighting *lighting) {
    const rgb *layer = lighting->out->layer;
    return rgb_luminance(rgb_add(
        layer[SHADE_DIRECT], rgb_add(layer[SHADE_INDIRECT_DIFFUSE], layer[SHADE_INDIRECT_GLOSSY])));
}

void shade_vertex_two_pass(struct shade_lighting *lighting) {
    const struct gather *g = lighting->shade->g;
    const struct shading_point *p = &lighting->vertex->point;
    const satin_options *o = g->options;
    const bool indirect = gather_indirect(o, lighting->vertex->depth);
    struct cache_plan plan;
    cache_plan_make(&lighting->shade->records, p, &plan);
    struct shade_pixel_value *value =
        shade_pixel_cache_find(&lighting->worker->pixel_cache, p, lighting->vertex->pixel);
    lighting->worker->counts.points++;

    // The gather rays of glossy lobes find lights too.
    const unsigned sampled = indirect ? plan.sampled : 0;
    const float before = added_luminance(lighting);
    const int finding = shade_direct(lighting, sampled, sampled ? o->glossy_samples : 0);
    if (!indirect) return;
    if (o->record_maps && lighting->shade->records.cache &&
        cache_has_record_near(lighting->shade->records.cache, p->interaction.p, p->base.n,
                              lighting->vertex->pixel))
        lighting->out->record = 1.0f;

    // Sampled lobes that reflect on the side of the normal read caustic photons, too.
    const unsigned sampled_caustic = p->wo_l.z > 0.0f ? plan.sampled & ~BRDF_THROUGH : 0u;
    const unsigned caustic = plan.cached | plan.diffuse | sampled_caustic;
    struct sampler apart = lighting->sampler;
    apart.dimension += 32;  // beyond those that the lobes below use
    const float u_caustic = sampler_1d(&apart);
    if (plan.cached && !indirect_cached(lighting, &plan, value))
        sample_missing(lighting, plan.cached);
    if (plan.diffuse && !lighting->shade->records.options[CACHE_IRRADIANCE].cache)
        sample_diffuse(lighting);
    else if (plan.diffuse && !diffuse_cached(lighting, value))
        sample_missing(lighting, plan.diffuse);
    if (plan.sampled) {
        const struct lobe_sampling by = {
            .lobes = plan.sampled,
            .count = o->glossy_samples,
            .finding = finding,
            .first = lighting->sampler.index * (uint32_t)o->glossy_samples,
            .stream = lighting->pixel_stream};
        sample_lobes(lighting, &by, NULL);
    }
    const struct photon_other_light other = {added_luminance(lighting) - before, u_caustic};
    const float pdf_most = plan.sampled & BRDF_GLOSSY ? GATHER_CAUSTIC_PDF_MOST : INFINITY;
    const struct photon_caustic_limits limits = {caustic, pdf_most,
                                                 photon_bounces_left(o, lighting->vertex->depth)};
    if (caustic)
        shade_add_uncached(lighting, SHADE_CAUSTIC,
                           photon_caustic(g->maps, g->scene, p, &limits, other));
}
