// SPDX-License-Identifier: Apache-2.0
// The filter of gathered irradiance, on images of walls whose irradiance is known.
#include "render/render_image.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/rng.h"
#include "test_scene.h"

enum { SIDE = 48, SAMPLES = 4 };
static const float PIXEL = 0.01f;

// The surface that a pixel shows, and its irradiance.
struct wall {
    vec3 p, n;
    float E;
};
typedef struct wall wall_fn(int x, int y);

static struct image_gathered gathered[SIDE * SIDE];
static struct image_pixel sampled_pixels[SIDE * SIDE];
static const struct render_image film_image = {
    .width = SIDE, .height = SIDE, .pixel = sampled_pixels, .gathered = gathered};

// A partition that stands in the plane x = 0, in which no pixel is.
static struct test_scene two_room_scene;

static int render_irradiance_setup(void **state) {
    (void)state;
    const struct mat4 stand = mat4_rotate(v3(0, 1, 0), 90.0f);
    test_scene_init(&two_room_scene);
    test_rectangle(&two_room_scene, stand, test_diffuse(&two_room_scene, 0.5f, 0.5f, 0.5f));
    test_scene_finish(&two_room_scene);
    return 0;
}

static int render_irradiance_teardown(void **state) {
    (void)state;
    test_scene_free(&two_room_scene);
    return 0;
}

// Albedos that vary from pixel to pixel, as those of a texture.
static rgb albedo_of(int x, int y) {
    return rgb_make(0.1f + 0.2f * (float)((x + y) % 2), 0.3f, 0.1f * (float)(x % 5));
}

// One sample has the light of one ray, whose deviation is 1.1 times its mean.
static struct shade_sample render_irradiance_sample(wall_fn *at, int x, int y, uint32_t index,
                                                    float rays) {
    const struct wall wall = at(x, y);
    struct rng rng = rng_make(3, RNG_TEST, (uint64_t)(y * SIDE + x) << 32 | index);
    const float u = rng_float(&rng), E = wall.E * 3.0f * u * u;
    const rgb albedo = albedo_of(x, y);
    return (struct shade_sample){
        .weight = 1.0f, .gathered = {rgb_scale(albedo, E), albedo, wall.p, wall.n, PIXEL, rays}};
}

static void render_irradiance_image(wall_fn *at, float rays) {
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            struct image_gathered *sum = &gathered[y * SIDE + x];
            *sum = (struct image_gathered){.rays = 0.0f};
            sampled_pixels[y * SIDE + x] =
                (struct image_pixel){.samples = SAMPLES, .weight = (float)SAMPLES};
            for (uint32_t i = 0; i < SAMPLES; i++) {
                const struct shade_sample s = render_irradiance_sample(at, x, y, i, rays);
                render_irradiance_gathered(sum, &s);
            }
        }
}

static rgb changed_by_filter(const satin_options *o, int x, int y) {
    return render_irradiance_change(&film_image, &two_room_scene.scene, o,
                                    render_irradiance_radius(&film_image, o), x, y);
}

// The irradiance of a pixel after the filter, by its green channel; before it without options.
static double render_irradiance_at(const satin_options *o, int x, int y) {
    const struct image_gathered *p = &gathered[y * SIDE + x];
    rgb change = rgb_grey(0.0f);
    if (o) change = changed_by_filter(o, x, y);
    return (double)(p->light.g / (float)SAMPLES + change.g) / (double)albedo_of(x, y).g;
}

// The mean and the relative deviation of E over the columns [x0, x1).
static double mean_of_columns(const satin_options *o, int x0, int x1, double *deviation) {
    double sum = 0.0, squares = 0.0, n = (double)SIDE * (x1 - x0);
    for (int y = 0; y < SIDE; y++)
        for (int x = x0; x < x1; x++) {
            const double E = render_irradiance_at(o, x, y);
            sum += E / n;
            squares += E * E / n;
        }
    *deviation = sqrt(fmax(squares - sum * sum, 0.0)) / sum;
    return sum;
}

static struct wall one_wall(int x, int y) {
    return (struct wall){
        {1.0f + PIXEL * (float)x, PIXEL * (float)y, 0.0f}, {0.0f, 0.0f, 1.0f}, 1.0f};
}

// Two walls that meet in an edge, one lit ten times as much.
static struct wall edge(int x, int y) {
    const float from = PIXEL * (float)(x - SIDE / 2);
    if (x < SIDE / 2) return (struct wall){{from, PIXEL * (float)y, 0.0f}, {0, 0, 1}, 10.0f};
    return (struct wall){{0.0f, PIXEL * (float)y, -from}, {1, 0, 0}, 1.0f};
}

