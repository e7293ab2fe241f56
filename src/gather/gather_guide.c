// SPDX-License-Identifier: Apache-2.0
// Guided rays: a hemisphere's even rays meet a small bright place by luck; some more rays go to
// each one that the site sees. Together they are one estimate by the balance heuristic [Veach and
// Guibas 1995]: every ray, whichever way it was drawn, counts by the density of the even rays over
// that of all, so nothing is counted twice and no light is left out where a place was not guessed.
#include "gather/gather_guide.h"

#include "base/rng.h"

// The deviation of what comes from one place over all, below which luck is good enough.
static const float LUCK = 0.01f;
// The same that guided rays should reach, and that of one of them that meets its place, over its
// mean.
static const float AIM = 0.01f, SPREAD = 0.5f;

enum { LEAST = 8, MOST = 256 };  // rays of one cone, powers of 2: whole nets

// How many rays a place is worth that sends a `share` of the light.
static int worth(const struct photon_cone *cone, float share, size_t even) {
    if (!(share > LUCK * sqrtf((float)even * cone->chance))) return 0;
    const float missed = 1.0f / clampf(cone->filled, 0.01f, 1.0f) - 1.0f;
    const float wanted = sqrf(share / AIM) * (sqrf(SPREAD) + missed);
    int rays = LEAST;
    while (rays < MOST && (float)rays < wanted) rays *= 2;
    return rays;
}

static float solid_angle(const struct photon_cone *cone) { return 2.0f * PI_F * cone->versine; }

// Deals rays to the cones and drops those that get none.
static void deal(struct gather_guide *guide, float expected, size_t even) {
    float all = expected;
    for (int i = 0; i < guide->count; i++) all += guide->cone[i].E;
    int total = 0, kept = 0;
    for (int i = 0; i < guide->count; i++) {
        guide->rays[i] = worth(&guide->cone[i], guide->cone[i].E / all, even);
        total += guide->rays[i];
    }
    // No more than half as many as there are without.
    int halvings = 0;
    while (total >> halvings > (int)(even / 2)) halvings++;
    for (int i = 0; i < guide->count; i++) {
        const int rays = guide->rays[i] >> halvings;
        if (rays == 0) continue;
        guide->cone[kept] = guide->cone[i];
        guide->rays[kept] = rays;
        guide->density[kept] = (float)rays / solid_angle(&guide->cone[i]);
        guide->dealt += rays;
        kept++;
    }
    guide->count = kept;
}

vec3 gather_guide_in_cone(const struct photon_cone *cone, vec2 u) {
    // As sample_uniform_cone, which has no digits left for the narrowest.
    const struct frame frame = frame_from_normal(cone->axis);
    const float away = u.x * cone->versine, sine = safe_sqrtf(away * (2.0f - away));
    const float phi = 2.0f * PI_F * u.y;
    return frame_to_world(&frame, v3(sine * cosf(phi), sine * sinf(phi), 1.0f - away));
}

// Whether a direction is in the cone: |w - axis|^2 = 2 (1 - cosine) keeps the digits.
bool gather_guide_holds(const struct photon_cone *cone, vec3 w) {
    return v3_dist2(w, cone->axis) <= 2.0f * cone->versine;
}

size_t gather_guide_rays(const struct gather *g, const struct gather_layout *layout,
                         const struct gather_site *site, struct gather_scratch *scratch) {
    const size_t even = gather_layout_rays(layout);
    const struct photon_eye eye = {site->p, site->frame.n, site->ng};
    struct gather_guide *guide = &scratch->guide;
    float expected = 0.0f;
    *guide = (struct gather_guide){.frame = site->frame, .p = site->p};
    if (!g->options->gather_guide) return 0;
    guide->count = photon_bright_cones(g->maps, g->scene, &eye, guide->cone, &expected);
    guide->expected = expected;
    guide->near.found = -1;
    if (guide->count == 0) return 0;
    deal(guide, expected, even);
    size_t i = even;
    for (int c = 0; c < guide->count; c++) {
        guide->first[c] = i;
        const uint32_t seed = (uint32_t)rng_mix(site->stream + 0x9e3779b97f4a7c15ull * (size_t)c);
        for (int k = 0; k < guide->rays[c]; k++) {
            const vec3 w = gather_guide_in_cone(&guide->cone[c], sample_sobol2((uint32_t)k, seed));
            const vec3 local = frame_to_local(&site->frame, w);
            if (!(local.z > 0.0f)) continue;
            scratch->x[i] = local.x;
            scratch->y[i] = local.y;
            scratch->z[i] = local.z;
            scratch->rays[i] = (struct gather_ray){
                .ray = scene_spawn(g->scene, site->p, site->ng, w),
                .item = (uint32_t)i,
                .spread = g->options->texture_filter ? sqrtf(1.0f / guide->density[c]) : 0.0f,
            };
            i++;
        }
    }
    return guide->made = i - even;
}

void gather_guide_weigh(const struct gather_layout *layout, struct gather_scratch *scratch) {
    const struct gather_guide *guide = &scratch->guide;
    const size_t even = gather_layout_rays(layout), count = even + guide->made;
    if (guide->count == 0) return;
    int own = -1;  // the cone that a guided ray was drawn from, whatever the last digit says
    for (size_t i = 0; i < count; i++) {
        while (own + 1 < guide->count && i >= guide->first[own + 1]) own++;
        struct gather_ray *ray = &scratch->rays[i];
        float density = (float)even * (layout->order ? 0.5f / PI_F : scratch->z[i] / PI_F);
        float all = density;
        for (int c = 0; c < guide->count; c++)
            if (c == own || gather_guide_holds(&guide->cone[c], ray->ray.d))
                all += guide->density[c];
        ray->L = rgb_scale(ray->L, density / all);
    }
}
