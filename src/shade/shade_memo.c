// SPDX-License-Identifier: Apache-2.0
// See shade_memo.h.
#include "shade/shade_memo.h"

// Directions alike: within 3.6 degrees.
#define ALIKE 0.998f
#define ROUGH 0.02f  // share of roughness
#define NEAR 2.0f    // pixels

struct shade_memo_entry *shade_memo_find(struct shade_memo *memo, const struct gather_point *p,
                                         float pixel) {
    vec3 wo = frame_to_world(&p->frame, p->wo_l);
    for (int i = 0; i < memo->count; i++) {
        struct shade_memo_entry *e = &memo->entry[i];
        if (e->side == p->side && fabsf(e->alpha - p->brdf.alpha_u) < ROUGH * e->alpha &&
            fabsf(e->exponent - p->brdf.exponent) <= 2.0f * ROUGH * e->exponent &&
            v3_dot(e->n, p->frame.n) > ALIKE && v3_dot(e->wo, wo) > ALIKE &&
            v3_dist2(e->p, p->interaction.p) < sqrf(NEAR * pixel))
            return e;
    }
    struct shade_memo_entry *e = &memo->entry[memo->next];
    memo->next = (memo->next + 1) % SHADE_MEMO;
    if (memo->count < SHADE_MEMO) memo->count++;
    *e = (struct shade_memo_entry){p->interaction.p, p->frame.n,       wo,         p->side,
                                   p->brdf.alpha_u,  p->brdf.exponent, .knows = 0u};
    return e;
}
