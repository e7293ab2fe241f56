// SPDX-License-Identifier: Apache-2.0
// The second pass at one point [K05 3.5]: the light that a point reflects, with each class of the
// path table once, and its lobes by the techniques of shade_records.h.
#include "shade/shade_indirect.h"
#include "shade/shade_pixel_cache.h"
#include "shade/shade_records.h"

// A point without records, as in a sliver along an edge, uses the nearest record within this many
// pixels.
#define FALLBACK_PIXELS 8.0f

// Adds light that is from a record.
static void add_cached(struct shade_job *job, enum shade_layer layer, rgb L) {
    job->out->layer[layer] = rgb_fma(job->out->layer[layer], job->vertex->T, L);
}

// Adds light that is from no record.
static void add_uncached(struct shade_job *job, enum shade_layer layer, rgb L) {
    add_cached(job, layer, L);
    job->out->uncached = rgb_fma(job->out->uncached, job->vertex->T, L);
}

static struct gather_site site_of(const struct shade_job *job) {
    const struct gather_point *p = &job->vertex->point;
    return (struct gather_site){p->interaction.p, p->interaction.ng, p->base, job->stream, false};
}

// E on a facet that a bump map has rotated, as in cache_irradiance.
static rgb rotate_irradiance(const struct gather_irradiance *value, vec3 n, vec3 facing) {
    vec3 rotation = v3_cross(n, facing);
    float cosine = minf(v3_dot(n, facing), 1.0f);
    const rgb E = rgb_make(cosine * value->E.r + v3_dot(rotation, value->grad_r[0]),
                           cosine * value->E.g + v3_dot(rotation, value->grad_r[1]),
                           cosine * value->E.b + v3_dot(rotation, value->grad_r[2]));
    return rgb_at_least(E, 0.0f);
}

static void note_records(struct shade_job *job, struct cache_used used) {
    job->worker->counts.interpolated++;
    job->worker->counts.records_used += (uint64_t)used.count;
    job->out->used = cache_used_add(job->out->used, used);
}

static void indirect_diffuse(struct shade_job *job, struct shade_pixel_entry *entry) {
    const struct shade *s = job->shade;
    const struct gather_point *p = &job->vertex->point;
    const struct cache_lookup at = shade_lookup(p, FALLBACK_PIXELS * job->vertex->pixel);
    rgb E = entry->E;
    if (!(entry->knows & PIXEL_IRRADIANCE)) {
        entry->used = (struct cache_used){0};
        if (s->g->options->irradiance_cache)
            entry->used = cache_irradiance(s->cache, &at, s->a_irradiance, &E);
    }
    if (entry->used.count) {
        entry->knows |= PIXEL_IRRADIANCE;
        entry->E = E;
        note_records(job, entry->used);
        add_cached(job, SHADE_INDIRECT_DIFFUSE, rgb_mul(shade_diffuse_albedo(p), E));
    } else {
        struct gather_irradiance value;
        struct gather_site site = site_of(job);
        bool off = !s->g->options->irradiance_cache;
        const struct gather_worker *w = &job->worker->gather;
        gather_hemisphere_trace(s->g, off ? s->gather : s->fallback, &site, w->scratch,
                                w->hemisphere);
        gather_hemisphere_irradiance(s->g, w->hemisphere, &value);
        job->worker->counts.rays += value.rays;
        E = rotate_irradiance(&value, p->base.n, p->frame.n);
        job->worker->counts.gathered++;
        add_uncached(job, SHADE_INDIRECT_DIFFUSE, rgb_mul(shade_diffuse_albedo(p), E));
    }
}

