// SPDX-License-Identifier: Apache-2.0
// Classes of photons behind glass: light that passes panes is direct, light that is refracted or
// reflected on its path is a caustic, and light that frosted glass scatters is indirect. Paths
// after the first 2^32 do not repeat those before.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "photon/photon_path.h"
#include "test_scene.h"

enum photon_trace_glass { NOTHING, PANE, TWO_PANES, THIN, BALL, FROSTED };

struct photon_trace_power {
    double of[PHOTON_CLASSES];
};

// The power of the photons of each class on a floor of half-width 1, under glass, in light that
// comes straight down with an irradiance of 1.
static struct photon_trace_power on_floor(enum photon_trace_glass glass) {
    struct test_scene t;
    test_scene_init(&t);
    const uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f);
    const char *model = glass == FROSTED ? "roughdielectric"
                        : glass == THIN  ? "thindielectric"
                                         : "dielectric";
    const uint32_t what = test_material(&t, model, rgb_grey(0.0f), rgb_grey(1.0f));
    test_rectangle(&t, mat4_identity(), grey);
    if (glass == THIN) test_rectangle(&t, test_transform(v3(0, 0, 1), v3(2, 2, 1)), what);
    const int plates = glass == TWO_PANES ? 2 : glass == PANE || glass == FROSTED;
    for (int i = 0; i < plates; i++)
        test_cube(&t, test_transform(v3(0, 0, 1.0f + 0.1f * (float)i), v3(2, 2, 0.01f)), false,
                  what);
    if (glass == BALL)
        test_quadric(&t, SHAPE_SPHERE, test_transform(v3(0, 0, 1), v3(2, 2, 2)), false, what);
    test_light(&t,
               (struct light){
                   .kind = LIGHT_DIRECTIONAL, .value = rgb_grey(1.0f), .direction = v3(0, 0, -1)});
    test_scene_finish(&t);
    struct parallel *pool = parallel_new(1);
    assert_non_null(pool);
    struct photon_trace_power power;
    for (int class = 0; class < PHOTON_CLASSES; class ++) {
        const struct photon_tracing tracing = {.scene = &t.scene,
                                               .seed = 1,
                                               .consumer = {{1 << 17, 1u << class, NULL}},
                                               .bounces = 64};
        struct photon_trace trace[PHOTON_CONSUMERS] = {{0}};
        assert_int_equal(photon_trace_run(&tracing, pool, (struct log){0}, trace), SATIN_OK);
        power.of[class] = 0.0;
        for (size_t k = 0; k < trace[0].count; k++)
            if (fabsf(trace[0].hit[k].p.z) < 0.01f)
                power.of[class] += (double)trace[0].hit[k].power.g;
        for (int k = 0; k < PHOTON_CONSUMERS; k++) photon_trace_free(&trace[k]);
    }
    parallel_free(pool);
    test_scene_free(&t);
    return power;
}

static void panes_keep_light_direct(void **state) {
    (void)state;
    // At an interface .04 is reflected. With all internal reflections, 2 n interfaces transmit
    // .96 / (.96 + 2 n .04), of which .96^2n without any; thin sheets count them as one.
    static const struct {
        enum photon_trace_glass glass;
        double direct, caustic;
    } c[] = {{NOTHING, 1.0, 0.0},
             {PANE, 0.96 * 0.96, 0.96 / 1.04 - 0.96 * 0.96},
             {TWO_PANES, 0.96 * 0.96 * 0.96 * 0.96, 0.96 / 1.12 - 0.96 * 0.96 * 0.96 * 0.96},
             {THIN, 0.96 / 1.04, 0.0}};
    for (size_t i = 0; i < sizeof c / sizeof *c; i++) {
        const struct photon_trace_power power = on_floor(c[i].glass);
        // The floor is 4 large; about 20,000 of the paths go there: .26 % of noise at most.
        print_message("glass %d: direct %.4f caustic %.5f\n", (int)c[i].glass,
                      power.of[PHOTON_DIRECT] / 4.0, power.of[PHOTON_CAUSTIC] / 4.0);
        assert_true(fabs(power.of[PHOTON_DIRECT] / 4.0 - c[i].direct) < 0.01);
        assert_true(fabs(power.of[PHOTON_CAUSTIC] / 4.0 - c[i].caustic) < 0.003);
    }
}

static void lenses_make_caustics(void **state) {
    (void)state;
    const struct photon_trace_power power = on_floor(BALL);
    assert_true(power.of[PHOTON_DIRECT] == 0.0);
    assert_true(power.of[PHOTON_CAUSTIC] > 4.0);  // it is focused on the floor
}

static void frosted_glass_scatters(void **state) {
    (void)state;
    const struct photon_trace_power power = on_floor(FROSTED);
    assert_true(power.of[PHOTON_DIRECT] == 0.0 && power.of[PHOTON_CAUSTIC] == 0.0);
    assert_true(power.of[PHOTON_INDIRECT] > 1.0);
}

enum { STARTS = 4096 };

static int compare_starts(const void *a, const void *b) { return memcmp(a, b, 4 * sizeof(float)); }

// Sets u to the starts of the paths from `first` on, and sorts them.
static void sort_starts(const struct photon_tracing *tracing, uint32_t light, uint64_t first,
                        float u[STARTS][4]) {
    for (uint64_t i = 0; i < STARTS; i++) photon_start_numbers(tracing, light, first + i, u[i]);
    qsort(u, STARTS, sizeof *u, compare_starts);
}

static int count_common(float a[STARTS][4], float b[STARTS][4]) {
    int common = 0;
    for (int i = 0; i < STARTS; i++)
        common += bsearch(a[i], b, STARTS, sizeof *b, compare_starts) != NULL;
    return common;
}

// Paths after the first 2^32 of a light do not repeat earlier ones, nor those of other lights, and
// are stratified as they are: each 4096th of each number has one of 4096 paths.
static void paths_beyond_32_bits_are_new(void **state) {
    (void)state;
    static const uint64_t first[] = {1ull << 32, 1ull << 33, 5ull << 32, 1ull << 40};
    static float early[STARTS][4], late[STARTS][4];
    const struct photon_tracing tracing = {.seed = 1};
    sort_starts(&tracing, 0, 0, early);
    assert_int_equal(count_common(early, early), STARTS);
    for (size_t k = 0; k < sizeof first / sizeof *first; k++) {
        sort_starts(&tracing, 0, first[k], late);
        assert_int_equal(count_common(late, early), 0);
        for (int d = 0; d < 4; d++) {
            static bool met[STARTS];
            memset(met, 0, sizeof met);
            for (int i = 0; i < STARTS; i++) {
                const int at = (int)(late[i][d] * STARTS);
                assert_true(at >= 0 && at < STARTS && !met[at]);
                met[at] = true;
            }
        }
    }
    sort_starts(&tracing, 1, 0, late);
    assert_int_equal(count_common(late, early), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(panes_keep_light_direct),
        cmocka_unit_test(lenses_make_caustics),
        cmocka_unit_test(frosted_glass_scatters),
        cmocka_unit_test(paths_beyond_32_bits_are_new),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
