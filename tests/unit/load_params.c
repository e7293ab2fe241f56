// SPDX-License-Identifier: Apache-2.0
// Typed parameters: every kind is read and refused as its table says; the tables describe
// themselves completely.
#include "load/load_params.h"

#include "base/fileio.h"
#include "brdf/brdf.h"
#include "load/load.h"
#include "scene_case.h"

static const char *const colours[] = {"red", "green", NULL};
static const struct param_spec flag = {"flag", PARAM_BOOLEAN, "true", 0, 0, NULL, ""};
static const struct param_spec load_params_count = {"count", PARAM_INTEGER, "7", RANGE_POSITIVE,
                                                    0,       NULL,          ""};
static const struct param_spec size = {"size", PARAM_FLOAT, ".5", RANGE_UNIT, 0, NULL, ""};
static const struct param_spec text = {"text", PARAM_STRING, "t", 0, 0, NULL, ""};
static const struct param_spec load_params_choice = {"choice", PARAM_CHOICE, "green", 0,
                                                     0,        colours,      ""};
static const struct param_spec load_params_point = {"point", PARAM_POINT, "1 2 3", 0, 0, NULL, ""};
static const struct param_spec load_params_colour = {"colour",      PARAM_COLOR, ".25", RANGE_UNIT,
                                                     PARAM_TEXTURE, NULL,        ""};
static const struct param_spec fraction = {"fraction",    PARAM_FLOAT, ".5", RANGE_UNIT,
                                           PARAM_TEXTURE, NULL,        ""};
static const struct param_spec load_params_texel = {"texel",       PARAM_COLOR, ".5", RANGE_TEXEL,
                                                    PARAM_TEXTURE, NULL,        ""};
static const struct param_spec load_params_light = {"light", PARAM_LIGHT, NULL, RANGE_NOT_NEGATIVE,
                                                    0,       NULL,        ""};
static const struct param_spec ior = {"ior", PARAM_IOR, "bk7", RANGE_POSITIVE, 0, NULL, ""};
static const struct param_spec must = {"must", PARAM_FLOAT, NULL, 0, PARAM_REQUIRED, NULL, ""};
static const struct param_spec *const specs[] = {&flag,
                                                 &load_params_count,
                                                 &size,
                                                 &text,
                                                 &load_params_choice,
                                                 &load_params_point,
                                                 &load_params_colour,
                                                 &fraction,
                                                 &load_params_texel,
                                                 &load_params_light,
                                                 &ior,
                                                 &must,
                                                 NULL};
static const struct plugin_spec plugin = {XML_BSDF, "test", "", specs, 1u << XML_BSDF, NULL, false};

static satin_status read_params(struct scene_case *c, const char *body, struct load_xml *xml,
                                struct params *out) {
    char file[2048];
    snprintf(file, sizeof file,
             "<scene version='3.0.0'><texture type='x' id='t'/><rgb id='common' value='.1 .2 "
             ".3'/><bsdf "
             "type='test'>\n%s</bsdf>"
             "</scene>",
             body);
    scene_case_file("scene.xml", file);
    uint64_t hash = FILEIO_HASH;
    struct log log = scene_case_begin(c);
    assert_int_equal(load_xml_read(log, log, "scene.xml", &(satin_scene_request){0}, &hash, xml),
                     SATIN_OK);
    return load_params_read((struct param_source){.log = log, .xml = xml}, &plugin, xml->root->last,
                            out);
}

#define MUST "<float name='must' value='0'/>"

// Reads the parameters of an element that has `more` beside that.
static satin_status read_besides(struct scene_case *c, const char *more, struct load_xml *xml,
                                 struct params *p) {
    char body[512];
    snprintf(body, sizeof body, MUST "%s", more);
    return read_params(c, body, xml, p);
}

static void missing_parameters_have_their_defaults(void **state) {
    (void)state;
    struct scene_case c;
    struct load_xml xml;
    struct params p;
    assert_int_equal(read_params(&c, MUST, &xml, &p), SATIN_OK);
    assert_true(load_param(&p, "flag")->b && load_param(&p, "count")->i == 7);
    assert_true(load_param(&p, "size")->f == 0.5f && load_param(&p, "choice")->i == 1);
    assert_string_equal(load_param(&p, "text")->s, "t");
    assert_true(load_param(&p, "point")->v.z == 3 && load_param(&p, "colour")->color.g == 0.25f);
    assert_true(fabsf(load_param(&p, "ior")->f - 1.5046f) < 1e-6f);
    assert_false(load_param(&p, "light")->given);
    assert_true(load_param(&p, "must")->given);
    load_xml_free(&xml);
}

