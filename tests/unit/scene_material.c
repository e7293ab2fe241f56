// SPDX-License-Identifier: Apache-2.0
// The BRDF at a surface point: sides, frames, textures.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "scene/scene.h"

static struct shape scene_material_shape;  // the one that surface interactions are on

static struct interaction interaction_facing(vec3 n) {
    return (struct interaction){.ng = n, .frame = frame_from_normal(n), .uv = {0.25f, 0.25f}};
}

static void sides_have_their_frames(void **state) {
    (void)state;
    struct material material = {
        .front.base = {.model = brdf_find("diffuse"), .diffuse = {.2f, .3f, .4f}},
        .back.base = {.model = brdf_find("phong"), .specular = {1, 1, 1}, .exponent = 5},
    };
    struct satin_scene scene = {
        .shape = &scene_material_shape, .material = &material, .material_count = 1};
    vec3 n = v3_unit(v3(1, 2, 3)), tilted = v3_unit(v3(2, 2, 2));
    struct interaction s = interaction_facing(n);
    struct brdf b;
    struct frame f;
    assert_true(scene_brdf(&scene, &s, tilted, &b, &f));
    assert_ptr_equal(b.model, material.front.base.model);
    assert_true(frame_to_local(&f, tilted).z > 0.0f);
    assert_false(scene_brdf(&scene, &s, v3_neg(tilted), &b, &f));  // one-sided

    material.two_sided = true;
    assert_true(scene_brdf(&scene, &s, v3_neg(tilted), &b, &f));
    assert_ptr_equal(b.model, material.back.base.model);
    assert_true(frame_to_local(&f, v3_neg(tilted)).z > 0.0f);
    assert_true(v3_dot(v3_cross(f.u, f.v), f.n) > 0.999f);  // still right-handed

    material.two_sided = false;
    material.front.base.model = brdf_find("dielectric");
    material.front.base.specular = rgb_grey(1.0f);
    assert_true(scene_brdf(&scene, &s, v3_neg(tilted), &b, &f));
    assert_true(frame_to_local(&f, v3_neg(tilted)).z < 0.0f);  // glass keeps its frame

    material.front.base = (struct brdf){.model = brdf_find("diffuse")};
    assert_false(scene_brdf(&scene, &s, tilted, &b, &f));  // black
}

static void textures_replace_the_values_of_slots(void **state) {
    (void)state;
    const struct texture colour = {.kind = TEXTURE_CONSTANT, .value = {.1f, .5f, .9f}};
    const struct texture number = {.kind = TEXTURE_CONSTANT, .value = {.3f, .3f, .3f}};
    struct material material = {
        .front.base = {.model = brdf_find("ward"), .alpha_u = .1f, .alpha_v = .1f, .exponent = 7}};
    struct satin_scene scene = {
        .shape = &scene_material_shape, .material = &material, .material_count = 1};
    struct interaction s = interaction_facing(v3(0, 0, 1));
    struct brdf b;
    struct frame f;
    material.front.slot[BRDF_SLOT_DIFFUSE] = &colour;
    material.front.slot[BRDF_SLOT_ALPHA_V] = &number;
    assert_true(scene_brdf(&scene, &s, v3(0, 0, 1), &b, &f));
    assert_true(b.diffuse.g == .5f && b.diffuse.b == .9f && rgb_black(b.specular));
    assert_true(b.alpha_u == .1f && fabsf(b.alpha_v - .3f) < 1e-6f && b.exponent == 7.0f);
    assert_true(rgb_black(material.front.base.diffuse));  // the material is untouched
    const struct texture negative = {.kind = TEXTURE_CONSTANT, .value = {-3, -3, -3}};
    material.front.slot[BRDF_SLOT_EXPONENT] = &negative;
    assert_true(scene_brdf(&scene, &s, v3(0, 0, 1), &b, &f));
    assert_true(b.exponent == 0.0f);
    // No more than 1 counts of a reflectance, but all of an index of refraction.
    const struct texture bright = {.kind = TEXTURE_CONSTANT, .value = {100, .5f, 2}};
    material.front.slot[BRDF_SLOT_DIFFUSE] = material.front.slot[BRDF_SLOT_SPECULAR] = &bright;
    material.front.slot[BRDF_SLOT_ETA] = &bright;
    assert_true(scene_brdf(&scene, &s, v3(0, 0, 1), &b, &f));
    assert_true(b.diffuse.r == 1.0f && b.diffuse.g == .5f && b.specular.b == 1.0f);
    assert_true(b.eta.r == 100.0f);
}

