// SPDX-License-Identifier: Apache-2.0
// Full convergence on a plane with an edge of irradiance across it: records on either side are
// shrunk to make way for each other, new ones fill the gaps, every point keeps a record, and no two
// records visibly disagree anywhere but within the least radius; the same for any number of
// threads.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "fill_case.h"

static const float CACHE_ADAPTIVE_PIXEL = 0.01f;

// A floor that is divided by a thin wall, lit on one side; records do not know of the wall, as the
// leak test is off.
static void fill_adaptive_start(struct fill_case *f, int threads) {
    fill_case_begin(f);
    uint32_t grey = test_diffuse(&f->scene, 0.8f, 0.8f, 0.8f);
    test_rectangle(&f->scene, mat4_scale(v3(3, 3, 1)), grey);
    test_cube(&f->scene, test_transform(v3(0, 0, 1.3f), v3(3, 3, 0.01f)), false, grey);
    test_cube(&f->scene, test_transform(v3(0, 0, 0.2f), v3(0.001f, 3, 0.2f)), false, grey);
    test_light(&f->scene,
               (struct light){
                   .kind = LIGHT_POINT, .position = v3(-0.4f, 0, 1.0f), .value = rgb_grey(1.0f)});
    f->options.irradiance_rays = 2000;
    f->options.irradiance_a = 1.0f;
    f->options.leak_test = false;
    f->options.irradiance_min_pixels = 1.0f;
    fill_case_finish(
        f, 0, threads, v3(0, 0, 0), v3(0.5f, 0, 0), v3(0, 0.5f, 0),
        (struct fill_site){.pixel = CACHE_ADAPTIVE_PIXEL, .kinds = 1 << CACHE_IRRADIANCE});
}

// Makes all sites diffuse, beside direct light of that luminance.
static void fill_adaptive_shade(struct fill_case *f, float light) {
    for (int i = 0; i < FILL_CASE_SITES; i++) {
        f->site[i].shading_p = f->site[i].p;
        f->site[i].diffuse = rgb_grey(0.8f / PI_F);
        f->site[i].direct = light;
    }
}

// Fills, then converges beside direct light of that luminance; returns how many records were added.
static size_t fill_adaptive_run(struct fill_case *f, float light) {
    struct fill_sites sites = {.site = f->site,
                               .count = 12,  // coarse to fine
                               .a = f->options.irradiance_a,
                               .factor_max = 2.0f,
                               .spacing = 1.5f};
    assert_int_equal(fill_records(f->fill, CACHE_IRRADIANCE, &sites), SATIN_OK);
    sites.count = FILL_CASE_SITES;
    assert_int_equal(fill_records(f->fill, CACHE_IRRADIANCE, &sites), SATIN_OK);
    fill_adaptive_shade(f, light);
    size_t before = cache_count(f->cache, CACHE_IRRADIANCE);
    assert_int_equal(fill_adapt(f->fill, CACHE_IRRADIANCE, &sites, 1.5f * sites.a), SATIN_OK);
    return cache_count(f->cache, CACHE_IRRADIANCE) - before;
}

static void assert_sites_are_covered(const struct fill_case *f) {
    struct cache_near near[CACHE_NEAR_MAX];
    for (int i = 0; i < FILL_CASE_SITES; i++)
        assert_true(cache_find(f->cache, CACHE_IRRADIANCE, f->site[i].p, f->site[i].frame.n,
                               f->options.irradiance_a, near) > 0);
}

static void records_are_added_where_they_disagree(void **state) {
    (void)state;
    struct fill_case f;
    fill_adaptive_start(&f, 1);
    size_t added = fill_adaptive_run(&f, 0.0f);
    assert_true(added > 0);
    assert_true(f.fill->adapted.passes >= 2 && f.fill->adapted.passes <= 11);
    bool smaller = false;
    for (size_t i = 0; i < f.cache->store[CACHE_IRRADIANCE].tree.head_count; i++)
        smaller = smaller || f.cache->store[CACHE_IRRADIANCE].tree.head[i].scale < 1.0f;
    assert_true(smaller);
    assert_sites_are_covered(&f);
    fill_case_free(&f);
}

