// SPDX-License-Identifier: Apache-2.0
// Smoothing lowers the noise of irradiance records and keeps their mean, slopes and steps that
// exceed the noise. Outliers are distributed without smoothing.
#include "fill_case.h"

// A floor, and a light that nothing depends on: the test sets the values of the records.
static void smooth_case_make(struct fill_case *c) {
    fill_case_begin(c);
    c->options.irradiance_rays = 16;
    test_rectangle(&c->scene, mat4_identity(), test_diffuse(&c->scene, 0.5f, 0.5f, 0.5f));
    const struct fill_site site = {.pixel = 0.01f, .kinds = 1u << CACHE_IRRADIANCE};
    fill_case_finish(c, 0, 2, v3(0, 0, 0), v3(0.9f, 0, 0), v3(0, 0.9f, 0), site);
    // Records of one radius on a grid, so that eight of them and more are near each other.
    for (int i = 0; i < FILL_CASE_SITES; i++) {
        const struct cache_head head = {.p = c->site[i].p,
                                        .R = 0.2f,
                                        .n = v3(0, 0, 1),
                                        .search_radius = 0.2f,
                                        .scale = 1.0f,
                                        .u = v3(1, 0, 0)};
        const struct cache_irradiance_record record = {.value = {.rays = 16}, .radius_ratio = 1.0f};
        assert_true(cache_insert_irradiance(c->cache, &head, &record));
    }
}

static struct cache_irradiance_record *smooth_case_record(struct fill_case *c, int i) {
    return &c->cache->store[CACHE_IRRADIANCE].irradiance[i];
}

// Sets E = 1 + slope x, and noise of this deviation, which the records know of.
static void smooth_case_set(struct fill_case *c, float slope, float noise) {
    struct rng rng = rng_make(1, RNG_TEST, 0);
    for (int i = 0; i < FILL_CASE_SITES; i++) {
        struct cache_irradiance_record *r = smooth_case_record(c, i);
        const float random = sqrtf(3.0f) * (2.0f * rng_float(&rng) - 1.0f);
        r->value.E = rgb_grey(1.0f + slope * c->site[i].p.x + noise * random);
        r->deviation = noise / r->value.E.g;
        for (int k = 0; k < 3; k++) r->value.grad_t[k] = v3(slope, 0, 0);
    }
}

// The mean error and its deviation.
static void smooth_case_error(struct fill_case *c, float slope, double *mean, double *deviation) {
    double sum = 0.0, square = 0.0;
    for (int i = 0; i < FILL_CASE_SITES; i++) {
        const double error =
            (double)(smooth_case_record(c, i)->value.E.g - 1.0f - slope * c->site[i].p.x);
        sum += error;
        square += error * error;
    }
    *mean = sum / FILL_CASE_SITES;
    *deviation = sqrt(square / FILL_CASE_SITES);
}

static void noise_falls_and_the_mean_stays(void **state) {
    (void)state;
    struct fill_case c;
    smooth_case_make(&c);
    for (int slope = 0; slope < 2; slope++) {
        double mean[2], deviation[2];
        smooth_case_set(&c, 0.5f * (float)slope, 0.1f);
        smooth_case_error(&c, 0.5f * (float)slope, &mean[0], &deviation[0]);
        assert_int_equal(fill_smooth(c.fill, 0.5f), SATIN_OK);
        smooth_case_error(&c, 0.5f * (float)slope, &mean[1], &deviation[1]);
        assert_true(deviation[1] < 0.5 * deviation[0]);
        assert_true(fabs(mean[1] - mean[0]) < 0.004);
    }
    fill_case_free(&c);
}

// Without noise, nothing is averaged with what is different.
static void steps_stay(void **state) {
    (void)state;
    struct fill_case c;
    smooth_case_make(&c);
    smooth_case_set(&c, 0.0f, 0.0f);
    for (int i = 0; i < FILL_CASE_SITES; i++) {
        struct cache_irradiance_record *r = smooth_case_record(&c, i);
        if (c.site[i].p.x > 0.0f) r->value.E = rgb_grey(2.0f);
        r->deviation = 0.02f;
    }
    assert_int_equal(fill_smooth(c.fill, 0.5f), SATIN_OK);
    for (int i = 0; i < FILL_CASE_SITES; i++) {
        const float want = c.site[i].p.x > 0.0f ? 2.0f : 1.0f;
        assert_true(fabsf(smooth_case_record(&c, i)->value.E.g - want) < 1e-4f);
    }
    fill_case_free(&c);
}

// Makes the record in the middle an outlier of that E.
static int smooth_case_set_outlier(struct fill_case *c, float E) {
    int middle = 0;
    for (int i = 0; i < FILL_CASE_SITES; i++)
        if (v3_len2(c->site[i].p) < v3_len2(c->site[middle].p)) middle = i;
    smooth_case_record(c, middle)->value.E = rgb_grey(E);
    smooth_case_record(c, middle)->deviation = 1.0f - 1.0f / E;
    return middle;
}

// The light of a record that one ray has made bright is distributed to those around it.
static void an_outlier_is_distributed(void **state) {
    (void)state;
    struct fill_case c;
    smooth_case_make(&c);
    smooth_case_set(&c, 0.0f, 0.1f);
    const int middle = smooth_case_set_outlier(&c, 3.0f);
    assert_int_equal(fill_smooth(c.fill, 0.5f), SATIN_OK);
    assert_true(smooth_case_record(&c, middle)->value.E.g < 1.2f);
    fill_case_free(&c);
}

// Among good records an outlier alone changes, and gives its light away up to the mean around it:
// of 1.8 as much all of .8, of 30 as much no more than 1.
static void outliers_alone_are_spread(void **state) {
    (void)state;
    for (int far = 0; far < 2; far++) {
        struct fill_case c;
        smooth_case_make(&c);
        smooth_case_set(&c, 0.5f, 0.0f);
        const int middle = smooth_case_set_outlier(&c, far ? 30.0f : 1.8f);
        assert_int_equal(fill_spread_outliers(c.fill, 0.25f), SATIN_OK);
        double sum = 0.0;
        for (int i = 0; i < FILL_CASE_SITES; i++) {
            const double more =
                (double)(smooth_case_record(&c, i)->value.E.g - 1.0f - 0.5f * c.site[i].p.x);
            assert_true(more >= -1e-5 && more < 0.1);
            if (v3_len(v3_sub(c.site[i].p, c.site[middle].p)) > 0.21f) assert_true(more < 1e-5);
            sum += more;
        }
        assert_true(fabs(sum - (far ? 1.0 : 0.8)) < 0.03);
        fill_case_free(&c);
    }
}

// Without outliers, all records are as they were.
static void good_records_stay(void **state) {
    (void)state;
    struct fill_case c;
    smooth_case_make(&c);
    smooth_case_set(&c, 0.0f, 0.05f);
    rgb before[FILL_CASE_SITES];
    for (int i = 0; i < FILL_CASE_SITES; i++) before[i] = smooth_case_record(&c, i)->value.E;
    assert_int_equal(fill_spread_outliers(c.fill, 0.25f), SATIN_OK);
    for (int i = 0; i < FILL_CASE_SITES; i++)
        assert_memory_equal(&before[i], &smooth_case_record(&c, i)->value.E, sizeof before[i]);
    fill_case_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_falls_and_the_mean_stays),
        cmocka_unit_test(steps_stay),
        cmocka_unit_test(an_outlier_is_distributed),
        cmocka_unit_test(outliers_alone_are_spread),
        cmocka_unit_test(good_records_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