// A component of a surface with holes is drawn among those that are not holes, by weight times
// opacity; surfaces that emit light have no holes.
static void holes_are_no_components(void **state) {
    (void)state;
    const struct material_side leaf[3] = {
        {.base = {.model = brdf_find("diffuse"), .diffuse = {1, 1, 1}}},
        {.base = {.model = brdf_find("phong"), .specular = {1, 1, 1}}},
        {.base = {.model = brdf_find("null"), .transmittance = {1, 1, 1}}, .holes = true}};
    const struct material_side mask = {
        .component = {&leaf[2], &leaf[0]}, .weight = 0.25f, .holes = true};
    struct material material = {
        .front = {.component = {&mask, &leaf[1]}, .weight = 0.1f, .holes = true}};
    struct satin_scene scene = {
        .shape = &scene_material_shape, .material = &material, .material_count = 1};
    struct interaction s = interaction_facing(v3(0, 0, 1));
    struct scene_component part[MATERIAL_COMPONENTS_MAX];
    s.light = -1;
    const float there = 0.9f * 0.25f + 0.1f, diffuse = 0.9f * 0.25f / there;
    assert_int_equal(scene_components(&scene, &s, v3(0, 0, 1), part), 2);
    assert_true(part[0].side == &leaf[0] && fabsf(part[0].weight - diffuse) < 1e-6f);
    assert_true(part[1].side == &leaf[1] && fabsf(part[1].weight - 0.1f / there) < 1e-6f);
    enum { DRAWS = 20000 };
    int count = 0;
    for (int i = 0; i < DRAWS; i++) {
        s.p = v3((float)i * 0.37f, 1.0f, 2.0f);
        const struct material_side *side = scene_draw_component(&scene, &s, v3(0, 0, 1));
        assert_ptr_not_equal(side, &leaf[2]);
        count += side == &leaf[0];
    }
    assert_true(fabsf((float)count / DRAWS - diffuse) <
                4.0f * sqrtf(diffuse * (1.0f - diffuse) / DRAWS));
    s.light = 0;
    assert_int_equal(scene_components(&scene, &s, v3(0, 0, 1), part), 3);
    assert_true(part[0].side == &leaf[2] && fabsf(part[0].weight - 0.9f * 0.75f) < 1e-6f);
}

// A blend lists its components with their weights, and draws them in proportion.
static void blends_draw_their_components(void **state) {
    (void)state;
    const struct texture third = {.kind = TEXTURE_CONSTANT, .value = {1 / 3.f, 1 / 3.f, 1 / 3.f}};
    const struct material_side leaf[3] = {
        {.base = {.model = brdf_find("diffuse"), .diffuse = {1, 1, 1}}},
        {.base = {.model = brdf_find("phong"), .specular = {1, 1, 1}}},
        {.base = {.model = brdf_find("null"), .transmittance = {1, 1, 1}}}};
    const struct material_side pair = {.component = {&leaf[0], &leaf[1]}, .weight = 0.25f};
    struct material material = {.front = {.component = {&pair, &leaf[2]}, .blend = &third}};
    struct satin_scene scene = {
        .shape = &scene_material_shape, .material = &material, .material_count = 1};
    struct interaction s = interaction_facing(v3(0, 0, 1));
    struct scene_component part[MATERIAL_COMPONENTS_MAX];
    const float want[3] = {0.5f, 1 / 6.f, 1 / 3.f};
    assert_int_equal(scene_components(&scene, &s, v3(0, 0, 1), part), 3);
    for (int i = 0; i < 3; i++)
        assert_true(part[i].side == &leaf[i] && fabsf(part[i].weight - want[i]) < 1e-6f);

    enum { DRAWS = 20000 };
    int count[3] = {0};
    for (int i = 0; i < DRAWS; i++) {
        s.p = v3((float)i * 0.37f, 1.0f, 2.0f);
        count[scene_draw_component(&scene, &s, v3(0, 0, 1)) - leaf]++;
    }
    for (int i = 0; i < 3; i++)
        assert_true(fabsf((float)count[i] / DRAWS - want[i]) < 4.0f * sqrtf(0.25f / DRAWS));
    struct brdf b;
    struct frame f;
    assert_false(scene_component_brdf(&scene, &leaf[0], &s, v3(0, 0, -1), &b, &f));
    assert_true(scene_component_brdf(&scene, &leaf[2], &s, v3(0, 0, -1), &b, &f));
}

