// SPDX-License-Identifier: Apache-2.0
// From a surface point to the BRDF there: chooses the side and the component of a blend, looks up
// textures and sets the frame. The side is that of the shading normal, as in the cosines of the
// BRDF.
//
// A blend is not evaluated as a sum: one component is drawn for each point and direction. Where the
// noise of that would be visible, all components are evaluated in turn. So each component is cached
// or sampled in its own way.
#include <string.h>

#include "base/rng.h"
#include "scene/scene_opacity.h"

static void visit(const struct material_side *side,
                  void (*fn)(void *ctx, const struct material_side *side), void *ctx) {
    if (!side->component[0]) {
        fn(ctx, side);
        return;
    }
    visit(side->component[0], fn, ctx);
    visit(side->component[1], fn, ctx);
}

void scene_material_visit(const struct material *m,
                          void (*fn)(void *ctx, const struct material_side *side), void *ctx) {
    visit(&m->front, fn, ctx);
    if (m->two_sided) visit(&m->back, fn, ctx);
}

// Sides are of the material or of the scene's arena, and so may be changed with the material.
static void polish_side(void *ctx, const struct material_side *side) {
    (void)ctx;
    if (side->slot[BRDF_SLOT_ALPHA_U] || side->slot[BRDF_SLOT_ALPHA_V]) return;
    brdf_polish(&((struct material_side *)side)->base);
}

void scene_material_polish(struct material *m) { scene_material_visit(m, polish_side, NULL); }

// Properties of all sides of a material together.
struct union_of {
    bool holes;  // whether holes count
    bool transmits;
    unsigned lobes;
};

static void add_side(void *ctx, const struct material_side *side) {
    struct union_of *all = ctx;
    if (side->holes && !all->holes) return;
    all->transmits |= side->base.model->transmits;
    all->lobes |= side->base.model->lobes;
}

bool scene_material_transmits(const struct material *m, bool holes) {
    struct union_of all = {.holes = holes};
    scene_material_visit(m, add_side, &all);
    return all.transmits;
}

unsigned scene_material_lobes(const struct material *m, bool holes) {
    struct union_of all = {.holes = holes};
    scene_material_visit(m, add_side, &all);
    return all.lobes;
}

// ---- Components of a blend ----------------------------------------------------------------------

static bool is_from_behind(const struct interaction *s, vec3 wo) {
    return v3_dot(wo, s->frame.n) < 0.0f;
}

static const struct material_side *side_towards(const struct satin_scene *scene,
                                                const struct interaction *s, vec3 wo) {
    const struct material *m = &scene->material[s->material];
    return m->two_sided && is_from_behind(s, wo) ? &m->back : &m->front;
}

static bool side_is_hole(const struct material_side *side) {
    return side->holes && !side->component[0];
}

// The weight of component[1]. If rays pass the holes, it is the weight among the other components.
static float blend_weight(const struct satin_scene *scene, const struct material_side *side,
                          const struct interaction *s) {
    const struct material_side *first = side->component[0], *second = side->component[1];
    const bool passed = side->holes && s->light < 0;
    if (passed && (side_is_hole(first) || side_is_hole(second)))
        return side_is_hole(first) ? 1.0f : 0.0f;
    struct texture_lookup at = scene_interaction_texture_lookup(scene, s);
    float weight = scene_opacity_weight(side, &at);
    if (!passed) return weight;
    float a = (1.0f - weight) * scene_opacity_side(first, &at),
          b = weight * scene_opacity_side(second, &at);
    return a + b > 0.0f ? b / (a + b) : weight;  // 0 where rounded uv are in a hole
}

static int list_components(const struct satin_scene *scene, const struct material_side *side,
                           const struct interaction *s, float weight, struct scene_component *out,
                           int count) {
    if (!(weight > 0.0f) || count == MATERIAL_COMPONENTS_MAX) return count;
    if (!side->component[0]) {
        out[count] = (struct scene_component){side, weight};
        return count + 1;
    }
    float second = blend_weight(scene, side, s);
    count = list_components(scene, side->component[0], s, weight * (1.0f - second), out, count);
    return list_components(scene, side->component[1], s, weight * second, out, count);
}

