// SPDX-License-Identifier: Apache-2.0
// Lights: samples follow the density that is reported, at points near, beside, inside and far, and
// photons have the analytic power and bring the irradiance that sampling finds.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/sampling.h"
#include "test_light.h"

static void densities_of_area_lights_are_right(void **state) {
    (void)state;
    struct test_scene t;
    const rgb white = rgb_grey(1.0f);
    struct mat4 plain = test_transform(v3(0, 0, 0), v3(1.0f, 0.6f, 1.0f));
    struct mat4 tilted = test_rotated(test_transform(v3(3, 1, 2), v3(1, 1, 1)), v3(1, 2, 3), 50.0f);
    struct mat4 skew = mat4_identity();
    skew.m[0][1] = 0.7f;
    for (int kind = 0; kind < 8; kind++) {
        test_scene_init(&t);
        uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f), shape = 0;
        if (kind == 0) shape = test_rectangle(&t, plain, grey);
        if (kind == 1) shape = test_rectangle(&t, skew, grey);
        if (kind == 2) shape = test_cube(&t, mat4_identity(), true, grey);
        if (kind == 3) shape = test_quadric(&t, SHAPE_SPHERE, mat4_identity(), false, grey);
        if (kind == 4) shape = test_quadric(&t, SHAPE_SPHERE, mat4_identity(), true, grey);
        if (kind == 5) shape = test_quadric(&t, SHAPE_DISK, tilted, false, grey);
        if (kind == 6) shape = test_quadric(&t, SHAPE_CYLINDER, tilted, false, grey);
        if (kind == 7) shape = test_quadric(&t, SHAPE_CYLINDER, mat4_identity(), true, grey);
        test_area_light(&t, shape, white);
        test_scene_finish(&t);
        if (kind < 2) {
            test_light_density(&t, 0, v3(0.2f, 0.1f, 0.7f), "rectangle near");
            if (kind == 0) test_light_density(&t, 0, v3(0.2f, 0.1f, 0.02f), "rectangle touching");
            test_light_density(&t, 0, v3(1.05f, 0.1f, 0.1f), "rectangle beside");
            test_light_density(&t, 0, v3(2.0f, -1.0f, 3.0f), "rectangle away");
        }
        if (kind == 2) {
            test_light_density(&t, 0, v3(0, 0, 0), "cube, centre");
            test_light_density(&t, 0, v3(0.9f, -0.95f, 0.3f), "cube, corner");
        }
        if (kind == 3) {
            test_light_density(&t, 0, v3(1.1f, 0.1f, 0.0f), "sphere near");
            test_light_density(&t, 0, v3(-2.0f, 1.0f, 2.0f), "sphere away");
        }
        if (kind == 4) test_light_density(&t, 0, v3(0.3f, 0.5f, -0.6f), "sphere inside");
        if (kind == 5) {
            struct mat4 m = tilted;
            test_light_density(&t, 0, mat4_point(&m, v3(0.3f, 0.2f, 0.8f)), "disk near");
            test_light_density(&t, 0, mat4_point(&m, v3(1.3f, 0.2f, 1.8f)), "disk away");
        }
        if (kind == 6) test_light_density(&t, 0, v3(1.0f, -1.0f, 0.0f), "cylinder");
        if (kind == 7) test_light_density(&t, 0, v3(0.3f, -0.2f, 0.4f), "cylinder inside");
        test_scene_free(&t);
    }
}

// A mesh of three triangles, which do not form faces in pairs, is sampled by triangle.
static void densities_of_triangles_are_right(void **state) {
    (void)state;
    static const float position[19] = {0, 0, 0, 1, 0, 0, 1, 1, 0.3f, 0, 1.2f, 0, -0.7f, 0.5f, 0, 0};
    static const uint32_t index[9] = {0, 1, 2, 0, 2, 3, 0, 3, 4};
    struct test_scene t;
    test_scene_init(&t);
    struct shape s = {.kind = SHAPE_MESH, .material = test_diffuse(&t, 0, 0, 0)};
    s.mesh = (struct mesh){5, 3, position, NULL, NULL, index, NULL, 0};
    test_area_light(&t, test_add_shape(&t, s), rgb_grey(1.0f));
    test_scene_finish(&t);
    test_light_density(&t, 0, v3(0.3f, 0.4f, 0.8f), "three triangles");
    test_scene_free(&t);
}

