// SPDX-License-Identifier: Apache-2.0
// Paths after the hits of gather rays: on average they find what path tracing finds, and paths
// longer than the options allow are left out.
#include "gather/gather_bounces.h"

#include <math.h>
#include <stdlib.h>

#include "photon/photon_map.h"
#include "photon_case.h"
#include "test_scene.h"

// Where there are no photons, rays continue as paths over diffuse and glossy lobes: their mean is
// that of path tracing, for both first passes that read photons.
static void paths_over_two_lobes_are_unbiased(void **state) {
    (void)state;
    enum { RAYS = 150000 };
    struct test_scene t;
    test_scene_init(&t);
    test_cube(&t, mat4_identity(), true,
              test_material(&t, "phong", rgb_make(.5f, .4f, .3f), rgb_grey(.4f)));
    test_light(&t, (struct light){
                       .kind = LIGHT_POINT, .position = v3(.3f, .2f, .4f), .value = rgb_grey(1)});
    test_scene_finish(&t);
    satin_options options = satin_options_default;
    options.max_depth = -1;
    options.rr_depth = 5;
    const struct photon_maps maps = {.area = true};
    const struct gather g = gather_make(&t.scene, &options, &maps);
    struct gather_scratch *scratch = gather_scratch_new(NULL, 0);
    assert_non_null(scratch);
    static struct gather_ray rays[RAYS];
    rgb path = rgb_grey(0.0f);
    for (uint32_t i = 0; i < RAYS; i++) {
        const vec2 u = sample_sobol2(i, 5);
        const struct ray ray = {v3(0, 0, 0), 0.0f, sample_uniform_sphere(u.x, u.y), INFINITY};
        struct sampler sampler = {i, 11, 0};
        struct gather_first first;
        rays[i] = (struct gather_ray){.ray = ray, .item = i};
        path = rgb_add(path, gather_path(&g, ray, &sampler, &first));
    }
    const satin_first_pass pass[] = {SATIN_FIRST_PRECOMPUTED, SATIN_FIRST_PHOTONS};
    for (int k = 0; k < 2; k++) {
        options.first_pass = pass[k];
        rgb sum = rgb_grey(0.0f);
        gather_rays(&g, scratch, rays, RAYS, 3);
        for (uint32_t i = 0; i < RAYS; i++) sum = rgb_add(sum, rays[i].L);
        print_message("%.4f of %.4f\n", (double)sum.g / RAYS, (double)path.g / RAYS);
        assert_true(fabsf(sum.r / path.r - 1.0f) < 0.01f && fabsf(sum.g / path.g - 1.0f) < 0.01f);
    }
    gather_scratch_free(scratch);
    test_scene_free(&t);
}

// A scene with the global photon map that gather rays read, at any radius of the lookup.
struct photon_fixture {
    struct test_scene t;
    satin_options options;
    struct parallel *pool;
    struct photon_maps *maps;
    struct gather g;
};

// The scene and max_depth must be set.
static void trace_photons(struct photon_fixture *f, int64_t photons, int64_t caustic) {
    struct stats stats = {0};
    f->options.photons = photons;
    f->options.caustic_photons = caustic;
    f->pool = parallel_new(1);
    assert_int_equal(photon_case_build(&f->t.scene, &f->options, f->pool, &stats, &f->maps),
                     SATIN_OK);
    f->g = gather_make(&f->t.scene, &f->options, f->maps);
    f->g.lookup_max = INFINITY;
}

static void free_photons(struct photon_fixture *f) {
    photon_maps_free(f->maps);
    parallel_free(f->pool);
    test_scene_free(&f->t);
}

// The unit sphere, diffuse, around a point light that brings an irradiance of pi.
static void lit_sphere(struct test_scene *t, float albedo) {
    test_scene_init(t);
    test_quadric(t, SHAPE_SPHERE, mat4_identity(), true, test_diffuse(t, albedo, albedo, albedo));
    test_light(t, (struct light){.kind = LIGHT_POINT, .value = rgb_grey(PI_F)});
    test_scene_finish(t);
}

