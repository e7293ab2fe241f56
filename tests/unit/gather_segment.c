// SPDX-License-Identifier: Apache-2.0
// Segments of light paths over a mirror, whose end, throughput and first surface are known, and the
// least roughness of lobes at their ends.
#include "gather/gather_segment.h"

#include <math.h>

#include "test_scene.h"

static const float GATHER_SEGMENT_ALBEDO = 0.5f, EMITTED = 3.0f;

// A mirror at z = 0, and 2 above it a diffuse ceiling that emits light on one side of x = 0.
static void gather_segment_scene_of(struct test_scene *t) {
    test_scene_init(t);
    const uint32_t mirror =
        test_material(t, "conductor", rgb_grey(0.0f), rgb_make(0.9f, 0.6f, 0.3f));
    const uint32_t diffuse =
        test_diffuse(t, GATHER_SEGMENT_ALBEDO, GATHER_SEGMENT_ALBEDO, GATHER_SEGMENT_ALBEDO);
    test_rectangle(t, mat4_identity(), mirror);
    struct mat4 over = test_transform(v3(-2, 0, 2), v3(2, 2, -1));
    test_rectangle(t, over, diffuse);
    over = test_transform(v3(2, 0, 2), v3(2, 2, -1));
    test_area_light(t, test_rectangle(t, over, diffuse), rgb_grey(EMITTED));
    test_scene_finish(t);
}

static bool test_gather_segment_trace(const struct test_scene *t, vec3 p, vec3 d, bool lit,
                                      struct gather_segment *out, struct shading_point *end) {
    satin_options options = satin_options_default;
    const struct gather g = {.scene = &t->scene, .options = &options};
    struct sampler sampler = {0, 1, 0};
    const struct light_receiver from = {p, v3(0, 0, 1), false};
    const struct gather_segment_start start = {
        .ray = {p, 0.0f, v3_unit(d), INFINITY}, .lit = lit ? &from : NULL, .depth = 1};
    return gather_segment_trace(&g, &start, &sampler, out, end);
}

static void a_segment_ends_behind_a_mirror(void **state) {
    (void)state;
    struct test_scene t;
    gather_segment_scene_of(&t);
    struct gather_segment segment;
    struct shading_point end;
    assert_true(
        test_gather_segment_trace(&t, v3(0, 0, 1), v3(-0.3f, 0, -1), false, &segment, &end));
    // The mirror is 1 below the start, and the ceiling 2 above the mirror.
    assert_true(v3_dist2(end.interaction.p, v3(-0.9f, 0, 2)) < 1e-10f);
    const float slant = sqrtf(1.0f + 0.3f * 0.3f);
    assert_true(fabsf(segment.first.r - slant) < 1e-5f);
    assert_true(v3_len(segment.first.ng) == 0.0f);
    // Without eta and k all light is reflected, times the colour.
    assert_true(fabsf(segment.T.r - 0.9f) < 1e-6f && fabsf(segment.T.b - 0.3f) < 1e-6f);
    assert_true(segment.light_pdf == 0.0f && rgb_black(segment.Le) &&
                rgb_black(segment.Le_specular));
    test_scene_free(&t);
}

// Light samples can draw light that is hit directly, but not light in the mirror.
static void emitted_light_is_direct_or_specular(void **state) {
    (void)state;
    struct test_scene t;
    gather_segment_scene_of(&t);
    struct gather_segment segment;
    struct shading_point end;
    assert_true(test_gather_segment_trace(&t, v3(0, 0, 1), v3(1, 0, 1), true, &segment, &end));
    assert_true(segment.T.r == 1.0f && segment.Le.r == EMITTED && segment.light_pdf > 0.0f);
    assert_true(rgb_black(segment.Le_specular) && v3_len(segment.first.ng) > 0.99f);
    assert_true(test_gather_segment_trace(&t, v3(0, 0, 1), v3(0.3f, 0, -1), true, &segment, &end));
    assert_true(rgb_black(segment.Le) && segment.light_pdf == 0.0f);
    assert_true(fabsf(segment.Le_specular.r - EMITTED * segment.T.r) < 1e-6f);
    test_scene_free(&t);
}

static void a_segment_may_leave_the_scene(void **state) {
    (void)state;
    struct test_scene t;
    gather_segment_scene_of(&t);
    struct gather_segment segment;
    struct shading_point end;
    assert_false(test_gather_segment_trace(&t, v3(0, 5, 1), v3(0, 1, 0), true, &segment, &end));
    assert_true(isinf(segment.first.r) && rgb_black(segment.Le));
    // This segment passes over the mirror and past the ceiling.
    assert_false(test_gather_segment_trace(&t, v3(0, 0, 0.1f), v3(0, 9, -1), true, &segment, &end));
    assert_true(segment.first.r > 0.9f && segment.first.r < 1.0f);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_segment_ends_behind_a_mirror),
        cmocka_unit_test(emitted_light_is_direct_or_specular),
        cmocka_unit_test(a_segment_may_leave_the_scene),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
