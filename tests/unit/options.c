// SPDX-License-Identifier: Apache-2.0
// Options: presets, setting by name, messages, the order of the layers.
#include "satin/options.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "message_case.h"
#include "render/options_quality.h"
#include "render/options_table.h"
#include "scene/scene.h"

static bool same_fields(const satin_options *a, const satin_options *b) {
    satin_option_info ia, ib;
    for (int i = 0; satin_options_describe(a, i, &ia); i++) {
        assert_true(satin_options_describe(b, i, &ib));
        if (strcmp(ia.value, ib.value) != 0) return false;
    }
    return true;
}

static void limits_of_arrays_are_those_of_options(void **state) {
    (void)state;
    assert_true(option_highest(options_find("glossy-samples")) == SATIN_GLOSSY_SAMPLES_MAX);
    assert_true(option_highest(options_find("recursive-bounces")) == SATIN_RECURSIVE_BOUNCES_MAX);
}

static void presets_set_what_they_decide(void **state) {
    (void)state;
    satin_options o = satin_options_default;
    satin_options_preset(&o, SATIN_PREVIEW);
    assert_true(same_fields(&o, &satin_options_default));
    o.photon_k = 77;
    satin_options_preset(&o, SATIN_DRAFT);
    assert_int_equal(o.photons, 100000);
    assert_int_equal(o.photon_k, 77);
    assert_int_equal(o.quality, SATIN_DRAFT);
    satin_options_preset(&o, SATIN_PRODUCTION);
    assert_int_equal(o.photons, 1200000);
    assert_int_equal(o.radiance_order, 14);
    assert_int_equal(options_quality_spp(SATIN_DRAFT), 9);
}

// A struct that was zeroed, or in which only some fields were set, renders as the defaults do.
static void presets_fill_zeroed_structs(void **state) {
    (void)state;
    satin_options o = {0}, wanted = satin_options_default;
    satin_options_preset(&o, SATIN_DRAFT);
    satin_options_preset(&wanted, SATIN_DRAFT);
    assert_int_equal(o.max_depth, -2);
    assert_true(same_fields(&o, &wanted));
    // A preset of options that are complete changes nothing else, even where they are 0.
    o.max_depth = 0;
    o.leak_test = false;
    satin_options_preset(&o, SATIN_PRODUCTION);
    assert_int_equal(o.max_depth, 0);
    assert_false(o.leak_test);
    satin_options some = {.spp = 7, .seed = UINT64_MAX, .max_depth = 3};
    satin_options_preset(&some, SATIN_PRODUCTION);
    assert_int_equal(some.spp, 7);
    assert_int_equal(some.max_depth, 3);
    assert_true(some.seed == UINT64_MAX && some.leak_test);
    assert_int_equal(some.hide_emitters, -1);
    assert_int_equal(some.photons, 1200000);
}

// Every default and preset is inside its own range: its text parses to the same value.
static void presets_are_in_range(void **state) {
    (void)state;
    for (int q = SATIN_DRAFT; q <= SATIN_PRODUCTION; q++) {
        satin_options o = satin_options_default, back = {0};
        satin_options_preset(&o, (satin_quality)q);
        satin_option_info info;
        for (int i = 0; satin_options_describe(&o, i, &info); i++)
            assert_true(option_parse(&options_table[i], info.value, &back));
        assert_true(same_fields(&o, &back));
    }
}

static void structs_are_checked(void **state) {
    (void)state;
    struct message message = {0};
    const struct log log = {keep, &message};
    satin_options o = {.spp = 16, .max_depth = 5};
    assert_int_equal(options_check(&o, log), SATIN_ERROR_INPUT);
    assert_int_equal(message.count, 1);
    assert_non_null(strstr(message.text, "satin_options_preset"));
    for (int q = SATIN_DRAFT; q <= SATIN_PRODUCTION; q++) {
        satin_options_preset(&o, (satin_quality)q);
        assert_int_equal(options_check(&o, log), SATIN_OK);
    }
    assert_int_equal(o.max_depth, 5);
    satin_options bad[9];
    for (int i = 0; i < 9; i++) bad[i] = satin_options_default;
    bad[0].spp = -1;
    bad[1].light_samples = 0;
    bad[2].irradiance_a = NAN;
    bad[3].time = INFINITY;
    bad[4].memory = -1;
    bad[5].photons = INT64_MAX;
    bad[6].integrator = (satin_integrator)(SATIN_SPPM + 1);
    bad[7].radiance_radius = SATIN_RADIUS_HESSIAN;
    memset(bad[8].layers, 'a', sizeof bad[8].layers);
    for (int i = 0; i < 9; i++) {
        message.count = 0;
        assert_int_equal(options_check(&bad[i], log), SATIN_ERROR_INPUT);
        assert_int_equal(message.count, 1);
    }
    assert_non_null(strstr(message.text, "option layers: 'aaa"));
    const int below = -1;
    o = satin_options_default;
    memcpy(&o.quality, &below, sizeof below);
    assert_int_equal(options_check(&o, log), SATIN_ERROR_INPUT);
    assert_string_equal(message.text, "option quality: '-1' is not in draft|preview|production");
    // The ends of ranges, also of those that a float does not have exactly.
    o = satin_options_default;
    o.radiance_error = 0.0001f;
    o.irradiance_a = 0.01f;
    o.spp = 1 << 20;
    assert_int_equal(options_check(&o, log), SATIN_OK);
}

