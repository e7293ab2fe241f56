// SPDX-License-Identifier: Apache-2.0
// Environments with a sun on top of the image; light.c has the rest.
#include <math.h>

#include "base/sampling.h"
#include "test_scene.h"

// A small sun is evaluated where it is sampled, and brings its radiance times its solid angle.
static void the_sun_is_a_disc(void **state) {
    (void)state;
    float texel[4 * 3 * 3] = {0};
    const struct image black = scene_image_make(4, 3, 3, texel);
    struct light light = {.kind = LIGHT_ENVMAP, .value = rgb_grey(1.0f), .image = &black};
    light.to_world = light.to_local = mat4_identity();
    light.sun = v3_unit(v3(0.3f, 0.2f, -0.8f));
    light.sun_value = rgb_grey(1e4f);
    light.sun_chord = 4.6e-3f;
    struct test_scene t;
    test_scene_init(&t);
    test_quadric(&t, SHAPE_SPHERE, mat4_identity(), false, test_diffuse(&t, 0.5f, 0.5f, 0.5f));
    test_light(&t, light);
    test_scene_finish(&t);
    double sum = 0.0;
    int seen = 0;
    for (int i = 0; i < 100; i++)
        for (int k = 0; k < 100; k++) {
            struct light_sample s;
            float u = ((float)i + 0.5f) * 0.01f, v = ((float)k + 0.5f) * 0.01f;
            if (!light_sample_wi(&t.scene, 0, v3(0, 0, 0), u, v, &s)) continue;
            sum += (double)(s.L.g / s.pdf_w) * 1e-4;
            seen += light_environment(&t.scene, s.wi).g == 1e4f;
        }
    double exact = 1e4 * M_PI * 4.6e-3 * 4.6e-3;
    assert_true(fabs(sum - exact) < 1e-3 * exact);
    assert_true(seen > 6900 && seen <= 7000);  // 7 of 10 samples; the rim is lost to rounding
    assert_true(rgb_black(light_environment(&t.scene, v3_unit(v3(0.3f, 0.21f, -0.8f)))));
    test_scene_free(&t);
}

// Beyond the last row with light all is black, and no sample goes there.
static void a_horizon_is_an_edge(void **state) {
    (void)state;
    float texel[4 * 5 * 3];
    for (int i = 0; i < 4 * 5 * 3; i++) texel[i] = 1.0f;
    const struct image white = scene_image_make(4, 5, 3, texel);
    struct light light = {.kind = LIGHT_ENVMAP, .value = rgb_grey(1.0f), .image = &white};
    light.to_world = light.to_local = mat4_identity();
    light.lit_rows = 2;  // of four: to the horizon
    struct test_scene t;
    test_scene_init(&t);
    test_quadric(&t, SHAPE_SPHERE, mat4_identity(), false, test_diffuse(&t, 0.5f, 0.5f, 0.5f));
    test_light(&t, light);
    test_scene_finish(&t);
    assert_true(light_environment(&t.scene, v3_unit(v3(1, 0.01f, 1))).g == 1.0f);
    assert_true(rgb_black(light_environment(&t.scene, v3_unit(v3(1, -0.01f, 1)))));
    double sum = 0.0;
    for (int i = 0; i < 100; i++)
        for (int k = 0; k < 100; k++) {
            struct light_sample s;
            const float u = ((float)i + 0.5f) * 0.01f, v = ((float)k + 0.5f) * 0.01f;
            assert_true(light_sample_wi(&t.scene, 0, v3(0, 0, 0), u, v, &s) && s.wi.y > -1e-6f);
            sum += (double)(s.L.g / s.pdf_w) * 1e-4;
        }
    assert_true(fabs(sum - 2.0 * M_PI) < 1e-3 * 2.0 * M_PI);
    test_scene_free(&t);
}

// A box of different sides.
static struct light_box light_environment_box(void) {
    return light_box_make(v3(-1.0f, -2.0f, -0.5f), v3(3.0f, 1.0f, 2.0f));
}

struct light_environment_bins {
    struct light_blocks blocks;
    struct light_histogram histogram;
};

static void build_environment_bins(const struct light_box *box,
                                   const float weight[LIGHT_HISTOGRAM_BINS], float fraction,
                                   struct light_environment_bins *out) {
    bool bin[LIGHT_HISTOGRAM_BINS];
    for (int i = 0; i < LIGHT_HISTOGRAM_BINS; i++) bin[i] = weight[i] > 0.0f;
    light_blocks_build(box, bin, &out->blocks);
    light_histogram_build(weight, fraction, &out->blocks, &out->histogram);
}