static void values_are_read(void **state) {
    (void)state;
    struct scene_case c;
    struct load_xml xml;
    struct params p;
    assert_int_equal(read_params(&c,
                                 MUST "<boolean name='flag' value='False'/>"
                                      "<integer name='count' value=' 12 '/>"
                                      "<integer name='size' value='1'/>"
                                      "<string name='choice' value='RED'/>"
                                      "<vector name='point' value='-1, 2e1 .5'/>"
                                      "<ref name='colour' id='t'/>"
                                      "<spectrum name='light' value='2'/>"
                                      "<string name='ior' value='Water'/><bsdf type='x'/>",
                                 &xml, &p),
                     SATIN_OK);
    assert_true(!load_param(&p, "flag")->b && load_param(&p, "count")->i == 12);
    assert_true(load_param(&p, "size")->f == 1.0f && load_param(&p, "choice")->i == 0);
    assert_true(load_param(&p, "point")->v.y == 20 && load_param(&p, "point")->v.z == 0.5f);
    assert_ptr_equal(load_param(&p, "colour")->texture, xml.root->child);
    assert_true(fabsf(rgb_luminance(load_param(&p, "light")->color) - 2.0f) < 1e-3f);
    assert_true(load_param(&p, "ior")->f == 1.333f);
    load_xml_free(&xml);
}

static void colours_are_read(void **state) {
    (void)state;
    static const struct {
        const char *text;
        rgb color;
    } cases[] = {{"<rgb name='colour' value='.5'/>", {.5f, .5f, .5f}},
                 {"<rgb name='colour' value='.1, .2 .3'/>", {.1f, .2f, .3f}},
                 {"<rgb name='colour' value='#ff8000'/>", {1, .21586050f, 0}},
                 {"<spectrum name='colour' value='.7'/>", {.7f, .7f, .7f}},
                 {"<ref name='colour' id='common'/>", {.1f, .2f, .3f}},
                 {"<spectrum name='colour' type='d65'/>", {1, 1, 1}},
                 {"<spectrum name='colour' type='uniform'><float name='value' value='.3'/>"
                  "</spectrum>",
                  {.3f, .3f, .3f}},
                 {"<spectrum name='colour' type='rgb'><rgb name='value' value='.1 .2 .3'/>"
                  "</spectrum>",
                  {.1f, .2f, .3f}},
                 // These spectra are written as Mitsuba 3.9 writes them.
                 {"<texture name='colour' type='d65'><float name='scale' value='.3'/></texture>",
                  {.3f, .3f, .3f}},
                 {"<texture name='colour' type='srgb'><vector name='color' x='.1' y='.2' z='.3'/>"
                  "</texture>",
                  {.1f, .2f, .3f}},
                 // The colours are what Mitsuba 3.9 makes of the same samples.
                 {"<spectrum name='colour' value='400:0.2, 500:0.5, 550:0.7,700:0.9'/>",
                  {.8484015f, .6581277f, .31988475f}},
                 {"<spectrum name='colour' type='irregular'>"
                  "<string name='wavelengths' value='400 500 550 700'/>"
                  "<string name='values' value='.2 .5 .7 .9'/></spectrum>",
                  {.8484015f, .6581277f, .31988475f}},
                 {"<float name='colour' value='1'/>", {1, 1, 1}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        struct load_xml xml;
        struct params p;
        assert_int_equal(read_besides(&c, cases[i].text, &xml, &p), SATIN_OK);
        rgb d = rgb_sub(load_param(&p, "colour")->color, cases[i].color);
        assert_true(fabsf(d.r) < 2e-6f && fabsf(d.g) < 2e-6f && fabsf(d.b) < 2e-6f);
        load_xml_free(&xml);
    }
}

// A parameter that may be textured may be a colour, which counts as its mean where a number is
// needed.
static void colours_count_as_their_mean(void **state) {
    (void)state;
    static const char *const cases[] = {
        "<rgb name='fraction' value='.5 .2 .9'/>", "<rgb name='fraction' value='.5333333'/>",
        "<spectrum name='fraction' value='.5333333'/>",
        "<texture name='fraction' type='uniform'><float name='value' value='.5333333'/></texture>"};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        struct load_xml xml;
        struct params p;
        assert_int_equal(read_besides(&c, cases[i], &xml, &p), SATIN_OK);
        assert_true(fabsf(load_param(&p, "fraction")->f - .5333333f) < 1e-6f);
        load_xml_free(&xml);
    }
}

