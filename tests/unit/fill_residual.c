// SPDX-License-Identifier: Apache-2.0
// Residuals: with its residual a record gives for its own lobe the same light as its rays, however
// few harmonics it has; other lobes get less of the residual, other BRDFs nothing.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cache/cache_value.h"
#include "fill_case.h"

enum { ORDER = 4, RAYS = 900, LOBE_NUMBER = 7 };

static const vec3 WO = {0.6f, 0.0f, 0.8f};

static struct brdf shiny(void) {
    return (struct brdf){
        .model = brdf_find("phong"), .specular = rgb_grey(1.0f), .exponent = 22.0f};
}

struct fill_residual_fixture {
    struct fill_case c;
    struct brdf_range *range;
};

// One record on the floor of a box that a point light in it lights from aside, of an order much too
// low for the lobe.
static void fill_residual_start(struct fill_residual_fixture *f, bool viewed) {
    const struct brdf brdf = shiny();
    const struct brdf_fit fit = {SATIN_HSH, ORDER, 0.01f, true};
    struct fill_case *c = &f->c;
    fill_case_begin(c);
    test_cube(&c->scene, mat4_identity(), true, test_diffuse(&c->scene, 0.5f, 0.4f, 0.3f));
    test_light(&c->scene,
               (struct light){
                   .kind = LIGHT_POINT, .position = v3(0.7f, 0.5f, 0.6f), .value = rgb_grey(1.0f)});
    c->options.radiance_rays = RAYS;
    fill_case_finish(c, ORDER, 1, v3(0, -1, 0), v3(0, 0, 0.9f), v3(0.9f, 0, 0),
                     (struct fill_site){.pixel = 0.01f, .kinds = 1 << CACHE_RADIANCE});
    assert_int_equal(brdf_range_build(&brdf, NULL, &fit, c->pool, &f->range), SATIN_OK);
    if (viewed) c->site[0].glossy = (struct fill_glossy){shiny(), f->range, 1, LOBE_NUMBER, WO};
    struct fill_sites sites = {
        .site = c->site, .count = 1, .a = 0.5f, .factor_max = 1.0f, .spacing = 1.0f};
    assert_int_equal(fill_records(c->fill, CACHE_RADIANCE, &sites), SATIN_OK);
    assert_int_equal(cache_count(c->cache, CACHE_RADIANCE), 1);
}

static void fill_residual_stop(struct fill_residual_fixture *f) {
    brdf_range_free(f->range);
    fill_case_free(&f->c);
}

// The light that the lobe reflects towards WO by the record.
static rgb fill_residual_reflected(const struct fill_residual_fixture *f) {
    const struct fill_site *s = &f->c.site[0];
    const struct brdf brdf = shiny();
    float C[3 * RSH_MAX_COEFFICIENTS];
    struct cache_lobe lobe = {.C = C, .channels = 1, .number = LOBE_NUMBER};
    lobe.order = brdf_range_lookup(f->range, &brdf, WO, C);
    lobe.mirror = frame_to_world(&s->frame, v3(-WO.x, -WO.y, WO.z));
    const struct cache_lookup at = {s->p, s->frame.n, s->frame, 0.0f};
    rgb L = rgb_grey(-1.0f);
    assert_int_equal(cache_radiance(f->c.cache, &at, 0.5f, &lobe, &L, NULL).count, 1);
    return L;
}

// Returns that light by the rays of the same record.
static rgb by_rays(const struct fill_residual_fixture *f) {
    const struct fill_site *s = &f->c.site[0];
    const struct brdf brdf = shiny();
    const struct gather_site site = {s->p, s->ng, s->frame, s->stream, true, &brdf, WO};
    float lambda[3 * ORDER * ORDER];
    struct gather_radiance radiance = {.lambda = lambda};
    struct gather_layout *layout = gather_layout_new(RAYS / 2, SATIN_HSH, ORDER);
    struct gather_worker *worker = gather_workers_new(NULL, 2 * RAYS);
    gather_hemisphere_trace(&f->c.g, layout, &site, worker->scratch, worker->hemisphere);
    gather_hemisphere_radiance(worker->hemisphere, f->c.g.options->radiance_gradients, &radiance);
    const rgb L = gather_hemisphere_reflected(worker->hemisphere, &brdf, WO, BRDF_GLOSSY);
    gather_workers_free(worker, 1);
    gather_layout_free(layout);
    return L;
}

static void a_record_reflects_what_its_rays_reflect(void **state) {
    (void)state;
    struct fill_residual_fixture with, without;
    fill_residual_start(&with, true);
    fill_residual_start(&without, false);
    const rgb wanted = by_rays(&with), found = fill_residual_reflected(&with),
              cut = fill_residual_reflected(&without);
    // The tolerance is for sums of some hundred floats.
    assert_true(fabsf(found.r - wanted.r) < 1e-4f * wanted.r);
    assert_true(fabsf(found.g - wanted.g) < 1e-4f * wanted.g);
    assert_true(fabsf(found.b - wanted.b) < 1e-4f * wanted.b);
    // Order 4 alone has a large error.
    assert_true(fabsf(cut.g - wanted.g) > 0.02f * wanted.g);
    fill_residual_stop(&with);
    fill_residual_stop(&without);
}

static void the_residual_of_other_lobes_is_smaller(void **state) {
    (void)state;
    const struct cache_residual residual = {LOBE_NUMBER, {0, 0, 1}, {1.0f, -2.0f, 3.0f}};
    struct cache_lobe lobe = {.number = LOBE_NUMBER, .mirror = {0, 0, 1}};
    float before = 2.0f;
    for (int i = 0; i < 10; i++) {
        const float angle = 0.02f * (float)i;
        lobe.mirror = v3(sinf(angle), 0.0f, cosf(angle));
        const rgb L = cache_residual_read(&residual, &lobe);
        assert_true(L.r < before || (L.r == 0.0f && angle > 0.1f));
        assert_true(L.g == -2.0f * L.r && fabsf(L.b - 3.0f * L.r) < 1e-6f);
        if (i == 0) assert_true(L.r == 1.0f);
        before = L.r;
    }
    assert_true(before == 0.0f);
    lobe.mirror = v3(0, 0, 1);
    lobe.number = LOBE_NUMBER + 1;
    assert_true(rgb_black(cache_residual_read(&residual, &lobe)));
    assert_true(rgb_black(cache_residual_read(&(struct cache_residual){.lobe_number = 0},
                                              &(struct cache_lobe){.number = 0})));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_record_reflects_what_its_rays_reflect),
        cmocka_unit_test(the_residual_of_other_lobes_is_smaller),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
