// SPDX-License-Identifier: Apache-2.0
// Lights that several tests are about, and a test of the density of their samples: chi-square over
// a grid of directions, and the density that evaluation reports.
#ifndef TEST_LIGHT_H
#define TEST_LIGHT_H

#include <math.h>
#include <stdio.h>

#include "base/sampling.h"
#include "test_scene.h"

static inline struct mat4 test_rotated(struct mat4 m, vec3 axis, float degrees) {
    struct mat4 r = mat4_rotate(axis, degrees);
    return mat4_mul(&m, &r);
}

static inline struct image test_noise_image(float *texel, int width, int height) {
    struct rng rng = rng_make(3, RNG_TEST, 3);
    for (int i = 0; i < width * height; i++)
        texel[3 * i] = texel[3 * i + 1] = texel[3 * i + 2] = powf(rng_float(&rng), 4.0f);
    for (int i = 0; i < 3; i++) texel[3 * (width + 2) + i] = 20.0f;       // a small sun
    for (int i = 0; i < 3 * width; i++) texel[3 * width * 3 + i] = 0.0f;  // a black line
    return scene_image_make(width, height, 3, texel);
}

static inline struct light test_environment(const struct image *image) {
    struct light light = {.kind = image ? LIGHT_ENVMAP : LIGHT_CONSTANT, .value = rgb_grey(0.5f)};
    light.image = image;
    light.to_world = mat4_rotate(v3(1, 2, -1), 40.0f);
    assert_true(mat4_inverse(&light.to_world, &light.to_local));
    return light;
}

// ---- Chi-square -------------------------------------------------------------------------------

enum { COLUMNS = 32, ROWS = 16, CELLS = COLUMNS * ROWS, FINE = 32 };

// Directions in a grid of equal solid angles around a frame.
static inline int test_light_cell(const struct frame *f, vec3 w) {
    vec3 l = frame_to_local(f, w);
    float around = atan2f(l.y, l.x) * (0.5f / PI_F);
    int column = (int)((around < 0.0f ? around + 1.0f : around) * COLUMNS);
    int row = (int)((l.z + 1.0f) * 0.5f * ROWS);
    return (row < ROWS ? row : ROWS - 1) * COLUMNS + (column < COLUMNS ? column : COLUMNS - 1);
}

// The density at p in direction w that MIS would use.
static inline float test_reported_density(const struct satin_scene *scene, uint32_t light, vec3 p,
                                          vec3 w) {
    enum light_kind kind = scene->light[light].kind;
    if (kind != LIGHT_AREA) return light_environment_pdf(scene, NULL, w);
    struct ray ray = {p, 0.0f, w, INFINITY};
    struct interaction s;
    if (!scene_intersect(scene, &ray, &s) || s.light != (int32_t)light) return 0.0f;
    return light_pdf(scene, p, w, &s);
}

// The upper tail of the chi-square distribution [Wilson and Hilferty 1931].
static inline double test_chi_square_tail(double chi2, double freedom) {
    double a = 2.0 / (9.0 * freedom), z = (cbrt(chi2 / freedom) - (1.0 - a)) / sqrt(a);
    return 0.5 * erfc(z / sqrt(2.0));
}

// The integral of the density over each cell, and the largest fraction of it that one of its FINE^2
// points has.
static inline void test_light_integrate(const struct satin_scene *scene, uint32_t light, vec3 p,
                                        const struct frame *f, double expected[CELLS],
                                        double most[CELLS]) {
    struct rng rng = rng_make(7, RNG_TEST, 1);
    for (int row = 0; row < ROWS * FINE; row++)
        for (int column = 0; column < COLUMNS * FINE; column++) {
            float z = 2.0f * ((float)row + rng_float(&rng)) / (ROWS * FINE) - 1.0f;
            float phi = 2.0f * PI_F * ((float)column + rng_float(&rng)) / (COLUMNS * FINE);
            float s = safe_sqrtf(1.0f - z * z);
            vec3 w = frame_to_world(f, v3(s * cosf(phi), s * sinf(phi), z));
            int cell = row / FINE * COLUMNS + column / FINE;
            double part =
                4.0 * M_PI / CELLS / (FINE * FINE) * test_reported_density(scene, light, p, w);
            expected[cell] += part;
            most[cell] = fmax(most[cell], part);
        }
}