// A colour of a texture is a colour; a number of it may be either.
static void the_value_of_a_texture_is_a_number_or_a_colour(void **state) {
    (void)state;
    static const struct {
        const char *text;
        float value;  // 0: refused
    } cases[] = {
        {"<float name='texel' value='15'/>", 15.0f},
        {"<spectrum name='texel' value='15'/>", 15.0f},
        {"<texture name='texel' type='uniform'><float name='value' value='15'/></texture>", 15.0f},
        {"<spectrum name='texel' value='400:15, 700:15'/>", 1.0f},
        {"<rgb name='texel' value='.5'/>", .5f},
        {"<rgb name='texel' value='15'/>", 0.0f},
        {"<texture name='texel' type='srgb'><rgb name='color' value='15'/></texture>", 0.0f},
        {"<float name='texel' value='-1'/>", 0.0f}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        struct load_xml xml;
        struct params p;
        satin_status status = read_besides(&c, cases[i].text, &xml, &p);
        assert_int_equal(status, cases[i].value > 0.0f ? SATIN_OK : SATIN_ERROR_INPUT);
        if (status == SATIN_OK) assert_true(load_param(&p, "texel")->color.g == cases[i].value);
        load_xml_free(&xml);
    }
}

static const char *const load_params_refusals[][2] = {
    {"<float name='sise' value='1'/>",
     "BRDF 'test' has no parameter 'sise' (did you mean 'size'?)"},
    {"<float name='size' value='1'/><float name='size' value='1'/>", "'size' is given twice"},
    {"<float name='count' value='1'/>", "'count' must be <integer>, not <float>"},
    {"<boolean name='colour' value='true'/>",
     "'colour' must be <integer>, <float>, <rgb> or <spectrum>, not <boolean>"},
    {"<integer name='count' value='1.0'/>", "count: '1.0' is not an integer, or too large"},
    {"<integer name='count' value='2147483648'/>",
     "count: '2147483648' is not an integer, or too large"},
    {"<integer name='count' value='0'/>", "count is 0, but must be positive"},
    {"<float name='size' value='1.5'/>", "size is 1.5, but must be in [0, 1]"},
    {"<rgb name='size' value='.5'/>", "'size' must be <integer> or <float>, not <rgb>"},
    {"<rgb name='fraction' value='1 1 2'/>", "fraction is 1.33333, but must be in [0, 1]"},
    {"<float name='size' value='1x'/>", "'1x' is not a number"},
    {"<float name='size' value='0x1'/>", "'0x1' is not a number"},
    {"<float name='size' value='inf'/>", "'inf' is not a number"},
    {"<float name='size' value='nan'/>", "'nan' is not a number"},
    {"<float name='size' value=''/>", "expected 1 number, found ''"},
    {"<boolean name='flag' value='1'/>", "flag: '1' is neither true nor false"},
    {"<string name='choice' value='geen'/>",
     "choice: unknown value 'geen' (did you mean 'green'?)"},
    {"<string name='ior' value='bk9'/>", "ior: unknown value 'bk9' (did you mean 'bk7'?)"},
    {"<float name='ior' value='-1'/>", "ior is -1, but must be positive"},
    {"<point name='point' x='1' z='2'/>", "<point> needs the attribute 'y'"},
    {"<rgb name='colour' value='1 1 2'/>", "colour is 2, but must be in [0, 1]"},
    {"<rgb name='colour' value='1 1'/>", "expected 3 numbers, found '1 1'"},
    {"<rgb name='colour' value='#12345g'/>", "'#12345g' is not a colour of the form #rrggbb"},
    {"<spectrum name='colour' value='400:1, 700'/>",
     "a spectrum is a list of pairs of wavelength and value, not '700'"},
    {"<spectrum name='colour' value='400:1, 400:2'/>", "wavelengths do not ascend at sample 1"},
    {"<spectrum name='colour'/>", "<spectrum> has either a value, a filename or a type"},
    {"<spectrum name='colour' filename='none.spd'/>",
     "cannot read 'none.spd': No such file or directory"},
    {"<spectrum name='colour' type='d56'/>", "unknown spectrum 'd56' (did you mean 'd65'?)"},
    {"<spectrum name='colour' type='blackbody'><float name='temperature' "
     "value='1'/></spectrum>",
     "a black body is light, not a reflectance"},
    {"<spectrum name='colour' type='regular'><string name='values' value='1'/>"
     "<float name='wavelength_min' value='1'/><float name='wavelength_max' value='2'/>"
     "</spectrum>",
     "a spectrum needs two values or more, one per wavelength"},
    {"<rgb value='1'/>", "<rgb> needs the attribute 'name'"},
    {"<rgb name='light' value='-1 0 0'/>", "light is -1, but must be 0 or more"},
    {"<texture name='light' type='x'/>", "light of BRDF 'test' cannot be textured"},
    {"<texture type='x'/>", "BRDF 'test' takes no <texture> without a name"},
    {"<texture name='color' type='x'/>",
     "BRDF 'test' has no parameter 'color' (did you mean 'colour'?)"},
    {"<shape type='cube'/>", "BRDF 'test' takes no <shape>; its place is <scene>"},
    {"<ref name='colour' id='s'/>", "reference to unknown id 's'"},
    {"<float name='size' value='1'/>", "BRDF 'test' needs the parameter 'must'"}};

