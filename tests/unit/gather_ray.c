// SPDX-License-Identifier: Apache-2.0
// Gather rays that look for lights: the light that they hit is weighted against the light samples
// of the point from which they start, although they begin off its surface and cells of visibility
// may end there.
#include "gather/gather.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "gather/gather_scratch.h"
#include "guide/guide_visibility.h"
#include "photon/photon_map.h"
#include "photon_case.h"
#include "test_scene.h"

// A floor at z = 0 beneath a sky and a lamp.
static void gather_ray_scene_of(struct test_scene *t) {
    test_scene_init(t);
    test_rectangle(t, test_transform(v3(0, 0, 0), v3(9, 9, 1)), test_diffuse(t, 1.0f, 1.0f, 1.0f));
    test_light(t, (struct light){.kind = LIGHT_CONSTANT, .value = rgb_grey(1.0f)});
    test_light(
        t, (struct light){.kind = LIGHT_POINT, .position = v3(0, 0, 2), .value = rgb_grey(4.0f)});
    test_scene_finish(t);
}

// Two cells that meet at `height`: the sky is hardly visible from the lower one, and the lamp not
// from the upper one.
static struct guide_visibility *cells_at(float height) {
    struct guide_visibility *visibility = calloc(1, sizeof *visibility);
    assert_non_null(visibility);
    visibility->choice = true;
    visibility->cells.depth = 1;
    visibility->cells.split[0] = (struct split_plane){v3(0, 0, 1), height};
    for (int cell = 0; cell < 2; cell++)
        for (int light = 0; light < 2; light++)
            visibility->visible[cell][light] = cell == light ? .02f : 1;
    return visibility;
}

static void light_is_weighted_at_the_start_of_a_ray(void **state) {
    (void)state;
    struct test_scene t;
    gather_ray_scene_of(&t);
    satin_options options = satin_options_default;
    options.first_pass = SATIN_FIRST_NONE;
    struct gather_scratch *scratch = gather_scratch_new(NULL, 0);
    assert_non_null(scratch);
    const vec3 p = v3(0, 0, 0), up = v3(0, 0, 1);
    const struct light_receiver from = {p, up, false};
    const float border[2] = {0.0f, 1e-30f};
    for (int i = 0; i < 2; i++) {
        const struct photon_maps maps = {.area = true};
        struct guide_visibility *visibility = cells_at(border[i]);
        const struct gather g = {
            .scene = &t.scene, .options = &options, .maps = &maps, .visibility = visibility};
        struct gather_ray ray = {.ray = scene_spawn(&t.scene, p, up, up), .lit = &from};
        gather_rays(&g, scratch, &ray, 1, 0);
        assert_true(ray.ray.o.z > border[1]);
        assert_true(rgb_luminance(ray.Le) > 0.0f);
        const struct light_connection to = {.d = up, .exit = up, .spread = 1.0f};
        struct light_product product;
        const struct light_visibility at = guide_visibility_at(visibility, &from, &product);
        assert_true(ray.light_pdf == gather_light_pdf(&g, p, at, &to, NULL));
        // A sky and a lamp that light p equally would get half of the samples each.
        assert_true(i == 0 ? ray.light_pdf > 0.4f / PI_F * 0.5f : ray.light_pdf < 0.05f / PI_F);
        free(visibility);
    }
    gather_scratch_free(scratch);
    test_scene_free(&t);
}

// A surface without a diffuse lobe has no irradiance estimate: none is left in the scratch from an
// earlier ray.
static void no_estimate_remains_from_an_earlier_call(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    test_rectangle(&t, test_transform(v3(0, 0, 0), v3(9, 9, 1)),
                   test_material(&t, "phong", rgb_grey(0.0f), rgb_grey(0.5f)));
    test_scene_finish(&t);
    satin_options options = satin_options_default;
    options.first_pass = SATIN_FIRST_PHOTONS;
    const struct photon_maps maps = {.area = true};
    const struct gather g = gather_make(&t.scene, &options, &maps);
    struct gather_scratch *scratch = gather_scratch_new(NULL, 0);
    assert_non_null(scratch);
    scratch->hits.E[0] = rgb_grey(NAN);
    scratch->hits.radius[0] = NAN;
    const struct ray down = {v3(0, 0, 1), 0.0f, v3(0, 0, -1), INFINITY};
    struct gather_ray ray = {.ray = down};
    gather_rays(&g, scratch, &ray, 1, 0);
    assert_int_equal(scratch->hits.hit[0].point.lobes & BRDF_SMOOTH, BRDF_GLOSSY);
    assert_true(rgb_black(scratch->hits.E[0]) && isinf(scratch->hits.radius[0]));
    gather_scratch_free(scratch);
    test_scene_free(&t);
}

