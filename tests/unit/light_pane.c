// SPDX-License-Identifier: Apache-2.0
// Light through panes: the transmitted fraction is Fresnel's, the change of density is that of a
// slab, light samples bring the irradiance that random directions find, and surfaces that are no
// panes stop them.
#include "test_scene.h"

#include <math.h>
#include <stdio.h>

static const double IOR = 1.5;

static uint32_t light_pane_glass(struct test_scene *t) {
    return test_material(t, "dielectric", rgb_grey(0.0f), rgb_grey(1.0f));
}

static float degrees(float angle) { return angle * 180.0f / PI_F; }

// A plate of half-width 4 whose middle is at height z, tilted about the x axis by an angle [rad].
static uint32_t plate(struct test_scene *t, float z, float thickness, float angle, uint32_t what) {
    const struct mat4 tilt = mat4_rotate(v3(1, 0, 0), degrees(angle)),
                      to = test_transform(v3(0, 0, z), v3(1, 1, 1)),
                      size = mat4_scale(v3(4, 4, 0.5f * thickness)),
                      rotated = mat4_mul(&tilt, &size);
    return test_cube(t, mat4_mul(&to, &rotated), false, what);
}

// A lamp at height 1 that shines down, of half-widths w and h, moved by x.
static void light_pane_lamp(struct test_scene *t, float x, float w, float h) {
    const uint32_t grey = test_diffuse(t, 0.5f, 0.5f, 0.5f);
    const struct mat4 down = test_transform(v3(x, 0, 1), v3(w, -h, -1));
    test_area_light(t, test_rectangle(t, down, grey), rgb_grey(1.0f));
}

// The fraction of unpolarised light that the two faces of a plate transmit at an angle of incidence
// [rad], without internal reflections.
static double light_pane_transmitted(double angle) {
    const double c = cos(angle), inner = sqrt(1.0 - pow(sin(angle) / IOR, 2.0));
    const double s = (c - IOR * inner) / (c + IOR * inner);
    const double p = (IOR * c - inner) / (IOR * c + inner);
    return pow(1.0 - 0.5 * (s * s + p * p), 2.0);
}

static vec3 inclined(double angle) { return v3((float)sin(angle), 0.0f, (float)cos(angle)); }

// The light that arrives at the origin from infinitely far along w; negative if it does not arrive.
static double arriving(const struct satin_scene *scene, vec3 w, int panes) {
    struct light_sample s = {.wi = w, .dist = INFINITY, .L = rgb_grey(1.0f), .pdf_w = 1.0f};
    if (!light_arrives(scene, v3(0, 0, 0), v3(0, 0, 1), panes, &s)) return -1.0;
    assert_true(v3_dist2(s.wi, w) == 0.0f && s.pdf_w == 1.0f);
    return (double)s.L.g;
}

static void panes_transmit_by_fresnel(void **state) {
    (void)state;
    for (int count = 1; count <= 2; count++)
        for (int tilted = 0; tilted <= 1; tilted++) {
            struct test_scene t;
            test_scene_init(&t);
            const uint32_t what = light_pane_glass(&t);
            const float tilt = tilted ? 0.3f : 0.0f;
            for (int i = 0; i < count; i++) plate(&t, 0.5f + 0.1f * (float)i, 0.01f, tilt, what);
            test_scene_finish(&t);
            assert_true(t.scene.panes);
            for (int i = 0; i <= 8; i++) {
                const double angle = i * M_PI / 18.0;
                const double incidence = tilted ? acos(cos(angle) * cos(0.3)) : angle;
                const double expected = pow(light_pane_transmitted(incidence), count);
                // In single precision 1 - F loses two digits at the steepest angle.
                assert_true(fabs(arriving(&t.scene, inclined(angle), 8) - expected) < 1e-5);
            }
            test_scene_free(&t);
        }
}

static void thin_sheets_transmit_straight(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    const uint32_t thin = test_material(&t, "thindielectric", rgb_grey(0.0f), rgb_grey(1.0f));
    // Thin panes may have any form: rays pass both sides of a ball, at angles of incidence of 0.
    test_quadric(&t, SHAPE_SPHERE, test_transform(v3(0, 0, 0), v3(0.5f, 0.5f, 0.5f)), false, thin);
    test_scene_finish(&t);
    // Two interfaces with all internal reflections: 1 - R with R = 2 F / (1 + F).
    const double F = 0.04, expected = (1.0 - F) / (1.0 + F);
    assert_true(fabs(arriving(&t.scene, inclined(0.7), 8) - expected) < 1e-5);
    test_scene_free(&t);
}