// The point that a ray from near its middle hits.
static struct shading_point gather_bounces_sphere_point(const struct gather *g,
                                                        struct sampler *sampler) {
    struct gather_first first;
    struct shading_point y;
    const struct ray ray = {v3(0.1f, 0, 0), 0.0f, v3(1, 0, 0), INFINITY};
    assert_true(gather_follow(g, ray, sampler, &first, &y));
    return y;
}

// Inside a diffuse sphere with a lamp in its middle every bounce brings its albedo times the light
// of the one before, in any direction. The first bounce is always made; whether the others are is
// decided by the albedo, so their number G has P(G >= k) = ALBEDO^k.
static void bounces_end_with_the_longest_path(void **state) {
    (void)state;
    enum { PATHS = 20000 };
    const float ALBEDO = 0.5f;
    struct test_scene t;
    lit_sphere(&t, ALBEDO);
    satin_options options = satin_options_default;
    const struct photon_maps maps = {.area = true};
    const struct gather g = gather_make(&t.scene, &options, &maps);
    struct sampler sampler = {0, 5, 0};
    const struct shading_point y = gather_bounces_sphere_point(&g, &sampler);
    const struct gather_estimate none = {rgb_grey(0.0f), false, NULL, 1};
    // With three segments the lamp lights y, and no bounce is kept; with four, one bounce is.
    const float expected[] = {ALBEDO, ALBEDO * (1.0f + ALBEDO)};
    for (int i = 0; i < 2; i++) {
        options.max_depth = 3 + i;
        const rgb L = gather_bounces(&g, &y, 2, none, NULL, sampler);
        assert_true(fabsf(L.g - expected[i]) < 1e-4f);
    }
    options.max_depth = -1;
    double sum = 0.0;
    for (uint32_t i = 0; i < PATHS; i++)
        sum += (double)gather_bounces(&g, &y, 2, none, NULL, (struct sampler){i, 7, 0}).g / PATHS;
    // L = ALBEDO (1 + ALBEDO (1 + G)) has the mean 1 and a standard deviation of 2^-1.5; five of
    // the mean's.
    assert_true(fabs(sum - 1.0) < 5.0 * 0.354 / sqrt(PATHS));
    // A reliable estimate is read instead: E / pi times the albedo, without the direct light in it.
    struct gather_estimate estimate = {rgb_grey(2.0f * PI_F), true, NULL, 1};
    options.gather_direct = false;
    assert_true(fabsf(gather_bounces(&g, &y, 2, estimate, NULL, sampler).g - 2.0f * ALBEDO) <
                1e-6f);
    options.gather_direct = true;
    assert_true(fabsf(gather_bounces(&g, &y, 2, estimate, NULL, sampler).g - 3.0f * ALBEDO) <
                1e-4f);
    // Known direct light replaces that of the lamp.
    const rgb direct = rgb_grey(4.0f * PI_F);
    estimate.direct = &direct;
    assert_true(fabsf(gather_bounces(&g, &y, 2, estimate, NULL, sampler).g - 6.0f * ALBEDO) <
                1e-5f);
    test_scene_free(&t);
}

// The longest path holds for light that photons bring to the end of a bounce, too: in the sphere
// the light of all bounces up to it adds up to a sum that is known. With one bounce more it would
// be 27 % more.
static void photons_are_within_the_longest_path(void **state) {
    (void)state;
    enum { PATHS = 4000, DEPTH = 5 };
    const float ALBEDO = 0.9f;
    struct photon_fixture f = {.options = satin_options_default};
    lit_sphere(&f.t, ALBEDO);
    f.options.max_depth = DEPTH;
    trace_photons(&f, 100000, 0);
    struct sampler sampler = {0, 5, 0};
    const struct shading_point y = gather_bounces_sphere_point(&f.g, &sampler);
    const struct gather_estimate none = {rgb_grey(0.0f), false, NULL, 1};
    double sum = 0.0, expected = 0.0;
    for (uint32_t i = 0; i < PATHS; i++)
        sum += (double)gather_bounces(&f.g, &y, 2, none, NULL, (struct sampler){i, 7, 0}).g / PATHS;
    for (int k = 1; k <= DEPTH - 2; k++) expected += pow((double)ALBEDO, k);
    assert_true(fabs(sum / expected - 1.0) < 0.02);
    free_photons(&f);
}