// Adds indirect light from radiance records. False if none is near.
static bool indirect_cached(struct shade_job *job, const struct shade_plan *plan,
                            struct shade_pixel_entry *entry) {
    const struct shade *s = job->shade;
    const struct gather_point *p = &job->vertex->point;
    const bool diffuse = p->lobes & BRDF_DIFFUSE, shiny = plan->cached & BRDF_GLOSSY;
    if (!(entry->knows & PIXEL_RADIANCE)) {
        const struct cache_lookup at = shade_lookup(p, FALLBACK_PIXELS * job->vertex->pixel);
        entry->used = shade_radiance(s, plan, p, &at, &entry->glossy, &entry->E);
        if (!entry->used.count) return false;
        entry->knows |= PIXEL_RADIANCE;
    }
    note_records(job, entry->used);
    rgb factor = rgb_scale(p->brdf.specular, plan->bump);
    if (shiny) add_cached(job, SHADE_INDIRECT_GLOSSY, rgb_mul(factor, entry->glossy));
    if (diffuse)
        add_cached(job, SHADE_INDIRECT_DIFFUSE, rgb_mul(shade_diffuse_albedo(p), entry->E));
    return true;
}

// The largest width over distance of a drawn ray's footprint.
#define SPREAD_MAX 0.2f

enum { GLOSSY_SAMPLES_MAX = 256 };  // rays of one sample; the limit of option glossy_samples

// Draws gather rays from `lobes`. Returns the number of those that did not fail, with their weights
// and densities.
static int draw_rays(struct shade_job *job, unsigned lobes, int count, struct gather_ray *ray,
                     rgb *weight, float *pdf) {
    const struct gather_point *p = &job->vertex->point;
    const bool sharp = !job->shade->g->options->texture_filter;
    int rays = 0;
    for (int i = 0; i < count; i++) {
        struct sampler u = {job->sampler.index * (uint32_t)count + (uint32_t)i, job->sampler.seed,
                            job->sampler.dimension};
        struct brdf_sample b;
        vec2 uv = sampler_2d(&u);
        float u_lobe = sampler_1d(&u);
        if (!brdf_sample(&p->brdf, p->wo_l, u_lobe, uv.x, uv.y, lobes, BRDF_RADIANCE, &b)) continue;
        vec3 d = frame_to_world(&p->frame, b.wi);
        ray[rays].ray = scene_spawn(job->shade->g->scene, p->interaction.p, p->interaction.ng, d);
        ray[rays].item = u.index;
        ray[rays].alpha_least = 0.0f;
        ray[rays].lit = &p->interaction.p;
        ray[rays].spread = sharp ? 0.0f : fminf(1.0f / sqrtf(b.pdf_w * (float)count), SPREAD_MAX);
        weight[rays] = b.weight;
        pdf[rays++] = b.pdf_w;
    }
    return rays;
}

// Importance sampling of `lobes` by gather rays. If ratio > 0 they also find lights, weighted
// against light samples for that many BRDF samples per light sample, and emitted light through
// specular surfaces.
static void sample_lobes(struct shade_job *job, unsigned lobes, float ratio) {
    const struct gather *g = job->shade->g;
    const int count = g->options->glossy_samples;
    rgb weight[GLOSSY_SAMPLES_MAX];
    float pdf[GLOSSY_SAMPLES_MAX];
    struct gather_ray ray[GLOSSY_SAMPLES_MAX];
    const int rays = draw_rays(job, lobes, count, ray, weight, pdf);
    job->worker->counts.rays += (uint64_t)rays;
    gather_rays(g, job->worker->gather.scratch, ray, (size_t)rays, job->pixel_stream);
    rgb direct = rgb_grey(0.0f), caustic = direct, indirect = direct;
    for (int i = 0; i < rays; i++) {
        if (ray[i].light_pdf > 0.0f)
            direct = rgb_fma(direct, weight[i],
                             rgb_scale(ray[i].Le, mis_power(ratio * pdf[i], ray[i].light_pdf)));
        caustic = rgb_fma(caustic, weight[i], ray[i].Le_specular);
        indirect = rgb_fma(indirect, weight[i], ray[i].L);
    }
    float weight_each = 1.0f / (float)count;
    add_uncached(job, SHADE_INDIRECT_GLOSSY, rgb_scale(indirect, weight_each));
    if (ratio > 0.0f) {
        add_uncached(job, SHADE_DIRECT, rgb_scale(direct, weight_each));
        add_uncached(job, SHADE_CAUSTIC, rgb_scale(caustic, weight_each));
    }
}