// A pane of two rectangles, the upper one rotated about x by an angle [rad].
static double through_wedge(float angle) {
    struct test_scene t;
    test_scene_init(&t);
    const uint32_t what = light_pane_glass(&t);
    const struct mat4 tilt = mat4_rotate(v3(1, 0, 0), degrees(angle)),
                      to = test_transform(v3(0, 0, 0.6f), v3(4, 4, 1));
    test_rectangle(&t, mat4_mul(&to, &tilt), what);
    test_rectangle(&t, test_transform(v3(0, 0, 0.4f), v3(4, -4, -1)), what);
    test_scene_finish(&t);
    const double found = arriving(&t.scene, inclined(0.4), 8);
    test_scene_free(&t);
    return found;
}

static void faces_must_be_parallel(void **state) {
    (void)state;
    assert_true(fabs(through_wedge(0.0f) - light_pane_transmitted(0.4)) < 1e-5);
    assert_true(through_wedge(1e-4f) > 0.0);
    assert_true(through_wedge(1e-2f) < 0.0);
}

static void what_is_no_pane_stops_light(void **state) {
    (void)state;
    static const char *const kind[] = {"frosted", "ball", "blocked", "plain"};
    for (int i = 0; i < 4; i++) {
        struct test_scene t;
        test_scene_init(&t);
        const uint32_t clear = light_pane_glass(&t), grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f);
        const uint32_t rough = test_material(&t, "roughdielectric", rgb_grey(0.0f), rgb_grey(1.0f));
        plate(&t, 0.5f, 0.01f, 0.0f, i == 0 ? rough : clear);
        const struct mat4 to_world = test_transform(v3(0, 0, 2), v3(0.5f, 0.5f, 0.5f));
        if (i == 1) test_quadric(&t, SHAPE_SPHERE, to_world, false, clear);
        if (i == 2) test_rectangle(&t, to_world, grey);
        test_scene_finish(&t);
        assert_true(t.scene.panes == (i != 0));
        if ((arriving(&t.scene, v3(0, 0, 1), 8) > 0.0) != (i == 3)) fail_msg("%s", kind[i]);
        test_scene_free(&t);
    }
}

static void panes_are_counted(void **state) {
    (void)state;
    for (int plates = 15; plates <= 17; plates++) {
        struct test_scene t;
        test_scene_init(&t);
        const uint32_t what = light_pane_glass(&t);
        for (int i = 0; i < plates; i++) plate(&t, 0.5f + 0.02f * (float)i, 0.01f, 0.0f, what);
        test_scene_finish(&t);
        const vec3 up = v3(0, 0, 1);
        assert_true(arriving(&t.scene, up, 2 * plates - 1) < 0.0);
        // More than 32 surfaces count as a caustic in every query.
        assert_true((arriving(&t.scene, up, 64) > 0.0) == (plates <= 16));
        struct light_found found;
        assert_false(light_find(&t.scene, v3(0, 0, 0), up, up, 64, &found));
        test_scene_free(&t);
    }
}

// ---- Lamps at finite distance -------------------------------------------------------------------

// How far a ray that leaves a point at an angle [rad] is beside it at height 1, behind a plate.
static double beside(double angle, double thickness) {
    return (1.0 - thickness) * tan(angle) + thickness * tan(asin(sin(angle) / IOR));
}

static void distances_are_those_of_a_slab(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    plate(&t, 0.5f, 0.3f, 0.0f, light_pane_glass(&t));
    light_pane_lamp(&t, 0.0f, 20.0f, 20.0f);
    test_scene_finish(&t);
    for (int i = 0; i <= 7; i++) {
        const double a = (i + 0.5) * M_PI / 18.0, step = 1e-4;
        struct light_found found;
        assert_true(light_find(&t.scene, v3(0, 0, 0), v3(0, 0, 1), inclined(a), 2, &found));
        assert_true(!found.environment && found.hit.light == 0);
        assert_true(found.connection.crossed == 2);
        // A bundle of rays that rotates by dphi about the axis is x dphi wide, one by da is cos a
        // dx.
        const double x = beside(a, 0.3),
                     dx = (beside(a + step, 0.3) - beside(a - step, 0.3)) / (2.0 * step);
        assert_true(fabs((double)found.hit.p.x - x) < 1e-4);
        const double section = x / sin(a) * cos(a) * dx, distance2 = x * x + 1.0;
        assert_true(fabs((double)found.connection.spread * distance2 / section - 1.0) < 1e-4);
        assert_true(v3_dist2(found.connection.d, inclined(a)) < 1e-8f);
    }
    test_scene_free(&t);
}