// Beside strong direct light the same differences are not visible [K05 6.4].
static void direct_light_hides_differences(void **state) {
    (void)state;
    struct fill_case f;
    fill_adaptive_start(&f, 1);
    assert_int_equal(fill_adaptive_run(&f, 1000.0f), 0);
    assert_int_equal(f.fill->adapted.shrunk, 0);
    fill_case_free(&f);
}

static void threads_do_not_change_adapted_records(void **state) {
    (void)state;
    struct fill_case a, b;
    fill_adaptive_start(&a, 1);
    fill_adaptive_start(&b, 3);
    fill_adaptive_run(&a, 0.0f);
    fill_adaptive_run(&b, 0.0f);
    const struct cache_tree *s = &a.cache->store[CACHE_IRRADIANCE].tree,
                            *t = &b.cache->store[CACHE_IRRADIANCE].tree;
    assert_int_equal(s->head_count, t->head_count);
    assert_memory_equal(s->head, t->head, s->head_count * sizeof *s->head);
    fill_case_free(&a);
    fill_case_free(&b);
}

static bool adaptation_stops(void *user, double done) {
    (void)done;
    return --*(int *)user < 0;
}

// Stopped anywhere, it leaves a record at every point that had one. *whole says
// whether it came to its end.
static void stop_adaptation(int chunks, bool *whole) {
    struct fill_case f;
    fill_adaptive_start(&f, 1);
    const struct fill_sites sites = {.site = f.site,
                                     .count = FILL_CASE_SITES,
                                     .a = f.options.irradiance_a,
                                     .factor_max = 2.0f,
                                     .spacing = 1.5f};
    assert_int_equal(fill_records(f.fill, CACHE_IRRADIANCE, &sites), SATIN_OK);
    fill_adaptive_shade(&f, 0.0f);
    parallel_set_progress(f.pool, adaptation_stops, &chunks);
    *whole = fill_adapt(f.fill, CACHE_IRRADIANCE, &sites, 1.5f * sites.a) == SATIN_OK;
    assert_sites_are_covered(&f);
    fill_case_free(&f);
}

static void a_stop_leaves_no_gaps(void **state) {
    (void)state;
    bool whole = false;
    int stops = 0;
    for (int chunks = 0; !whole; chunks += 1 + chunks / 8, stops++) stop_adaptation(chunks, &whole);
    assert_true(stops > 8);
}

// The largest difference, over the mean, of the light of a record at any site from that of all
// records that are read there, among those that are farther away than the least radius. *reads is
// set to the mean number of records that are read.
static float largest_difference(const struct fill_case *f, float a, float *reads) {
    const struct cache_tree *tree = &f->cache->store[CACHE_IRRADIANCE].tree;
    struct cache_near near[CACHE_NEAR_MAX];
    float most = 0.0f;
    *reads = 0.0f;
    for (int k = 0; k < FILL_CASE_SITES; k++) {
        const struct fill_site *s = &f->site[k];
        const int count = cache_find(f->cache, CACHE_IRRADIANCE, s->p, s->frame.n, a, near);
        float sum = 0.0f, weights = 0.0f;
        for (int i = 0; i < count; i++) {
            sum += near[i].weight *
                   f->cache->store[CACHE_IRRADIANCE].irradiance[near[i].record].value.E.g;
            weights += near[i].weight;
        }
        for (int i = 0; i < count; i++) {
            const float E = f->cache->store[CACHE_IRRADIANCE].irradiance[near[i].record].value.E.g;
            if (v3_dist2(tree->head[near[i].record].p, s->p) > sqrf(CACHE_ADAPTIVE_PIXEL))
                most = fmaxf(most, fabsf(E * weights / sum - 1.0f));
        }
        *reads += (float)count / FILL_CASE_SITES;
    }
    return most;
}

