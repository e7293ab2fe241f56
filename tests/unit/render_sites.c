// SPDX-License-Identifier: Apache-2.0
// Grids of pixels, and the sites of many pixels: those of each pixel, in the order of the pixels,
// however many threads look for them.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "render/render_state.h"
#include "scene_case.h"

enum { WIDTH = 131, HEIGHT = 77, BLOCK = 8192 };  // more pixels than are traced at a time

// Looks at a plate that fills the left of the film; the rest is empty.
static const char RENDER_SITES_SCENE[] =
    "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='90'/>"
    "<transform name='to_world'><lookat origin='0, 0, 4' target='0, 0, 0' up='0, 1, 0'/>"
    "</transform><film type='hdrfilm'><integer name='width' value='131'/>"
    "<integer name='height' value='77'/><rfilter type='box'/></film></sensor>"
    "<shape type='rectangle'><bsdf type='diffuse'/><transform name='to_world'>"
    "<scale x='9' y='9'/><translate x='9'/></transform></shape></scene>";

struct render_sites_fixture {
    struct scene_case loading;
    satin_scene *scene;
    struct render r;
    struct gather g;
    struct cache_tables tables;
};

static void render_sites_start(struct render_sites_fixture *f, int threads) {
    *f = (struct render_sites_fixture){0};
    f->scene = scene_case_load(&f->loading, RENDER_SITES_SCENE);
    if (!f->scene) fail_msg("%s", f->loading.error);
    f->r.scene = *f->scene;
    f->r.options = satin_options_default;
    f->r.options.width = WIDTH;
    f->r.options.height = HEIGHT;
    f->r.options.max_depth = -1;
    f->r.options.first_pass = SATIN_FIRST_NONE;
    f->r.pool = parallel_new(threads);
    assert_non_null(f->r.pool);
    f->g = gather_make(f->scene, &f->r.options, NULL);
    f->r.second_pass.shade =
        (struct shade){.g = &f->g,
                       .camera = &f->r.scene.camera,
                       .records = cache_reader_make(NULL, &f->tables, &f->r.options)};
    scene_film_filter_make(&f->scene->film, &f->r.second_pass.shade.filter);
}

static void render_sites_stop(struct render_sites_fixture *f) {
    parallel_free(f->r.pool);
    satin_scene_free(f->scene);
}

// All grids from coarse to fine have every pixel once, in an order that is not that of the rows.
static void grids_have_every_pixel_once(void **state) {
    (void)state;
    const struct render r = {.options = {.width = WIDTH, .height = HEIGHT, .seed = 3}};
    static int times[WIDTH * HEIGHT];
    size_t all = 0, ascents = 0;
    for (int stride = 32; stride > 0; stride /= 2) {
        size_t count;
        uint32_t *pixel = render_grid(&r, stride, stride < 32, &count);
        assert_non_null(pixel);
        for (size_t i = 0; i < count; i++) {
            assert_true(pixel[i] < WIDTH * HEIGHT);
            assert_int_equal(pixel[i] % WIDTH % (uint32_t)stride, 0);
            assert_int_equal(pixel[i] / WIDTH % (uint32_t)stride, 0);
            times[pixel[i]]++;
            ascents += i > 0 && pixel[i] > pixel[i - 1];
        }
        all += count;
        free(pixel);
    }
    assert_int_equal(all, WIDTH * HEIGHT);
    for (int i = 0; i < WIDTH * HEIGHT; i++) assert_int_equal(times[i], 1);
    assert_true(ascents > all / 2 - all / 20 && ascents < all / 2 + all / 20);
}

static void grids_depend_on_the_seed_alone(void **state) {
    (void)state;
    struct render r = {.options = {.width = WIDTH, .height = HEIGHT, .seed = 3}};
    size_t count;
    uint32_t *a = render_grid(&r, 4, true, &count), *b = render_grid(&r, 4, true, &count);
    r.options.seed = 4;
    uint32_t *c = render_grid(&r, 4, true, &count);
    assert_memory_equal(a, b, count * sizeof *a);
    assert_memory_not_equal(a, c, count * sizeof *a);
    free(a);
    free(b);
    free(c);
}

static void sites_are_in_the_order_of_the_pixels(void **state) {
    (void)state;
    for (int threads = 1; threads <= 3; threads += 2) {
        struct render_sites_fixture f;
        render_sites_start(&f, threads);
        size_t pixels, at = 0;
        uint32_t *pixel = render_grid(&f.r, 1, false, &pixels);
        struct render_sites sites = {0};
        // The second search replaces what the first one found.
        size_t few = 100;
        assert_int_equal(render_find_sites(&f.r, 0, pixel, &few, SIZE_MAX, false, &sites),
                         SATIN_OK);
        assert_int_equal(render_find_sites(&f.r, 0, pixel, &pixels, SIZE_MAX, false, &sites),
                         SATIN_OK);
        assert_int_equal(few, 100);
        for (size_t i = 0; i < pixels; i++) {
            struct fill_site one;
            const int x = (int)(pixel[i] % WIDTH), y = (int)(pixel[i] / WIDTH);
            if (!shade_sites(&f.r.second_pass.shade, x, y, false, &one, 1)) continue;
            assert_true(at < sites.count);
            assert_true(sites.site[at].stream == one.stream);
            assert_true(v3_dist2(sites.site[at].p, one.p) == 0.0f);
            at++;
        }
        assert_int_equal(at, sites.count);
        assert_true(at > pixels / 3 && at < 2 * pixels / 3);
        free(pixel);
        render_sites_free(&sites);
        assert_null(sites.site);
        render_sites_stop(&f);
    }
}

