// SPDX-License-Identifier: Apache-2.0
// Adaptive sampling of an image whose noise is known: where the samples go, how many, and that the
// error falls.
#include "render/render_adaptive_sampling.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/rng.h"

enum { SIZE = 64, EQUAL = 4, ALL = 16 };

// The image is 1 with noise that is ten times as strong right of the middle.
static float render_adaptive_sampling_noise_of(int x) { return x < SIZE / 2 ? 0.05f : 0.5f; }

static struct shade_sample render_adaptive_sampling_of(float value) {
    return (struct shade_sample){.beauty = rgb_grey(value)};
}

static void render_adaptive_sampling_take(struct adaptive_sampling *adapt, uint64_t seed) {
    for (int i = 0; i < SIZE * SIZE; i++) {
        struct adaptive_pixel *p = &adapt->pixel[i];
        while (p->count < p->target) {
            struct rng rng = rng_make(seed, RNG_TEST, (uint64_t)i << 32 | p->count);
            float e = render_adaptive_sampling_noise_of(i % SIZE) * (rng_float(&rng) - 0.5f);
            const struct shade_sample s = render_adaptive_sampling_of(1.0f + e);
            render_adaptive_add(p, &s);
        }
    }
    render_adaptive_compare(adapt);
}

// Renders with ALL samples per pixel on average; returns how many were taken.
static uint64_t render_adaptive_sampling_render(struct adaptive_sampling *adapt, uint64_t seed) {
    assert_true(render_adaptive_make(adapt, SIZE, SIZE, 4, 1));
    for (uint32_t n = 1; n <= EQUAL; n *= 2) {
        render_adaptive_equal(adapt, 1, n);
        render_adaptive_sampling_take(adapt, seed);
    }
    uint64_t taken = (uint64_t)EQUAL * SIZE * SIZE, all = (uint64_t)ALL * SIZE * SIZE;
    while (taken < all) {
        uint64_t want = taken < all - taken ? taken : all - taken;
        render_adaptive_distribute(adapt, want);
        taken += want;
        render_adaptive_sampling_take(adapt, seed);
    }
    return taken;
}

static double mean_count(const struct adaptive_sampling *adapt, int from, int to) {
    double sum = 0.0;
    for (int y = 0; y < SIZE; y++)
        for (int x = from; x < to; x++) sum += adapt->pixel[y * SIZE + x].count;
    return sum / (SIZE * (to - from));
}

static double error2(const struct adaptive_sampling *adapt) {
    double sum = 0.0;
    for (int i = 0; i < SIZE * SIZE; i++) {
        const struct adaptive_pixel *p = &adapt->pixel[i];
        double e = (double)p->sum.r / p->count - 1.0;
        sum += e * e;
    }
    return sum / (SIZE * SIZE);
}

static void samples_go_to_the_noise(void **state) {
    (void)state;
    struct adaptive_sampling adapt;
    uint64_t taken = render_adaptive_sampling_render(&adapt, 1);
    assert_int_equal(taken, ALL * SIZE * SIZE);
    uint64_t counted = 0;
    for (int i = 0; i < SIZE * SIZE; i++) {
        assert_true(adapt.pixel[i].count >= EQUAL);
        counted += adapt.pixel[i].count;
    }
    assert_true(counted == taken);
    // 100 times the variance needs 100^(1 / 2.5) = 6.3 times the samples.
    double quiet = mean_count(&adapt, 0, SIZE / 2 - 4),
           loud = mean_count(&adapt, SIZE / 2 + 4, SIZE);
    assert_true(loud > 4.0 * quiet && loud < 9.0 * quiet);
    // Noise of variance 0.5^2 / 12 over half of the image.
    assert_true(error2(&adapt) < 0.7 * 0.5 * (0.25 / 12.0) / ALL);
    render_adaptive_destroy(&adapt);
}