// In a gap that is narrower than an estimate's disc, light falls off within the disc, so an
// estimate far inside is too bright. All segments are short there, and paths go on until one is
// long. Where they ended at the second segment, this gap had over twice its light.
static void gaps_are_left_before_photons_are_read(void **state) {
    (void)state;
    enum { RAYS = 10000 };
    struct photon_fixture f = {.options = satin_options_default};
    test_scene_init(&f.t);
    const uint32_t white = test_diffuse(&f.t, .9f, .9f, .9f);
    test_cube(&f.t, mat4_identity(), true, white);
    test_cube(&f.t, test_transform(v3(0.58f, 0, 0), v3(0.4f, 0.4f, 0.4f)), false, white);
    test_light(&f.t, (struct light){
                         .kind = LIGHT_POINT, .position = v3(.5f, .9f, 0), .value = rgb_grey(1)});
    test_scene_finish(&f.t);
    f.options.max_depth = -1;
    f.options.rr_depth = 5;
    trace_photons(&f, 4000, 0);
    struct gather_scratch *scratch = gather_scratch_new(NULL, 0);
    struct gather_ray *ray_of = calloc(RAYS, sizeof *ray_of);
    assert_true(scratch && ray_of);
    // The gap is measured at five depths, each of which has the same weight.
    double ratio = 0.0;
    for (int k = 0; k < 5; k++) {
        const vec3 p = v3(0.981f, 0.3f - 0.05f * (float)k, 0);
        double path = 0.0, found = 0.0;
        for (uint32_t i = 0; i < RAYS; i++) {
            const struct ray ray = {p, 0.0f, v3(1, 0, 0), INFINITY};
            struct sampler sampler = {i, 11, 0};
            struct gather_first first;
            ray_of[i] = (struct gather_ray){.ray = ray, .item = i};
            path += (double)gather_path(&f.g, ray, &sampler, &first).g;
        }
        gather_rays(&f.g, scratch, ray_of, RAYS, 3);
        for (uint32_t i = 0; i < RAYS; i++) found += (double)ray_of[i].L.g;
        ratio += 0.2 * found / path;
    }
    print_message("%.3f of the light of paths\n", ratio);
    assert_true(ratio > 0.9 && ratio < 1.5);
    free(ray_of);
    gather_scratch_free(scratch);
    free_photons(&f);
}

struct moments {
    double mean, variance;
};

static struct moments average_paths(const struct gather *g, const struct shading_point *y,
                                    struct gather_estimate estimate, uint32_t paths) {
    double sum = 0.0, squares = 0.0;
    for (uint32_t i = 0; i < paths; i++) {
        const rgb L = gather_bounces(g, y, 2, estimate, NULL, (struct sampler){i, 7, 0});
        sum += (double)L.g;
        squares += (double)(L.g * L.g);
    }
    const double mean = sum / paths;
    return (struct moments){mean, squares / paths - mean * mean};
}

// Makes a disc of a material, the floor of a scene without lights.
static void begin_floor(struct test_scene *t, float glossy) {
    test_scene_init(t);
    test_quadric(t, SHAPE_DISK, mat4_identity(), false,
                 test_material(t, "phong", rgb_grey(.5f), rgb_grey(glossy)));
}

// Returns what a ray from above hits of the floor.
static struct shading_point floor_point(struct test_scene *t) {
    const satin_options options = satin_options_default;
    const struct gather g = gather_make(&t->scene, &options, NULL);
    const struct ray ray = {v3(.2f, .1f, 1), 0.0f, v3_unit(v3(.5f, 0, -1)), INFINITY};
    struct sampler sampler = {0, 5, 0};
    struct gather_first first;
    struct shading_point y;
    assert_true(gather_follow(&g, ray, &sampler, &first, &y));
    return y;
}