int scene_components(const struct satin_scene *scene, const struct interaction *s, vec3 wo,
                     struct scene_component out[MATERIAL_COMPONENTS_MAX]) {
    return list_components(scene, side_towards(scene, s, wo), s, 1.0f, out, 0);
}

// A number in [0, 1) that is a function of the point and the direction.
static float component_number(const struct interaction *s, vec3 wo) {
    const float f[6] = {s->p.x, s->p.y, s->p.z, wo.x, wo.y, wo.z};
    uint32_t bits[6];
    uint64_t key = 0x5851f42d4c957f2dull;
    memcpy(bits, f, sizeof bits);
    for (int i = 0; i < 6; i += 2) key = rng_mix(key ^ ((uint64_t)bits[i] << 32 | bits[i + 1]));
    return (float)(key >> 40) * 0x1p-24f;
}

const struct material_side *scene_draw_component(const struct satin_scene *scene,
                                                 const struct interaction *s, vec3 wo) {
    const struct material_side *side = side_towards(scene, s, wo);
    if (!side->component[0]) return side;
    float u = component_number(s, wo);
    while (side->component[0]) {
        float second = blend_weight(scene, side, s);
        bool take = u < second;
        u = take ? u / second : (u - second) / (1.0f - second);
        side = side->component[take];
    }
    return side;
}

// ---- The BRDF of a component --------------------------------------------------------------------

// Clamps a texture's number to the valid range of a slot.
static float clamp_number(enum brdf_slot slot, float x) {
    return slot == BRDF_SLOT_IOR ? clampf(x, BRDF_IOR_MIN, BRDF_IOR_MAX) : clampf(x, 0.0f, 1e6f);
}

// A colour from a texture, whose values may be any: of a reflectance or transmittance no more than
// 1 counts, as photons and paths would become stronger at each bounce.
static rgb clamp_reflectance(enum brdf_slot slot, rgb x) {
    return slot < BRDF_SLOT_ETA ? rgb_at_most(x, 1.0f) : x;
}

// Sets the values of `b` that are textured. Colours are averaged over the footprint, unless a
// texture decides where they are shown.
static void set_brdf_values(const struct material_side *side, const struct texture_lookup *at,
                            struct brdf *b) {
    const struct texture *const *slot = side->slot;
    struct texture_lookup point = *at;
    point.width = 0.0f;
    for (enum brdf_slot i = 0; i < BRDF_SLOT_COUNT; i++) {
        if (!slot[i]) continue;
        if (i < BRDF_SLOT_NUMBERS)
            *brdf_color(b, i) =
                clamp_reflectance(i, scene_texture_eval(slot[i], side->pointwise ? &point : at));
        else
            *brdf_number(b, i) = clamp_number(i, scene_texture_number(slot[i], &point));
    }
}

// Whether wo is behind a surface that is two-sided or a thin sheet, which reflects there as from
// the front.
static bool is_flipped(const struct satin_scene *scene, const struct material_side *side,
                       const struct interaction *s, vec3 wo) {
    if (!is_from_behind(s, wo)) return false;
    return side->base.model->thin || (scene->material[s->material].two_sided && !side->one_sided);
}

struct frame scene_component_frame(const struct satin_scene *scene,
                                   const struct material_side *side, const struct interaction *s,
                                   vec3 wo) {
    return is_flipped(scene, side, s, wo) ? frame_flip(s->frame) : s->frame;
}

