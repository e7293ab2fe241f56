// SPDX-License-Identifier: Apache-2.0
// What a glossy lobe of a sample of the image reads of the first pass.
#include "shade/shade_eye.h"

bool shade_look_up(const struct shade *shade, int x, int y, uint32_t index,
                   struct shade_lookup *out) {
    const struct gather *g = shade->g;
    struct shade_eye eye;
    struct sampler sampler = shade_eye_sampler(g, x, y, index, RNG_PIXEL);
    shade_eye_trace(shade, x, y, &sampler, &eye);
    float probability;
    const struct shade_vertex *v = shade_eye_choose(&eye, sampler_1d(&sampler), &probability);
    if (!v || !(v->point.lobes & BRDF_GLOSSY) || !gather_indirect(g->options, v->depth))
        return false;
    const struct shading_point *p = &v->point;
    struct brdf_sample b;
    const float u_lobe = sampler_1d(&sampler);
    const vec2 u = sampler_2d(&sampler);
    if (!brdf_sample_wi(&p->brdf, p->wo_l, u_lobe, u, BRDF_GLOSSY, BRDF_RADIANCE, &b)) return false;
    const struct ray ray =
        scene_spawn(g->scene, p->interaction.p, p->interaction.ng, frame_to_world(&p->frame, b.wi));
    if (!gather_look_up(g, ray, b.pdf_w, &sampler, &out->read) || out->read.entry < 0) return false;
    out->Y = rgb_luminance(rgb_mul(v->T, rgb_mul(b.weight, out->read.L))) / probability;
    return true;
}
