// SPDX-License-Identifier: Apache-2.0
// The statistic of blocks.h on synthetic images: noise of several kinds is not flagged; a dark disc
// in one of ten images is flagged at any position, in that image alone.
#include "blocks.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/rng.h"

enum { SIZE = 64, SEEDS = 10, BLOCKS = (SIZE / BLOCK_SIZE) * (SIZE / BLOCK_SIZE), TRIALS = 200 };
static const double threshold = 6.0;

static float blocks_test_image[SEEDS][SIZE * SIZE];

// Brightness falls by a factor of ten across the image; noise is of pixels, with a tail (the square
// of an exponential), and of discs as records make them, 5 % strong.
static void make_noise(uint64_t trial) {
    for (int s = 0; s < SEEDS; s++) {
        struct rng rng = rng_make(trial, RNG_TEST, (uint64_t)s);
        float patch[SIZE * SIZE] = {0};
        for (int k = 0; k < 20; k++) {
            const float x = SIZE * rng_float(&rng), y = SIZE * rng_float(&rng);
            const float strength = 0.1f * (rng_float(&rng) - 0.5f);
            for (int p = 0; p < SIZE * SIZE; p++) {
                const float dx = (float)(p % SIZE) - x, dy = (float)(p / SIZE) - y;
                if (dx * dx + dy * dy < 64.0f) patch[p] += strength;
            }
        }
        for (int p = 0; p < SIZE * SIZE; p++) {
            const float brightness = powf(10.0f, -(float)(p % SIZE) / SIZE);
            const float e = logf(fmaxf(1.0f - rng_float(&rng), 1e-7f));
            blocks_test_image[s][p] = brightness * (1.0f + patch[p] + 0.1f * e * e);
        }
    }
}

static void score(struct block_scores *out) {
    const float *pixel[SEEDS];
    for (int s = 0; s < SEEDS; s++) pixel[s] = blocks_test_image[s];
    const struct block_stack stack = {SIZE, SIZE, SEEDS, pixel, NULL};
    assert_true(block_scores_make(&stack, out));
    assert_int_equal(out->count, BLOCKS);
}

// The number of flagged blocks of an image.
static int blocks_test_flagged(const struct block_scores *scores, int seed) {
    int count = 0;
    for (int b = 0; b < BLOCKS; b++) count += fabs(scores->score[seed * BLOCKS + b]) > threshold;
    return count;
}

// 128,000 blocks.
static void noise_is_not_flagged(void **state) {
    (void)state;
    for (int trial = 0; trial < TRIALS; trial++) {
        struct block_scores scores;
        make_noise((uint64_t)trial);
        score(&scores);
        for (int s = 0; s < SEEDS; s++) assert_int_equal(blocks_test_flagged(&scores, s), 0);
        block_scores_free(&scores);
    }
}

// Discs of a radius of seven pixels, anywhere: no 8x8 block need be inside.
static void dark_discs_are_found(void **state) {
    (void)state;
    for (int trial = 0; trial < TRIALS; trial++) {
        struct block_scores scores;
        struct rng rng = rng_make((uint64_t)trial, RNG_TEST, SEEDS);
        const float x = 8.0f + 48.0f * rng_float(&rng), y = 8.0f + 48.0f * rng_float(&rng);
        const int bad = trial % SEEDS;
        make_noise((uint64_t)trial);
        for (int p = 0; p < SIZE * SIZE; p++)
            if (hypotf((float)(p % SIZE) - x, (float)(p / SIZE) - y) < 7.0f)
                blocks_test_image[bad][p] = 0.0f;
        score(&scores);
        for (int s = 0; s < SEEDS; s++)
            assert_true(s == bad ? blocks_test_flagged(&scores, s) > 0
                                 : blocks_test_flagged(&scores, s) == 0);
        block_scores_free(&scores);
    }
}

// A small glossy object: nine pixels of a block have noise, the square of an exponential, on a
// black ground, beside blocks without any. In most seeds the trimmed mean has none of it, so that
// scores by the spread over the seeds alone exceed the threshold in 100 of 2,000 images; with the
// scale by pixels it is one.
static void few_noisy_pixels_are_noise(void **state) {
    (void)state;
    int flags = 0;
    for (int trial = 0; trial < TRIALS; trial++) {
        struct block_scores scores;
        make_noise((uint64_t)trial);
        for (int s = 0; s < SEEDS; s++) {
            struct rng rng = rng_make((uint64_t)trial, RNG_TEST, (uint64_t)(100 + s));
            for (int p = 0; p < SIZE * SIZE; p++) {
                const bool glossy = p % SIZE / 3 == 9 && p / SIZE / 3 == 9;
                const float e = logf(fmaxf(1.0f - rng_float(&rng), 1e-7f));
                blocks_test_image[s][p] = glossy ? e * e : 0.01f;
            }
        }
        score(&scores);
        for (int s = 0; s < SEEDS; s++) flags += blocks_test_flagged(&scores, s);
        block_scores_free(&scores);
    }
    assert_in_range(flags, 0, 1);
}

// No more bright pixels than the mean of a block leaves out.
static void bright_pixels_are_noise(void **state) {
    (void)state;
    struct block_scores scores;
    make_noise(0);
    for (int i = 0; i < BLOCK_TRIM; i++) blocks_test_image[3][20 * SIZE + 20 + i] = 1e6f;
    score(&scores);
    assert_int_equal(blocks_test_flagged(&scores, 3), 0);
    block_scores_free(&scores);
}

// Images that are all equal, black ones too, have no noise and no flag.
static void same_pictures_have_no_flag(void **state) {
    (void)state;
    for (int value = 0; value < 2; value++) {
        struct block_scores scores;
        for (int s = 0; s < SEEDS; s++)
            for (int p = 0; p < SIZE * SIZE; p++) blocks_test_image[s][p] = (float)value;
        score(&scores);
        for (int s = 0; s < SEEDS; s++) assert_int_equal(blocks_test_flagged(&scores, s), 0);
        block_scores_free(&scores);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_is_not_flagged),       cmocka_unit_test(dark_discs_are_found),
        cmocka_unit_test(few_noisy_pixels_are_noise), cmocka_unit_test(bright_pixels_are_noise),
        cmocka_unit_test(same_pictures_have_no_flag),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