// The search ends where there are as many sites as it is asked for, with the same ones.
static void a_search_ends_with_enough_sites(void **state) {
    (void)state;
    struct render_sites_fixture f;
    render_sites_start(&f, 2);
    size_t pixels;
    uint32_t *pixel = render_grid(&f.r, 1, false, &pixels);
    struct render_sites all = {0}, sites = {0};
    assert_int_equal(render_find_sites(&f.r, 0, pixel, &pixels, SIZE_MAX, false, &all), SATIN_OK);
    size_t count = pixels;
    assert_int_equal(render_find_sites(&f.r, 0, pixel, &count, 1, false, &sites), SATIN_OK);
    assert_int_equal(count, BLOCK);
    const size_t first = sites.count;
    assert_true(first > 0 && first < all.count);
    for (size_t i = 0; i < first; i++) assert_true(sites.site[i].stream == all.site[i].stream);
    count = pixels;
    assert_int_equal(render_find_sites(&f.r, 0, pixel, &count, first + 1, false, &sites), SATIN_OK);
    assert_int_equal(count, pixels);
    assert_int_equal(sites.count, all.count);
    free(pixel);
    render_sites_free(&all);
    render_sites_free(&sites);
    render_sites_stop(&f);
}

static void the_sites_of_a_view_are_those_of_its_camera(void **state) {
    (void)state;
    struct render_sites_fixture f;
    render_sites_start(&f, 1);
    // The second camera is the first one, a tenth to the left.
    struct camera view[2] = {f.r.scene.camera, f.r.scene.camera};
    const vec3 shift = mat4_vector(&view[1].to_world, v3(0.1f, 0, 0));
    view[1].to_world.m[0][3] += shift.x;
    view[1].to_world.m[1][3] += shift.y;
    view[1].to_world.m[2][3] += shift.z;
    f.r.scene.view = view;
    f.r.scene.view_count = 2;
    size_t pixels;
    uint32_t *pixel = render_grid(&f.r, 1, false, &pixels);
    struct render_sites sites[2] = {{0}};
    for (uint32_t i = 0; i < 2; i++) {
        assert_int_equal(render_find_sites(&f.r, i, pixel, &pixels, SIZE_MAX, false, &sites[i]),
                         SATIN_OK);
        f.r.second_pass.shade.camera = &view[i];
        size_t at = 0;
        for (size_t k = 0; k < pixels; k++) {
            struct fill_site one;
            const int x = (int)(pixel[k] % WIDTH), y = (int)(pixel[k] / WIDTH);
            if (!shade_sites(&f.r.second_pass.shade, x, y, false, &one, 1)) continue;
            assert_true(at < sites[i].count);
            assert_true(v3_dist2(sites[i].site[at].p, one.p) == 0.0f);
            // The first view has the streams of a single image, the others have separate ones.
            assert_true((sites[i].site[at].stream == one.stream) == (i == 0));
            at++;
        }
        assert_int_equal(at, sites[i].count);
    }
    assert_true(v3_dist2(sites[0].site[0].p, sites[1].site[0].p) > 0.0f);
    free(pixel);
    render_sites_free(&sites[0]);
    render_sites_free(&sites[1]);
    render_sites_stop(&f);
}

static bool render_sites_cancel(void *user, double done) {
    (void)user;
    (void)done;
    return true;
}

static void a_search_can_be_cancelled(void **state) {
    (void)state;
    struct render_sites_fixture f;
    render_sites_start(&f, 2);
    size_t pixels;
    uint32_t *pixel = render_grid(&f.r, 1, false, &pixels);
    struct render_sites sites = {0};
    parallel_set_progress(f.r.pool, render_sites_cancel, NULL);
    assert_int_equal(render_find_sites(&f.r, 0, pixel, &pixels, SIZE_MAX, false, &sites),
                     SATIN_CANCELLED);
    render_sites_free(&sites);
    free(pixel);
    render_sites_stop(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grids_have_every_pixel_once),
        cmocka_unit_test(grids_depend_on_the_seed_alone),
        cmocka_unit_test(sites_are_in_the_order_of_the_pixels),
        cmocka_unit_test(a_search_ends_with_enough_sites),
        cmocka_unit_test(the_sites_of_a_view_are_those_of_its_camera),
        cmocka_unit_test(a_search_can_be_cancelled),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
