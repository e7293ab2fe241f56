// SPDX-License-Identifier: Apache-2.0
// The balance of power: what photons bring from each light is what the light emits, and is absorbed
// or leaves the scene. The number of photons of a path, and their factor for light about a
// shading normal.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "photon/photon.h"
#include "photon/photon_map.h"
#include "photon/photon_scatter.h"
#include "test_scene.h"

enum { PHOTON_PATH_PATHS = 1 << 17 };

// Traces the paths, and sets the power of each light. Returns that of all.
static struct photon_power photon_path_trace(const struct test_scene *t, uint64_t paths,
                                             int bounces,
                                             struct photon_power light[PHOTON_POWERS]) {
    struct parallel *pool = parallel_new(2);
    assert_non_null(pool);
    const struct photon_tracing tracing = {
        .scene = &t->scene, .seed = 1, .consumer = {{paths, 0, NULL}}, .bounces = bounces};
    struct photon_trace trace[PHOTON_CONSUMERS] = {{0}};
    assert_int_equal(photon_trace_run(&tracing, pool, (struct log){0}, trace), SATIN_OK);
    struct photon_power all = {0};
    for (int i = 0; i < PHOTON_POWERS; i++) {
        const struct photon_power *power = &trace[0].power[i];
        if (light) light[i] = *power;
        all.emitted += power->emitted;
        all.absorbed += power->absorbed;
        all.escaped += power->escaped;
        all.ended += power->ended;
    }
    for (int k = 0; k < PHOTON_CONSUMERS; k++) photon_trace_free(&trace[k]);
    parallel_free(pool);
    return all;
}

static struct photon_power photon_path_balance(const struct test_scene *t, int bounces) {
    return photon_path_trace(t, PHOTON_PATH_PATHS, bounces, NULL);
}

// The lamps of the cases, with the power that they emit by their definition [W]; 0: it depends on
// the size of the scene.
struct photon_path_case {
    const char *name;
    struct light light;
    double power;
};

// A floor with a glass ball, a metal ball and a glossy wall, under a sphere that can be a lamp.
static void photon_path_scene(struct test_scene *t, const struct photon_path_case *lights,
                              int count) {
    test_scene_init(t);
    test_rectangle(t, test_transform(v3(0, 0, 0), v3(3, 3, 3)), test_diffuse(t, .7f, .5f, .3f));
    test_quadric(t, SHAPE_SPHERE, test_transform(v3(-1, 0, .5f), v3(.5f, .5f, .5f)), false,
                 test_material(t, "dielectric", rgb_grey(0), rgb_grey(1)));
    test_quadric(t, SHAPE_SPHERE, test_transform(v3(1, 0, .5f), v3(.5f, .5f, .5f)), false,
                 test_material(t, "roughconductor", rgb_grey(0), rgb_grey(1)));
    test_cube(t, test_transform(v3(0, 2, 1), v3(2, .1f, 1)), false,
              test_material(t, "phong", rgb_grey(.4f), rgb_grey(.4f)));
    const uint32_t lamp =
        test_quadric(t, SHAPE_SPHERE, test_transform(v3(0, 0, 2), v3(.2f, .2f, .2f)), false,
                     test_diffuse(t, .5f, .5f, .5f));
    for (int i = 0; i < count; i++) {
        if (lights[i].light.kind == LIGHT_AREA)
            test_area_light(t, lamp, lights[i].light.value);
        else
            test_light(t, lights[i].light);
    }
    test_scene_finish(t);
}

enum { PHOTON_PATH_CASES = 5 };
static const struct photon_path_case photon_path_cases[PHOTON_PATH_CASES] = {
    {"area", {.kind = LIGHT_AREA, .value = {1, 1, 1}}, 4.0 * M_PI *M_PI * .04},
    {"point", {.kind = LIGHT_POINT, .value = {1, 1, 1}, .position = {0, -1, 1}}, 4.0 * M_PI},
    {"spot",
     {.kind = LIGHT_SPOT,
      .value = {1, 1, 1},
      .position = {0, -1, 1.5f},
      .direction = {0, 0, -1},
      .cos_beam = .9f,
      .cos_cutoff = .9f},
     2.0 * M_PI * .1},
    {"directional", {.kind = LIGHT_DIRECTIONAL, .value = {1, 1, 1}, .direction = {0, 0, -1}}, 0.0},
    {"constant", {.kind = LIGHT_CONSTANT, .value = {1, 1, 1}}, 0.0}};