// Direct light is found by light samples and by directions of the lobes. Their weights add up to 1,
// whether the lobes are followed always or seldom, and however many light samples there are.
static void direct_light_counts_once(void **state) {
    (void)state;
    enum { PATHS = 1 << 16 };
    for (int seldom = 0; seldom < 2; seldom++) {
        struct test_scene t;
        begin_floor(&t, seldom ? .04f : .4f);
        test_light(&t, (struct light){.kind = LIGHT_CONSTANT, .value = rgb_grey(1.0f)});
        test_scene_finish(&t);
        const struct shading_point y = floor_point(&t);
        satin_options options = satin_options_default;
        options.max_depth = -1;
        const struct photon_maps maps = {.area = true};
        const struct gather g = gather_make(&t.scene, &options, &maps);
        const struct gather_mis alone = {2, {{BRDF_GLOSSY, 0.0f}}};
        const struct gather_light_samples many = {1 << 20, 0};
        const float glossy =
            gather_sample_lights(&g, &y, alone, many, (struct sampler){0, 3, 0}, NULL).g;
        const float diffuse = brdf_albedo(&y.brdf, y.wo_l, BRDF_DIFFUSE).g;
        const rgb known = rgb_grey(PI_F);
        // The diffuse lobe's direct light is known, sampled where the path goes on, or sampled by
        // 16 samples.
        const struct gather_estimate estimate[] = {{rgb_grey(0.0f), true, &known, 1},
                                                   {rgb_grey(0.0f), false, NULL, 1},
                                                   {rgb_grey(0.0f), false, NULL, 16}};
        for (int k = 0; k < 3; k++) {
            const struct moments found = average_paths(&g, &y, estimate[k], PATHS);
            const double expected = (double)(glossy + diffuse);
            print_message("%.4f of %.4f\n", found.mean, expected);
            assert_true(fabs(found.mean / expected - 1.0) < 0.005);
        }
        test_scene_free(&t);
    }
}

// Light of a lamp in the middle of a glass ball is met by caustic photons, or by the glossy lobe in
// directions in which it is sharp. Together they find what path tracing finds, by a wide lobe and
// by one of which a part is sharp.
static void light_through_glass_counts_once(void **state) {
    (void)state;
    enum { PATHS = 1 << 16, POINTS = 64 };
    const struct {
        const char *model;
        float exponent;
        bool inside;
    } cases[] = {{"phong", 30.0f, false},
                 {"phong", 1000.0f, false},
                 {"roughdielectric", 0.0f, true},
                 {"roughdielectric", 0.0f, false}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct photon_fixture f = {.options = satin_options_default};
        test_scene_init(&f.t);
        const uint32_t floor = test_material(&f.t, cases[k].model, rgb_grey(.02f), rgb_grey(.4f));
        struct material *m = &f.t.material[floor];
        m->front.base.exponent = cases[k].exponent;
        m->front.base.ior = m->back.base.ior = 2.5f;  // reflects more than glass
        const uint32_t glass = test_material(&f.t, "dielectric", rgb_grey(0), rgb_grey(1));
        test_quadric(&f.t, SHAPE_DISK, mat4_identity(), cases[k].inside, floor);
        const vec3 lamp = v3(.5f, 0, 1);
        test_quadric(&f.t, SHAPE_SPHERE, test_transform(lamp, v3(.3f, .3f, .3f)), false, glass);
        test_area_light(&f.t,
                        test_quadric(&f.t, SHAPE_SPHERE, test_transform(lamp, v3(.15f, .15f, .15f)),
                                     false, glass),
                        rgb_grey(1.0f));
        test_scene_finish(&f.t);
        f.options.max_depth = -1;
        trace_photons(&f, 0, 400000);
        const struct gather_estimate none = {rgb_grey(0.0f), false, NULL, 1};
        double found = 0.0, expected = 0.0;
        for (uint32_t i = 0; i < POINTS; i++) {
            // Around the mirror direction of the middle of the lamp.
            const vec2 u = sample_sobol2(i, 3);
            const vec3 eye = v3(-.5f, 0, 1);
            const vec3 p = v3(.2f * u.x - .1f, .2f * u.y - .1f, 0);
            const struct ray ray = {eye, 0.0f, v3_unit(v3_sub(p, eye)), INFINITY};
            struct sampler sampler = {i, 5, 0};
            struct gather_first first;
            struct shading_point y;
            assert_true(gather_follow(&f.g, ray, &sampler, &first, &y));
            found += average_paths(&f.g, &y, none, PATHS / POINTS).mean / POINTS;
            for (uint32_t j = 0; j < PATHS / POINTS; j++) {
                struct sampler path = {i * PATHS + j, 11, 0};
                expected += (double)gather_path(&f.g, ray, &path, &first).g / PATHS;
            }
        }
        print_message("%.5f of %.5f\n", found, expected);
        assert_true(fabs(found / expected - 1.0) < 0.04);
        free_photons(&f);
    }
}