static void the_mean_is_kept(void **state) {
    (void)state;
    double sum = 0.0;
    enum { RUNS = 20 };
    for (uint64_t seed = 0; seed < RUNS; seed++) {
        struct adaptive_sampling adapt;
        render_adaptive_sampling_render(&adapt, 100 + seed);
        for (int i = 0; i < SIZE * SIZE; i++)
            sum += (double)adapt.pixel[i].sum.r / adapt.pixel[i].count;
        render_adaptive_destroy(&adapt);
    }
    double mean = sum / (RUNS * SIZE * SIZE);
    // Standard error: 0.5 / sqrt(12 * 2 * 16 * 20 * 64^2) = 9e-5 at most; five of them.
    assert_true(mean > 1.0 - 4.5e-4 && mean < 1.0 + 4.5e-4);
}

// An image whose halves agree everywhere but for one pixel by `difference`.
static void make_quiet(struct adaptive_sampling *adapt, float difference) {
    assert_true(render_adaptive_make(adapt, SIZE, SIZE, 4, 1));
    const struct shade_sample two = render_adaptive_sampling_of(2.0f);
    for (uint32_t n = 1; n <= 2; n++) {
        render_adaptive_equal(adapt, 1, n);
        for (int i = 0; i < SIZE * SIZE; i++) render_adaptive_add(&adapt->pixel[i], &two);
        if (n == 2) adapt->pixel[SIZE * SIZE / 2].sum.r += difference;
        render_adaptive_compare(adapt);
    }
}

static uint64_t count_targets(const struct adaptive_sampling *adapt) {
    uint64_t sum = 0;
    for (int i = 0; i < SIZE * SIZE; i++) sum += adapt->pixel[i].target;
    return sum;
}

// Whether nothing is noisy, or one pixel by very little, the samples are those of the options,
// and no pixel gets the largest growth because another needs almost none.
static void the_number_of_samples_is_kept(void **state) {
    (void)state;
    static const float difference[] = {0.0f, 1e-18f, 1e-3f, 1.0f, 1e18f, 3e38f, INFINITY};
    for (size_t d = 0; d < sizeof difference / sizeof *difference; d++)
        for (uint64_t want = 1; want < 10 * SIZE * SIZE; want = 3 * want + 1) {
            struct adaptive_sampling adapt;
            make_quiet(&adapt, difference[d]);
            render_adaptive_distribute(&adapt, want);
            assert_int_equal(count_targets(&adapt), 2 * SIZE * SIZE + want);
            render_adaptive_destroy(&adapt);
        }
}

// One pixel is noisy. The more samples it has, the larger is the factor by which their number
// grows, within limits; samples that are left over go to all pixels.
static void growth_follows_the_number_of_samples(void **state) {
    (void)state;
    static const uint32_t count[] = {2, 16, 64}, growth[] = {4, 8, 16};
    for (int k = 0; k < 3; k++) {
        struct adaptive_sampling adapt;
        make_quiet(&adapt, 0.0f);
        for (int i = 0; i < SIZE * SIZE; i++) adapt.pixel[i].count = count[k];
        const struct adaptive_pixel *noisy = &adapt.pixel[SIZE * SIZE / 2 + SIZE / 2];
        adapt.pixel[noisy - adapt.pixel].variance = 1.0f;
        render_adaptive_distribute(&adapt, (uint64_t)SIZE * SIZE * count[k]);
        assert_in_range(noisy->target, growth[k] * count[k], (growth[k] + 1) * count[k] + 2);
        render_adaptive_destroy(&adapt);
    }
}

// The wanted counts lie far more than 2^24 apart, in a strip of little noise beside one of much
// noise.
static void faint_noise_does_not_hide_strong_noise(void **state) {
    (void)state;
    struct adaptive_sampling adapt;
    make_quiet(&adapt, 0.0f);
    for (int i = 0; i < SIZE * SIZE; i++)
        adapt.pixel[i].variance = i % SIZE < SIZE / 2 ? 1e-30f : 1e-2f * (float)(1 + i / SIZE);
    const uint64_t want = SIZE * SIZE;
    render_adaptive_distribute(&adapt, want);
    assert_int_equal(count_targets(&adapt), 3 * SIZE * SIZE);
    uint64_t quiet = 0;
    for (int i = 0; i < SIZE * SIZE; i++)
        if (i % SIZE < SIZE / 2 - 4) quiet += adapt.pixel[i].target - 2;
    assert_int_equal(quiet, 0);
    render_adaptive_destroy(&adapt);
}