// What a light emits is its power, and is absorbed or escapes.
static void photon_path_check(const char *name, const struct photon_power *power, double expected) {
    print_message("%s: of %.5f W %.5f emitted, %.5f absorbed, %.5f escaped, %.2g ended\n", name,
                  expected, power->emitted, power->absorbed, power->escaped, power->ended);
    assert_true(fabs(power->emitted / expected - 1.0) < 1e-4);
    assert_true(fabs((power->absorbed + power->escaped) / power->emitted - 1.0) < 1e-4);
    assert_true(power->absorbed > 0.05 * power->emitted);
    assert_true(power->escaped > 0.05 * power->emitted);
}

static void power_is_absorbed_or_escapes(void **state) {
    (void)state;
    for (int i = 0; i < PHOTON_PATH_CASES; i++) {
        struct test_scene t;
        photon_path_scene(&t, &photon_path_cases[i], 1);
        const struct photon_power power = photon_path_balance(&t, -1);
        photon_path_check(photon_path_cases[i].name, &power,
                          photon_path_cases[i].power > 0.0 ? photon_path_cases[i].power
                                                           : (double)t.scene.light[0].power);
        test_scene_free(&t);
    }
}

// Lights of one scene each have their own balance. As much of one is absorbed as if it were alone:
// five deviations of their paths, by which absorption is drawn.
static void power_is_that_of_each_light(void **state) {
    (void)state;
    struct test_scene t;
    struct photon_power power[PHOTON_POWERS];
    photon_path_scene(&t, photon_path_cases, PHOTON_PATH_CASES);
    const struct photon_power all = photon_path_trace(&t, PHOTON_PATH_PATHS, -1, power);
    for (int i = 0; i < PHOTON_PATH_CASES; i++) {
        struct test_scene alone;
        photon_path_check(photon_path_cases[i].name, &power[i], (double)t.scene.light[i].power);
        photon_path_scene(&alone, &photon_path_cases[i], 1);
        const struct photon_power one = photon_path_balance(&alone, -1);
        const double fraction = one.absorbed / one.emitted,
                     paths = PHOTON_PATH_PATHS * power[i].emitted / all.emitted;
        assert_true(fabs(power[i].absorbed / power[i].emitted - fraction) < 2.5 / sqrt(paths));
        test_scene_free(&alone);
    }
    test_scene_free(&t);
}

// If there are many lights, the last power is that of all further ones.
static void further_lights_are_counted_together(void **state) {
    (void)state;
    enum { LIGHTS = PHOTON_POWERS + 4 };
    struct test_scene t;
    struct photon_power power[PHOTON_POWERS];
    test_scene_init(&t);
    test_quadric(&t, SHAPE_SPHERE, mat4_identity(), true, test_diffuse(&t, .5f, .5f, .5f));
    for (int i = 0; i < LIGHTS; i++)
        test_light(&t, (struct light){.kind = LIGHT_POINT, .value = rgb_grey((float)(1 + i))});
    test_scene_finish(&t);
    photon_path_trace(&t, PHOTON_PATH_PATHS, -1, power);
    double further = 0.0;
    for (int i = PHOTON_POWERS - 1; i < LIGHTS; i++) further += 4.0 * M_PI * (1 + i);
    for (int i = 0; i < PHOTON_POWERS; i++) {
        const double expected = i < PHOTON_POWERS - 1 ? 4.0 * M_PI * (1 + i) : further;
        assert_true(fabs(power[i].emitted / expected - 1.0) < 1e-4);
        assert_true(fabs(power[i].absorbed / expected - 1.0) < 1e-4);
    }
    test_scene_free(&t);
}