static void densities_of_environments_are_right(void **state) {
    (void)state;
    float texel[16 * 9 * 3];
    struct image image = test_noise_image(texel, 16, 9);
    for (int kind = 0; kind < 3; kind++) {
        struct test_scene t;
        test_scene_init(&t);
        test_quadric(&t, SHAPE_SPHERE, mat4_identity(), false, test_diffuse(&t, 0.5f, 0.5f, 0.5f));
        struct light light = test_environment(kind ? &image : NULL);
        if (kind == 2) {
            light.sun = v3_unit(v3(0.3f, 0.2f, -0.8f));
            light.sun_value = rgb_grey(5.0f), light.sun_chord = 0.3f;
        }
        test_light(&t, light);
        test_scene_finish(&t);
        test_light_density(&t, 0, v3(0, 0, 0), kind == 2 ? "sun" : kind ? "envmap" : "constant");
        test_scene_free(&t);
    }
}

// The values are those of Mitsuba 3.9.1 for an image of 4 x 3 texels, red = 1 + index, rotated by
// 30 degrees about y.
static void environments_are_oriented_as_in_mitsuba(void **state) {
    (void)state;
    float texel[36] = {0};
    for (int i = 0; i < 12; i++) texel[3 * i] = (float)(i + 1);
    struct image image = scene_image_make(4, 3, 3, texel);
    struct light light = {.kind = LIGHT_ENVMAP, .value = rgb_grey(1.0f), .image = &image};
    light.to_world = mat4_rotate(v3(0, 1, 0), 30.0f);
    assert_true(mat4_inverse(&light.to_world, &light.to_local));
    struct test_scene t;
    test_scene_init(&t);
    test_quadric(&t, SHAPE_SPHERE, mat4_identity(), false, test_diffuse(&t, 0.5f, 0.5f, 0.5f));
    test_light(&t, light);
    test_scene_finish(&t);
    static const struct {
        vec3 w;
        float red;
    } known[] = {
        {{0, 0, -1}, 5.500000f}, {{0, 0, 1}, 6.833333f},      {{1, 0, 0}, 5.833333f},
        {{-1, 0, 0}, 7.833333f}, {{1, 1, 0}, 3.833333f},      {{-1, 2, 1}, 4.900640f},
        {{1, -2, 3}, 8.064568f}, {{0, -1, 0.1f}, 10.579530f}, {{-3, -1, -2}, 8.065948f},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        rgb L = light_environment(&t.scene, v3_unit(known[i].w));
        assert_true(fabsf(L.r - known[i].red) < 1e-4f && L.g == 0.0f);
    }
    test_scene_free(&t);
}

// ---- One-sidedness, choice, spots -------------------------------------------------------------

static void area_lights_have_a_front(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f);
    test_area_light(&t, test_rectangle(&t, mat4_identity(), grey), rgb_grey(2.0f));
    struct mat4 high = test_transform(v3(0, 0, 5), v3(1, 1, 1));
    test_area_light(&t, test_quadric(&t, SHAPE_SPHERE, high, false, grey), rgb_grey(3.0f));
    test_scene_finish(&t);
    struct light_sample s;
    assert_false(light_sample_wi(&t.scene, 0, v3(0, 0, -1), 0.3f, 0.6f, &s));
    assert_true(light_sample_wi(&t.scene, 0, v3(0, 0, 1), 0.3f, 0.6f, &s));
    assert_false(light_sample_wi(&t.scene, 1, v3(0, 0, 5), 0.3f, 0.6f, &s));
    for (int side = -1; side <= 1; side += 2) {
        struct ray ray = {v3(0.1f, 0.2f, (float)side), 0.0f, v3(0, 0, (float)-side), INFINITY};
        struct interaction hit;
        assert_true(scene_intersect(&t.scene, &ray, &hit));
        rgb L = light_emitted(&t.scene, &hit, v3_neg(ray.d));
        assert_true(L.r == (side > 0 ? 2.0f : 0.0f));
        assert_true((light_pdf(&t.scene, ray.o, ray.d, &hit) > 0.0f) == (side > 0));
    }
    test_scene_free(&t);
}

