// SPDX-License-Identifier: Apache-2.0
// The eye's points as adaptive caching asks for them: how a record's light would be reflected, and
// the direct light beside it [K05 6.2, 6.4].
#include "shade/shade_eye.h"
#include "shade/shade_records.h"

enum { LIGHT_SAMPLES = 4 };

// The point that a site was made from, without its bumps: they spend no records.
static struct gather_point find(const struct shade *shade, const struct cache_site *site,
                                struct sampler *sampler) {
    struct shade_eye eye;
    const uint32_t width = (uint32_t)shade->g->options->width;
    int x = (int)(site->source % width), y = (int)(site->source / width);
    *sampler = shade_eye_sampler(shade->g, x, y, 0, RNG_SITE);
    shade_eye_trace(shade, x, y, sampler, &eye);
    struct gather_point p = eye.vertex[site->vertex].point;
    p.wo_l = frame_to_local(&p.base, frame_to_world(&p.frame, p.wo_l));
    p.frame = p.base;
    return p;
}

void shade_surface(const struct shade *shade, const struct cache_site *site, struct cache_place *at,
                   struct cache_surface *out) {
    struct sampler sampler;
    const struct gather_point p = find(shade, site, &sampler);
    *at = (struct cache_place){p.interaction.p, p.base.n, p.base, 0.0f};
    out->diffuse = rgb_scale(brdf_albedo(&p.brdf, p.wo_l, BRDF_DIFFUSE), 1.0f / PI_F);
    out->lobe = (struct cache_lobe){.C = out->coefficients};
    shade_lobe_name(&p, &out->lobe);
    out->specular = p.brdf.specular;
    const struct brdf_range *table =
        p.lobes & BRDF_GLOSSY ? shade_table(shade, &p, &out->lobe.channels) : NULL;
    if (table) out->lobe.order = brdf_range_lookup(table, &p.brdf, p.wo_l, out->coefficients);
}

float shade_surface_direct(const struct shade *shade, const struct cache_site *site) {
    static const struct gather_mis lights_alone = {1, {{BRDF_SMOOTH, 0.0f}}};
    struct sampler sampler;
    const struct gather_point p = find(shade, site, &sampler);
    return rgb_luminance(gather_direct(
        shade->g, &p, lights_alone,
        (struct gather_lights){LIGHT_SAMPLES, LIGHT_SAMPLES * sampler.index}, sampler, NULL));
}

bool shade_view(const struct shade *shade, const struct cache_site *site, struct cache_view *out) {
    struct sampler sampler;
    struct cache_lobe lobe;
    const struct gather_point p = find(shade, site, &sampler);
    if (!(p.lobes & BRDF_GLOSSY)) return false;
    shade_lobe_name(&p, &lobe);
    out->table = shade_table(shade, &p, &out->channels);
    out->brdf = p.brdf;
    out->brdf.specular = rgb_grey(1.0f);
    out->name = lobe.name;
    out->wo = p.wo_l;
    return out->table && out->name;
}
