// SPDX-License-Identifier: Apache-2.0
// The channels that `aov` integrators request, and one message for each that does not exist.
#include "scene/scene.h"
#include "scene_case.h"

#define AOV(pairs) \
    SCENE_TEXT("<integrator type='aov'><string name='aovs' value='" pairs "'/></integrator>")

static void channels_have_the_names_of_the_scene(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(&c, AOV("dd.y:depth,nn:sh_normal  i:shape_index,d:depth"));
    assert_non_null(scene);
    assert_int_equal(c.warnings, 0);
    const struct scene_aovs *aovs = &scene->hints.aovs;
    const char *const name[] = {"dd.y.T", "nn.X", "nn.Y", "nn.Z", "i.I", "d.T"};
    const int value[] = {0, 1, 2, 3, 4, 0};
    assert_int_equal(aovs->count, 6);
    assert_int_equal(aovs->values, 5);
    for (int i = 0; i < aovs->count; i++) {
        assert_string_equal(aovs->channel[i].name, name[i]);
        assert_int_equal(aovs->channel[i].value, value[i]);
    }
    assert_int_equal(aovs->first[AOV_SH_NORMAL], 1);
    assert_int_equal(aovs->first[AOV_UV], -1);
    assert_false(aovs->partials);
    satin_scene_free(scene);
}

static void every_kind_of_aov_is_held(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c, AOV("a:albedo,b:depth,c:position,d:uv,e:geo_normal,f:sh_normal,g:dp_du,h:dp_dv,"
                "i:duv_dx,j:duv_dy,k:prim_index,l:shape_index"));
    assert_non_null(scene);
    assert_int_equal(scene->hints.aovs.values, AOV_VALUES - 3);
    assert_int_equal(scene->hints.aovs.count, AOV_VALUES - 3);
    assert_true(scene->hints.aovs.partials);
    satin_scene_free(scene);
}

static void options_of_aovs_are_held(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c, SCENE_TEXT("<integrator type='aov'><string name='aovs' value='a:uv'/><integrator "
                       "type='satin'><integer name='photons' value='7'/></integrator>"
                       "</integrator>"));
    assert_non_null(scene);
    assert_int_equal(scene->hints.aovs.count, 2);
    assert_int_equal(scene->hints.option_count, 1);
    assert_string_equal(scene->hints.option[0].name, "photons");
    assert_string_equal(scene->hints.option[0].value, "7");
    satin_scene_free(scene);
}

// Named as Mitsuba 3.9.1 names them.
static void a_moment_has_the_squares_of_its_channels(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c, SCENE_TEXT("<integrator type='moment'><integrator type='aov' name='in'><string "
                       "name='aovs' value='q:uv'/></integrator></integrator>"));
    assert_non_null(scene);
    assert_int_equal(c.warnings, 0);
    const struct scene_aovs *aovs = &scene->hints.aovs;
    const char *const name[] = {"in.q.U",    "in.q.V",    "in.X",    "in.Y",    "in.Z",
                                "m2_in.q.U", "m2_in.q.V", "m2_in.X", "m2_in.Y", "m2_in.Z"};
    assert_true(aovs->moment && aovs->values == 5 && aovs->count == 10);
    for (int i = 0; i < aovs->count; i++) {
        assert_string_equal(aovs->channel[i].name, name[i]);
        assert_int_equal(aovs->channel[i].value, i % 5);
        assert_int_equal(aovs->channel[i].squared, i >= 5);
    }
    satin_scene_free(scene);
    // `aov` around another integrator has the name of its own; an integrator without a name has
    // Mitsuba's name for it.
    scene = scene_case_load(
        &c, SCENE_TEXT("<integrator type='aov'><string name='aovs' value='q:depth'/><integrator "
                       "type='moment'><integrator type='satin'/></integrator></integrator>"));
    assert_non_null(scene);
    assert_int_equal(scene->hints.aovs.count, 7);
    assert_string_equal(scene->hints.aovs.channel[3].name, "m2__arg_0.X");
    assert_string_equal(scene->hints.aovs.channel[6].name, "q.T");
    satin_scene_free(scene);
}

static void unsupported_aovs_are_refused_by_name(void **state) {
    (void)state;
    static const struct {
        const char *text, *error;
    } bad[] = {
        {AOV("depth"), "scene.xml:3:24: aovs: 'depth' is not a pair name:type"},
        {AOV("a:"), "scene.xml:3:24: aovs: 'a:' is not a pair name:type"},
        {AOV(":depth"), "scene.xml:3:24: aovs: ':depth' is not a pair name:type"},
        {AOV("a:b:depth"), "scene.xml:3:24: aovs: 'a:b:depth' is not a pair name:type"},
        {AOV("a:dept"), "scene.xml:3:24: aovs: unknown type 'dept' (did you mean 'depth'?)"},
        {AOV("a:boundary_test"), "scene.xml:3:24: aovs: type 'boundary_test' is not supported"},
        {AOV("a:depth,a:depth"), "scene.xml:3:24: aovs: channel 'a.T' is given twice"},
        {AOV("a:position,a:sh_normal"), "scene.xml:3:24: aovs: channel 'a.X' is given twice"},
        {SCENE_TEXT("<integrator type='aov'/>"),
         "scene.xml:3:1: integrator 'aov' needs the parameter 'aovs'"},
        {SCENE_TEXT("<integrator type='aov'><string name='aovs' value='a:uv'/><integrator "
                    "type='aov'><string name='aovs' value='b:uv'/></integrator></integrator>"),
         "scene.xml:3:24: the scene has another integrator 'aov'"},
        {SCENE_TEXT("<integrator type='moment'><integrator type='moment'>"
                    "<integrator type='path'/></integrator></integrator>"),
         "scene.xml:3:27: the scene has another integrator 'moment'"},
        {SCENE_TEXT("<integrator type='moment'><integrator type='aov' name='a'><string name='aovs' "
                    "value='m:depth'/></integrator><integrator type='path'/></integrator>"),
         "scene.xml:3:109: integrator 'moment': it takes one integrator"},
        {SCENE_TEXT("<integrator type='aov'><string name='aovs' value='a:uv'/>"
                    "<integrator type='path'/><integrator type='direct'/></integrator>"),
         "scene.xml:3:83: integrator 'aov': it takes one integrator"},
        {SCENE_TEXT("<integrator type='aov' id='i'><string name='aovs' value='a:uv'/>"
                    "<ref id='i'/></integrator>"),
         "scene.xml:3:65: integrators are nested too deep"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct scene_case c;
        assert_null(scene_case_load(&c, bad[i].text));
        assert_string_equal(c.error, bad[i].error);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(channels_have_the_names_of_the_scene),
        cmocka_unit_test(every_kind_of_aov_is_held),
        cmocka_unit_test(options_of_aovs_are_held),
        cmocka_unit_test(a_moment_has_the_squares_of_its_channels),
        cmocka_unit_test(unsupported_aovs_are_refused_by_name),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
