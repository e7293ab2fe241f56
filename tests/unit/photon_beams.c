// SPDX-License-Identifier: Apache-2.0
// Beams of indirect light: found where photons arrive from a narrow cone, with its axis and width,
// and not where they arrive from everywhere, or are of caustics.
#include <math.h>

#include "beam_shower.h"

enum { POINTS = 200 };

static const vec3 UP = {0.0f, 0.0f, 1.0f};

static vec3 position_of(uint32_t i) {
    const vec2 u = sample_sobol2(i, 3);
    return v3(0.8f * (u.x - 0.5f), 0.8f * (u.y - 0.5f), 0.0f);
}

// In 64 photons, a fraction of .4 is 26, with a standard deviation of 4.
static void a_beam_is_found(void **state) {
    (void)state;
    const struct beam_shower shower = {v3_unit(v3(0.6f, -0.2f, 1.0f)), 0.4f, true};
    struct photon_maps maps = {0};
    beam_shower_build(&shower, &maps);
    double fraction = 0.0;
    for (uint32_t i = 0; i < POINTS; i++) {
        struct photon_beam beam[PHOTON_BEAMS];
        assert_true(photon_beams(&maps, position_of(i), UP, beam) > 0);
        const float width = sqrtf(2.0f * beam[0].versine);
        assert_true(v3_dist2(beam[0].axis, shower.axis) < sqrf(0.5f * BEAM_SHOWER_HALF_ANGLE));
        assert_true(width > 0.8f * BEAM_SHOWER_HALF_ANGLE && width < 2.0f * BEAM_SHOWER_HALF_ANGLE);
        fraction += (double)beam[0].fraction / POINTS;
        assert_int_equal(photon_beams(&maps, position_of(i), v3_neg(UP), beam), 0);
    }
    print_message("fraction %.3f\n", fraction);
    assert_true(fabs(fraction - 0.4) < 0.04);
    photon_map_free(&maps.global);
}

// What is found by chance has a small part of the light, and a wide cone.
static void even_light_has_no_beam(void **state) {
    (void)state;
    const struct beam_shower shower = {UP, 0.0f, true};
    struct photon_maps maps = {0};
    beam_shower_build(&shower, &maps);
    for (uint32_t i = 0; i < POINTS; i++) {
        struct photon_beam beam[PHOTON_BEAMS];
        const int count = photon_beams(&maps, position_of(i), UP, beam);
        for (int b = 0; b < count; b++)
            assert_true(beam[b].fraction < 0.25f && beam[b].versine > 0.005f);
    }
    photon_map_free(&maps.global);
}

// Gather rays do not carry the light of caustics.
static void caustics_are_no_beams(void **state) {
    (void)state;
    const struct beam_shower shower = {v3_unit(v3(0.6f, -0.2f, 1.0f)), 0.4f, false};
    struct photon_maps maps = {0};
    beam_shower_build(&shower, &maps);
    struct photon_beam beam[PHOTON_BEAMS];
    assert_int_equal(photon_beams(&maps, position_of(0), UP, beam), 0);
    photon_map_free(&maps.global);
    maps.global = (struct photon_map){0};
    assert_int_equal(photon_beams(&maps, position_of(0), UP, beam), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_beam_is_found),
        cmocka_unit_test(even_light_has_no_beam),
        cmocka_unit_test(caustics_are_no_beams),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