static struct light light_spot(float cutoff, float beam) {
    return (struct light){.kind = LIGHT_SPOT,
                          .value = rgb_grey(3.0f),
                          .position = v3(0, 0, 0),
                          .direction = v3(0, 0, 1),
                          .cos_cutoff = cosf(cutoff * PI_F / 180.0f),
                          .cos_beam = cosf(beam * PI_F / 180.0f)};
}

// Lights are drawn as often as light_choose_probability says, few or many; and with a probability
// above 0 wherever they bring light.
static void lights_are_chosen_with_their_probability(void **state) {
    (void)state;
    for (int lights = 3; lights <= 28; lights += 25) {
        struct test_scene t;
        test_scene_init(&t);
        uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f);
        for (int i = 0; i < lights; i++) {
            struct mat4 m = test_transform(v3((float)i, 0, 0), v3(0.3f, 0.3f, 0.3f));
            test_area_light(&t, test_rectangle(&t, m, grey), rgb_grey((float)(1 + i % 3)));
        }
        // One light of each other kind, on a line with the others, and from far away.
        struct light other[] = {
            light_spot(60.0f, 20.0f), {.kind = LIGHT_POINT}, test_environment(NULL)};
        other[0].position = v3(3, 0.5f, -1);
        other[1].position = v3(8, 0.5f, 2);
        other[1].value = rgb_grey(2.0f);
        for (int i = 0; i < 3 && lights > 16; i++) test_light(&t, other[i]);
        lights += lights > 16 ? 3 : 0;
        test_scene_finish(&t);
        assert_true((t.scene.light_tree != NULL) == (lights > 16));
        vec3 p = v3(1.0f, 0.5f, 0.7f);
        double drawn[32] = {0}, rest[32] = {0}, sum = 0.0;
        for (int i = 0; i < 100000; i++) {
            float probability, u = ((float)i + 0.5f) * 1e-5f;
            uint32_t l = light_choose(&t.scene, p, LIGHT_ALL_VISIBLE, &u, &probability);
            assert_true(fabsf(probability -
                              light_choose_probability(&t.scene, p, LIGHT_ALL_VISIBLE, l)) < 1e-7f);
            assert_true(u >= 0.0f && u < 1.0f);
            drawn[l] += 1e-5;
            rest[l] += (double)u * 1e-5;
        }
        for (int i = 0; i < lights; i++) {
            float probability =
                light_choose_probability(&t.scene, p, LIGHT_ALL_VISIBLE, (uint32_t)i);
            struct light_sample s;
            if (light_sample_wi(&t.scene, (uint32_t)i, p, 0.5f, 0.5f, &s))
                assert_true(probability > 1e-4f);
            assert_true(fabs(drawn[i] - probability) < 1e-4);
            assert_true(fabs(rest[i] - 0.5 * probability) < 1e-4);  // it is uniform within each
            sum += probability;
        }
        assert_true(fabs(sum - 1.0) < 1e-5);
        test_scene_free(&t);
    }
}

// Mitsuba's falloff is linear in the angle (measured with 3.9.1).
static void spots_fall_off_between_their_angles(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    test_rectangle(&t, test_transform(v3(0, 0, 2), v3(9, 9, 1)), test_diffuse(&t, 0, 0, 0));
    test_light(&t, light_spot(40.0f, 10.0f));
    test_scene_finish(&t);
    static const float known[][2] = {{5, 0.75f}, {12, 0.7f}, {25, 0.375f}, {39, 0.025f}, {41, 0}};
    for (int i = 0; i < 5; i++) {
        float a = known[i][0] * PI_F / 180.0f;
        struct light_sample s;
        bool lit = light_sample_wi(&t.scene, 0, v3(2 * sinf(a), 0, 2 * cosf(a)), 0.5f, 0.5f, &s);
        assert_true(lit == (known[i][1] > 0.0f));
        if (lit) assert_true(s.delta && s.pdf_w == 1.0f && fabsf(s.L.r - known[i][1]) < 2e-5f);
    }
    test_scene_free(&t);
}