// A floor in two rooms.
static struct wall two_rooms(int x, int y) {
    const float from = PIXEL * ((float)(x - SIDE / 2) + 0.5f);
    return (struct wall){
        {from, PIXEL * (float)(y - SIDE / 2), 0.0f}, {0, 0, 1}, from < 0.0f ? 10.0f : 1.0f};
}

// A wall before another one of the same orientation.
static struct wall two_depths(int x, int y) {
    const float z = x < SIDE / 2 ? 1.0f : 0.0f;
    return (struct wall){
        {PIXEL * (float)x, PIXEL * (float)y, z}, {0, 0, 1}, z > 0.0f ? 10.0f : 1.0f};
}

static void neighbours_are_averaged(void **state) {
    (void)state;
    double before, after;
    render_irradiance_image(one_wall, 1.0f);
    const double mean_before = mean_of_columns(NULL, 0, SIDE, &before);
    const double mean_after = mean_of_columns(&satin_options_default, 0, SIDE, &after);
    assert_true(before > 0.4);
    assert_true(after < before / 5.0);
    assert_true(fabs(mean_after / mean_before - 1.0) < 0.01);
}

static void other_surfaces_are_not(void **state) {
    (void)state;
    wall_fn *const walls[] = {edge, two_depths, two_rooms};
    double deviation;
    for (int i = 0; i < 3; i++) {
        render_irradiance_image(walls[i], 1.0f);
        for (int x = SIDE / 2 - 2; x < SIDE / 2 + 2; x++) {
            const double mean = mean_of_columns(&satin_options_default, x, x + 1, &deviation);
            assert_true(fabs(mean / (double)walls[i](x, 0).E - 1.0) < 0.1);
        }
    }
}

// With the rays of a record in each of its samples, a pixel needs no other.
static void many_rays_suffice(void **state) {
    (void)state;
    render_irradiance_image(one_wall, 1000.0f);
    for (int x = 0; x < SIDE; x++) {
        const rgb change = changed_by_filter(&satin_options_default, x, x);
        assert_true(fabsf(change.g) <= 1e-6f * gathered[x * SIDE + x].light.g);
    }
}

// A sample a thousand times as bright as the others, which have enough rays with few pixels: it is
// averaged with more of them, so its pixel is no dot.
static void bright_samples_are_averaged_more(void **state) {
    (void)state;
    const float rays = satin_options_default.irradiance_rays / 16.0f;
    render_irradiance_image(one_wall, rays);
    const int x = SIDE / 2;
    const double before = render_irradiance_at(&satin_options_default, x, x);
    const struct wall bright = {one_wall(x, x).p, one_wall(x, x).n, 1000.0f};
    const rgb albedo = albedo_of(x, x);
    const struct shade_sample s = {
        .weight = 1.0f,
        .gathered = {rgb_scale(albedo, bright.E), albedo, bright.p, bright.n, PIXEL, rays}};
    render_irradiance_gathered(&gathered[x * SIDE + x], &s);
    const double after = render_irradiance_at(&satin_options_default, x, x);
    gathered[x * SIDE + x].most = 0.0f;
    const double unaware = render_irradiance_at(&satin_options_default, x, x);
    print_message("%.2f, with a bright sample %.2f, and %.2f if it counts as any other\n", before,
                  after, unaware);
    assert_true(after < 0.75 * unaware);
}

static void pixels_with_records_stay(void **state) {
    (void)state;
    render_irradiance_image(one_wall, 1.0f);
    gathered[5 * SIDE + 5] = (struct image_gathered){.rays = 0.0f};
    assert_true(rgb_black(changed_by_filter(&satin_options_default, 5, 5)));
}

static void denoised_images_have_no_filter(void **state) {
    (void)state;
    satin_options o = satin_options_default;
    assert_true(render_irradiance_rays(&o) > 0.0f);
    o.denoise = true;
    assert_true(render_irradiance_rays(&o) == 0.0f);
    o = satin_options_default;
    o.irradiance_filter = false;
    assert_true(render_irradiance_rays(&o) == 0.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(neighbours_are_averaged),
                                       cmocka_unit_test(other_surfaces_are_not),
                                       cmocka_unit_test(many_rays_suffice),
                                       cmocka_unit_test(bright_samples_are_averaged_more),
                                       cmocka_unit_test(pixels_with_records_stay),
                                       cmocka_unit_test(denoised_images_have_no_filter)};
    return cmocka_run_group_tests(tests, render_irradiance_setup, render_irradiance_teardown);
}
