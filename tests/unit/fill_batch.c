// SPDX-License-Identifier: Apache-2.0
// Filling a cache: every site that needs a record is covered, members of a batch lie apart, records
// whose value depends on a few rays are gathered again, and new ones among adapted ones take their
// scale.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "fill_case.h"

enum { RAYS = 600 };

// The floor of a box that is lit from aside by a point light in it. A pixel is a tenth wide, and
// the least radius such that a record serves two pixels.
static void fill_start(struct fill_case *f) {
    fill_case_begin(f);
    test_cube(&f->scene, mat4_identity(), true, test_diffuse(&f->scene, 0.5f, 0.5f, 0.5f));
    test_light(&f->scene,
               (struct light){
                   .kind = LIGHT_POINT, .position = v3(0.7f, 0.5f, 0.6f), .value = rgb_grey(1.0f)});
    f->options.irradiance_rays = RAYS;
    f->options.irradiance_a = 0.2f;
    f->options.irradiance_min_pixels = 2.0f;
    fill_case_finish(f, 0, 2, v3(0, -1, 0), v3(0, 0, 0.9f), v3(0.9f, 0, 0),
                     (struct fill_site){.pixel = 0.1f, .kinds = 1 << CACHE_IRRADIANCE});
}

static void fill_all_sites(struct fill_case *f, struct fill_sites sites) {
    sites.site = f->site;
    sites.a = f->options.irradiance_a;
    sites.factor_max = 1.0f;
    assert_int_equal(fill_records(f->fill, CACHE_IRRADIANCE, &sites), SATIN_OK);
}

static bool is_covered(const struct fill_case *f, const struct fill_site *s) {
    struct cache_near near[CACHE_NEAR_MAX];
    return cache_find(f->cache, CACHE_IRRADIANCE, s->p, s->frame.n, f->options.irradiance_a, near) >
           0;
}

static void sites_that_need_records_are_covered(void **state) {
    (void)state;
    struct fill_case f;
    fill_start(&f);
    // The sites of one half need no records, and are too far from the others to be covered by
    // theirs.
    for (int i = 0; i < FILL_CASE_SITES; i++)
        if (f.site[i].p.x > 0.0f) f.site[i].kinds = 1 << CACHE_RADIANCE;
    // Farther apart than the influence radius of a record: sites between the members of a batch
    // must wait.
    fill_all_sites(&f, (struct fill_sites){.count = FILL_CASE_SITES, .spacing = 5.0f});
    int bare = 0;
    for (int i = 0; i < FILL_CASE_SITES; i++) {
        const bool needed = f.site[i].kinds & 1 << CACHE_IRRADIANCE;
        if (needed) assert_true(is_covered(&f, &f.site[i]));
        bare += !is_covered(&f, &f.site[i]);
    }
    assert_true(bare > FILL_CASE_SITES / 4);
    const size_t count = cache_count(f.cache, CACHE_IRRADIANCE);
    for (size_t i = 0; i < count; i++) {
        vec3 p, n;
        float R;
        cache_record(f.cache, CACHE_IRRADIANCE, i, &p, &n, &R);
        assert_true(p.x <= 0.0f);
    }
    // A site that is covered gets no second record.
    fill_all_sites(&f, (struct fill_sites){.count = FILL_CASE_SITES, .spacing = 1.0f});
    assert_int_equal(cache_count(f.cache, CACHE_IRRADIANCE), count);
    // A cache without harmonics gets no radiance records either.
    struct fill_sites radiance = {
        .site = f.site, .count = FILL_CASE_SITES, .a = 0.2f, .factor_max = 1.0f, .spacing = 1.0f};
    assert_int_equal(fill_records(f.fill, CACHE_RADIANCE, &radiance), SATIN_OK);
    assert_int_equal(cache_count(f.cache, CACHE_RADIANCE), 0);
    fill_case_free(&f);
}