// The bin of a direction is that in which it was drawn, with its density, from points in the box,
// near its faces and beyond them.
static void directions_are_in_their_bins(void **state) {
    (void)state;
    const vec3 point[] = {v3(0, 0, 0), v3(2.99f, 0.5f, 1.0f), v3(5.0f, -3.0f, 1.0f)};
    const struct light_box box = light_environment_box();
    for (int k = 0; k < 3; k++)
        for (int bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++) {
            float drawn, found;
            const vec3 w = light_box_direction(&box, point[k], bin, 0.3f, 0.8f, &drawn);
            assert_true(fabsf(v3_len(w) - 1.0f) < 1e-6f);
            assert_int_equal(light_box_bin(&box, point[k], w, &found), bin);
            assert_true(fabsf(drawn - found) <= 1e-4f * drawn);
        }
}

static void bins_around_a_bin_are_on_its_face(void **state) {
    (void)state;
    enum { SIDE = LIGHT_HISTOGRAM_SIDE };
    int around[9];
    assert_int_equal(light_box_around(SIDE * SIDE, around), 4);
    assert_int_equal(around[0], SIDE * SIDE);
    assert_int_equal(light_box_around(SIDE * SIDE + 1, around), 6);
    assert_int_equal(light_box_around(2 * SIDE * SIDE - SIDE - 2, around), 9);
    assert_int_equal(around[0], 2 * SIDE * SIDE - 2 * SIDE - 3);
    assert_int_equal(around[8], 2 * SIDE * SIDE - 1);
}

// Behind a window that leaves most bins dark, the density that is reported is that of the samples,
// and the light of every octant of the sky has the right mean, from all points. Rounding moves the
// point of a face that is drawn by up to 4e-7 of its side, and so a sample in 4 * 32 * 4e-7 over an
// edge of its bin, where it is reported with another density.
static void histograms_do_not_change_the_mean(void **state) {
    (void)state;
    const vec3 point[] = {v3(0, 0, 0), v3(2.99f, 0.5f, 1.0f), v3(5.0f, -3.0f, 1.0f)};
    const struct light_box box = light_environment_box();
    struct test_scene t;
    test_scene_init(&t);
    test_quadric(&t, SHAPE_SPHERE, mat4_identity(), false, test_diffuse(&t, 0.5f, 0.5f, 0.5f));
    test_light(&t, (struct light){.kind = LIGHT_CONSTANT, .value = rgb_grey(2.0f)});
    test_scene_finish(&t);
    float weight[LIGHT_HISTOGRAM_BINS];
    struct light_environment_bins bins;
    for (int i = 0; i < LIGHT_HISTOGRAM_BINS; i++) weight[i] = i % 7 ? 0.0f : (float)(i % 5);
    build_environment_bins(&box, weight, 0.75f, &bins);
    enum { SAMPLES = 1 << 20, OCTANTS = 8 };
    for (int k = 0; k < 9; k++) {
        // With a normal of any direction, of none, and lit from behind.
        const vec3 n = k < 6 ? v3_unit(v3(0.3f, -0.5f, 1.0f)) : v3(0, 0, 0);
        const struct light_receiver at = {point[k % 3], n, k / 3 == 1};
        struct light_product product;
        light_product_make(&bins.histogram, &at, &product);
        const struct light_visibility visibility = {&product, NULL};
        double sum[OCTANTS] = {0};
        int moved = 0;
        for (uint32_t i = 0; i < SAMPLES; i++) {
            const vec2 u = sample_sobol2(i, 3);
            struct light_sample s;
            assert_true(light_sample_visible(&t.scene, 0, visibility, at.p, u.x, u.y, &s));
            const float reported = light_environment_pdf(&t.scene, &product, s.wi);
            moved += !(fabsf(reported - s.pdf_w) <= 1e-4f * reported);
            const int octant = (s.wi.x > 0.0f) + 2 * (s.wi.y > 0.0f) + 4 * (s.wi.z > 0.0f);
            sum[octant] += (double)(s.L.g / s.pdf_w) / SAMPLES;
        }
        assert_true(moved <= 4 * 32 * 4e-7 * SAMPLES);
        for (int i = 0; i < OCTANTS; i++) assert_true(fabs(sum[i] - M_PI) < 2e-3 * M_PI);
    }
    test_scene_free(&t);
}