// Light samples where direct light is noisy, in the number that costs least: on the left the noise
// is of lights alone, on the right of the rest as well, and none of lights in the last quarter,
// where two show the variance of lights if there is any. BRDF samples likewise, in the lower half.
static void light_samples_go_where_lights_are_noisy(void **state) {
    (void)state;
    enum { LIGHTS = 4, SAMPLES = 4096 };
    struct adaptive_sampling adapt;
    assert_true(render_adaptive_make(&adapt, SIZE, SIZE, LIGHTS, 1));
    for (int i = 0; i < SIZE * SIZE; i++) {
        struct rng rng = rng_make(3, RNG_TEST, (uint64_t)i);
        const int quarter = i % SIZE / (SIZE / 4);
        const float light = quarter == 3 ? 0.0f : 0.5f, rest = quarter == 0 ? 0.0f : 0.1f;
        const float lobe = i / SIZE < SIZE / 2 ? 0.0f : light;
        for (int k = 0; k < SAMPLES; k++) {
            // Uniform over a width of a has the variance a^2 / 12.
            const float e = light / sqrtf(LIGHTS) * (rng_float(&rng) - 0.5f) +
                            lobe / sqrtf(LIGHTS) * (rng_float(&rng) - 0.5f) +
                            rest * (rng_float(&rng) - 0.5f);
            struct shade_sample s = render_adaptive_sampling_of(1.0f + e);
            s.light_variance = light * light / 12.0f;
            s.lobe_variance = lobe * lobe / 12.0f;
            render_adaptive_add(&adapt.pixel[i], &s);
        }
    }
    assert_true(render_adaptive_light_samples(&adapt) == LIGHTS);
    const float cost = 8.0f;
    render_adaptive_counts(&adapt, cost, false);
    // m^2.5 = 3 * 8 * (.5 / .1)^2: 12.9, rounded down. The blur mixes quarters at their borders.
    for (int y = 0; y < SIZE; y++) {
        const struct adaptive_pixel *row = adapt.pixel + y * SIZE;
        for (int x = 2; x < SIZE / 4 - 2; x++) assert_true(row[x].light.next >= 15);
        for (int x = SIZE / 4 + 2; x < 3 * SIZE / 4 - 2; x++)
            assert_true(row[x].light.next >= 10 && row[x].light.next <= 15);
        for (int x = 3 * SIZE / 4 + 2; x < SIZE; x++) assert_true(row[x].light.next == 2);
        for (int x = 0; x < SIZE && y < SIZE / 2 - 2; x++) assert_true(row[x].lobe.next == 2);
        for (int x = 0; x < SIZE && y >= SIZE / 2 + 2; x++)
            assert_true(row[x].lobe.next == row[x].light.next);
    }
    render_adaptive_destroy(&adapt);
}

// Adds samples of two gather rays, or of one, of this standard deviation each.
static void add_gathers_of(struct adaptive_pixel *pixel, float deviation, uint64_t stream) {
    struct rng rng = rng_make(5, RNG_TEST, stream);
    const uint32_t rays = pixel->gather.next;
    for (int k = 0; k < 4096; k++) {
        const float width = deviation * sqrtf(12.0f / (float)rays);
        const float e = width * (rng_float(&rng) - 0.5f) + 0.1f * (rng_float(&rng) - 0.5f);
        struct shade_sample s = render_adaptive_sampling_of(1.0f + e);
        s.gathers = deviation > 0.0f;
        s.gather_variance = rays > 1 ? deviation * deviation : 0.0f;
        render_adaptive_add(pixel, &s);
    }
}