// All records that are read are tested, where some 16 are read at a point.
static void no_record_is_read_untested(void **state) {
    (void)state;
    static const float READ = 0.7f;
    struct fill_case f;
    fill_adaptive_start(&f, 1);
    const struct fill_sites sites = {
        .site = f.site, .count = FILL_CASE_SITES, .a = 0.3f, .factor_max = 2.5f, .spacing = 0.5f};
    assert_int_equal(fill_records(f.fill, CACHE_IRRADIANCE, &sites), SATIN_OK);
    fill_adaptive_shade(&f, 0.0f);
    float reads, last;
    const float before = largest_difference(&f, READ, &reads);
    assert_int_equal(fill_adapt(f.fill, CACHE_IRRADIANCE, &sites, READ), SATIN_OK);
    const float after = largest_difference(&f, READ, &last);
    print_message("%.1f records per point, difference %.2f, adapted %.2f\n", (double)reads,
                  (double)before, (double)after);
    assert_true(reads > 12.0f && before > 2.0f);
    assert_true(after < 0.75f);  // 1.5 if six of them are tested
    fill_case_free(&f);
}

// Gives records on an evenly lit floor gradients of noise, a third of E over the largest distance
// at which they are read. Returns how many are shrunk if they know of it, or do not.
static uint64_t shrunk_by_noise(bool known) {
    struct fill_case f;
    struct rng rng = rng_make(1, RNG_SITE, 0);
    fill_case_begin(&f);
    test_rectangle(&f.scene, mat4_scale(v3(3, 3, 1)), test_diffuse(&f.scene, 0.8f, 0.8f, 0.8f));
    f.options.leak_test = false;
    fill_case_finish(
        &f, 0, 1, v3(0, 0, 0), v3(0.5f, 0, 0), v3(0, 0.5f, 0),
        (struct fill_site){.pixel = CACHE_ADAPTIVE_PIXEL, .kinds = 1 << CACHE_IRRADIANCE});
    fill_adaptive_shade(&f, 0.0f);
    for (int i = 0; i < FILL_CASE_SITES; i += 7) {
        const struct cache_head head = {.p = f.site[i].p,
                                        .R = 0.6f,
                                        .n = f.site[i].frame.n,
                                        .search_radius = 0.6f,
                                        .scale = 1.0f,
                                        .u = f.site[i].frame.u};
        struct cache_irradiance_record record = {.value = {.E = rgb_grey(1.0f), .rays = 100},
                                                 .gradient_deviation = known ? 1.1f : 0.0f,
                                                 .radius_ratio = 1.0f};
        const float angle = 2.0f * PI_F * rng_float(&rng);
        for (int c = 0; c < 3; c++)
            record.value.grad_t[c] = v3(1.1f * cosf(angle), 1.1f * sinf(angle), 0.0f);
        assert_true(cache_insert_irradiance(f.cache, &head, &record));
    }
    const struct fill_sites sites = {
        .site = f.site, .count = FILL_CASE_SITES, .a = 0.25f, .factor_max = 2.0f, .spacing = 1.5f};
    assert_int_equal(fill_adapt(f.fill, CACHE_IRRADIANCE, &sites, 0.5f), SATIN_OK);
    const uint64_t shrunk = f.fill->adapted.shrunk;
    fill_case_free(&f);
    return shrunk;
}

static void noise_of_gradients_shrinks_no_record(void **state) {
    (void)state;
    assert_int_equal(shrunk_by_noise(true), 0);
    assert_true(shrunk_by_noise(false) > 10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(records_are_added_where_they_disagree),
        cmocka_unit_test(no_record_is_read_untested),
        cmocka_unit_test(direct_light_hides_differences),
        cmocka_unit_test(threads_do_not_change_adapted_records),
        cmocka_unit_test(a_stop_leaves_no_gaps),
        cmocka_unit_test(noise_of_gradients_shrinks_no_record),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