// Fails if light_sample_wi and light_pdf disagree at p: a false alarm in 1 of 10^5 tests.
static inline void test_light_density(const struct test_scene *t, uint32_t light, vec3 p,
                                      const char *what) {
    enum { N = 40000 };
    const struct satin_scene *scene = &t->scene;
    struct frame f = frame_from_normal(v3_unit(v3(0.3f, -0.5f, 0.8f)));
    double expected[CELLS] = {0}, most[CELLS] = {0}, found[CELLS] = {0}, sum = 0.0;
    test_light_integrate(scene, light, p, &f, expected, most);
    struct rng rng = rng_make(8, RNG_TEST, 2);
    int wrong = 0;
    for (int i = 0; i < N; i++) {
        struct light_sample s;
        float u = rng_float(&rng), v = rng_float(&rng);
        if (!light_sample_wi(scene, light, p, u, v, &s)) continue;
        assert_true(fabsf(v3_len(s.wi) - 1.0f) < 1e-5f && s.pdf_w > 0.0f && !s.delta);
        float reported = test_reported_density(scene, light, p, s.wi);
        // Samples on an edge may miss it, and where a cylinder curves away the cosine is known to
        // few digits; all others must have the same density both times.
        wrong += !(fabsf(reported - s.pdf_w) <= 2e-3f * s.pdf_w);
        found[test_light_cell(&f, s.wi)] += 1.0;
    }
    if (wrong > N / 400) printf("%s: %d of %d densities differ\n", what, wrong, N);
    assert_true(wrong <= N / 400);
    double chi2 = 0.0, rest_e = 0.0, rest_f = 0.0, drawn = 0.0;
    int freedom = -1;
    for (int i = 0; i < CELLS; i++) {
        double e = expected[i] * N;
        sum += expected[i];
        drawn += found[i] / N;  // less than 1 where samples fall on a side that faces away
        if (e < 8.0) {
            rest_e += e;
            rest_f += found[i];
            continue;
        }
        // The samples' own variance, and that of the integral: an edge of the light that cuts the
        // cell passes by up to 2 FINE of its jittered points, each of which falls on either side by
        // chance.
        double integration = 0.25 * 2 * FINE * (most[i] * N) * (most[i] * N);
        chi2 += (found[i] - e) * (found[i] - e) / (e + integration);
        freedom++;
    }
    chi2 += (rest_f - rest_e) * (rest_f - rest_e) / (rest_e + 8.0);
    freedom++;
    double tail = freedom > 0 ? test_chi_square_tail(chi2, freedom) : 1.0;
    if (tail < 1e-5 || fabs(sum - drawn) > 0.02)
        printf("%s: chi2 %.1f, freedom %d, tail %g, integral %g\n", what, chi2, freedom, tail, sum);
    assert_true(tail >= 1e-5);
    assert_true(fabs(sum - drawn) <= 0.02);
}

// The deviation of the irradiance on a surface of normal n at p, by one sample of the only light,
// relative to its mean.
static inline float test_light_deviation(const struct test_scene *t, vec3 p, vec3 n) {
    enum { N = 4000 };
    struct rng rng = rng_make(3, RNG_TEST, 0);
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < N; i++) {
        struct light_sample s;
        const float u = rng_float(&rng), v = rng_float(&rng);
        if (!light_sample_wi(&t->scene, 0, p, u, v, &s)) continue;
        const double E = (double)(fmaxf(v3_dot(s.wi, n), 0.0f) / s.pdf_w);
        sum += E;
        squares += E * E;
    }
    const double mean = sum / N;
    return (float)(sqrt(squares / N - mean * mean) / mean);
}

#endif
