// SPDX-License-Identifier: Apache-2.0
// Curves: surface points by Mitsuba 3.9's numbers, rays that leave without hitting the curve again,
// refusals with their line.
#include "scene/scene_curve.h"

#include "base/rng.h"
#include "base/sampling.h"
#include "scene_case.h"

static const char two_curves[] =
    "-1 0 0 0.2\n-0.3 0.5 0 0.3\n0.4 -0.2 0.1 0.2\r\n1 0.3 0 0.25\n1.6 0 0 .2\n\n \n"
    "0 2 0 .1\n0 3 0 .1\n0 4 0 .3\n1 4 0 .1";

#define CURVE(kind, more) \
    SCENE_TEXT("<shape type='" kind "'><string name='filename' value='a.txt'/>" more "</shape>")

static void scene_curve_agrees_with_mitsuba(void **state) {
    (void)state;
    static const struct {
        int kind;
        vec3 o, d, p, n;
        float v;
    } known[] = {{0,
                  {0, 0, 5},
                  {0, 0, -1},
                  {0, 0, .2424984f},
                  {-.30314696f, -.5462679f, .78082854f},
                  .18676487f},
                 {0,
                  {.05f, -.1f, 5},
                  {0, 0, -1},
                  {.05f, -.1f, .1608572f},
                  {-.3980796f, -.8073129f, .43563575f},
                  .22090912f},
                 {0,
                  {.5f, 5, .05f},
                  {0, -1, 0},
                  {.5f, .2257886f, .05f},
                  {-.24433151f, .9685609f, -.04681894f},
                  .42113695f},
                 {1,
                  {.05f, .1f, 5},
                  {0, 0, -1},
                  {.05f, .1f, .29745054f},
                  {-.10069975f, -.10217749f, .9896562f},
                  .2193506f},
                 {1, {0, 2.5f, 5}, {0, 0, -1}, {0, 2.5f, .0999999f}, {0, 0, .9999999f}, .6428572f},
                 {1, {-5, 0, 0}, {1, 0, 0}, {-1.2f, 0, 0}, {-1, 0, 0}, 0}};
    scene_case_file("a.txt", two_curves);
    struct scene_case c;
    satin_scene *scene[2] = {scene_case_load(&c, CURVE("bsplinecurve", "")),
                             scene_case_load(&c, CURVE("linearcurve", ""))};
    assert_true(scene[0] && scene[1] && scene[0]->shape[0].curves.segments == 3 &&
                scene[1]->shape[0].curves.segments == 7);
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        struct ray ray = {known[i].o, 0, known[i].d, INFINITY};
        struct interaction s;
        assert_true(scene_intersect(scene[known[i].kind], &ray, &s));
        assert_true(v3_dist2(s.p, known[i].p) < 1e-6f);  // a thousandth of the radius off
        assert_true(v3_dot(s.ng, known[i].n) > 0.9999f);
        assert_true(fabsf(s.uv.y - known[i].v) < 1e-3f && s.uv.x >= 0 && s.uv.x <= 1);
    }
    satin_scene_free(scene[0]);
    satin_scene_free(scene[1]);
}

// A straight tube: rays to the outside do not hit it.
static void rays_leave_curves(void **state) {
    (void)state;
    static const char *const texts[] = {CURVE("bsplinecurve", ""), CURVE("linearcurve", "")};
    scene_case_file("a.txt", "50 0 0 .01\n51 0 0 .02\n52 0 0 .02\n53 0 0 .01\n");
    for (int kind = 0; kind < 2; kind++) {
        struct scene_case c;
        satin_scene *scene = scene_case_load(&c, texts[kind]);
        int hits = 0;
        for (uint64_t i = 0; i < 100000; i++) {
            struct rng rng = rng_make(1, RNG_TEST, i);
            vec3 from = v3(51.1f + .8f * rng_float(&rng), rng_float(&rng) - .5f, 1);
            vec3 to = v3(51.1f + .8f * rng_float(&rng), .04f * rng_float(&rng) - .02f, 0);
            struct ray ray = {from, 0, v3_unit(v3_sub(to, from)), INFINITY};
            struct interaction s, other;
            if (!scene_intersect(scene, &ray, &s)) continue;
            hits++;
            float u = rng_float(&rng), v = rng_float(&rng);
            vec3 d = frame_to_world(&s.frame, sample_cosine_hemisphere(u, v));
            struct ray next = scene_spawn(scene, s.p, s.ng, d);
            assert_false(scene_intersect(scene, &next, &other));
        }
        assert_true(hits > 50000);
        satin_scene_free(scene);
    }
}

static void bad_curves_are_refused(void **state) {
    (void)state;
    static const char *const cases[][3] = {
        {"0 0 0 1\n1 0 0", CURVE("linearcurve", ""), "a.txt:2: expected a point: x y z radius"},
        {"0 0 0 1\n# x", CURVE("linearcurve", ""), "a.txt:2: expected a point: x y z radius"},
        {"0 0 0 1 2\n1 0 0 1", CURVE("linearcurve", ""), "a.txt:1: expected a point: x y z radius"},
        {"0 0 0 -1\n1 0 0 1", CURVE("linearcurve", ""),
         "a.txt:1: the point or its radius is out of range"},
        {"0 0 0 1\n1 0 0 1\n2 0 0 1\n", CURVE("bsplinecurve", ""),
         "a.txt:4: a curve of 3 points, but it needs 4"},
        {"\n\n", CURVE("bsplinecurve", ""), "a.txt: there is no curve in it"},
        {"0 0 0 1\n1 0 0 1", CURVE("linearcurve", "<emitter type='area'/>"),
         "scene.xml:3:1: shape 'linearcurve': curves cannot emit"},
        {"0 0 0 1\n1 0 0 1", CURVE("linearcurve", "<bsdf type='dielectric'/>"),
         "scene.xml:3:1: shape 'linearcurve': curves cannot transmit light"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        scene_case_file("a.txt", cases[i][0]);
        assert_null(scene_case_load(&c, cases[i][1]));
        assert_string_equal(c.error, cases[i][2]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(scene_curve_agrees_with_mitsuba),
                                       cmocka_unit_test(rays_leave_curves),
                                       cmocka_unit_test(bad_curves_are_refused)};
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