// The influence radius of a record is larger than the spacing, so two records lie that near only if
// they were members of one batch.
static void members_of_a_batch_lie_apart(void **state) {
    (void)state;
    struct fill_case f;
    fill_start(&f);
    const float spacing = 1.8f, least = spacing * 0.1f;
    fill_all_sites(&f, (struct fill_sites){.count = FILL_CASE_SITES, .spacing = spacing});
    const size_t count = cache_count(f.cache, CACHE_IRRADIANCE);
    assert_true(count > 8);
    for (size_t i = 0; i < count; i++)
        for (size_t j = 0; j < i; j++) {
            vec3 a, b, n;
            float R;
            cache_record(f.cache, CACHE_IRRADIANCE, i, &a, &n, &R);
            cache_record(f.cache, CACHE_IRRADIANCE, j, &b, &n, &R);
            assert_true(v3_dist2(a, b) >= 0.999f * least * least);
        }
    fill_case_free(&f);
}

// All light comes from a small bright patch that a narrow spot lights on the ceiling: a tenth of
// the rays meets it by chance.
static void records_of_few_rays_are_gathered_again(void **state) {
    (void)state;
    struct fill_case f;
    fill_case_begin(&f);
    test_cube(&f.scene, mat4_identity(), true, test_diffuse(&f.scene, 0.5f, 0.5f, 0.5f));
    test_light(&f.scene, (struct light){.kind = LIGHT_SPOT,
                                        .position = v3(0, 0, 0),
                                        .direction = v3(0, 1, 0),
                                        .to_world = mat4_identity(),
                                        .cos_cutoff = cosf(0.2f),
                                        .cos_beam = cosf(0.19f),
                                        .value = rgb_grey(1.0f)});
    f.options.irradiance_rays = RAYS;
    f.options.irradiance_a = 0.2f;
    fill_case_finish(&f, 0, 2, v3(0, -1, 0), v3(0, 0, 0.9f), v3(0.9f, 0, 0),
                     (struct fill_site){.pixel = 0.1f, .kinds = 1 << CACHE_IRRADIANCE});
    assert_int_equal(fill_limit_rays(f.fill, 0.1f), SATIN_OK);
    fill_all_sites(&f, (struct fill_sites){.count = FILL_CASE_SITES, .spacing = 1.0f});
    const size_t count = cache_count(f.cache, CACHE_IRRADIANCE);
    size_t again = 0;
    uint64_t rays = 0;
    for (size_t i = 0; i < count; i++) {
        const struct cache_irradiance_record *r = &f.cache->store[CACHE_IRRADIANCE].irradiance[i];
        const bool few = r->value.rays < 0.12 * RAYS;
        if (few)
            assert_true(r->deviation <= 0.4f);
        else
            assert_true(r->value.rays > 1.05 * RAYS && r->value.rays < 1.15 * RAYS);
        again += !few;
        rays += r->value.rays;
    }
    assert_true(again > count / 4);
    assert_int_equal(cache_rays(f.cache), rays);
    fill_case_free(&f);
}

// Among records whose scale is .5, the first new one has 1.4 times that [K05 6.3.2].
static void new_records_take_the_scale_of_adapted_ones(void **state) {
    (void)state;
    for (int adapted = 0; adapted < 2; adapted++) {
        struct fill_case f;
        fill_start(&f);
        fill_all_sites(&f, (struct fill_sites){.count = FILL_CASE_SITES, .spacing = 1.0f});
        struct cache_tree *tree = &f.cache->store[CACHE_IRRADIANCE].tree;
        const size_t before = tree->head_count;
        for (size_t i = 0; i < before; i++) {
            assert_true(tree->head[i].scale == 1.0f);
            tree->head[i].scale = 0.5f;
        }
        fill_all_sites(&f, (struct fill_sites){
                               .count = FILL_CASE_SITES, .spacing = 1.0f, .adapted = adapted == 1});
        assert_true(tree->head_count > before);
        assert_float_equal(tree->head[before].scale, adapted ? 0.7f : 1.0f, 1e-6f);
        for (size_t i = before; i < tree->head_count; i++) assert_true(tree->head[i].scale <= 1.0f);
        fill_case_free(&f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sites_that_need_records_are_covered),
        cmocka_unit_test(members_of_a_batch_lie_apart),
        cmocka_unit_test(records_of_few_rays_are_gathered_again),
        cmocka_unit_test(new_records_take_the_scale_of_adapted_ones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