static void bad_parameters_are_refused(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof load_params_refusals / sizeof *load_params_refusals; i++) {
        struct scene_case c;
        struct load_xml xml;
        struct params p;
        assert_int_equal(read_params(&c, load_params_refusals[i][0], &xml, &p), SATIN_ERROR_INPUT);
        assert_int_equal(strncmp(c.error, "scene.xml:", 10), 0);
        assert_string_equal(strstr(c.error, ": ") + 2, load_params_refusals[i][1]);
        assert_int_equal(c.errors, 1);
        load_xml_free(&xml);
    }
}

// A name far from every known one is a parameter of another renderer.
static void elements_of_others_are_skipped(void **state) {
    (void)state;
    static const char *const others[] = {"<float name='zzzzzzzz' value='1'/>",
                                         "<texture type='bitmap' name='zzzzzzzz'/>"};
    for (int i = 0; i < 2; i++) {
        struct scene_case c;
        struct load_xml xml;
        struct params p;
        assert_int_equal(read_besides(&c, others[i], &xml, &p), SATIN_OK);
        assert_int_equal(c.warnings, 1);
        assert_non_null(
            strstr(c.warning, ": BRDF 'test' has no parameter 'zzzzzzzz', which has no effect"));
        load_xml_free(&xml);
    }
}

// Every plugin describes itself and its parameters, and has defaults that can be read.
static void tables_of_plugins_are_complete(void **state) {
    (void)state;
    struct load_plugin_info info;
    int plugins = 0;
    for (; load_plugin_describe(plugins, &info); plugins++) {
        struct load_param_info p;
        assert_true(info.name[0] && info.doc[0] && info.element[0]);
        int params = 0;
        for (; load_param_describe(plugins, params, &p); params++) {
            assert_true(p.name[0] && p.doc[0] && p.kind[0]);
            assert_false(p.required && p.value);
        }
        assert_true(params <= PARAM_MAX);
    }
    assert_true(plugins > 30);
    assert_false(load_plugin_describe(-1, &info));
}

// A parameter may be textured exactly if its model allows it.
static void textures_fit_their_models(void **state) {
    (void)state;
    static const char *const slot_params[BRDF_SLOT_COUNT][3] = {
        {"reflectance", "diffuse_reflectance", "base_color"},
        {"specular_reflectance", NULL},
        {"specular_transmittance", NULL},
        {NULL},  // of coats
        {"eta", NULL},
        {"k", NULL},
        {NULL},
        {"alpha", "alpha_u", "roughness"},
        {"alpha", "alpha_v"},
        {"exponent", NULL},
        {"metallic", NULL},
        {"anisotropic", NULL},
        {"spec_trans", NULL},
        {"spec_tint", NULL},
        {"sheen", NULL},
        {"sheen_tint", NULL},
        {"flatness", NULL},
        {"clearcoat", NULL},
        {"clearcoat_gloss", NULL},
        {"diff_trans", NULL},
        {"eta", NULL}};
    for (const struct plugin_spec *b = load_bsdf_plugins; b->name; b++) {
        if (!b->build) continue;
        // A plugin of version 0.6, which is principledthin with other parameters.
        if (strcmp(b->name, "difftrans") == 0) continue;
        const struct brdf_model *model = brdf_find(b->name);
        assert_non_null(model);
        // Their roughness has no direction.
        const bool one =
            strcmp(b->name, "roughdiffuse") == 0 || strcmp(b->name, "roughplastic") == 0;
        for (int i = 0; i < BRDF_SLOT_COUNT; i++) {
            if (one && i == BRDF_SLOT_ALPHA_V) continue;
            bool textured = false;
            const enum param_kind kind = i < BRDF_SLOT_NUMBERS ? PARAM_COLOR : PARAM_FLOAT;
            for (int j = 0; b->params && b->params[j]; j++)
                for (int k = 0; k < 3; k++)
                    if (slot_params[i][k] && b->params[j]->kind == kind &&
                        strcmp(b->params[j]->name, slot_params[i][k]) == 0)
                        textured |= (b->params[j]->flags & PARAM_TEXTURE) != 0;
            assert_int_equal(textured, model->slots >> i & 1);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(missing_parameters_have_their_defaults),
        cmocka_unit_test(values_are_read),
        cmocka_unit_test(colours_count_as_their_mean),
        cmocka_unit_test(colours_are_read),
        cmocka_unit_test(the_value_of_a_texture_is_a_number_or_a_colour),
        cmocka_unit_test(bad_parameters_are_refused),
        cmocka_unit_test(elements_of_others_are_skipped),
        cmocka_unit_test(tables_of_plugins_are_complete),
        cmocka_unit_test(textures_fit_their_models),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