static void values_are_checked(void **state) {
    (void)state;
    static const char *const bad[][2] = {
        {"spp", "-1"},
        {"spp", "1.5"},
        {"spp", ""},
        {"spp", "1048577"},
        {"spp", "12x"},
        {"seed", "-1"},
        {"seed", "1e3"},
        {"seed", "18446744073709551616"},
        {"photons", "1e13"},
        {"photons", "inf"},
        {"irradiance-a", "nan"},
        {"irradiance_a", "0"},
        {"integrator", "paths"},
        {"gather-near", "maybe"},
        {"hide-emitters", "2"},
        {"radiance-order", "15"},
        {"time", "-1"},
        {"memory", "much"},
        {"memory", "4X"},
        {"memory", "-4G"},
        {"memory", "4GG"},
        {"memory", "G"},
        {"memory", "4iB"},
        {"memory", "2P"},
        {"material-cache", "floor=maybe"},
        {"material-cache", "=on"},
        {"material.floor.cache", "1"},
        {"material..cache", "on"},
    };
    satin_options o = satin_options_default;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct message message = {0};
        assert_int_equal(satin_options_set(&o, bad[i][0], bad[i][1], keep, &message),
                         SATIN_ERROR_INPUT);
        assert_int_equal(message.count, 1);
        assert_true(same_fields(&o, &satin_options_default));
    }
    assert_int_equal(satin_options_set(&o, "photons", "2.5e6", NULL, NULL), SATIN_OK);
    assert_int_equal(o.photons, 2500000);
    assert_int_equal(satin_options_set(&o, "seed", "18446744073709551615", NULL, NULL), SATIN_OK);
    assert_true(o.seed == UINT64_MAX);
    assert_int_equal(satin_options_set(&o, "first_pass", "none", NULL, NULL), SATIN_OK);
    assert_int_equal(o.first_pass, SATIN_FIRST_NONE);
    assert_int_equal(satin_options_set(&o, "radiance_cache", "false", NULL, NULL), SATIN_OK);
    assert_false(o.radiance_cache);
    assert_int_equal(satin_options_set(&o, "material.floor.cache", "on", NULL, NULL), SATIN_OK);
    assert_int_equal(satin_options_set(&o, "material.a.b.cache", "off", NULL, NULL), SATIN_OK);
    assert_string_equal(o.material_cache, "a.b=off,floor=on");
    assert_int_equal(satin_options_set(&o, "max-depth", "-1", NULL, NULL), SATIN_OK);
    assert_int_equal(o.max_depth, -1);
}

static void bytes_have_units(void **state) {
    (void)state;
    satin_options o = satin_options_default;
    static const struct {
        const char *text, *printed;
        int64_t bytes;
    } sizes[] = {{"4G", "4G", 4ll << 30},       {"1.5MiB", "1536K", 3ll << 19},
                 {"700", "700", 700},           {"2kB", "2K", 2ll << 10},
                 {"0.5T", "512G", 1ll << 39},   {"0", "0", 0},
                 {"1048576B", "1M", 1ll << 20}, {"0.0001", "1", 1}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        char text[OPTION_TEXT_SIZE];
        assert_int_equal(satin_options_set(&o, "memory", sizes[i].text, NULL, NULL), SATIN_OK);
        assert_true(o.memory == sizes[i].bytes);
        option_print(options_find("memory"), &o, text, sizeof text);
        assert_string_equal(text, sizes[i].printed);
    }
}

static void messages_suggest_a_correction(void **state) {
    (void)state;
    satin_options o = satin_options_default;
    struct message message = {0};
    satin_options_set(&o, "photon", "3", keep, &message);
    assert_string_equal(message.text, "unknown option 'photon' (did you mean 'photons'?)");
    satin_options_set(&o, "whatever-it-is", "3", keep, &message);
    assert_string_equal(message.text, "unknown option 'whatever-it-is'");
    satin_options_set(&o, "radiance_order", "15", keep, &message);
    assert_string_equal(message.text, "option radiance-order: '15' is not in 1..14");
}

