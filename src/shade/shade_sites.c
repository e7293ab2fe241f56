// SPDX-License-Identifier: Apache-2.0
// The shading points of an eye ray as sites for the cache: positions at which records may be made,
// the reflection there, and the direct light beside it [K05 6.2, 6.4].
#include "shade/shade_eye.h"

enum { LIGHT_SAMPLES = 4 };

// The distance of records from edges, at which rays might slip through gaps [K05 6.5.3].
static const float SHIFT_PIXELS = 0.5f;

// The direction to the eye in the frame of the surface without bump and normal maps, which need no
// additional records.
static vec3 base_wo(const struct shading_point *p) {
    return frame_to_local(&p->base, frame_to_world(&p->frame, p->wo_l));
}

static void add_glossy(const struct shade *shade, const struct shading_point *p,
                       struct fill_glossy *glossy) {
    glossy->table = p->lobes & BRDF_GLOSSY
                        ? cache_table(shade->records.tables, p->side, &glossy->channels)
                        : NULL;
    if (!glossy->table) return;
    glossy->brdf = brdf_white(&p->brdf);
    glossy->lobe_number = cache_lobe_number(p);
    glossy->wo = base_wo(p);
}

// Sets the members of a site for fill_adapt; direct light is by a few light samples alone.
static void add_light(const struct shade *shade, const struct shading_point *bumpy,
                      struct sampler sampler, struct fill_site *site) {
    static const struct gather_mis lights_alone = {1, {{BRDF_SMOOTH, 0.0f}}};
    const struct gather_light_samples light_samples = {LIGHT_SAMPLES,
                                                       LIGHT_SAMPLES * sampler.index};
    struct shading_point p = *bumpy;
    p.wo_l = base_wo(bumpy);
    p.frame = p.base;
    site->shading_p = p.interaction.p;
    site->diffuse = rgb_scale(brdf_albedo(&p.brdf, p.wo_l, BRDF_DIFFUSE), 1.0f / PI_F);
    site->specular = brdf_glossy_factor(&p.brdf);
    site->direct = rgb_luminance(
        gather_sample_lights(shade->g, &p, lights_alone, light_samples, sampler, NULL));
}

struct fill_site shade_site(const struct shading_point *p, float pixel, uint64_t stream,
                            unsigned kinds) {
    return (struct fill_site){.p = p->interaction.p,
                              .ng = p->interaction.ng,
                              .frame = p->base,
                              .pixel = pixel,
                              .stream = rng_mix(stream),
                              .kinds = (uint8_t)kinds};
}

int shade_sites(const struct shade *shade, int x, int y, bool adaptive, struct fill_site *out,
                int max) {
    const struct gather *g = shade->g;
    struct shade_eye eye;
    struct sampler sampler = shade_eye_sampler(g, x, y, 0, RNG_SITE);
    shade_eye_trace(shade, x, y, &sampler, &eye);
    int count = 0;
    for (int i = 0; i < eye.count && count < max; i++) {
        const struct shade_vertex *v = &eye.vertex[i];
        const struct interaction *s = &v->point.interaction;
        const unsigned kinds = cache_plan_kinds(&shade->records, &v->point);
        if (!kinds || shade_in_gap(shade, v)) continue;
        struct fill_site *site = &out[count++];
        *site =
            shade_site(&v->point, v->pixel, ((uint64_t)sampler.seed << 20) + (uint64_t)i, kinds);
        if (g->options->origin_shift)
            site->p = scene_origin_shift(g->scene, s, SHIFT_PIXELS * v->pixel);
        add_glossy(shade, &v->point, &site->glossy);
        if (adaptive) add_light(shade, &v->point, sampler, site);
    }
    return count;
}