// A disc under a point light meets (1 - cos) / 2 of its light, and absorbs that but for
// the albedo. Inside a closed sphere all is absorbed, in the proportions of a geometric series if
// the number of bounces is limited.
static void fractions_are_those_of_the_scene(void **state) {
    (void)state;
    const double albedo = 0.5;
    struct test_scene t;
    test_scene_init(&t);
    test_quadric(&t, SHAPE_DISK, mat4_identity(), false, test_diffuse(&t, .5f, .5f, .5f));
    test_light(&t,
               (struct light){.kind = LIGHT_POINT, .position = v3(0, 0, 1), .value = rgb_grey(1)});
    test_scene_finish(&t);
    struct photon_power power = photon_path_balance(&t, -1);
    const double met = (1.0 - sqrt(0.5)) / 2.0;
    // Absorption is drawn: five deviations.
    assert_true(fabs(power.absorbed / power.emitted - met * (1.0 - albedo)) <
                5.0 * sqrt(met * albedo * (1.0 - albedo) / PHOTON_PATH_PATHS));
    test_scene_free(&t);

    test_scene_init(&t);
    test_quadric(&t, SHAPE_SPHERE, mat4_identity(), true, test_diffuse(&t, .5f, .5f, .5f));
    test_light(&t, (struct light){.kind = LIGHT_POINT, .value = rgb_grey(1)});
    test_scene_finish(&t);
    for (int bounces = 0; bounces < 3; bounces++) {
        power = photon_path_balance(&t, bounces);
        const double left = pow(albedo, bounces + 1);
        print_message("%d bounces: %.4f of the power ended, %.4f expected\n", bounces,
                      power.ended / power.emitted, left);
        assert_true(power.escaped == 0.0);
        assert_true(fabs(power.ended / power.emitted - left) <
                    5.0 * sqrt(left * (1.0 - left) / PHOTON_PATH_PATHS));
        assert_true(fabs((power.absorbed + power.ended) / power.emitted - 1.0) < 1e-6);
    }
    test_scene_free(&t);
}

// A wall that reflects four times what arrives, which no scene file can have: photons become
// stronger at each bounce, and the paths end all the same, with all of their power.
static void paths_of_growing_power_end(void **state) {
    (void)state;
    enum { PATHS = 16, BOUNCES = 14 };
    struct test_scene t;
    test_scene_init(&t);
    test_quadric(&t, SHAPE_SPHERE, mat4_identity(), true, test_diffuse(&t, 4, 4, 4));
    test_light(&t, (struct light){.kind = LIGHT_POINT, .value = rgb_grey(1)});
    test_scene_finish(&t);
    const struct photon_power power = photon_path_trace(&t, PATHS, BOUNCES, NULL);
    assert_true(fabs(power.ended / (power.emitted * pow(4.0, BOUNCES + 1)) - 1.0) < 1e-4);
    test_scene_free(&t);
}

// In a closed sphere a path has 1 / (1 - albedo) photons in the mean, with a standard deviation
// that is at most as large; the mean is over 256 of them.
static void paths_store_by_albedo(void **state) {
    (void)state;
    const float albedos[] = {0.5f, 0.9f, 0.98f};
    for (size_t i = 0; i < sizeof albedos / sizeof *albedos; i++) {
        struct test_scene t;
        const float albedo = albedos[i];
        test_scene_init(&t);
        test_quadric(&t, SHAPE_SPHERE, mat4_identity(), true,
                     test_diffuse(&t, albedo, albedo, albedo));
        test_light(&t, (struct light){.kind = LIGHT_POINT, .value = rgb_grey(1)});
        test_scene_finish(&t);
        satin_options o = satin_options_default;
        o.max_depth = -1;
        const struct photon_request request = {.scene = &t.scene, .options = &o};
        struct parallel *pool = parallel_new(1);
        double stored = 0.0;
        assert_int_equal(photon_count_stored(&request, pool, (struct log){0}, &stored), SATIN_OK);
        const double expected = 1.0 / (1.0 - (double)albedo);
        print_message("albedo %.2f: %.2f photons, %.2f expected\n", (double)albedo, stored,
                      expected);
        assert_true(fabs(stored / expected - 1.0) < 4.0 / 16.0);
        parallel_free(pool);
        test_scene_free(&t);
    }
}

// A normal map that tilts normals by b towards x, and a floor that has it.
static struct texture photon_path_map(float b) {
    return (struct texture){.value = rgb_make(0.5f + 0.5f * sinf(b), 0.5f, 0.5f + 0.5f * cosf(b))};
}

static uint32_t photon_path_floor(struct test_scene *t, float albedo, const struct texture *map) {
    const uint32_t floor = test_diffuse(t, albedo, albedo, albedo);
    t->material[floor].front.bump[0].normal = map;
    test_rectangle(t, mat4_identity(), floor);
    return floor;
}