// The normal of a bump or normal map, of any length, in the frame that it rotates.
static vec3 bump_normal(const struct satin_scene *scene, const struct material_bump *bump,
                        const struct interaction *s, const struct frame *frame) {
    if (bump->normal) {
        struct texture_lookup at = scene_interaction_texture_lookup(scene, s);
        at.width = 0.0f;
        rgb c = scene_texture_eval(bump->normal, &at);
        return v3(2.0f * c.r - 1.0f, 2.0f * c.g - 1.0f, 2.0f * c.b - 1.0f);
    }
    vec2 slope = scene_texture_gradient(bump->height, s->uv);
    vec3 n = frame->n, u = s->dp_du, v = s->dp_dv;
    u = v3_mad(u, bump->scale * slope.x - v3_dot(n, u), n);
    v = v3_mad(v, bump->scale * slope.y - v3_dot(n, v), n);
    n = v3_cross(u, v);
    return frame_to_local(frame, v3_dot(n, s->ng) < 0.0f ? v3_neg(n) : n);
}

// Rotates `frame` by a bump or normal map whose normal is n for direction wo. False if the frame
// stays as it is. *shadows is set to the alpha^2 of its slopes.
static bool rotate_frame(const struct material_bump *bump, vec3 n, vec3 wo, bool flipped,
                         struct frame *frame, float *shadows) {
    vec3 w = frame_to_local(frame, wo);
    // frame_flip keeps u and negates v.
    if (flipped) n = bump->outside ? v3(-n.x, n.y, n.z) : v3(n.x, -n.y, n.z);
    if (bump->upright && w.z * v3_dot(w, n) <= 0.0f) n = v3(-n.x, -n.y, n.z);
    float length = v3_len(n);
    if (!(length > 0.0f && isfinite(length))) return false;
    n = v3_mul(n, 1.0f / length);
    if (n.z >= 1.0f) return false;
    *frame = frame_from_tangent(frame_to_world(frame, n), frame->u);
    float c2 = n.z * n.z;
    *shadows = bump->shadows ? minf(0.125f * (1.0f - c2) / maxf(c2, 1e-12f), 1.0f) : 0.0f;
    return true;
}

// Rotates `frame` by the bump and normal maps of a side, the outermost first, and stores in the
// BRDF what their shadowing needs.
static void apply_bumps(const struct satin_scene *scene, const struct material_side *side,
                        const struct interaction *s, vec3 wo, struct frame *frame, struct brdf *b) {
    const bool flipped = is_flipped(scene, side, s, wo);
    vec3 up[BRDF_BUMPS_MAX];
    int rotated = 0;
    for (int i = 0; i < BRDF_BUMPS_MAX && scene_bump_used(&side->bump[i]); i++) {
        const struct frame front = flipped ? frame_flip(*frame) : *frame;
        vec3 n = bump_normal(scene, &side->bump[i], s, &front);
        up[rotated] = frame->n;
        rotated += rotate_frame(&side->bump[i], n, wo, flipped, frame, &b->bump[rotated]);
    }
    for (int i = 0; i < rotated; i++) b->base[i] = frame_to_local(frame, up[i]);
}

bool scene_component_brdf(const struct satin_scene *scene, const struct material_side *side,
                          const struct interaction *s, vec3 wo, struct brdf *brdf,
                          struct frame *frame) {
    const bool flipped = is_flipped(scene, side, s, wo);
    if (is_from_behind(s, wo) && !flipped && !brdf_transmits(&side->base)) return false;
    *brdf = side->base;
    struct texture_lookup at = scene_interaction_texture_lookup(scene, s);
    set_brdf_values(side, &at, brdf);
    *frame = flipped ? frame_flip(s->frame) : s->frame;
    if (scene_bump_used(&side->bump[0])) apply_bumps(scene, side, s, wo, frame, brdf);
    return brdf_lobes(brdf) != 0;
}

bool scene_brdf(const struct satin_scene *scene, const struct interaction *s, vec3 wo,
                struct brdf *brdf, struct frame *frame) {
    return scene_component_brdf(scene, scene_draw_component(scene, s, wo), s, wo, brdf, frame);
}
