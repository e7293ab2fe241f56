// SPDX-License-Identifier: Apache-2.0
// The filter of noise, on images whose light is known.
#include "render/render_image.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"

// More than one tile of the filter, and no multiple of it.
enum { WIDE = 90, HIGH = 70, PIXELS = WIDE * HIGH };

static struct image_pixel noise_pixels[PIXELS];
static struct image_noisy noisy_sums[PIXELS];
static struct image_change noise_change[PIXELS];
static struct render_image noise_image = {.width = WIDE,
                                          .height = HIGH,
                                          .pixel = noise_pixels,
                                          .noisy_light = noisy_sums,
                                          .change = noise_change};
static struct parallel *noise_pool;

// What a pixel shows: irradiance, of which samples have up to twice as much or none, normal, and
// distance if that is to count.
struct noisy_point {
    float E, noise;  // E: of green and blue; noise: in [0, 1]
    vec3 n;
    float red;  // irradiance of red over that of green
    float distance;
};
typedef struct noisy_point noise_scene_fn(int x, int y);

static rgb texture_of(int x, int y) {
    return rgb_make(0.2f + 0.6f * (float)((x + y) % 2), 0.5f, 0.1f + 0.1f * (float)(x % 5));
}

static void add_noisy_sample(int x, int y, uint32_t index, rgb E, vec3 n, float distance,
                             float weight) {
    const rgb albedo = texture_of(x, y), light = rgb_mul(albedo, E);
    // A third of the light is glossy.
    struct shade_sample s = {.weight = weight,
                             .uncached_glossy = rgb_scale(light, 1.0f / 3.0f),
                             .sampled_glossy = true,
                             .shown = {albedo, {n.x, n.y, n.z}, distance, 1.0f}};
    struct image_pixel *p = &noise_pixels[y * WIDE + x];
    s.layer[SHADE_DIRECT] = rgb_scale(light, 2.0f / 3.0f);
    p->layer[SHADE_DIRECT] = rgb_mad(p->layer[SHADE_DIRECT], s.layer[SHADE_DIRECT], weight);
    p->samples++;
    p->weight += weight;
    render_noise_add(&noisy_sums[y * WIDE + x], x + y + (int)index, &s);
}

static void fill_image(noise_scene_fn *at, uint32_t samples, float scale) {
    memset(noise_pixels, 0, sizeof noise_pixels);
    memset(noisy_sums, 0, sizeof noisy_sums);
    for (int y = 0; y < HIGH; y++)
        for (int x = 0; x < WIDE; x++)
            for (uint32_t k = 0; k < samples; k++) {
                const struct noisy_point s = at(x, y);
                struct rng rng = rng_make(5, RNG_TEST, (uint64_t)(y * WIDE + x) << 32 | k);
                const float E = scale * s.E * (1.0f + s.noise * (2.0f * rng_float(&rng) - 1.0f));
                add_noisy_sample(x, y, k, rgb_make(s.red * E, E, E), s.n, s.distance, 1.0f);
            }
}

// Green light over its albedo, before and after the filter.
static float light_before(int x, int y) {
    const size_t at = (size_t)(y * WIDE + x);
    const float sum = noise_pixels[at].layer[SHADE_DIRECT].g + noisy_sums[at].glossy.g;
    return sum / noise_pixels[at].weight / texture_of(x, y).g;
}

static float light_after(int x, int y) {
    const rgb *change = noise_change[y * WIDE + x].layer;
    const float sum = change[NOISY_DIRECT].g + change[NOISY_GLOSSY].g;
    return light_before(x, y) + sum / texture_of(x, y).g;
}

typedef float light_fn(int x, int y);

// The mean square of the difference from what is shown, and the mean of the difference.
static double mean_square(light_fn *light, noise_scene_fn *at, double scale, double *bias) {
    double squares = 0.0, sum = 0.0;
    for (int y = 0; y < HIGH; y++)
        for (int x = 0; x < WIDE; x++) {
            const double d = (double)light(x, y) / scale - (double)at(x, y).E;
            squares += d * d;
            sum += d;
        }
    *bias = sum / PIXELS;
    return squares / PIXELS;
}