// Light along (-sin a, 0, -cos a) has the irradiance cos a on a floor, and cos(a - b) about a
// normal that a map tilts by b towards it; 0 where this normal faces away.
static void tilted_normals_have_their_irradiance(void **state) {
    (void)state;
    const float b = 0.6f, angles[] = {-1.2f, -0.5f, 0.0f, 0.7f, 1.3f};
    const struct texture map = photon_path_map(b);
    for (size_t i = 0; i < sizeof angles / sizeof *angles; i++) {
        struct test_scene t;
        const float a = angles[i];
        test_scene_init(&t);
        photon_path_floor(&t, 0.5f, &map);
        test_light(&t, (struct light){.kind = LIGHT_DIRECTIONAL,
                                      .value = rgb_grey(1),
                                      .direction = v3(-sinf(a), 0, -cosf(a))});
        test_scene_finish(&t);
        struct parallel *pool = parallel_new(1);
        const struct photon_tracing tracing = {
            .scene = &t.scene, .seed = 1, .consumer = {{4096, 1 << PHOTON_DIRECT, NULL}}};
        struct photon_trace trace[PHOTON_CONSUMERS] = {{0}};
        assert_int_equal(photon_trace_run(&tracing, pool, (struct log){0}, trace), SATIN_OK);
        double flat = 0.0, tilted = 0.0;
        for (size_t k = 0; k < trace[0].count; k++) {
            const double power = (double)trace[0].hit[k].power.g;
            flat += power;
            tilted += power * (double)photon_unpack_tilt(trace[0].hit[k].tilt);
        }
        const double expected = fmax(cosf(a - b) / cosf(a), 0.0);
        print_message("%.1f rad: %.3f times the light, %.3f expected\n", (double)a, tilted / flat,
                      expected);
        assert_true(flat > 0.0);
        assert_true(fabs(tilted / flat - expected) <= 0.009 * expected);
        for (int k = 0; k < PHOTON_CONSUMERS; k++) photon_trace_free(&trace[k]);
        parallel_free(pool);
        test_scene_free(&t);
    }
}

// A beam of .0014 rad along (-sin a, 0, -cos a) to the origin, in a black sphere.
static void photon_path_beam(struct test_scene *t, float a) {
    test_quadric(t, SHAPE_SPHERE, test_transform(v3(0, 0, 0), v3(30, 30, 30)), true,
                 test_diffuse(t, 0, 0, 0));
    test_light(t, (struct light){.kind = LIGHT_SPOT,
                                 .value = rgb_grey(1),
                                 .position = v3(20 * sinf(a), 0, 20 * cosf(a)),
                                 .direction = v3(-sinf(a), 0, -cosf(a)),
                                 .cos_beam = 1.0f - 1e-6f,
                                 .cos_cutoff = 1.0f - 1e-6f});
}

// A narrow beam along (-sin a, 0, -cos a) meets a floor whose normal is tilted by b. By the adjoint
// BSDF the floor scatters albedo cos(a - b) / cos(a) (1 + cos b) / 2 of its power: the integral of
// the cosine about the flat normal over the directions above both horizons is pi (1 + cos b) / 2.
// Where the map is mirrored for its viewers, the directions behind the normal have that of the
// mirrored one. No photon is much stronger than those of the light, so none of them is an outlier.
static void scatter_at_tilted_normal(float a, bool upright) {
    const float albedo = 0.5f, b = 0.6f;
    const struct texture map = photon_path_map(b);
    struct test_scene t;
    test_scene_init(&t);
    const uint32_t floor = photon_path_floor(&t, albedo, &map);
    t.material[floor].front.bump[0].upright = upright;
    photon_path_beam(&t, a);
    test_scene_finish(&t);
    struct parallel *pool = parallel_new(1);
    const struct photon_tracing tracing = {.scene = &t.scene,
                                           .seed = 1,
                                           .consumer = {{1 << 16, 1 << PHOTON_INDIRECT, NULL}},
                                           .bounces = -1};
    struct photon_trace trace[PHOTON_CONSUMERS] = {{0}};
    assert_int_equal(photon_trace_run(&tracing, pool, (struct log){0}, trace), SATIN_OK);
    double sum = 0.0, most = 0.0;
    for (size_t k = 0; k < trace[0].count; k++) {
        sum += (double)trace[0].hit[k].power.g;
        most = fmax(most, (double)trace[0].hit[k].power.g);
    }
    sum /= trace[0].power[0].emitted;
    most *= (1 << 16) / trace[0].power[0].emitted;
    const double front = fmax(cosf(a - b), 0.0), mirrored = upright ? fmax(cosf(a + b), 0.0) : 0.0;
    const double both = front * (1.0 + cos((double)b)) + mirrored * (1.0 - cos((double)b));
    const double expected = (double)albedo * both / (2.0 * (double)cosf(a));
    print_message("%.1f rad%s: %.4f of the power, %.4f expected; at most %.2f times a photon\n",
                  (double)a, upright ? ", mirrored" : "", sum, expected, most);
    // Five deviations of 2^16 photons; the beam is .0014 rad wide.
    assert_true(fabs(sum / expected - 1.0) < 0.02);
    assert_true(most < 1.51);
    for (int k = 0; k < PHOTON_CONSUMERS; k++) photon_trace_free(&trace[k]);
    parallel_free(pool);
    test_scene_free(&t);
}