// ---- Emission ---------------------------------------------------------------------------------

// Shoots N photons of one light and returns the mean power; adds what arrives on rectangles facing
// up (+z) around p within `half` to *irradiance.
static double emit(const struct test_scene *t, int n, vec3 p, float half, double *irradiance) {
    double power = 0.0;
    *irradiance = 0.0;
    for (int i = 0; i < n; i++) {
        vec2 a = sample_sobol2((uint32_t)i, 11), b = sample_sobol2((uint32_t)i, 12);
        float u[4] = {a.x, a.y, b.x, b.y};
        struct light_ray ray;
        if (!light_emit(&t->scene, 0, NULL, u, &ray)) continue;
        power += ray.power.r / n;
        struct interaction s;
        if (!scene_intersect(&t->scene, &ray.ray, &s)) continue;
        vec3 d = v3_sub(s.p, p);
        if (fabsf(d.x) < half && fabsf(d.y) < half && fabsf(d.z) < 1e-3f && ray.ray.d.z < 0.0f)
            *irradiance += ray.power.r / n / (4.0 * half * half);
    }
    return power;
}

// The irradiance at p with normal +z by light_sample.
static double sampled_irradiance(const struct test_scene *t, vec3 p) {
    enum { N = 65536 };
    double E = 0.0;
    for (uint32_t i = 0; i < N; i++) {
        vec2 u = sample_sobol2(i, 5);
        struct light_sample s;
        if (!light_sample_wi(&t->scene, 0, p, u.x, u.y, &s) || !(s.wi.z > 0.0f)) continue;
        struct ray ray = light_shadow_ray(&t->scene, p, v3(0, 0, 1), &s);
        if (!scene_occluded(&t->scene, &ray)) E += s.L.r * s.wi.z / s.pdf_w / N;
    }
    return E;
}

struct emission_case {
    const char *name;
    struct light light;
    int shape;     // of an area light: as in area_density; else -1
    double power;  // [W]; 0: not known in closed form
};

static void check_emission(const struct emission_case *c) {
    enum { N = 1 << 18 };
    struct test_scene t;
    test_scene_init(&t);
    uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f);
    struct mat4 up = test_transform(v3(0.2f, 0, 2), v3(0.5f, 0.5f, 0.5f));
    struct mat4 down = test_rotated(up, v3(1, 0, 0), 180.0f);
    struct mat4 lying = test_rotated(up, v3(1, 0, 0), 90.0f);
    uint32_t shape = 0;
    if (c->shape == 0) shape = test_rectangle(&t, down, grey);
    if (c->shape == 1) shape = test_cube(&t, up, false, grey);
    if (c->shape == 2) shape = test_quadric(&t, SHAPE_SPHERE, up, false, grey);
    if (c->shape == 3) shape = test_quadric(&t, SHAPE_DISK, down, false, grey);
    if (c->shape == 4) shape = test_quadric(&t, SHAPE_CYLINDER, lying, false, grey);
    if (c->shape >= 0)
        test_area_light(&t, shape, rgb_grey(3.0f));
    else
        test_light(&t, c->light);
    test_rectangle(&t, test_transform(v3(0, 0, 0), v3(4, 4, 1)), grey);
    test_scene_finish(&t);
    vec3 p = v3(0.3f, 0.1f, 0.0f);
    // Light from infinity is distributed over all the floor, but uniformly.
    float half = t.light[0].kind >= LIGHT_DIRECTIONAL ? 1.5f : 0.2f;
    double arrived, power = emit(&t, N, p, half, &arrived), E = sampled_irradiance(&t, p);
    if (!(fabs(arrived / E - 1.0) <= 0.08) ||
        (c->power > 0.0 && fabs(power / c->power - 1.0) > 2e-3))
        printf("%s: power %g of %g, irradiance %g by photons, %g by samples\n", c->name, power,
               c->power, arrived, E);
    if (c->power > 0.0) assert_true(fabs(power / c->power - 1.0) < 2e-3);
    // The power of an image is summed over its cells at their centres; these cells are large.
    // That of a slide over a grid, which its edges cut.
    double rough = c->light.image ? 0.1 : c->light.texture ? 0.02 : 2e-3;
    assert_true(fabs(power / t.light[0].power - 1.0) < rough);
    // The patch takes at least 1500 photons: three standard deviations are 8 % at most, while a
    // lost cosine or factor would be tens of per cent.
    assert_true(fabs(arrived / E - 1.0) < 0.08);
    test_scene_free(&t);
}

