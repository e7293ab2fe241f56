// SPDX-License-Identifier: Apache-2.0
// Direct light at a vertex: light samples and BRDF samples, weighted by the power heuristic [Veach
// 1997, 9.2]. A glossy lobe takes several BRDF samples, because light samples cannot replace them:
// where the floor of a room reflects its windows, a light sample is rarely in the lobe, and a
// sample of the lobe often beside the window. The lobes are sampled one
// by one, because a faint coat would get few of the samples of all lobes together. A diffuse lobe
// takes one: it only meets the light that light samples miss.
#include "shade/shade_two_pass.h"

// The light that one BRDF sample of `lobes` finds, weighted against the light samples.
static rgb find_light(const struct shade_lighting *lighting, unsigned lobes, float ratio,
                      struct sampler u) {
    const struct gather *g = lighting->shade->g;
    const struct shading_point *p = &lighting->vertex->point;
    const rgb none = rgb_grey(0.0f);
    struct brdf_sample b;
    const vec2 uv = sampler_2d(&u);
    if (!brdf_sample_wi(&p->brdf, p->wo_l, sampler_1d(&u), uv, lobes, BRDF_RADIANCE, &b))
        return none;
    const vec3 d = frame_to_world(&p->frame, b.wi);
    const int panes = gather_panes(g, lighting->vertex->depth);
    struct light_found found;
    if (!light_find(g->scene, p->interaction.p, p->interaction.ng, d, panes, &found)) return none;
    const struct interaction *hit = found.environment ? NULL : &found.hit;
    const float light_pdf =
        gather_light_pdf(g, p->interaction.p, lighting->visibility, &found.connection, hit);
    return rgb_scale(rgb_mul(b.weight, found.L), mis_power(ratio * b.pdf_w, light_pdf));
}

// Adds `count` of `all` BRDF samples of the lobes; gather rays are the others. Returns the variance
// of the luminance of one, 0 if there are less than two.
static float add_brdf_samples(struct shade_lighting *lighting, unsigned lobes, int count, int all,
                              uint32_t first) {
    const float ratio = (float)all / (float)lighting->samples.light.count;
    rgb sum = rgb_grey(0.0f);
    float squares = 0.0f;
    for (int i = 0; i < count; i++) {
        const struct sampler u = {first + (uint32_t)i, lighting->sampler.seed,
                                  lighting->sampler.dimension};
        const rgb L = find_light(lighting, lobes, ratio, u);
        sum = rgb_add(sum, L);
        squares += sqrf(rgb_luminance(L));
    }
    shade_add_uncached(lighting, SHADE_DIRECT, rgb_scale(sum, 1.0f / (float)all));
    const float n = (float)count;
    return count > 1 ? fmaxf(squares - sqrf(rgb_luminance(sum)) / n, 0.0f) / (n - 1.0f) : 0.0f;
}

int shade_direct(struct shade_lighting *lighting, unsigned sampled, int rays) {
    const struct gather *g = lighting->shade->g;
    const struct shading_point *p = &lighting->vertex->point;
    const struct shade_sample_counts samples = lighting->samples;
    const int lights = samples.light.count;
    const int of_glossy = g->rays_find_lights ? samples.lobe.count : 0;
    const int of_sampled = of_glossy > rays ? of_glossy : rays;
    const unsigned diffuse = p->lobes & BRDF_DIFFUSE & ~sampled;
    const unsigned glossy = p->lobes & BRDF_SMOOTH & ~sampled & ~diffuse;
    const bool by_diffuse = diffuse && g->wide_lights;
    const struct gather_mis mis = {lighting->vertex->depth,
                                   {{diffuse, by_diffuse ? 1.0f / (float)lights : 0.0f},
                                    {glossy, (float)of_glossy / (float)lights},
                                    {sampled, (float)of_sampled / (float)lights}}};
    float by_light, by_lobe = 0.0f;
    shade_add_uncached(
        lighting, SHADE_DIRECT,
        gather_sample_lights(g, p, mis, samples.light, lighting->sampler, &by_light));
    lighting->sampler.dimension += 2;
    struct light_product product;
    lighting->visibility = gather_visibility(g, p, &product);
    if (by_diffuse) add_brdf_samples(lighting, diffuse, 1, 1, lighting->sampler.index);
    lighting->sampler.dimension += 2;
    if (glossy && of_glossy)
        by_lobe += add_brdf_samples(lighting, glossy, of_glossy, of_glossy, samples.lobe.first);
    if (sampled && of_sampled > rays)
        by_lobe +=
            add_brdf_samples(lighting, sampled, of_sampled - rays, of_sampled, samples.lobe.first);
    lighting->sampler.dimension += 2;
    const float T2 = sqrf(rgb_luminance(lighting->vertex->T));
    lighting->out->light_variance += T2 * by_light;
    lighting->out->lobe_variance += T2 * by_lobe;
    return of_sampled;
}