// One BRDF sample of `lobes` that only finds lights.
static void sample_lights_by_brdf(struct shade_job *job, unsigned lobes, float ratio) {
    const struct gather *g = job->shade->g;
    const struct gather_point *p = &job->vertex->point;
    struct brdf_sample b;
    struct sampler u = job->sampler;
    vec2 uv = sampler_2d(&u);
    if (!brdf_sample(&p->brdf, p->wo_l, sampler_1d(&u), uv.x, uv.y, lobes, BRDF_RADIANCE, &b))
        return;
    vec3 d = frame_to_world(&p->frame, b.wi);
    struct interaction hit;
    bool sky;
    struct light_found found;
    if (!light_find(g->scene, p->interaction.p, p->interaction.ng, d, gather_panes(g, 1), &hit,
                    &sky, &found))
        return;
    float light_pdf = gather_light_pdf(g, p->interaction.p, &found.chain, sky ? NULL : &hit);
    add_uncached(job, SHADE_DIRECT,
                 rgb_scale(rgb_mul(b.weight, found.L), mis_power(ratio * b.pdf_w, light_pdf)));
}

// The luminance of direct and indirect light so far.
static float added_luminance(const struct shade_job *job) {
    const rgb *layer = job->out->layer;
    return rgb_luminance(rgb_add(
        layer[SHADE_DIRECT], rgb_add(layer[SHADE_INDIRECT_DIFFUSE], layer[SHADE_INDIRECT_GLOSSY])));
}

void shade_vertex_two_pass(struct shade_job *job) {
    const struct gather *g = job->shade->g;
    const struct gather_point *p = &job->vertex->point;
    const satin_options *o = g->options;
    const bool indirect = gather_indirect(o);
    struct shade_plan plan;
    shade_plan_make(job->shade, p, &plan);
    struct shade_pixel_entry *entry =
        shade_pixel_cache_find(&job->worker->pixel_cache, p, job->vertex->pixel);
    job->worker->counts.points++;

    // Direct light. The samples of glossy lobes, or one additional BRDF sample, are combined with
    // light samples by multiple importance sampling.
    const unsigned sampled = indirect ? plan.sampled : 0, rest = p->lobes & BRDF_SMOOTH & ~sampled;
    const unsigned extra = g->wide_lights ? rest : rest & ~(unsigned)BRDF_DIFFUSE;
    const float lights = (float)job->lights.samples, ratio = (float)o->glossy_samples / lights;
    const struct gather_mis mis = {
        1, {{rest & ~extra, 0.0f}, {extra, 1.0f / lights}, {sampled, ratio}}};
    float variance;
    const float before = added_luminance(job);
    add_uncached(job, SHADE_DIRECT, gather_direct(g, p, mis, job->lights, job->sampler, &variance));
    job->out->light_variance += sqrf(rgb_luminance(job->vertex->T)) * variance;
    job->sampler.dimension += 2;
    if (extra) sample_lights_by_brdf(job, extra, 1.0f / lights);
    job->sampler.dimension += 2;
    if (!indirect) return;
    if (o->record_maps &&
        cache_has_record_near(job->shade->cache, p->interaction.p, p->base.n, job->vertex->pixel))
        job->out->record = 1.0f;

    const unsigned caustic = plan.cached | plan.diffuse;
    struct sampler apart = job->sampler;
    apart.dimension += 32;  // beyond those that the lobes below use
    const float u_caustic = sampler_1d(&apart);
    if (plan.cached && !indirect_cached(job, &plan, entry)) {
        // No record is near: gathers for the diffuse lobe and samples the glossy one.
        plan.diffuse = plan.cached & BRDF_DIFFUSE;
        if (plan.cached & BRDF_GLOSSY) sample_lobes(job, BRDF_GLOSSY, 0.0f);
        job->worker->counts.gathered++;
    }
    if (plan.diffuse) indirect_diffuse(job, entry);
    if (plan.sampled) sample_lobes(job, plan.sampled, ratio);
    const struct photon_beside beside = {added_luminance(job) - before, u_caustic};
    if (caustic)
        add_uncached(job, SHADE_CAUSTIC,
                     photon_caustic(g->maps, g->scene, p->interaction.p, p->ng, &p->frame, &p->brdf,
                                    p->wo_l, caustic, beside));
}