// Light of a lamp inside a glass ball takes one segment more than that of the lamp alone, and a
// gather ray through the ball has two more. It counts where all of them are within the longest
// path.
static void caustics_are_within_the_longest_path(void **state) {
    (void)state;
    enum { RAYS = 64 };
    float expected = 0.0f;
    for (int longest = 3; longest <= 6; longest++) {
        struct photon_fixture f = {.options = satin_options_default};
        test_scene_init(&f.t);
        test_quadric(&f.t, SHAPE_DISK, test_transform(v3(0, 0, 0), v3(9, 9, 9)), false,
                     test_diffuse(&f.t, .5f, .5f, .5f));
        const uint32_t glass = test_material(&f.t, "dielectric", rgb_grey(0), rgb_grey(1));
        const vec3 lamp = v3(-.5f, 0, 1);
        test_quadric(&f.t, SHAPE_SPHERE, test_transform(lamp, v3(.3f, .3f, .3f)), false, glass);
        test_area_light(
            &f.t,
            test_quadric(&f.t, SHAPE_SPHERE, test_transform(lamp, v3(.1f, .1f, .1f)), false, glass),
            rgb_grey(1.0f));
        test_scene_finish(&f.t);
        f.options.max_depth = longest;
        trace_photons(&f, 0, 100000);
        const struct shading_point y = floor_point(&f.t);
        const struct gather_estimate none = {rgb_grey(0.0f), false, NULL, 1};
        for (int depth = 2; depth <= 5; depth++) {
            const float L =
                gather_bounces(&f.g, &y, depth, none, NULL, (struct sampler){0, 7, 0}).g;
            print_message("longest path %d, %d to the floor: %.6f\n", longest, depth, L);
            if (depth + 2 > longest) assert_true(L == 0.0f);
            if (depth + 2 == longest && depth == 2) expected = L;
            if (depth + 2 == longest) assert_true(L > 0.0f && fabsf(L / expected - 1.0f) < 0.1f);
        }
        struct gather_scratch *scratch = gather_scratch_new(NULL, 0);
        assert_non_null(scratch);
        struct gather_ray through[RAYS];
        int lit = 0;
        for (uint32_t i = 0; i < RAYS; i++)
            through[i] = (struct gather_ray){.ray = {v3(-.25f, 0, 3), 0.0f, v3(0, 0, -1), INFINITY},
                                             .item = i};
        gather_rays(&f.g, scratch, through, RAYS, 3);
        for (int i = 0; i < RAYS; i++) lit += through[i].L.g > 0.0f;
        print_message("longest path %d: %d of %d rays\n", longest, lit, RAYS);
        // A tenth is reflected by the ball towards the floor.
        if (longest < 5) assert_int_equal(lit, 0);
        if (longest == 5) assert_true(lit > 0 && lit < RAYS / 4);
        if (longest == 6) assert_true(lit > RAYS * 3 / 4);
        gather_scratch_free(scratch);
        free_photons(&f);
    }
}