// The irradiance of a small lamp follows from Fermat's path to it.
static void points_of_light_are_found(void **state) {
    (void)state;
    const double thickness = 0.08, x = 0.7;
    struct test_scene t;
    test_scene_init(&t);
    plate(&t, 0.5f, (float)thickness, 0.0f, light_pane_glass(&t));
    const uint32_t i = test_light(
        &t, (struct light){
                .kind = LIGHT_POINT, .value = rgb_grey(1.0f), .position = v3((float)x, 0, 1)});
    test_scene_finish(&t);
    double lo = 0.0, hi = 1.5;
    for (int k = 0; k < 60; k++) {
        const double middle = 0.5 * (lo + hi);
        *(beside(middle, thickness) < x ? &lo : &hi) = middle;
    }
    const double step = 1e-4, sagittal = x / sin(lo);
    const double dx = beside(lo + step, thickness) - beside(lo - step, thickness);
    const double expected =
        light_pane_transmitted(lo) / (sagittal * dx / (2.0 * step));  // E = I T cos / ...
    struct light_sample s;
    assert_true(light_sample_wi(&t.scene, i, v3(0, 0, 0), 0.5f, 0.5f, &s));
    assert_true(light_arrives(&t.scene, v3(0, 0, 0), v3(0, 0, 1), 2, &s));
    assert_true(v3_dist2(s.wi, inclined(lo)) < 1e-8f);
    assert_true(fabs((double)(s.L.g * s.wi.z / s.pdf_w) / expected - 1.0) < 1e-3);
    assert_false(light_arrives(&t.scene, v3(0, 0, 0), v3(0, 0, 1), 1, &s));
    test_scene_free(&t);
}

enum { LIGHT_SIDE = 64 };

// Irradiance at p, upwards, by light samples. Counts how often the density reported for them
// differs from that reported for rays that find the same light.
static double by_samples(const struct satin_scene *scene, vec3 p, int *wrong) {
    const vec3 up = v3(0, 0, 1);
    double sum = 0.0;
    for (int i = 0; i < LIGHT_SIDE * LIGHT_SIDE; i++) {
        const float u = ((float)(i % LIGHT_SIDE) + 0.5f) / LIGHT_SIDE;
        const float v = ((float)(i / LIGHT_SIDE) + 0.5f) / LIGHT_SIDE;
        struct light_sample s;
        if (!light_sample_wi(scene, 0, p, u, v, &s) || !light_arrives(scene, p, up, 8, &s))
            continue;
        sum += (double)(s.L.g * s.wi.z / s.pdf_w);
        struct light_found found;
        if (!light_find(scene, p, up, s.wi, 8, &found) || found.environment) {
            ++*wrong;
            continue;
        }
        const float reported = light_connection_pdf(scene, p, &found.connection, &found.hit);
        *wrong += !(fabsf(reported - s.pdf_w) < 1e-2f * s.pdf_w);
    }
    return sum / (LIGHT_SIDE * LIGHT_SIDE);
}

// The directions, side^2 of them, go towards a square of half-width 0.8 at height 1 that the lamp
// is in.
static double by_directions(const struct satin_scene *scene, vec3 p, int side) {
    struct rng rng = rng_make(3, RNG_TEST, 0);
    const float width = 1.6f / (float)side;
    double sum = 0.0;
    for (int i = 0; i < side * side; i++) {
        const float x = width * ((float)(i % side) + rng_float(&rng)) - 0.8f - p.x;
        const float y = width * ((float)(i / side) + rng_float(&rng)) - 0.8f - p.y;
        const vec3 d = v3_unit(v3(x, y, 1));
        struct light_found found;
        if (!light_find(scene, p, v3(0, 0, 1), d, 8, &found) || found.environment) continue;
        sum += (double)(found.L.g * powf(d.z, 4.0f) * width * width);
    }
    return sum;
}