// A window of 12 x 12 bins of a face, of which a half-plane at an angle is visible. The variance of
// the number of visible samples among 64 is .078 of that of independent samples; without products,
// when all bins of the window had as many samples, it was .070, and .087 when u alone drew the bin
// and its row, and v only the position within a column.
static void samples_of_bins_are_stratified(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    test_light(&t, (struct light){.kind = LIGHT_CONSTANT, .value = rgb_grey(1.0f)});
    test_scene_finish(&t);
    // The face at x = 1, whose rows are along y, one above the other along z.
    enum { FACE = 1, FIRST = 8, SIDE = 12, SAMPLES = 64, SEEDS = 1024 };
    const struct light_box box = light_box_make(v3(-1, -1, -1), v3(1, 1, 1));
    float weight[LIGHT_HISTOGRAM_BINS] = {0.0f};
    struct light_environment_bins bins;
    for (int i = 0; i < SIDE * SIDE; i++)
        weight[(FACE * LIGHT_HISTOGRAM_SIDE + FIRST + i / SIDE) * LIGHT_HISTOGRAM_SIDE + FIRST +
               i % SIDE] = 1.0f;
    build_environment_bins(&box, weight, 0.99f, &bins);
    struct light_product product;
    light_product_make(&bins.histogram, &(struct light_receiver){v3(0, 0, 0), v3(0, 0, 0), false},
                       &product);
    const struct light_visibility visibility = {&product, NULL};
    const float side = LIGHT_HISTOGRAM_SIDE, middle = FIRST + 0.5f * SIDE;
    double sum = 0.0, squares = 0.0;
    for (uint32_t seed = 0; seed < SEEDS; seed++) {
        int visible = 0;
        for (uint32_t i = 0; i < SAMPLES; i++) {
            const vec2 u = sample_sobol2(i, seed);
            struct light_sample s;
            // Only samples by bins.
            light_sample_visible(&t.scene, 0, visibility, v3(0, 0, 0), 0.99f * u.x, u.y, &s);
            const float y = side * (0.5f + 0.5f * s.wi.z / s.wi.x) - middle;
            const float x = side * (0.5f + 0.5f * s.wi.y / s.wi.x) - middle;
            visible += 0.4f * x + y > 0.0f;
        }
        sum += (double)visible / SEEDS;
        squares += (double)(visible * visible) / SEEDS;
    }
    const double ratio = (squares - sum * sum) / (sum * (1.0 - sum / SAMPLES));
    print_message("variance over that of independent samples: %.3f\n", ratio);
    assert_true(ratio < 0.082);
    test_scene_free(&t);
}

// A sample that is drawn first and read later is that of light_sample_visible, by bins, by radiance
// and in the sun, and panes between the two reduce its radiance.
static void samples_are_read_after_they_arrive(void **state) {
    (void)state;
    enum { WIDTH = 4, HEIGHT = 3, SAMPLES = 1 << 12 };
    float texel[WIDTH * HEIGHT * 3], weight[LIGHT_HISTOGRAM_BINS];
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++)
        texel[i] = i < 2 * WIDTH * 3 ? 0.0f : (float)(i % 5);
    const struct image image = scene_image_make(WIDTH, HEIGHT, 3, texel);
    struct light light = {.kind = LIGHT_ENVMAP, .value = rgb_grey(1.0f), .image = &image};
    light.to_world = light.to_local = mat4_identity();
    light.sun = v3_unit(v3(0.3f, 0.2f, -0.8f));
    light.sun_value = rgb_grey(1e2f);
    light.sun_chord = 0.1f;
    struct test_scene t;
    test_scene_init(&t);
    test_quadric(&t, SHAPE_SPHERE, mat4_identity(), false, test_diffuse(&t, 0.5f, 0.5f, 0.5f));
    test_light(&t, light);
    test_scene_finish(&t);
    for (int i = 0; i < LIGHT_HISTOGRAM_BINS; i++) weight[i] = (float)(i % 5);
    struct light_environment_bins bins;
    const struct light_box box = light_environment_box();
    build_environment_bins(&box, weight, 0.75f, &bins);
    struct light_product product;
    light_product_make(&bins.histogram, &(struct light_receiver){v3(0, 0, 0), v3(0, 1, 0), false},
                       &product);
    const struct light_visibility visibility = {&product, NULL};
    const rgb T = {0.5f, 0.25f, 0.125f};  // factors without rounding
    int unread = 0, black = 0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        const vec2 u = sample_sobol2(i, 3);
        struct light_sample s, whole;
        const bool lit =
            light_sample_visible(&t.scene, 0, visibility, v3(0, 0, 0), u.x, u.y, &whole);
        bool later = light_sample_draw(&t.scene, 0, visibility, v3(0, 0, 0), u.x, u.y, &s);
        if (later && s.unread) {
            unread++;
            assert_true(s.L.r == 1.0f && s.L.g == 1.0f && s.L.b == 1.0f);
        }
        s.L = rgb_mul(s.L, T);
        later = later && light_sample_read(&t.scene, visibility, &s);
        assert_int_equal(later, lit);
        black += !lit;
        if (!lit) continue;
        const rgb L = rgb_mul(whole.L, T);
        assert_true(s.L.r == L.r && s.L.g == L.g && s.L.b == L.b && s.pdf_w == whole.pdf_w);
        assert_true(v3_dist2(s.wi, whole.wi) == 0.0f);
    }
    assert_true(unread > SAMPLES / 2 && unread < SAMPLES && black > 0);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_sun_is_a_disc),
        cmocka_unit_test(a_horizon_is_an_edge),
        cmocka_unit_test(directions_are_in_their_bins),
        cmocka_unit_test(bins_around_a_bin_are_on_its_face),
        cmocka_unit_test(histograms_do_not_change_the_mean),
        cmocka_unit_test(samples_of_bins_are_stratified),
        cmocka_unit_test(samples_are_read_after_they_arrive),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