// The number of gather rays in the next sample of a pixel whose rays have this deviation.
static uint32_t next_gathers(float deviation, int rays, float cost, bool gathers) {
    struct adaptive_sampling adapt;
    assert_true(render_adaptive_make(&adapt, 8, 8, 1, rays));
    for (uint64_t i = 0; i < 64; i++) add_gathers_of(&adapt.pixel[i], deviation, i);
    render_adaptive_counts(&adapt, cost, gathers);
    const uint32_t next = adapt.pixel[27].gather.next;
    render_adaptive_destroy(&adapt);
    return next;
}

// (v / w * cost / 6)^.4, rounded, where w is the variance of the rest, 1 / 1200: more rays where
// they are noisier or the rest of a sample costs more, at most eight.
static void gather_rays_follow_their_noise_and_cost(void **state) {
    (void)state;
    assert_int_equal(next_gathers(0.1f, 2, 6.0f, true), 3);   // 12^.4 = 2.7
    assert_int_equal(next_gathers(0.1f, 2, 24.0f, true), 5);  // 48^.4 = 4.7
    assert_int_equal(next_gathers(1.0f, 2, 6.0f, true), 8);   // 17, but at most 8
    assert_int_equal(next_gathers(0.02f, 2, 6.0f, true), 1);  // .74
    assert_int_equal(next_gathers(0.02f, 8, 6.0f, true), 1);
    assert_int_equal(next_gathers(0.1f, 1, 24.0f, true), 1);   // of one ray nothing is known
    assert_int_equal(next_gathers(0.0f, 2, 24.0f, true), 2);   // nor where no sample gathers
    assert_int_equal(next_gathers(0.1f, 8, 24.0f, false), 8);  // they are not asked for
}

// The fraction of the pixels with two samples, in every 11x7 block of an image of 33x21 to 3 of 77.
static void check_spread(struct adaptive_sampling *adapt, double fraction) {
    render_adaptive_some(adapt, fraction, 2);
    for (int block = 0; block < 9; block++) {
        int two = 0;
        for (int i = 0; i < 77; i++) {
            const int x = block % 3 * 11 + i % 11, y = block / 3 * 7 + i / 11;
            two += adapt->pixel[y * 33 + x].target == 2;
        }
        assert_true(fabs(two - 77.0 * fraction) < 3.0);
    }
}

// Every pixel of a grid and no other is asked for a sample, by one thread and by three.
static void first_samples_are_on_a_grid(void **state) {
    (void)state;
    for (int threads = 1; threads <= 3; threads += 2) {
        struct adaptive_sampling adapt;
        assert_true(render_adaptive_make(&adapt, 33, 21, 1, 1));
        adapt.pool = threads > 1 ? parallel_new(threads) : NULL;
        for (int stride = 8; stride > 0; stride /= 2) {
            render_adaptive_equal(&adapt, stride, 1);
            for (int i = 0; i < 33 * 21; i++)
                assert_int_equal(adapt.pixel[i].target,
                                 i % 33 % stride == 0 && i / 33 % stride == 0);
        }
        render_adaptive_some(&adapt, 0.0, 2);
        check_spread(&adapt, 0.3);
        check_spread(&adapt, 0.7);
        render_adaptive_some(&adapt, 1.0, 1);
        check_spread(&adapt, 0.7);
        render_adaptive_equal(&adapt, 4, 3);
        assert_int_equal(adapt.pixel[4 * 33 + 32].target, 3);
        render_adaptive_equal(&adapt, 1, 2);
        assert_int_equal(adapt.pixel[4 * 33 + 32].target, 3);
        assert_int_equal(adapt.pixel[20 * 33 + 31].target, 2);
        parallel_free(adapt.pool);
        render_adaptive_destroy(&adapt);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(samples_go_to_the_noise),
                                       cmocka_unit_test(first_samples_are_on_a_grid),
                                       cmocka_unit_test(the_mean_is_kept),
                                       cmocka_unit_test(the_number_of_samples_is_kept),
                                       cmocka_unit_test(growth_follows_the_number_of_samples),
                                       cmocka_unit_test(faint_noise_does_not_hide_strong_noise),
                                       cmocka_unit_test(light_samples_go_where_lights_are_noisy),
                                       cmocka_unit_test(gather_rays_follow_their_noise_and_cost)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
