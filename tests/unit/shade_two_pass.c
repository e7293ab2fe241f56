// SPDX-License-Identifier: Apache-2.0
// Indirect light of a glossy room without records: samples by single gather rays have the mean of
// the samples that gather over hemispheres, in each layer, and rays to photon clusters that of rays
// by the lobes.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>
#include <math.h>

#include "photon_case.h"
#include "scene_case.h"
#include "shade/shade.h"

// A box of 2 x 2 x 2, seen from within, without its lamp.
#define SHADE_TWO_PASS_BOX                                                                       \
    "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='60'/>"           \
    "<transform name='to_world'><lookat origin='.1, -.8, .2' target='.2, 1, -.4' up='0, 0, 1'/>" \
    "</transform><film type='hdrfilm'><integer name='width' value='2'/>"                         \
    "<integer name='height' value='2'/><rfilter type='box'/></film></sensor>"                    \
    "<shape type='cube'><boolean name='flip_normals' value='true'/><bsdf type='phong'>"          \
    "<rgb name='diffuse_reflectance' value='.3, .4, .5'/>"                                       \
    "<rgb name='specular_reflectance' value='.3, .2, .1'/><float name='exponent' value='8'/>"    \
    "</bsdf></shape>"
static const char SHADE_TWO_PASS_POINT[] = SHADE_TWO_PASS_BOX
    "<emitter type='point'><point name='position' x='.3' y='.2' z='.5'/>"
    "<rgb name='intensity' value='1, 1, 1'/></emitter></scene>";
// A spot of light on a wall, some centimetres wide.
static const char SHADE_TWO_PASS_SPOT[] = SHADE_TWO_PASS_BOX
    "<emitter type='spot'><transform name='to_world'>"
    "<lookat origin='.3, .2, .5' target='1, .3, .6' up='0, 0, 1'/></transform>"
    "<float name='cutoff_angle' value='5'/><rgb name='intensity' value='100, 100, 100'/></emitter>"
    "</scene>";

// A box with walls of a glossy lobe alone around a lamp in a glass ball, whose reflection is seen.
static const char SHADE_TWO_PASS_BULB[] =
    "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='4'/>"
    "<transform name='to_world'><lookat origin='-.7, -.8, .2' target='.5, 1.8, 0' up='0, 0, 1'/>"
    "</transform><film type='hdrfilm'><integer name='width' value='2'/>"
    "<integer name='height' value='2'/><rfilter type='box'/></film></sensor>"
    "<shape type='cube'><boolean name='flip_normals' value='true'/><bsdf type='phong'>"
    "<rgb name='diffuse_reflectance' value='0'/><rgb name='specular_reflectance' value='.6'/>"
    "<float name='exponent' value='30'/></bsdf></shape>"
    "<shape type='sphere'><point name='center' x='.5' y='.2' z='0'/>"
    "<float name='radius' value='.3'/><bsdf type='dielectric'/></shape>"
    "<shape type='sphere'><point name='center' x='.5' y='.2' z='0'/>"
    "<float name='radius' value='.15'/><bsdf type='diffuse'/>"
    "<emitter type='area'><rgb name='radiance' value='1'/></emitter></shape></scene>";

enum { SAMPLES = 1 << 14 };

struct shade_two_pass_room {
    satin_scene *scene;
    satin_options options;
    struct parallel *pool;
    struct photon_maps *maps;
    struct cache_tables tables;
};