static void lamps_bring_what_directions_find(void **state) {
    (void)state;
    // The lamp is .5 from a pane of 5 mm, of 1 cm, a block, a tilted pane, and two panes. Then it
    // is narrow.
    static const struct {
        float thickness, tilt, w, h;
        int plates;
    } c[] = {{0.005f, 0.0f, 0.3f, 0.3f, 1}, {0.01f, 0.0f, 0.05f, 0.3f, 1},
             {0.08f, 0.0f, 0.3f, 0.3f, 1},  {0.01f, 0.5f, 0.3f, 0.3f, 1},
             {0.01f, 0.0f, 0.3f, 0.1f, 2},  {0.08f, 0.5f, 0.1f, 0.1f, 2}};
    for (size_t i = 0; i < sizeof c / sizeof *c; i++) {
        struct test_scene t;
        test_scene_init(&t);
        const uint32_t what = light_pane_glass(&t);
        for (int k = 0; k < c[i].plates; k++)
            plate(&t, 0.5f - 0.2f * (float)k, c[i].thickness, c[i].tilt, what);
        light_pane_lamp(&t, 0.35f, c[i].w, c[i].h);
        test_scene_finish(&t);
        int wrong = 0;
        const double sampled = by_samples(&t.scene, v3(0, 0, 0), &wrong);
        const double found = by_directions(&t.scene, v3(0, 0, 0), 500);
        const double error = sampled / found - 1.0;
        print_message("case %zu: %.5f by samples, %+.2f %%, %d densities differ\n", i, sampled,
                      100.0 * error, wrong);
        assert_true(fabs(error) < 0.005);
        assert_true(wrong <= LIGHT_SIDE * LIGHT_SIDE / 100);
        test_scene_free(&t);
    }
}

// A pane of 6 mm in the middle of a wall 10 cm thick: light that the wall hides from straight rays
// alone is lost. The floor is lit through an opening of .8 x .8, from straight below to grazing the
// wall.
static void frames_hide_little(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    const uint32_t what = light_pane_glass(&t), grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f);
    test_cube(&t, test_transform(v3(0, 0, 0.5f), v3(0.4f, 0.4f, 0.003f)), false, what);
    for (int side = -1; side <= 1; side += 2) {
        const float at = (float)side;
        test_cube(&t, test_transform(v3(2.4f * at, 0, 0.5f), v3(2, 4, 0.05f)), false, grey);
        test_cube(&t, test_transform(v3(0, 2.4f * at, 0.5f), v3(0.4f, 2, 0.05f)), false, grey);
    }
    light_pane_lamp(&t, 0.35f, 0.3f, 0.3f);
    test_scene_finish(&t);
    double sampled = 0.0, found = 0.0;
    int wrong = 0;
    for (int i = 0; i < 64; i++) {
        const vec3 p = v3(0.25f * (float)(i % 8) - 0.875f, 0.25f * (float)(i / 8) - 0.875f, 0);
        sampled += by_samples(&t.scene, p, &wrong);
        found += by_directions(&t.scene, p, 100);
    }
    print_message("framed: %.5f by samples, %+.2f %%\n", sampled, 100.0 * (sampled / found - 1.0));
    assert_true(fabs(sampled / found - 1.0) < 0.005);
    test_scene_free(&t);
}

// The irradiance below a pane and a lamp, of one or two sheets, at (at, at, 0).
static double below_sheets(float at, int sheets) {
    static const uint32_t index[12] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
    float corner[3 * 8 + 1];
    for (int i = 0; i < 8; i++) {
        corner[3 * i] = at + (i % 4 == 2 || i % 4 == 3 ? 0.3f : -0.3f);
        corner[3 * i + 1] = at + (i % 4 == 1 || i % 4 == 2 ? 0.2f : -0.2f);
        corner[3 * i + 2] = i < 4 ? 1.0f : 1.001f;
    }
    struct test_scene t;
    test_scene_init(&t);
    const struct mat4 to = test_transform(v3(at, at, 0.5f), v3(4, 4, 0.0025f));
    test_cube(&t, to, false, light_pane_glass(&t));
    struct shape s = {.kind = SHAPE_MESH, .material = test_diffuse(&t, 0, 0, 0)};
    s.mesh = (struct mesh){
        (uint32_t)(4 * sheets), (uint32_t)(2 * sheets), corner, NULL, NULL, index, NULL, 0};
    test_area_light(&t, test_add_shape(&t, s), rgb_grey(1.0f));
    test_scene_finish(&t);
    int wrong = 0;
    const double E = by_samples(&t.scene, v3(at, at, 0), &wrong);
    test_scene_free(&t);
    return E;
}

// A sheet a thousandth behind another one is hidden, and nothing is lost far from the origin, where
// positions are rounded to 1e-5.
static void lamps_hide_themselves(void **state) {
    (void)state;
    const double one = below_sheets(0.0f, 1), two = below_sheets(0.0f, 2);
    const double far = below_sheets(100.0f, 1);
    print_message("one sheet %.5f, a second behind it %+.2f %%, far away %+.2f %%\n", one,
                  100.0 * (two / one - 1.0), 100.0 * (far / one - 1.0));
    assert_true(one > 0.05 && fabs(two / one - 1.0) < 0.005 && fabs(far / one - 1.0) < 0.005);
}