static void photons_carry_the_power_of_their_light(void **state) {
    (void)state;
    float texel[16 * 9 * 3];
    struct image image = test_noise_image(texel, 16, 9);
    struct light point = {.kind = LIGHT_POINT, .value = rgb_grey(2.0f), .position = v3(0, 0.2f, 2)};
    struct light down = light_spot(50.0f, 20.0f), sun = {.kind = LIGHT_DIRECTIONAL};
    down.position = v3(0.5f, 0.2f, 2.0f);
    down.direction = v3(0, 0, -1);
    sun.value = rgb_grey(1.5f);
    sun.direction = v3_unit(v3(0.5f, 0.3f, -1.0f));
    double c = 50.0 * M_PI / 180.0, b = 20.0 * M_PI / 180.0;
    double spot_power = 3.0 * 2.0 * M_PI * (1.0 - (sin(c) - sin(b)) / (c - b));
    // The slides are at the position of `down` and look down.
    const struct texture light = {.value = rgb_grey(0.9f)}, dark = {.value = rgb_grey(0.2f)};
    struct texture checks = {.kind = TEXTURE_CHECKERBOARD,
                             .check = {&light, &dark},
                             .to_uv = {1.4f, 0, 0, 0, 0.8f, 0},  // no edge near p
                             .mean = rgb_grey(0.55f)};
    struct mat4 to_world =
        test_rotated(test_transform(v3(0.5f, 0.2f, 2.0f), v3(1, 1, 1)), v3(1, 0, 0), 180);
    struct light slide = light_spot(50.0f, 20.0f), projector = {.kind = LIGHT_PROJECTOR};
    slide.texture = projector.texture = &checks;
    slide.position = projector.position = down.position;
    slide.direction = projector.direction = down.direction;
    projector.value = rgb_grey(3.0f);
    projector.tan_x = 0.6f;
    projector.tan_y = 0.4f;
    slide.to_world = projector.to_world = to_world;
    assert_true(mat4_inverse(&to_world, &slide.to_local));
    projector.to_local = slide.to_local;
    const struct emission_case cases[] = {
        {"rectangle", {0}, 0, 3.0 * M_PI},
        {"cube", {0}, 1, 3.0 * M_PI * 6.0},
        {"sphere", {0}, 2, 3.0 * M_PI * M_PI},
        {"disk", {0}, 3, 3.0 * M_PI * M_PI * 0.25},
        {"cylinder", {0}, 4, 3.0 * M_PI * M_PI * 0.5},
        {"point", point, -1, 8.0 * M_PI},
        {"spot", down, -1, spot_power},
        {"spot with a slide", slide, -1, 0.0},
        {"projector", projector, -1, 0.0},
        {"directional", sun, -1, 1.5 * 64.0 * (double)-sun.direction.z},
        {"constant", test_environment(NULL), -1, 0.5 * M_PI * 128.0},
        {"envmap", test_environment(&image), -1, 0.0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) check_emission(&cases[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(densities_of_area_lights_are_right),
        cmocka_unit_test(densities_of_triangles_are_right),
        cmocka_unit_test(densities_of_environments_are_right),
        cmocka_unit_test(environments_are_oriented_as_in_mitsuba),
        cmocka_unit_test(area_lights_have_a_front),
        cmocka_unit_test(lights_are_chosen_with_their_probability),
        cmocka_unit_test(spots_fall_off_between_their_angles),
        cmocka_unit_test(photons_carry_the_power_of_their_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
