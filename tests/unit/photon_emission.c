// SPDX-License-Identifier: Apache-2.0
// Where caustic paths start: by fewer paths than from everywhere on the lights, the same light
// arrives where it is seen, with less noise.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "photon/photon_map.h"
#include "photon_case.h"

static const enum light_kind KINDS[] = {LIGHT_AREA, LIGHT_POINT, LIGHT_SPOT, LIGHT_DIRECTIONAL,
                                        LIGHT_CONSTANT};
enum { KIND_COUNT = sizeof KINDS / sizeof *KINDS };

// A slight wedge of glass over a floor, both of the given half width, with a lamp over them: no
// pane, but light leaves it almost in the direction in which it came.
static void wedge_scene(struct test_scene *t, enum light_kind kind, float half) {
    test_scene_init(t);
    uint32_t grey = test_diffuse(t, 0.5f, 0.5f, 0.5f);
    uint32_t glass = test_material(t, "dielectric", rgb_grey(0), rgb_grey(1));
    struct mat4 tilt = mat4_rotate(v3(1, 0, 0), 0.6f),
                over = test_transform(v3(0, 0, 1.3f), v3(half, half, 1));
    test_rectangle(t, test_transform(v3(0, 0, 0), v3(half, half, 1)), grey);
    test_rectangle(t, test_transform(v3(0, 0, 1), v3(half, -half, -1)), glass);
    test_rectangle(t, mat4_mul(&tilt, &over), glass);
    photon_case_lamp(t, kind, grey);
    test_scene_finish(t);
}

// A camera `height` above the floor, which it sees in a square of the given half width.
static void look_down(struct test_scene *t, float height, float half) {
    const struct mat4 up = test_transform(v3(0, 0, height), v3(1, 1, -1));
    t->scene.camera = (struct camera){
        .to_world = up, .tan_x = half / height, .tan_y = half / height, .far_clip = INFINITY};
    t->scene.film =
        (struct scene_film){.width = 64, .height = 64, .crop_width = 64, .crop_height = 64};
}

static struct guide_emission *learn_emission(const struct test_scene *t, struct parallel *pool) {
    satin_options o = satin_options_default;
    struct guide_emission *emission;
    const struct photon_request request = {
        .scene = &t->scene, .options = &o, .paths = render_budget_paths(&o, 0.0)};
    assert_int_equal(photon_emission_build(&request, pool, (struct log){0}, &emission), SATIN_OK);
    return emission;
}

static struct photon_trace trace_caustics(const struct test_scene *t, bool learnt, uint64_t paths,
                                          int threads) {
    struct parallel *pool = parallel_new(threads);
    struct guide_emission *emission = learnt ? learn_emission(t, pool) : NULL;
    assert_true((emission != NULL) == learnt);
    struct photon_tracing tracing = {.scene = &t->scene,
                                     .seed = 1,
                                     .consumer = {{paths, 1 << PHOTON_CAUSTIC, NULL}},
                                     .bounces = -1,
                                     .emission = emission};
    struct photon_trace out[PHOTON_CONSUMERS];
    assert_int_equal(photon_trace_run(&tracing, pool, (struct log){0}, out), SATIN_OK);
    guide_emission_free(emission);
    parallel_free(pool);
    return out[0];
}

// The flux within a square of the floor, and its standard deviation if photons are independent;
// that of well distributed ones is less.
static double flux_near(const struct photon_trace *trace, float half, double *deviation) {
    double sum = 0.0, squares = 0.0;
    for (size_t i = 0; i < trace->count; i++) {
        const struct photon_hit *hit = &trace->hit[i];
        if (fabsf(hit->p.x) > half || fabsf(hit->p.y) > half || fabsf(hit->p.z) > 1e-3f) continue;
        sum += (double)hit->power.g;
        squares += (double)hit->power.g * (double)hit->power.g;
    }
    *deviation = sqrt(squares);
    return sum;
}

// Traces `paths` from everywhere and `fewer` where it was learnt, compares the flux in the square
// and asserts that as many from everywhere have more than `gain` times the variance of these.
static void compare_flux(const struct test_scene *t, float half, uint64_t paths, uint64_t fewer,
                         double gain) {
    struct photon_trace plain = trace_caustics(t, false, paths, 2),
                        learnt = trace_caustics(t, true, fewer, 2);
    double error[2];
    const double a = flux_near(&plain, half, &error[0]), b = flux_near(&learnt, half, &error[1]);
    const double gained = pow(error[0] / error[1], 2.0) * (double)paths / (double)fewer;
    const bool equal = a > 0.0 && fabs(a - b) < 4.0 * hypot(error[0], error[1]);
    if (!equal || !(gained > gain))
        printf("plain %g +- %g, learnt %g +- %g, gain %g\n", a, error[0], b, error[1], gained);
    assert_true(equal);
    assert_true(gained > gain);
    photon_trace_free(&plain);
    photon_trace_free(&learnt);
}

static void learnt_emission_is_unbiased(void **state) {
    (void)state;
    for (int i = 0; i < KIND_COUNT; i++) {
        struct test_scene t;
        photon_case_caustic(&t, KINDS[i]);
        look_down(&t, 2.5f, 3.0f);
        compare_flux(&t, 3.0f, 200000, 50000, 2.0);
        test_scene_free(&t);
    }
}