static void tilted_normals_scatter_equal_photons(void **state) {
    (void)state;
    const float angles[] = {-1.5f, -0.5f, 0.7f, 1.3f, 1.5f};
    for (size_t i = 0; i < sizeof angles / sizeof *angles; i++) {
        if (angles[i] > -1.0f) scatter_at_tilted_normal(angles[i], false);
        scatter_at_tilted_normal(angles[i], true);
    }
}

// A mirror whose normal is tilted by b reflects cos(a - 2 b) / cos(a) of the power of a beam, by
// the adjoint BSDF. Parts of a photon would all meet the same point, so it stays whole.
static void mirrored_photons_stay_whole(void **state) {
    (void)state;
    const float a = 1.4f, b = 0.6f;
    const struct texture map = photon_path_map(b);
    struct test_scene t;
    test_scene_init(&t);
    const uint32_t mirror = test_material(&t, "conductor", rgb_grey(0), rgb_grey(1));
    t.material[mirror].front.bump[0].normal = &map;
    test_rectangle(&t, mat4_identity(), mirror);
    photon_path_beam(&t, a);
    test_scene_finish(&t);
    struct parallel *pool = parallel_new(1);
    enum { PATHS = 4096 };
    const struct photon_tracing tracing = {.scene = &t.scene,
                                           .seed = 1,
                                           .consumer = {{PATHS, 1 << PHOTON_CAUSTIC, NULL}},
                                           .bounces = -1};
    struct photon_trace trace[PHOTON_CONSUMERS] = {{0}};
    assert_int_equal(photon_trace_run(&tracing, pool, (struct log){0}, trace), SATIN_OK);
    double sum = 0.0;
    for (size_t k = 0; k < trace[0].count; k++) sum += (double)trace[0].hit[k].power.g;
    sum /= trace[0].power[0].emitted;
    const double expected = (double)(cosf(a - 2.0f * b) / cosf(a));
    print_message("%zu photons of %d paths, %.4f of the power, %.4f expected\n", trace[0].count,
                  PATHS, sum, expected);
    // A few paths start beside the beam, where it has no light.
    assert_in_range(trace[0].count, PATHS * 99 / 100, PATHS);
    assert_true(fabs(sum / expected - 1.0) < 0.01);  // the beam is .0014 rad wide
    for (int k = 0; k < PHOTON_CONSUMERS; k++) photon_trace_free(&trace[k]);
    parallel_free(pool);
    test_scene_free(&t);
}

// Openings are sampled in all directions, also in the plane of the surface: there the cosines of
// the adjoint BSDF are 0/0.
static void nothing_is_scattered_in_the_plane(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    test_rectangle(&t, test_transform(v3(0, 0, 0), v3(1, 1, 1)), test_diffuse(&t, .7f, .7f, .7f));
    test_scene_finish(&t);
    const struct ray ray = {v3(.1f, .2f, 1), 0.0f, v3(0, 0, -1), INFINITY};
    struct interaction s;
    struct photon_surface at;
    assert_true(scene_intersect(&t.scene, &ray, &s));
    assert_true(photon_surface_make(&t.scene, &s, v3(0, 0, 1), &at));
    struct photon_scattered to = {.wo = {.6f, .8f, 0}};
    assert_false(photon_scatter_along(&at, 184.0f, &to));
    to.wo = v3(.6f, 0, .8f);
    assert_true(photon_scatter_along(&at, 184.0f, &to));
    assert_float_equal(to.sample.weight.r, .7 * .8 / (M_PI * 184), 1e-7);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(power_is_absorbed_or_escapes),
        cmocka_unit_test(power_is_that_of_each_light),
        cmocka_unit_test(further_lights_are_counted_together),
        cmocka_unit_test(fractions_are_those_of_the_scene),
        cmocka_unit_test(paths_of_growing_power_end),
        cmocka_unit_test(paths_store_by_albedo),
        cmocka_unit_test(tilted_normals_have_their_irradiance),
        cmocka_unit_test(tilted_normals_scatter_equal_photons),
        cmocka_unit_test(mirrored_photons_stay_whole),
        cmocka_unit_test(nothing_is_scattered_in_the_plane),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
