// SPDX-License-Identifier: Apache-2.0
// The BRDF at a surface point: sides, frames, textures.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "scene/scene.h"

static struct surfel surfel_facing(vec3 n) {
    return (struct surfel){.ng = n, .frame = frame_from_normal(n), .uv = {0.25f, 0.25f}};
}

static void sides_and_frames(void **state) {
    (void)state;
    struct material material = {
        .front.base = {.model = brdf_find("diffuse"), .diffuse = {.2f, .3f, .4f}},
        .back.base = {.model = brdf_find("phong"), .specular = {1, 1, 1}, .exponent = 5},
    };
    struct satin_scene scene = {.material = &material, .material_count = 1};
    vec3 n = v3_unit(v3(1, 2, 3)), tilted = v3_unit(v3(2, 2, 2));
    struct surfel s = surfel_facing(n);
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

static void textures_replace_slots(void **state) {
    (void)state;
    const struct texture colour = {.kind = TEXTURE_CONSTANT, .value = {.1f, .5f, .9f}};
    const struct texture number = {.kind = TEXTURE_CONSTANT, .value = {.3f, .3f, .3f}};
    struct material material = {
        .front.base = {.model = brdf_find("ward"), .alpha_u = .1f, .alpha_v = .1f, .exponent = 7}};
    struct satin_scene scene = {.material = &material, .material_count = 1};
    struct surfel s = surfel_facing(v3(0, 0, 1));
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
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sides_and_frames),
        cmocka_unit_test(textures_replace_slots),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
