// SPDX-License-Identifier: Apache-2.0
// Numbers of rays by the variance that records around measured: the number of the options where
// there are none, a quarter or four times as many at the ends, and between them the deviation that
// the options ask for.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "fill_case.h"

enum { RAYS = 900 };

// The floor of a box that is lit from aside by a point light in it.
static void fill_rays_start(struct fill_case *f, int threads, int rays, float noise) {
    fill_case_begin(f);
    test_cube(&f->scene, mat4_identity(), true, test_diffuse(&f->scene, 0.5f, 0.5f, 0.5f));
    test_light(&f->scene,
               (struct light){
                   .kind = LIGHT_POINT, .position = v3(0.7f, 0.5f, 0.6f), .value = rgb_grey(1.0f)});
    f->options.irradiance_rays = f->options.radiance_rays = rays;
    f->options.irradiance_a = f->options.radiance_a = 0.5f;
    f->options.irradiance_noise = f->options.radiance_noise = noise;
    fill_case_finish(
        f, 4, threads, v3(0, -1, 0), v3(0, 0, 0.9f), v3(0.9f, 0, 0),
        (struct fill_site){.pixel = 0.01f, .kinds = 1 << CACHE_IRRADIANCE | 1 << CACHE_RADIANCE});
}

// Some coarse records, then finer ones among them; returns how many were coarse.
static size_t fill_rays_fill(struct fill_case *f, enum cache_kind kind) {
    struct fill_sites sites = {
        .site = f->site, .count = 16, .a = 0.5f, .factor_max = 2.0f, .spacing = 1.0f};
    assert_int_equal(fill_records(f->fill, kind, &sites), SATIN_OK);
    size_t coarse = cache_count(f->cache, kind);
    sites.count = FILL_CASE_SITES;
    sites.a = 0.25f;
    assert_int_equal(fill_records(f->fill, kind, &sites), SATIN_OK);
    assert_true(cache_count(f->cache, kind) > coarse + 8);
    return coarse;
}

static uint32_t rays_of(const struct fill_case *f, enum cache_kind kind, size_t i) {
    return kind == CACHE_IRRADIANCE ? f->cache->store[CACHE_IRRADIANCE].irradiance[i].value.rays
                                    : f->cache->store[CACHE_RADIANCE].radiance[i].rays;
}

static bool near_to(uint32_t rays, double wanted) {
    return (double)rays > 0.9 * wanted && (double)rays < 1.1 * wanted;
}

static void numbers_of_rays_differ_by_at_most_four(void **state) {
    (void)state;
    static const float noise[] = {0.0f, 1e-4f, 1.0f};
    static const double times[] = {1.0, 4.0, 0.25};
    for (int k = 0; k < 6; k++) {
        const enum cache_kind kind = k % 2 ? CACHE_RADIANCE : CACHE_IRRADIANCE;
        struct fill_case f;
        fill_rays_start(&f, 2, RAYS, noise[k / 2]);
        size_t coarse = fill_rays_fill(&f, kind);
        const size_t count = cache_count(f.cache, kind);
        size_t off = 0;
        for (size_t i = 0; i < count; i++) {
            const uint32_t rays = rays_of(&f, kind, i);
            const bool plain = near_to(rays, RAYS);  // where no record served
            if (i < coarse) assert_true(plain);
            assert_true(plain || near_to(rays, RAYS * times[k / 2]));
            off += near_to(rays, RAYS * times[k / 2]);
        }
        assert_true(4 * off > 3 * (count - coarse));
        fill_case_free(&f);
    }
}

// Half of the deviation that records of the options' number of rays have needs four times the rays.
static void rays_give_the_deviation_of_the_options(void **state) {
    (void)state;
    double mean[2] = {0};
    for (int asked = 0; asked < 2; asked++) {
        struct fill_case f;
        fill_rays_start(&f, 2, RAYS, asked ? 0.7f * (float)mean[0] : 0.0f);
        size_t coarse = fill_rays_fill(&f, CACHE_IRRADIANCE);
        const size_t count = cache_count(f.cache, CACHE_IRRADIANCE);
        double square = 0.0, rays = 0.0;
        for (size_t i = coarse; i < count; i++) {
            const double d = (double)f.cache->store[CACHE_IRRADIANCE].irradiance[i].deviation;
            square += d * d / (double)(count - coarse);
            rays += (double)rays_of(&f, CACHE_IRRADIANCE, i) / (double)(count - coarse);
        }
        mean[asked] = sqrt(square);
        if (asked) assert_true(rays > 1.5 * RAYS && rays < 3.0 * RAYS);
        fill_case_free(&f);
    }
    assert_true(mean[1] > 0.5 * mean[0] && mean[1] < 0.9 * mean[0]);
}

static void threads_do_not_change_numbers_of_rays(void **state) {
    (void)state;
    struct fill_case one, four;
    fill_rays_start(&one, 1, RAYS, 0.02f);
    fill_rays_start(&four, 4, RAYS, 0.02f);
    fill_rays_fill(&one, CACHE_RADIANCE);
    fill_rays_fill(&four, CACHE_RADIANCE);
    const enum cache_kind kinds[] = {CACHE_IRRADIANCE, CACHE_RADIANCE};
    for (int k = 0; k < 2; k++) {
        const size_t count = cache_count(one.cache, kinds[k]);
        assert_int_equal(count, cache_count(four.cache, kinds[k]));
        for (size_t i = 0; i < count; i++)
            assert_int_equal(rays_of(&one, kinds[k], i), rays_of(&four, kinds[k], i));
    }
    fill_case_free(&one);
    fill_case_free(&four);
}

// Rays to clusters are half as many as stratified ones, and those of lobes as many.
static void hemispheres_hold_all_rays(void **state) {
    (void)state;
    for (int k = 0; k < 2; k++)
        for (int rays = 4; rays < 100; rays++) {
            struct fill_case f;
            fill_rays_start(&f, 1, rays, k ? 0.1f : 0.0f);
            const struct gather_hemisphere *h = f.fill->worker[0].hemisphere;
            const size_t capacity = (size_t)(h->y - h->x);
            for (int i = 0; i < FILL_LAYOUTS; i++) {
                const struct gather_layout *lobes = f.fill->side[CACHE_RADIANCE].glossy[i];
                const struct gather_layout *plain = f.fill->side[CACHE_IRRADIANCE].layout[i];
                assert_true(!lobes == !plain);
                if (!lobes) continue;
                const size_t half = gather_layout_rays(lobes), all = gather_layout_rays(plain);
                assert_true(2 * half + half / 2 <= capacity && all + all / 2 <= capacity);
            }
            fill_case_free(&f);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_of_rays_differ_by_at_most_four),
        cmocka_unit_test(rays_give_the_deviation_of_the_options),
        cmocka_unit_test(threads_do_not_change_numbers_of_rays),
        cmocka_unit_test(hemispheres_hold_all_rays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
