// SPDX-License-Identifier: Apache-2.0
// Direct light of a floor that reflects a lamp: its mean does not depend on the numbers of light
// samples and gather rays, and the BRDF samples that come with light samples lower its noise.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "photon_case.h"
#include "scene_case.h"
#include "shade/shade.h"

// A lamp behind a floor that is diffuse and glossy, seen at a slant; one pixel sees its reflection.
static const char SHADE_DIRECT_SCENE[] =
    "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='4'/>"
    "<transform name='to_world'><lookat origin='0, -4, 1' target='0, 0, 0' up='0, 0, 1'/>"
    "</transform><film type='hdrfilm'><integer name='width' value='1'/>"
    "<integer name='height' value='1'/><rfilter type='box'/></film></sensor>"
    "<shape type='rectangle'><transform name='to_world'><scale value='20'/></transform>"
    "<bsdf type='roughplastic'><float name='alpha' value='.1'/>"
    "<rgb name='diffuse_reflectance' value='.05, .05, .05'/></bsdf></shape>"
    "<shape type='rectangle'><transform name='to_world'><scale value='2'/>"
    "<rotate x='1' angle='90'/><translate x='.3' y='4' z='3'/></transform>"
    "<emitter type='area'><rgb name='radiance' value='10, 10, 10'/></emitter></shape></scene>";

struct shade_direct_result {
    double mean, deviation;  // of the pixel's direct light by one sample
    double error;            // standard error of the mean, as of independent samples
};

static struct shade_direct_result shade_direct_pixel(const struct satin_scene *scene,
                                                     struct parallel *pool, int lights, int rays,
                                                     bool indirect) {
    enum { SAMPLES = 1 << 14 };
    satin_options o = satin_options_default;
    o.width = o.height = 1;
    o.max_depth = indirect ? -1 : 2;
    o.glossy_samples = rays;
    o.photons = 1000;
    o.caustic_photons = 0;
    struct photon_maps *maps = NULL;
    struct stats stats = {0};
    assert_int_equal(photon_case_build(scene, &o, pool, &stats, &maps), SATIN_OK);
    const struct gather g = gather_make(scene, &o, maps);
    const struct cache_tables none = {0};
    struct shade shade;
    assert_int_equal(shade_init(&shade, &g, cache_reader_make(NULL, &none, &o),
                                (struct shade_missing){8, 1.0f}, pool),
                     SATIN_OK);
    struct shade_worker worker = {.gather = shade.worker[0]};
    struct shade_direct_result out = {0};
    for (uint32_t i = 0; i < SAMPLES; i++) {
        struct shade_sample s;
        const struct gather_light_samples direct = {lights, i * (uint32_t)lights};
        shade_pixel_begin(&worker);
        shade_pixel(&shade, &worker, 0, 0, i,
                    (struct shade_sample_counts){direct, direct, {8, 8 * i}}, &s);
        const double L = (double)rgb_luminance(s.layer[SHADE_DIRECT]);
        out.mean += L / SAMPLES;
        out.deviation += L * L / SAMPLES;
    }
    out.deviation = sqrt(out.deviation - out.mean * out.mean);
    out.error = out.deviation / sqrt(SAMPLES);
    shade_destroy(&shade);
    photon_maps_free(maps);
    return out;
}

static void samples_do_not_change_the_mean(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(&c, SHADE_DIRECT_SCENE);
    struct parallel *pool = parallel_new(1);
    assert_non_null(scene);
    // Without gather rays; with one of the BRDF samples by a gather ray; with more gather rays.
    const struct {
        int lights, rays;
        bool indirect;
    } by[] = {{1, 1, false}, {6, 1, false}, {6, 1, true}, {2, 4, true}};
    struct shade_direct_result result[4];
    for (int i = 0; i < 4; i++) {
        result[i] = shade_direct_pixel(scene, pool, by[i].lights, by[i].rays, by[i].indirect);
        print_message("%.5f +- %.5f\n", result[i].mean, result[i].error);
        // Samples of a sequence deviate by less than independent ones.
        assert_true(fabs(result[i].mean - result[0].mean) <=
                    3.0 * (result[i].error + result[0].error));
    }
    // Six samples of each kind: 1 / sqrt(6) = .41 by independent ones; .88 if only one BRDF sample
    // finds the lamp.
    assert_true(result[1].deviation < 0.45 * result[0].deviation);
    assert_true(result[2].deviation < 0.45 * result[0].deviation);
    parallel_free(pool);
    satin_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(samples_do_not_change_the_mean)};
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