static struct noisy_point even_light(int x, int y) {
    (void)x;
    (void)y;
    return (struct noisy_point){1.0f, 1.0f, {0, 0, 1}, 1.0f, 0.0f};
}

// Light on both sides of an edge that no normal shows.
static struct noisy_point shadow(int x, int y) {
    (void)y;
    return (struct noisy_point){x < 45 ? 1.0f : 0.1f, 1.0f, {0, 0, 1}, 1.0f, 0.0f};
}

static struct noisy_point folded(int x, int y) {
    (void)y;
    return x < 45 ? (struct noisy_point){1.0f, 1.0f, {0, 0, 1}, 1.0f, 0.0f}
                  : (struct noisy_point){0.6f, 1.0f, {1, 0, 0}, 1.0f, 0.0f};
}

// Posts of three pixels before a wall, of which few samples see the bright sky. They are as far
// away as the wall, or nearer.
static struct noisy_point post(int x, float distance) {
    return x % 15 < 3 ? (struct noisy_point){0.8f, 1.0f, {0, 0, 1}, 1.0f, distance}
                      : (struct noisy_point){0.5f, 0.3f, {0, 0, 1}, 1.0f, 8.0f + 0.1f * (float)x};
}
static struct noisy_point far_posts(int x, int y) {
    (void)y;
    return post(x, 8.0f + 0.1f * (float)x);
}
static struct noisy_point near_posts(int x, int y) {
    (void)y;
    return post(x, 6.0f);
}

// Two colours of equal luminance.
static struct noisy_point coloured(int x, int y) {
    (void)y;
    return x < 45 ? (struct noisy_point){1.0f, 0.2f, {0, 0, 1}, 1.0f, 0.0f}
                  : (struct noisy_point){0.8f, 0.2f, {0, 0, 1}, 2.175f, 0.0f};
}

static struct noisy_point quiet(int x, int y) {
    return (struct noisy_point){
        0.5f + 0.004f * (float)((x * 7 + y * 3) % 100), 0.0f, {0, 0, 1}, 1.0f, 0.0f};
}

// The noise of even_light light becomes much less, at any scale, whether a pixel has one sample or
// more.
static void test_even_light(void **state) {
    (void)state;
    static const float scales[] = {1e-9f, 1.0f, 1e9f};
    for (int i = 0; i < 3; i++)
        for (uint32_t samples = 1; samples <= 8; samples *= 2) {
            double bias, before, after;
            fill_image(even_light, samples, scales[i]);
            before = mean_square(light_before, even_light, (double)scales[i], &bias);
            assert_true(render_noise_change(&noise_image, noise_pool));
            after = mean_square(light_after, even_light, (double)scales[i], &bias);
            assert_true(after < 0.15 * before);
            assert_true(fabs(bias) < 0.01);
        }
}

// The mean square of the difference from what is shown in pixels of a grid, before and after.
static void grid_squares(noise_scene_fn *at, int stride, double *before, double *after) {
    *before = *after = 0.0;
    int count = 0;
    for (int y = 0; y < HIGH; y += stride)
        for (int x = 0; x < WIDE; x += stride, count++) {
            *before += pow((double)light_before(x, y) - (double)at(x, y).E, 2.0);
            *after += pow((double)light_after(x, y) - (double)at(x, y).E, 2.0);
        }
    *before /= count;
    *after /= count;
}

// Stripes of shadow.
static struct noisy_point striped(int x, int y) {
    (void)y;
    return (struct noisy_point){x / 8 % 2 ? 1.0f : 0.1f, 0.2f, {0, 0, 1}, 1.0f, 0.0f};
}

static void fill_coarse(noise_scene_fn *at, int stride) {
    fill_image(at, 1, 1.0f);
    for (int y = 0; y < HIGH; y++)
        for (int x = 0; x < WIDE; x++) {
            if (x % stride == 0 && y % stride == 0) continue;
            noise_pixels[y * WIDE + x] = (struct image_pixel){0};
            noisy_sums[y * WIDE + x] = (struct image_noisy){0};
        }
    noise_image.coarsest = stride;
    assert_true(render_noise_change(&noise_image, noise_pool));
    noise_image.coarsest = 0;
}