// Under a wedge 40 wide, the area that is seen is 1 wide.
static void large_wedges_are_aimed_through(void **state) {
    (void)state;
    for (int i = 0; i < KIND_COUNT; i++) {
        struct test_scene t;
        wedge_scene(&t, KINDS[i], 20.0f);
        look_down(&t, 0.5f, 0.5f);
        compare_flux(&t, 0.4f, 1000000, 40000, 2.0);
        test_scene_free(&t);
    }
}

// Nine beads of glass, one more than there are covers, far apart on a floor. From everywhere on the
// lights, one path in thousands hits one.
static void small_balls_are_aimed_at(void **state) {
    static const double GAIN[KIND_COUNT] = {90.0, 400.0, 25.0, 240.0, 190.0};
    (void)state;
    for (int i = 0; i < KIND_COUNT; i++) {
        struct test_scene t;
        test_scene_init(&t);
        const uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f),
                       glass = test_material(&t, "dielectric", rgb_grey(0), rgb_grey(1));
        test_rectangle(&t, test_transform(v3(0, 0, 0), v3(3, 3, 1)), grey);
        for (int k = 0; k < 9; k++) {
            const vec3 at = v3(k % 2 ? -1.0f : 0.5f, 0.2f * (float)k - 0.8f, 0.1f);
            test_quadric(&t, SHAPE_SPHERE, test_transform(at, v3(0.04f, 0.04f, 0.04f)), false,
                         glass);
        }
        photon_case_lamp(&t, KINDS[i], grey);
        test_scene_finish(&t);
        look_down(&t, 2.5f, 3.0f);
        compare_flux(&t, 3.0f, 1000000, 40000, GAIN[i]);
        test_scene_free(&t);
    }
}

// One of fifty lamps is over the glass ball; the others face away from it.
static void the_lamp_of_the_caustic_gets_most(void **state) {
    (void)state;
    enum { LAMPS = 50, PATHS = 100000 };
    struct test_scene t;
    test_scene_init(&t);
    const uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f),
                   glass = test_material(&t, "dielectric", rgb_grey(0), rgb_grey(1));
    test_rectangle(&t, test_transform(v3(0, 0, 0), v3(3, 3, 1)), grey);
    test_quadric(&t, SHAPE_SPHERE, test_transform(v3(0, 0, 0.6f), v3(0.4f, 0.4f, 0.4f)), false,
                 glass);
    for (int i = 0; i < LAMPS; i++)
        test_light(&t, (struct light){.kind = LIGHT_SPOT,
                                      .value = rgb_grey(10.0f),
                                      .position = v3(0.1f * (float)i, 0.0f, 3.0f),
                                      .direction = v3(0, 0, i == 0 ? -1.0f : 1.0f),
                                      .cos_cutoff = 0.9f,
                                      .cos_beam = 0.95f});
    test_scene_finish(&t);
    look_down(&t, 2.5f, 3.0f);
    struct parallel *pool = parallel_new(2);
    struct guide_emission *emission = learn_emission(&t, pool);
    uint64_t all = 0;
    for (uint32_t i = 0; i < LAMPS; i++) all += guide_emission_paths(emission, PATHS, i);
    assert_int_equal(all, PATHS);
    assert_true(guide_emission_paths(emission, PATHS, 0) > 0.75 * PATHS);
    guide_emission_free(emission);
    parallel_free(pool);
    test_scene_free(&t);
}

static void unseen_caustics_start_everywhere(void **state) {
    (void)state;
    struct test_scene t;
    photon_case_caustic(&t, LIGHT_POINT);
    look_down(&t, -1.0f, 0.1f);
    compare_flux(&t, 3.0f, 200000, 200000, 0.8);
    test_scene_free(&t);
}

static void without_specular_surfaces_there_is_none(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    const uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f);
    test_rectangle(&t, test_transform(v3(0, 0, 0), v3(3, 3, 1)), grey);
    photon_case_lamp(&t, LIGHT_POINT, grey);
    test_scene_finish(&t);
    look_down(&t, 2.5f, 3.0f);
    struct parallel *pool = parallel_new(1);
    assert_null(learn_emission(&t, pool));
    parallel_free(pool);
    test_scene_free(&t);
}

static void threads_do_not_change_it(void **state) {
    (void)state;
    struct test_scene t;
    photon_case_caustic(&t, LIGHT_AREA);
    look_down(&t, 2.5f, 3.0f);
    struct photon_trace one = trace_caustics(&t, true, 10000, 1),
                        three = trace_caustics(&t, true, 10000, 3);
    assert_int_equal(one.count, three.count);
    assert_memory_equal(one.hit, three.hit, one.count * sizeof *one.hit);
    photon_trace_free(&one);
    photon_trace_free(&three);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(learnt_emission_is_unbiased),
        cmocka_unit_test(large_wedges_are_aimed_through),
        cmocka_unit_test(small_balls_are_aimed_at),
        cmocka_unit_test(the_lamp_of_the_caustic_gets_most),
        cmocka_unit_test(unseen_caustics_start_everywhere),
        cmocka_unit_test(without_specular_surfaces_there_is_none),
        cmocka_unit_test(threads_do_not_change_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
