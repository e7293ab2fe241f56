// SPDX-License-Identifier: Apache-2.0
// Indirect light of a glossy room without records: samples by single gather rays have the mean of
// the samples that gather over hemispheres, in each layer.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "photon_case.h"
#include "scene_case.h"
#include "shade/shade.h"

// A box of 2 x 2 x 2 with a lamp, seen from within.
static const char SHADE_TWO_PASS_SCENE[] =
    "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='60'/>"
    "<transform name='to_world'><lookat origin='.1, -.8, .2' target='.2, 1, -.4' up='0, 0, 1'/>"
    "</transform><film type='hdrfilm'><integer name='width' value='2'/>"
    "<integer name='height' value='2'/><rfilter type='box'/></film></sensor>"
    "<shape type='cube'><boolean name='flip_normals' value='true'/><bsdf type='phong'>"
    "<rgb name='diffuse_reflectance' value='.3, .4, .5'/>"
    "<rgb name='specular_reflectance' value='.3, .2, .1'/><float name='exponent' value='8'/>"
    "</bsdf></shape><emitter type='point'><point name='position' x='.3' y='.2' z='.5'/>"
    "<rgb name='intensity' value='1, 1, 1'/></emitter></scene>";

enum { SAMPLES = 1 << 14 };

struct shade_two_pass_room {
    satin_scene *scene;
    satin_options options;
    struct parallel *pool;
    struct photon_maps *maps;
    struct cache_tables tables;
};

static void shade_two_pass_make(struct shade_two_pass_room *room) {
    struct scene_case c;
    *room = (struct shade_two_pass_room){.scene = scene_case_load(&c, SHADE_TWO_PASS_SCENE),
                                         .options = satin_options_default};
    if (!room->scene) fail_msg("%s", c.error);
    satin_options *o = &room->options;
    o->width = o->height = 2;
    o->max_depth = -1;
    o->photons = 20000;
    o->caustic_photons = 0;
    o->light_samples = 1;
    o->spp = SAMPLES;
    room->pool = parallel_new(1);
    assert_non_null(room->pool);
    struct stats stats = {0};
    assert_int_equal(photon_case_build(room->scene, o, room->pool, &stats, &room->maps), SATIN_OK);
    assert_int_equal(cache_tables_build(room->scene, o, room->pool, (struct log){0}, &room->tables),
                     SATIN_OK);
}

static void destroy(struct shade_two_pass_room *room) {
    cache_tables_free(&room->tables);
    photon_maps_free(room->maps);
    parallel_free(room->pool);
    satin_scene_free(room->scene);
}

// The mean layers of a pixel without records, and the number of gather rays per sample.
static double mean_layers(const struct shade_two_pass_room *room, const satin_options *o,
                          double *layer) {
    const struct gather g = gather_make(room->scene, o, room->maps);
    struct shade shade;
    assert_int_equal(
        shade_init(&shade, &g, &room->tables, NULL, render_budget_missing_rays(o), room->pool),
        SATIN_OK);
    struct shade_worker worker = {.gather = shade.worker[0]};
    for (int i = 0; i < SHADE_LAYERS; i++) layer[i] = 0.0;
    shade_pixel_begin(&worker);
    for (uint32_t i = 0; i < SAMPLES; i++) {
        struct shade_sample s;
        shade_pixel(&shade, &worker, 0, 1, i, (struct gather_lights){1, i}, &s);
        assert_true(shade_sample_finite(&s));
        for (int k = 0; k < SHADE_EMISSION; k++)
            layer[k] += (double)rgb_luminance(s.layer[k]) / SAMPLES;
        // No light is from records.
        const rgb rest = rgb_sub(s.beauty, s.uncached);
        assert_true(fabsf(rgb_luminance(rest)) <= 1e-5f * rgb_luminance(s.beauty));
    }
    shade_destroy(&shade);
    return (double)worker.counts.rays / SAMPLES;
}

static void single_rays_have_the_mean_of_hemispheres(void **state) {
    (void)state;
    struct shade_two_pass_room room;
    shade_two_pass_make(&room);
    double single[SHADE_LAYERS], hemisphere[SHADE_LAYERS];
    // One ray per sample with a time limit, else eight.
    satin_options timed = room.options, off = room.options;
    timed.time = 1.0;
    assert_true(mean_layers(&room, &timed, single) <= 1.0);
    const double rays = mean_layers(&room, &room.options, single);
    assert_true(rays > 7.5 && rays <= 8.0);
    mean_layers(&room, &timed, single);
    off.irradiance_cache = off.radiance_cache = false;
    cache_tables_free(&room.tables);
    assert_true(mean_layers(&room, &off, hemisphere) > 8.0);
    for (int i = SHADE_INDIRECT_DIFFUSE; i <= SHADE_INDIRECT_GLOSSY; i++) {
        print_message("%f by single rays, %f by hemispheres\n", single[i], hemisphere[i]);
        // The noise of 16384 samples is .5 to 1 %.
        assert_true(hemisphere[i] > 0.01 && fabs(single[i] / hemisphere[i] - 1.0) < 0.03);
    }
    destroy(&room);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(single_rays_have_the_mean_of_hemispheres),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