// So does that of an image of which every second or fourth pixel of each row and column has a
// sample, although the grid of these samples is that of a checkerboard's fields of one colour.
static void test_coarse_image(void **state) {
    (void)state;
    for (int stride = 2; stride <= 4; stride *= 2) {
        double before, after;
        fill_coarse(even_light, stride);
        grid_squares(even_light, stride, &before, &after);
        print_message("stride %d: error after %.3f of that before\n", stride, after / before);
        assert_true(after < 0.15 * before);
    }
    double before, after;
    fill_coarse(striped, 2);
    grid_squares(striped, 2, &before, &after);
    print_message("stripes: error after %.3f of that before\n", after / before);
    assert_true(after < 0.5 * before);
}

// Four samples show an edge between light and shadow: no noise of the one side is on the other one.
static void test_edges(void **state) {
    (void)state;
    noise_scene_fn *const edges[] = {shadow, folded, coloured};
    for (int i = 0; i < 3; i++) {
        double bias, before, after;
        fill_image(edges[i], 4, 1.0f);
        before = mean_square(light_before, edges[i], 1.0, &bias);
        assert_true(render_noise_change(&noise_image, noise_pool));
        after = mean_square(light_after, edges[i], 1.0, &bias);
        assert_true(after < 0.25 * before);
        assert_true(fabs(bias) < 0.01);
    }
}

// What posts lose to the wall behind them, as a fraction of their light.
static double lost_by_posts(noise_scene_fn *at) {
    double before = 0.0, after = 0.0;
    fill_image(at, 2, 1.0f);
    assert_true(render_noise_change(&noise_image, noise_pool));
    for (int y = 0; y < HIGH; y++)
        for (int x = 0; x < WIDE; x++) {
            if (x % 15 >= 3) continue;
            before += (double)light_before(x, y);
            after += (double)light_after(x, y);
        }
    return 1.0 - after / before;
}

static void test_thin_objects(void **state) {
    (void)state;
    const double lost = lost_by_posts(near_posts), if_far = lost_by_posts(far_posts);
    print_message("posts lose %.3f, at the distance of the wall %.3f\n", lost, if_far);
    assert_true(fabs(lost) < 0.02 && if_far > 0.05);
}

static void test_no_noise(void **state) {
    (void)state;
    fill_image(quiet, 2, 1.0f);
    assert_true(render_noise_change(&noise_image, noise_pool));
    for (int y = 0; y < HIGH; y++)
        for (int x = 0; x < WIDE; x++)
            assert_true(fabsf(light_after(x, y) - quiet(x, y).E) < 1e-5f);
}

// The light of a bright sample stays in the image: it is spread over pixels around, and fades from
// it on.
static void test_bright_sample(void **state) {
    (void)state;
    for (uint32_t k = 0; k < 2; k++) {
        double before = 0.0, after = 0.0;
        fill_image(even_light, 2, 1.0f);
        assert_true(render_noise_change(&noise_image, noise_pool));
        const float beside = light_after(41, 31), last = light_after(44, 34);
        fill_image(even_light, 2, 1.0f);
        add_noisy_sample(40, 30, k, rgb_grey(200.0f), v3(0, 0, 1), 0.0f, 1.0f);
        const float bright = light_before(40, 30);
        assert_true(render_noise_change(&noise_image, noise_pool));
        for (int y = 0; y < HIGH; y++)
            for (int x = 0; x < WIDE; x++) {
                before += (double)light_before(x, y);
                after += (double)light_after(x, y);
            }
        assert_true(light_after(40, 30) < 0.2f * bright);
        const float there = light_after(41, 31) - beside;
        assert_true(there > 0.5f && light_after(44, 34) - last < 0.3f * there);
        assert_true(fabs(after / before - 1.0) < 0.01);
    }
}

static bool change_finite(size_t at) {
    const rgb *change = noise_change[at].layer;
    return rgb_finite(change[NOISY_DIRECT]) && rgb_finite(change[NOISY_GLOSSY]);
}