static struct material white_under(struct material_bump outer, struct material_bump inner) {
    struct material m = {.front.base = {.model = brdf_find("diffuse"), .diffuse = {1, 1, 1}},
                         .front.bump = {outer, inner},
                         .two_sided = true,
                         .tangent = true};
    m.back = m.front;
    return m;
}

// A tilted normal rotates the frame, on both sides of a twosided material; the geometric surface
// still bounds the light.
static void bumps_rotate_the_frame(void **state) {
    (void)state;
    const struct texture tilt = {.kind = TEXTURE_CONSTANT,
                                 .value = {.8f, .5f, .9f}};  // (.6, 0, .8)
    const struct material_bump bump = {.normal = &tilt, .upright = true, .shadows = true};
    struct material m = white_under(bump, (struct material_bump){.normal = NULL});
    struct satin_scene scene = {
        .shape = &scene_material_shape, .material = &m, .material_count = 1};
    struct interaction s = interaction_facing(v3(0, 0, 1));
    struct brdf b;
    struct frame f;
    vec3 x = s.frame.u, n = s.frame.n;
    assert_true(scene_brdf(&scene, &s, n, &b, &f));
    assert_true(v3_dist2(f.n, v3_mad(v3_mul(n, .8f), .6f, x)) < 1e-10f);
    assert_true(v3_dist2(frame_to_world(&f, b.base[0]), n) < 1e-10f);
    assert_true(fabsf(b.bump[0] - 0.125f * 0.5625f) < 1e-6f);
    // The direction is behind the facet but above the surface, and the other way round.
    vec3 wo = frame_to_local(&f, n), under = v3_unit(v3_mad(v3_mul(x, -1), .2f, n));
    assert_true(rgb_black(brdf_eval(&b, wo, frame_to_local(&f, under), BRDF_ALL)));
    under = v3_unit(v3_mad(x, -.2f, n));
    assert_true(frame_to_local(&f, under).z > 0.0f);
    assert_true(rgb_black(brdf_eval(&b, wo, frame_to_local(&f, under), BRDF_ALL)));
    // From directions from which the facet faces away, it is mirrored.
    assert_true(scene_brdf(&scene, &s, v3_unit(v3_mad(v3_mul(x, -1), .2f, n)), &b, &f));
    assert_true(v3_dot(f.n, x) < -0.5f);
    // From behind, twosided around the map mirrors it at the surface, but the map around twosided
    // does not.
    assert_true(scene_brdf(&scene, &s, v3_neg(n), &b, &f));
    assert_true(v3_dist2(f.n, v3_mad(v3_mul(n, -.8f), .6f, x)) < 1e-10f);
    m.back.bump[0].outside = true;
    assert_true(scene_brdf(&scene, &s, v3_neg(n), &b, &f));
    assert_true(v3_dist2(f.n, v3_mad(v3_mul(n, -.8f), -.6f, x)) < 1e-10f);
}

