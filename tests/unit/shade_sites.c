// SPDX-License-Identifier: Apache-2.0
// Sites on a plate that a point light lights: their positions, the records that they want, and the
// light that adaptive caching needs, against formulas.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "scene_case.h"
#include "shade/shade.h"

// Looks down the z axis from 4 above a plate of reflectance .6: in the middle of the film a pixel
// is 4 * 2 / 100 wide. The light is 2 above the plate, aside.
static const char SHADE_SITES_SCENE[] =
    "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='90'/>"
    "<transform name='to_world'><lookat origin='0, 0, 4' target='0, 0, 0' up='0, 1, 0'/>"
    "</transform><film type='hdrfilm'><integer name='width' value='100'/>"
    "<integer name='height' value='100'/><rfilter type='box'/></film></sensor>"
    "<shape type='rectangle'><bsdf type='diffuse'><rgb name='reflectance' value='.6, .6, .6'/>"
    "</bsdf><transform name='to_world'><scale x='9' y='9'/></transform></shape>"
    "<emitter type='point'><point name='position' x='1' y='0' z='2'/>"
    "<rgb name='intensity' value='5, 5, 5'/></emitter>";

// The sites of pixel (x, y), at most one, with more shapes in the scene.
static int shade_sites_find_below(const char *shapes, bool adaptive, int x, int y,
                                  struct fill_site *out) {
    struct scene_case c;
    char text[2048];
    snprintf(text, sizeof text, "%s%s</scene>", SHADE_SITES_SCENE, shapes);
    satin_scene *scene = scene_case_load(&c, text);
    if (!scene) fail_msg("%s", c.error);
    satin_options options = satin_options_default;
    options.width = options.height = 100;
    options.max_depth = -1;
    options.first_pass = SATIN_FIRST_NONE;
    const struct gather g = gather_make(scene, &options, NULL);
    const struct cache_tables tables = {0};
    struct shade shade = {
        .g = &g, .camera = &scene->camera, .records = cache_reader_make(NULL, &tables, &options)};
    scene_film_filter_make(&scene->film, &shade.filter);
    const int count = shade_sites(&shade, x, y, adaptive, out, 1);
    satin_scene_free(scene);
    return count;
}

static int shade_sites_find_site(bool adaptive, int x, int y, struct fill_site *out) {
    return shade_sites_find_below("", adaptive, x, y, out);
}

static void a_site_has_its_position_and_stream(void **state) {
    (void)state;
    struct fill_site site, other;
    assert_int_equal(shade_sites_find_site(false, 50, 50, &site), 1);
    assert_int_equal(shade_sites_find_site(false, 51, 50, &other), 1);
    // The pixel's square on the plate; the edge of its triangle may move it by half a pixel more.
    assert_true(fabsf(site.p.x) < 0.13f && fabsf(site.p.y) < 0.13f && fabsf(site.p.z) < 1e-5f);
    assert_true(v3_dist2(site.frame.n, v3(0, 0, 1)) < 1e-10f);
    assert_true(v3_dist2(site.ng, v3(0, 0, 1)) < 1e-10f);
    assert_float_equal(site.pixel, 0.08f, 1e-3f);
    assert_int_equal(site.kinds, 1 << CACHE_IRRADIANCE);
    assert_null(site.glossy.table);
    assert_true(site.stream != other.stream);
}

static void light_is_found_for_adaptive_caching_alone(void **state) {
    (void)state;
    struct fill_site plain, site;
    assert_int_equal(shade_sites_find_site(false, 30, 60, &plain), 1);
    assert_int_equal(shade_sites_find_site(true, 30, 60, &site), 1);
    assert_true(plain.direct == 0.0f && rgb_black(plain.diffuse));
    assert_true(v3_dist2(plain.p, site.p) == 0.0f && plain.stream == site.stream);
    // The radiance is rho / pi I cos(theta) / d^2 by floats, and every light sample is the same.
    const vec3 d = v3_sub(v3(1, 0, 2), site.shading_p);
    const float d2 = v3_len2(d), rho_pi = 0.6f / PI_F;
    assert_float_equal(site.diffuse.r, rho_pi, 1e-5f);
    assert_float_equal(site.direct, rho_pi * 5.0f * d.z / (d2 * sqrtf(d2)), 1e-4f);
}

// Whether there is a site in pixel (98, 50), 3.84 to 3.92 from the middle of the plate, where a
// pixel is .11 wide, below plates of a material at a height, from `begin` outwards. The eye ray
// passes them.
static bool shade_sites_found_below(const char *material, const char *height, float begin) {
    char shapes[1024];
    int at = 0;
    for (int side = -1; side <= 1; side += 2)
        at += snprintf(shapes + at, sizeof shapes - (size_t)at,
                       "<shape type='rectangle'><bsdf type='%s'/><transform name='to_world'>"
                       "<scale x='.5' y='2'/><translate x='%g' z='%s'/></transform></shape>",
                       material, (double)((float)side * (begin + 0.5f)), height);
    struct fill_site site;
    const int count = shade_sites_find_below(shapes, false, 98, 50, &site);
    if (count) assert_true(fabsf(site.p.z) < 1e-5f);
    return count > 0;
}

static void gaps_of_a_pixel_or_two_have_no_site(void **state) {
    (void)state;
    assert_false(shade_sites_found_below("diffuse", ".1", 3.83f));
    assert_true(shade_sites_found_below("thindielectric", ".1", 3.83f));
    assert_true(shade_sites_found_below("diffuse", ".1", 4.0f));
    assert_true(shade_sites_found_below("diffuse", ".3", 3.7f));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_site_has_its_position_and_stream),
        cmocka_unit_test(light_is_found_for_adaptive_caching_alone),
        cmocka_unit_test(gaps_of_a_pixel_or_two_have_no_site),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