// ---- Curved glass -------------------------------------------------------------------------------

enum { BALL, BULB, BULB_INSIDE_OUT, BULB_WITH_THICK_GLASS };

// A ball that glows, beside the middle of a ball of glass or of a hollow one, over the origin.
static void glass_ball(struct test_scene *t, int kind) {
    test_scene_init(t);
    const uint32_t clear = light_pane_glass(t), grey = test_diffuse(t, 0.5f, 0.5f, 0.5f);
    const vec3 middle = v3(0.1f, 0, 1);
    const float inside = kind == BULB_WITH_THICK_GLASS ? 0.15f : 0.29f;
    const uint32_t lamp =
        test_quadric(t, SHAPE_SPHERE,
                     test_transform(v3(0.15f, 0.02f, 1.05f), v3(0.06f, 0.06f, 0.06f)), false, grey);
    test_quadric(t, SHAPE_SPHERE, test_transform(middle, v3(0.3f, 0.3f, 0.3f)), false, clear);
    // The front of the inner surface may be in the glass.
    const uint32_t inner = light_pane_glass(t);
    if (kind == BULB_INSIDE_OUT) t->scene.material[inner].front.base.ior = 1.0f / (float)IOR;
    if (kind != BALL)
        test_quadric(t, SHAPE_SPHERE, test_transform(middle, v3(inside, inside, inside)),
                     kind != BULB_INSIDE_OUT, inner);
    test_area_light(t, lamp, rgb_grey(1.0f));
    test_scene_finish(t);
}

// Light that the directions find arrives by refraction; that which light samples do not find is
// left to caustics.
static void test_bulb(int kind) {
    struct test_scene t;
    glass_ball(&t, kind);
    assert_true(t.scene.panes && t.scene.shape[1].deflects_little &&
                t.scene.shape[2].deflects_little);
    int wrong = 0;
    const double sampled = by_samples(&t.scene, v3(0, 0, 0), &wrong);
    const double found = by_directions(&t.scene, v3(0, 0, 0), 1000);
    // Without the glass, and with the two surfaces' Fresnel loss at normal incidence.
    const double sine2 = 0.06 * 0.06 / (0.15 * 0.15 + 0.02 * 0.02 + 1.05 * 1.05);
    const double cosine = 1.05 / sqrt(0.15 * 0.15 + 0.02 * 0.02 + 1.05 * 1.05);
    const double alone = M_PI * sine2 * cosine * light_pane_transmitted(0.0);
    print_message("bulb: %.6f by samples, %+.2f %%, %d densities differ; %.6f\n", sampled,
                  100.0 * (sampled / found - 1.0), wrong, alone);
    assert_true(fabs(sampled / found - 1.0) < 0.005);
    assert_true(wrong <= LIGHT_SIDE * LIGHT_SIDE / 100);
    assert_true(fabs(sampled / alone - 1.0) < 0.05);
    test_scene_free(&t);
}

static void bulbs_bring_what_directions_find(void **state) {
    (void)state;
    test_bulb(BULB);
    test_bulb(BULB_INSIDE_OUT);
}

static void what_deflects_light_is_no_pane(void **state) {
    (void)state;
    static const int kind[] = {BALL, BULB_WITH_THICK_GLASS};
    for (int i = 0; i < 2; i++) {
        struct test_scene t;
        glass_ball(&t, kind[i]);
        struct light_sample s;
        assert_false(t.scene.panes);
        assert_true(light_sample_wi(&t.scene, 0, v3(0, 0, 0), 0.5f, 0.5f, &s));
        assert_false(light_arrives(&t.scene, v3(0, 0, 0), v3(0, 0, 1), 8, &s));
        test_scene_free(&t);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(panes_transmit_by_fresnel),
        cmocka_unit_test(thin_sheets_transmit_straight),
        cmocka_unit_test(faces_must_be_parallel),
        cmocka_unit_test(what_is_no_pane_stops_light),
        cmocka_unit_test(panes_are_counted),
        cmocka_unit_test(distances_are_those_of_a_slab),
        cmocka_unit_test(points_of_light_are_found),
        cmocka_unit_test(lamps_bring_what_directions_find),
        cmocka_unit_test(frames_hide_little),
        cmocka_unit_test(lamps_hide_themselves),
        cmocka_unit_test(bulbs_bring_what_directions_find),
        cmocka_unit_test(what_deflects_light_is_no_pane),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