static void shade_two_pass_make(struct shade_two_pass_room *room, const char *xml, int max_depth,
                                uint64_t seed) {
    struct scene_case c;
    *room = (struct shade_two_pass_room){.scene = scene_case_load(&c, xml),
                                         .options = satin_options_default};
    if (!room->scene) fail_msg("%s", c.error);
    satin_options *o = &room->options;
    o->width = o->height = 2;
    o->max_depth = max_depth;
    o->photons = 20000;
    o->caustic_photons = max_depth < 0 ? 0 : 100000;
    o->light_samples = 1;
    o->seed = seed;
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

// What a pixel without records shows: its mean layers, the standard deviations of one sample, and
// the number of gather rays per sample.
struct shade_two_pass_pixel {
    double layer[SHADE_LAYERS], deviation[SHADE_LAYERS], rays;
};

static struct shade_two_pass_pixel shade_two_pass_pixel_of(const struct shade_two_pass_room *room,
                                                           const satin_options *o,
                                                           uint32_t samples) {
    struct shade_two_pass_pixel out = {0};
    const int rays = render_budget_first_gathers(o);
    const struct gather g = gather_make(room->scene, o, room->maps);
    struct shade shade;
    assert_int_equal(shade_init(&shade, &g, cache_reader_make(NULL, &room->tables, o),
                                render_budget_missing(o, 0.0), room->pool),
                     SATIN_OK);
    struct shade_worker worker = {.gather = shade.worker[0]};
    shade_pixel_begin(&worker);
    for (uint32_t i = 0; i < samples; i++) {
        struct shade_sample s;
        shade_pixel(&shade, &worker, 0, 1, i,
                    (struct shade_sample_counts){{1, i}, {1, i}, {rays, (uint32_t)rays * i}}, &s);
        assert_true(shade_sample_finite(&s));
        for (int k = 0; k < SHADE_EMISSION; k++) {
            const double L = (double)rgb_luminance(s.layer[k]);
            out.layer[k] += L / samples;
            out.deviation[k] += L * L / samples;
        }
        // No light is from records.
        const rgb rest = rgb_sub(s.beauty, s.uncached);
        assert_true(fabsf(rgb_luminance(rest)) <= 1e-5f * rgb_luminance(s.beauty));
    }
    for (int k = 0; k < SHADE_EMISSION; k++)
        out.deviation[k] = sqrt(out.deviation[k] - out.layer[k] * out.layer[k]);
    shade_destroy(&shade);
    out.rays = (double)worker.counts.rays / samples;
    return out;
}

static void single_rays_have_the_mean_of_hemispheres(void **state) {
    (void)state;
    struct shade_two_pass_room room;
    shade_two_pass_make(&room, SHADE_TWO_PASS_POINT, -1, 0);
    // One ray per sample with a time limit, else eight.
    satin_options timed = room.options, off = room.options;
    timed.time = 1.0;
    const struct shade_two_pass_pixel single = shade_two_pass_pixel_of(&room, &timed, SAMPLES);
    assert_true(single.rays <= 1.0);
    const double rays = shade_two_pass_pixel_of(&room, &room.options, SAMPLES).rays;
    assert_true(rays > 7.5 && rays <= 8.0);
    off.irradiance_cache = off.radiance_cache = false;
    cache_tables_free(&room.tables);
    const struct shade_two_pass_pixel hemisphere = shade_two_pass_pixel_of(&room, &off, SAMPLES);
    assert_true(hemisphere.rays > 8.0);
    for (int i = SHADE_INDIRECT_DIFFUSE; i <= SHADE_INDIRECT_GLOSSY; i++) {
        print_message("%f by single rays, %f by hemispheres\n", single.layer[i],
                      hemisphere.layer[i]);
        // The noise of 16384 samples is .5 to 1 %.
        assert_true(hemisphere.layer[i] > 0.01 &&
                    fabs(single.layer[i] / hemisphere.layer[i] - 1.0) < 0.03);
    }
    destroy(&room);
}

// The light of a spot that few rays hit, reflected by the diffuse and by the glossy lobe.
static void rays_to_clusters_have_the_mean_and_less_noise(void **state) {
    (void)state;
    struct shade_two_pass_room room;
    shade_two_pass_make(&room, SHADE_TWO_PASS_SPOT, -1, 0);
    satin_options alone = room.options;
    alone.guide_clusters = false;
    const struct shade_two_pass_pixel with = shade_two_pass_pixel_of(&room, &room.options, SAMPLES);
    const struct shade_two_pass_pixel without = shade_two_pass_pixel_of(&room, &alone, SAMPLES);
    for (int i = SHADE_INDIRECT_DIFFUSE; i <= SHADE_INDIRECT_GLOSSY; i++) {
        const double noise = hypot(with.deviation[i], without.deviation[i]) / sqrt(SAMPLES);
        print_message("%f +- %f guided, %f +- %f by the lobes alone\n", with.layer[i],
                      with.deviation[i], without.layer[i], without.deviation[i]);
        assert_true(with.layer[i] > 0.001);
        // The seeds are fixed; four standard deviations.
        assert_true(fabs(with.layer[i] - without.layer[i]) < 4.0 * noise);
    }
    // The glossy lobe reflects little of the spot.
    assert_true(with.deviation[SHADE_INDIRECT_DIFFUSE] <
                0.5 * without.deviation[SHADE_INDIRECT_DIFFUSE]);
    assert_true(with.deviation[SHADE_INDIRECT_GLOSSY] <
                1.5 * without.deviation[SHADE_INDIRECT_GLOSSY]);
    destroy(&room);
}

// What a pixel without records shows of uncached light by path tracing, and its standard deviation.
static double shade_two_pass_path(const struct shade_two_pass_room *room, double *deviation) {
    satin_options o = room->options;
    o.integrator = SATIN_PATH;
    const struct gather g = gather_make(room->scene, &o, NULL);
    struct shade shade;
    assert_int_equal(shade_init(&shade, &g, cache_reader_make(NULL, &room->tables, &o),
                                render_budget_missing(&o, 0.0), room->pool),
                     SATIN_OK);
    struct shade_worker worker = {.gather = shade.worker[0]};
    shade_pixel_begin(&worker);
    double sum = 0.0, squares = 0.0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        struct shade_sample s;
        shade_pixel(&shade, &worker, 0, 1, i,
                    (struct shade_sample_counts){{1, i}, {1, i}, {8, 8 * i}}, &s);
        const double L = (double)rgb_luminance(s.uncached);
        sum += L / SAMPLES;
        squares += L * L / SAMPLES;
    }
    shade_destroy(&shade);
    *deviation = sqrt(squares - sum * sum);
    return sum;
}

// Sampled lobes show light through glass by caustic photons: with a longest path of three segments,
// that is all that path tracing finds by chance, and without its noise. The estimates of one map
// have a standard deviation of 6 %.
static void sampled_lobes_read_caustic_photons(void **state) {
    enum { MAPS = 8 };
    double found = 0.0, expected = 0.0, deviation = 0.0;
    (void)state;
    for (uint64_t seed = 1; seed <= MAPS; seed++) {
        struct shade_two_pass_room room;
        shade_two_pass_make(&room, SHADE_TWO_PASS_BULB, 3, seed);
        cache_tables_free(&room.tables);
        if (seed == 1) expected = shade_two_pass_path(&room, &deviation);
        const struct shade_two_pass_pixel pixel =
            shade_two_pass_pixel_of(&room, &room.options, SAMPLES / MAPS);
        found += pixel.layer[SHADE_CAUSTIC] / MAPS;
        assert_true(pixel.deviation[SHADE_CAUSTIC] < 0.5 * deviation);
        destroy(&room);
    }
    print_message("%f by photons, %f by paths\n", found, expected);
    assert_true(fabs(found / expected - 1.0) < 0.05);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(single_rays_have_the_mean_of_hemispheres),
        cmocka_unit_test(rays_to_clusters_have_the_mean_and_less_noise),
        cmocka_unit_test(sampled_lobes_read_caustic_photons),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