// Each light sample finds one of many lights of different power, so several have less variance.
static void more_light_samples_are_less_noisy(void **state) {
    (void)state;
    enum { PATHS = 1 << 12, LIGHTS = 8 };
    struct test_scene t;
    begin_floor(&t, 0.0f);
    for (int i = 0; i < LIGHTS; i++)
        test_light(&t, (struct light){.kind = LIGHT_POINT,
                                      .position = v3((float)i - 4.0f, i % 2 ? 0.4f : 0.2f, 0.5f),
                                      .value = rgb_grey(1.0f)});
    test_scene_finish(&t);
    const struct shading_point y = floor_point(&t);
    const satin_options options = satin_options_default;
    const struct photon_maps maps = {.area = true};
    const struct gather g = gather_make(&t.scene, &options, &maps);
    struct gather_estimate estimate = {rgb_grey(0.0f), true, NULL, 1};
    const struct moments one = average_paths(&g, &y, estimate, PATHS);
    estimate.light_samples = 16;
    const struct moments many = average_paths(&g, &y, estimate, PATHS);
    print_message("%.4f, %.4f; variances %.2g, %.2g\n", one.mean, many.mean, one.variance,
                  many.variance);
    assert_true(fabs(many.mean / one.mean - 1.0) < 5.0 * sqrt(one.variance / PATHS) / one.mean);
    assert_true(one.variance > 0.0 && many.variance < one.variance / 8.0);
    test_scene_free(&t);
}

// A ray to the lit end of a corridor takes more light samples if it is gathered together with rays
// to the dark end than alone.
static void bright_hits_take_more_light_samples(void **state) {
    (void)state;
    enum { RAYS = 64, TRIES = 400, LIGHTS = 8 };
    struct photon_fixture f = {.options = satin_options_default};
    test_scene_init(&f.t);
    test_cube(&f.t, test_transform(v3(0, 0, 0), v3(8, 1, 1)), true,
              test_diffuse(&f.t, .5f, .5f, .5f));
    for (int i = 0; i < LIGHTS; i++)
        test_light(&f.t, (struct light){.kind = LIGHT_POINT,
                                        .position = v3(7.5f, 0.2f * (float)i - 0.7f, 0.5f),
                                        .value = rgb_grey(1.0f)});
    test_scene_finish(&f.t);
    trace_photons(&f, 4000, 0);
    struct gather_scratch *scratch = gather_scratch_new(NULL, 0);
    assert_non_null(scratch);
    struct gather_ray rays[RAYS];
    struct moments found[2] = {{0}};  // alone, with the others
    for (int k = 0; k < 2; k++) {
        for (uint64_t i = 0; i < TRIES; i++) {
            for (uint32_t r = 0; r < RAYS; r++)
                rays[r] = (struct gather_ray){
                    .ray = {v3(0, 0, 0), 0.0f, v3(r == 0 ? 1.0f : -1.0f, 0, 0), INFINITY},
                    .item = r};
            gather_rays(&f.g, scratch, rays, k == 0 ? 1 : RAYS, i);
            found[k].mean += (double)rays[0].L.g / TRIES;
            found[k].variance += (double)sqrf(rays[0].L.g) / TRIES;
        }
        found[k].variance -= found[k].mean * found[k].mean;
        print_message("%.4f, variance %.2g\n", found[k].mean, found[k].variance);
    }
    const double deviation = 5.0 * sqrt(found[0].variance / TRIES);
    assert_true(fabs(found[1].mean - found[0].mean) < deviation);
    assert_true(found[0].variance > 0.0 && found[1].variance < found[0].variance / 8.0);
    gather_scratch_free(scratch);
    free_photons(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(paths_over_two_lobes_are_unbiased),
        cmocka_unit_test(bounces_end_with_the_longest_path),
        cmocka_unit_test(photons_are_within_the_longest_path),
        cmocka_unit_test(caustics_are_within_the_longest_path),
        cmocka_unit_test(direct_light_counts_once),
        cmocka_unit_test(light_through_glass_counts_once),
        cmocka_unit_test(more_light_samples_are_less_noisy),
        cmocka_unit_test(bright_hits_take_more_light_samples),
        cmocka_unit_test(gaps_are_left_before_photons_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