// The radiance along a ray in a closed cube, if rays like it are drawn with this density.
static float luminance_by(const struct gather *g, struct gather_scratch *scratch, float pdf) {
    const vec3 p = v3(0.1f, 0.2f, -1.0f), n = v3(0, 0, 1), d = v3_unit(v3(0.2f, 0.1f, 1.0f));
    struct gather_ray ray = {.ray = scene_spawn(g->scene, p, n, d), .pdf_w = pdf};
    gather_rays(g, scratch, &ray, 1, 0);
    return rgb_luminance(ray.L);
}

// A lookup is read if the rays of a lobe hit so large an area that the noise of the mean lookup is
// below 2 %, else the ray is followed: by one bounce, whose light differs.
static void narrow_lobes_do_not_show_single_lookups(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    test_cube(&t, mat4_identity(), true, test_diffuse(&t, 0.5f, 0.5f, 0.5f));
    test_light(&t, (struct light){
                       .kind = LIGHT_POINT, .position = v3(0, 0.5f, 0), .value = rgb_grey(1.0f)});
    test_scene_finish(&t);
    satin_options options = satin_options_default;
    options.max_depth = -1;
    options.photons = 50000;
    options.caustic_photons = 0;
    struct parallel *pool = parallel_new(1);
    struct stats stats = {0};
    struct photon_maps *maps;
    assert_int_equal(photon_case_build(&t.scene, &options, pool, &stats, &maps), SATIN_OK);
    const struct gather g = gather_make(&t.scene, &options, maps);
    struct gather_scratch *scratch = gather_scratch_new(NULL, 0);
    assert_non_null(scratch);
    const float read = luminance_by(&g, scratch, 0.0f);
    assert_true(scratch->hits.reliable[0]);
    // The radius is that of twice the photons of the lookup's disc.
    const float disc = 0.5f * PI_F * sqrf(scratch->hits.radius[0]);
    const float lookups = 1.0f / (sqrf(0.02f) * (float)options.photon_k);
    const float most = sqrf(scratch->hits.hit[0].point.interaction.t) / (disc * lookups);
    assert_true(luminance_by(&g, scratch, 0.99f * most) == read);
    assert_true(luminance_by(&g, scratch, 1.01f * most) != read);
    gather_scratch_free(scratch);
    photon_maps_free(maps);
    parallel_free(pool);
    test_scene_free(&t);
}

// A ray is reflected down to a floor with a lamp above it: eye, mirror, floor and lamp make a path
// of four segments.
static void paths_are_no_longer_than_the_limit(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    test_rectangle(&t, test_transform(v3(0, 0, 0), v3(9, 9, 1)),
                   test_diffuse(&t, 0.5f, 0.5f, 0.5f));
    test_rectangle(&t, test_transform(v3(0, 0, 2), v3(9, 9, 1)),
                   test_material(&t, "conductor", rgb_grey(0.0f), rgb_grey(1.0f)));
    test_light(
        &t, (struct light){.kind = LIGHT_POINT, .position = v3(1, 0, 1), .value = rgb_grey(1.0f)});
    test_scene_finish(&t);
    const struct photon_maps maps = {.area = true};
    struct gather_scratch *scratch = gather_scratch_new(NULL, 0);
    assert_non_null(scratch);
    const satin_first_pass passes[] = {SATIN_FIRST_NONE, SATIN_FIRST_PHOTONS, SATIN_FIRST_PATH};
    for (int i = 0; i < 3; i++)
        for (int depth = 3; depth <= 4; depth++) {
            satin_options options = satin_options_default;
            options.first_pass = passes[i];
            options.max_depth = depth;
            const struct gather g = gather_make(&t.scene, &options, &maps);
            struct gather_ray ray = {.ray = {v3(0, 0, 1), 0.0f, v3(0, 0, 1), INFINITY}};
            gather_rays(&g, scratch, &ray, 1, 0);
            assert_true(rgb_black(ray.L) == (depth == 3));
        }
    gather_scratch_free(scratch);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_is_weighted_at_the_start_of_a_ray),
        cmocka_unit_test(no_estimate_remains_from_an_earlier_call),
        cmocka_unit_test(narrow_lobes_do_not_show_single_lookups),
        cmocka_unit_test(paths_are_no_longer_than_the_limit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