// A map in a map rotates the frame that the outer one has rotated; both hide directions behind
// them. From behind, maps around twosided are the same surface.
static void bumps_rotate_one_after_another(void **state) {
    (void)state;
    const struct texture right = {.kind = TEXTURE_CONSTANT, .value = {.8f, .5f, .9f}},
                         left = {.kind = TEXTURE_CONSTANT, .value = {.3f, .5f, .95826f}};
    const struct material_bump outer = {.normal = &right, .shadows = true, .outside = true},
                               inner = {.normal = &left, .shadows = true, .outside = true};
    struct material m = white_under(outer, inner);
    struct satin_scene scene = {
        .shape = &scene_material_shape, .material = &m, .material_count = 1};
    struct interaction s = interaction_facing(v3(0, 0, 1));
    struct brdf b;
    struct frame f;
    const vec3 x = s.frame.u, n = s.frame.n, first = v3_mad(v3_mul(n, .8f), .6f, x);
    const float angle = asinf(.6f) - asinf(.4f);
    const vec3 want = v3_mad(v3_mul(n, cosf(angle)), sinf(angle), x);
    assert_true(scene_brdf(&scene, &s, n, &b, &f));
    assert_true(v3_dist2(f.n, want) < 1e-8f);
    assert_true(v3_dist2(frame_to_world(&f, b.base[0]), n) < 1e-8f);
    assert_true(v3_dist2(frame_to_world(&f, b.base[1]), first) < 1e-8f);
    assert_true(fabsf(b.bump[1] - 0.125f * .16f / .84f) < 1e-5f);
    // The direction is above the surface and the last facet, but behind the first.
    vec3 wo = frame_to_local(&f, n), wi = v3_unit(v3_mad(n, 2.0f, v3_neg(x)));
    assert_true(v3_dot(wi, n) > 0.0f && v3_dot(wi, f.n) > 0.0f && v3_dot(wi, first) < 0.0f);
    assert_true(rgb_black(brdf_eval(&b, wo, frame_to_local(&f, wi), BRDF_ALL)));
    assert_true(scene_brdf(&scene, &s, v3_neg(n), &b, &f));
    assert_true(v3_dist2(f.n, v3_neg(want)) < 1e-8f);
    assert_true(v3_dist2(frame_to_world(&f, b.base[1]), v3_neg(first)) < 1e-8f);
}

// A map in bumps rotates their facet; bumps in a map rise over its facet, where the axes of the
// texture are foreshortened.
static void bumps_and_maps_nest(void **state) {
    (void)state;
    static const float height[4] = {0.0f, 0.25f, 0.0f, 0.25f};
    const struct image image = scene_image_make(2, 2, 1, height);
    const struct texture slope = {
        .kind = TEXTURE_BITMAP, .image = &image, .to_uv = {1, 0, 0, 0, 1}};
    const struct texture tilt = {.kind = TEXTURE_CONSTANT, .value = {.8f, .5f, .9f}};
    const struct material_bump rise = {.height = &slope, .scale = 1.0f, .outside = true},
                               tilted = {.normal = &tilt, .outside = true};
    struct interaction s = interaction_facing(v3_unit(v3(1, 2, 3)));
    s.uv = (vec2){0.5f, 0.5f};
    s.dp_du = s.frame.u, s.dp_dv = s.frame.v;
    const float up = asinf(.6f), back = atanf(.5f), steep = atanf(.5f / .8f);
    const struct {
        struct material_bump outer, inner;
        float angle;
    } cases[] = {{rise, tilted, up - back}, {tilted, rise, up - steep}};
    for (int i = 0; i < 2; i++) {
        struct material m = white_under(cases[i].outer, cases[i].inner);
        struct satin_scene scene = {
            .shape = &scene_material_shape, .material = &m, .material_count = 1};
        vec3 want =
            v3_mad(v3_mul(s.frame.n, cosf(cases[i].angle)), sinf(cases[i].angle), s.frame.u);
        struct brdf b;
        struct frame f;
        for (int side = 1; side >= -1; side -= 2) {
            vec3 wo = v3_mul(s.frame.n, (float)side);
            assert_true(scene_brdf(&scene, &s, wo, &b, &f));
            assert_true(v3_dist2(v3_mul(f.n, (float)side), want) < 1e-8f);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blends_draw_their_components),
        cmocka_unit_test(bumps_and_maps_nest),
        cmocka_unit_test(holes_are_no_components),
        cmocka_unit_test(bumps_rotate_the_frame),
        cmocka_unit_test(bumps_rotate_one_after_another),
        cmocka_unit_test(sides_have_their_frames),
        cmocka_unit_test(textures_replace_the_values_of_slots),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