// An option that had another name is refused with the name that it has, by every spelling; the new
// name is one of the table, the earlier one is not.
static void renamed_options_are_named(void **state) {
    (void)state;
    static const char *const before[] = {
        "adaptive",      "gather-bounce",        "gather-guide",  "gather-shadow",
        "light-guide",   "radiance-neighbours",  "radiance-turn", "recursive-levels",
        "radiance_turn", "irradiance-neighbours"};
    satin_options o = satin_options_default;
    struct message message = {0};
    for (size_t i = 0; i < sizeof before / sizeof *before; i++) {
        const char *now = options_renamed(before[i]);
        assert_non_null(now);
        assert_non_null(options_find(now));
        assert_null(options_find(before[i]));
        assert_int_equal(satin_options_set(&o, before[i], "1", keep, &message), SATIN_ERROR_INPUT);
        assert_non_null(strstr(message.text, now));
        assert_true(same_fields(&o, &satin_options_default));
    }
    assert_string_equal(
        message.text, "option 'irradiance-neighbours' is now called 'irradiance-neighbour-clamp'");
    for (int i = 0; i < options_table_count; i++)
        assert_null(options_renamed(options_table[i].name));
}

// Every field of the struct has a row: setting all rows changes every byte that padding leaves.
static void table_covers_the_struct(void **state) {
    (void)state;
    size_t covered = 0;
    static const size_t size[] = {
        [OPTION_CHOICE] = sizeof(int),    [OPTION_BOOL] = sizeof(bool),
        [OPTION_INT] = sizeof(int),       [OPTION_COUNT] = sizeof(int64_t),
        [OPTION_BYTES] = sizeof(int64_t), [OPTION_SEED] = 8,
        [OPTION_FLOAT] = sizeof(float),   [OPTION_DOUBLE] = sizeof(double),
        [OPTION_TEXT] = OPTION_TEXT_SIZE};
    size_t end = 0;
    for (int i = 0; i < options_table_count; i++) {
        const struct option *o = &options_table[i];
        assert_true(o->doc[strlen(o->doc) - 1] == '.');
        size_t align = o->kind == OPTION_TEXT ? 1 : size[o->kind], padding = o->offset - end;
        covered += size[o->kind];
        // Rows stand in the order of the fields, so that a forgotten field leaves a gap.
        if (o->offset >= end && end > 0) assert_true(padding < align);
        if (o->offset + size[o->kind] > end) end = o->offset + size[o->kind];
    }
    assert_true(sizeof(satin_options) - end < 8);
    // Up to three bytes behind each of ten runs of flags, and the end's alignment.
    assert_true(sizeof(satin_options) - covered < 38);
}

static void settings_replace_those_before_them(void **state) {
    (void)state;
    struct scene_option option[] = {{"irradiance_a", "0.11", {"a.xml", 3, 5}},
                                    {"quality", "production", {"a.xml", 4, 5}},
                                    {"spp", "5", {"a.xml", 5, 5}}};
    struct satin_scene scene = {.hints = {.option = option, .option_count = 3}};
    satin_options o;
    assert_int_equal(satin_options_resolve(&scene, NULL, 0, NULL, NULL, &o), SATIN_OK);
    assert_int_equal(o.quality, SATIN_PRODUCTION);
    assert_true(o.irradiance_a == 0.11f);
    const satin_setting user[] = {{"spp", "7"}, {"quality", "draft"}};
    assert_int_equal(satin_options_resolve(&scene, user, 2, NULL, NULL, &o), SATIN_OK);
    assert_int_equal(o.quality, SATIN_DRAFT);
    assert_int_equal(o.photons, 100000);
    assert_true(o.irradiance_a == 0.11f);
    assert_int_equal(o.spp, 7);
    const satin_setting wrong[] = {{"spp", "7"}, {"photon_k", "0"}};
    satin_options before = o;
    assert_int_equal(satin_options_resolve(NULL, wrong, 2, NULL, NULL, &o), SATIN_ERROR_INPUT);
    assert_true(same_fields(&o, &before));
    struct message message = {0};
    option[2].value = "many";
    assert_int_equal(satin_options_resolve(&scene, user, 2, keep, &message, &o), SATIN_ERROR_INPUT);
    assert_int_equal(message.count, 1);
    assert_string_equal(message.text, "a.xml:5:5: option spp: 'many' is not in 0..1048576");
    assert_true(same_fields(&o, &before));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(limits_of_arrays_are_those_of_options),
        cmocka_unit_test(presets_set_what_they_decide),
        cmocka_unit_test(presets_fill_zeroed_structs),
        cmocka_unit_test(presets_are_in_range),
        cmocka_unit_test(structs_are_checked),
        cmocka_unit_test(values_are_checked),
        cmocka_unit_test(bytes_have_units),
        cmocka_unit_test(messages_suggest_a_correction),
        cmocka_unit_test(renamed_options_are_named),
        cmocka_unit_test(table_covers_the_struct),
        cmocka_unit_test(settings_replace_those_before_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