static void clear_pixel(size_t at) {
    noise_pixels[at] = (struct image_pixel){0};
    noisy_sums[at] = (struct image_noisy){0};
}

// A pixel without samples, or with light that no float can hold, keeps what it has, and so do those
// around it.
static void test_unusable_pixels(void **state) {
    (void)state;
    fill_image(even_light, 2, 1.0f);
    clear_pixel(30 * WIDE + 40);
    noise_pixels[50 * WIDE + 60].layer[SHADE_DIRECT] = rgb_grey(INFINITY);
    add_noisy_sample(20, 20, 0, rgb_grey(1.0f), v3(0, 0, 1), 0.0f,
                     -1.5f);  // a filter's negative lobe
    assert_true(render_noise_change(&noise_image, noise_pool));
    for (size_t i = 0; i < PIXELS; i++) assert_true(change_finite(i));
    assert_true(rgb_black(noise_change[30 * WIDE + 40].layer[NOISY_DIRECT]));
    assert_true(rgb_black(noise_change[50 * WIDE + 60].layer[NOISY_DIRECT]));
}

// As where a time limit ends among the first samples: in the last rows one pixel of four has one.
static void test_incomplete_image(void **state) {
    (void)state;
    enum { WHOLE = 40 };
    double before[2] = {0.0, 0.0}, after[2] = {0.0, 0.0};
    fill_image(even_light, 1, 1.0f);
    for (int y = WHOLE; y < HIGH; y++)
        for (int x = 0; x < WIDE; x++)
            if (x % 2 || y % 2) clear_pixel((size_t)(y * WIDE + x));
    assert_true(render_noise_change(&noise_image, noise_pool));
    for (int y = 0; y < HIGH; y++)
        for (int x = 0; x < WIDE; x++) {
            if (!noise_pixels[y * WIDE + x].samples) continue;
            before[y >= WHOLE] += pow((double)light_before(x, y) - 1.0, 2.0);
            after[y >= WHOLE] += pow((double)light_after(x, y) - 1.0, 2.0);
        }
    print_message("error after %.3f of that before, beside pixels without samples %.3f\n",
                  after[0] / before[0], after[1] / before[1]);
    assert_true(after[0] < 0.15 * before[0] && after[1] <= before[1]);
}

// Pixels at the border, of images narrower than a patch too.
static void test_small_images(void **state) {
    (void)state;
    static const int sides[][2] = {{1, 1}, {1, 9}, {9, 1}, {64, 1}, {65, 3}};
    fill_image(even_light, 2, 1.0f);
    struct render_image small = noise_image;
    for (int i = 0; i < 5; i++) {
        small.width = sides[i][0];
        small.height = sides[i][1];
        assert_true(render_noise_change(&small, noise_pool));
        for (int at = 0; at < small.width * small.height; at++)
            assert_true(change_finite((size_t)at));
    }
}

static void test_threads(void **state) {
    (void)state;
    static struct image_change first[PIXELS];
    fill_image(shadow, 3, 1.0f);
    assert_true(render_noise_change(&noise_image, noise_pool));
    memcpy(first, noise_change, sizeof first);
    struct parallel *alone = parallel_new(1);
    assert_non_null(alone);
    assert_true(render_noise_change(&noise_image, alone));
    parallel_free(alone);
    assert_memory_equal(first, noise_change, sizeof first);
}

static int noise_setup(void **state) {
    (void)state;
    noise_pool = parallel_new(3);
    return noise_pool ? 0 : -1;
}

static int noise_teardown(void **state) {
    (void)state;
    parallel_free(noise_pool);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_coarse_image),  cmocka_unit_test(test_even_light),
        cmocka_unit_test(test_edges),         cmocka_unit_test(test_no_noise),
        cmocka_unit_test(test_bright_sample), cmocka_unit_test(test_unusable_pixels),
        cmocka_unit_test(test_small_images),  cmocka_unit_test(test_threads),
        cmocka_unit_test(test_thin_objects),  cmocka_unit_test(test_incomplete_image),
    };
    return cmocka_run_group_tests(tests, noise_setup, noise_teardown);
}
