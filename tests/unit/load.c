// SPDX-License-Identifier: Apache-2.0
// Loading whole scenes: what the elements become, and one line for every bad input.
#include "satin/scene.h"

#include "light/light.h"
#include "scene_case.h"

static satin_scene *test_load(const char *text) {
    struct scene_case c;
    satin_scene *scene = scene_case_load(&c, text);
    if (!scene) fail_msg("%s", c.error);
    return scene;
}

// A twosided material around another shows the front of that on both sides, also around a blend of
// such.
static void twosided_materials_nest(void **state) {
    (void)state;
    struct satin_scene *scene = test_load(SCENE_TEXT(
        "<shape type='disk'><bsdf type='twosided'><bsdf type='twosided'><bsdf type='plastic'/>"
        "<bsdf type='diffuse'/></bsdf></bsdf></shape>"
        "<shape type='disk'><bsdf type='twosided'><bsdf type='blendbsdf'>"
        "<float name='weight' value='.5'/><bsdf type='twosided'><bsdf type='plastic'/></bsdf>"
        "<bsdf type='diffuse'/></bsdf></bsdf></shape>"));
    const struct material *m = scene->material;
    assert_true(m->two_sided && m->front.base.model == brdf_find("plastic"));
    assert_ptr_equal(m->back.base.model, m->front.base.model);
    assert_true(m[1].two_sided && !m[1].back.component[1]->one_sided);
    satin_scene_free(scene);
}

// Masks and null materials nest in each other and in blends, on one side and on two. Fractions
// beyond [0, 1] are its ends.
static void masks_nest(void **state) {
    (void)state;
#define MASK "<bsdf type='mask'><float name='opacity' value='.6'/>"
#define BLEND "<bsdf type='blendbsdf'><float name='weight' value='.25'/>"
#define PLAIN "<bsdf type='diffuse'/>"
    struct satin_scene *scene =
        test_load(SCENE_TEXT(
            "<shape type='disk'>" MASK MASK PLAIN "</bsdf></bsdf></shape>"
            "<shape type='disk'>" BLEND MASK PLAIN "</bsdf>" PLAIN "</bsdf></shape>"
            "<shape type='disk'>" MASK BLEND PLAIN MASK "<bsdf type='twosided'>" PLAIN
            "</bsdf></bsdf></bsdf></bsdf></shape>"
            "<shape type='disk'>" BLEND PLAIN "<bsdf type='null'/></bsdf></shape>"
            "<shape type='disk'>" MASK BLEND "<bsdf type='null'/><bsdf type='null'/></bsdf></bsdf>"
            "</shape>"
            "<shape type='disk'>" BLEND PLAIN PLAIN "</bsdf></shape>"
            "<shape type='disk'><bsdf type='mask'><float name='opacity' value='1.5'/>" PLAIN
            "</bsdf></shape>"
            "<shape type='disk'><bsdf type='blendbsdf'>"
            "<float name='weight' value='-2'/><bsdf type='null'/>" PLAIN "</bsdf></shape>"));
    const float opacity[] = {.36f, .7f, .54f, .75f, 0.0f, 1.0f, 1.0f, 0.0f};
    const struct texture_lookup at = {.width = 0.0f};
    for (int i = 0; i < 8; i++) {
        const struct material *m = &scene->material[i];
        assert_true(fabsf(scene_opacity_material(m, &at) - opacity[i]) < 1e-6f);
        assert_int_equal(m->front.holes, i != 5);
        assert_int_equal(m->back.holes, m->front.holes);
        assert_int_equal(m->two_sided, i == 2);
    }
    assert_null(scene->material[4].front.component[0]);
    satin_scene_free(scene);
}

// Returns the colour of a texture averaged over a footprint of a quarter of the image, at its left.
static float averaged_red(const satin_scene *scene, uint32_t material) {
    const struct interaction s = {.shape = material,
                                  .material = material,
                                  .ng = {0, 0, 1},
                                  .frame = frame_from_normal(v3(0, 0, 1)),
                                  .uv = {0.25f, 0.5f},
                                  .footprint = 1.0f,
                                  .uv_rate = 1.0f,
                                  .light = -1};
    struct brdf b;
    struct frame f;
    assert_true(scene_brdf(scene, &s, v3(0, 0, 1), &b, &f));
    return b.diffuse.r;
}

// A bitmap's colours where a mask or a blend never shows it do not mix into those that are shown.
static void hidden_colours_do_not_bleed(void **state) {
    (void)state;
    enum { SIZE = 8 };
    unsigned char leaf[12 + 3 * SIZE * SIZE] = "P6\n8 8\n255\n", mask[sizeof leaf];
    memcpy(mask, leaf, sizeof leaf);
    for (int i = 0; i < SIZE * SIZE; i++) {
        const bool shown = i % SIZE < SIZE / 2;
        memset(&leaf[11 + 3 * i], shown ? 60 : 255, 3);
        memset(&mask[11 + 3 * i], shown ? 255 : 0, 3);
    }
    scene_case_bytes("leaf.ppm", leaf, sizeof leaf - 1);
    scene_case_bytes("mask.ppm", mask, sizeof mask - 1);
#define BITMAP(name, file) \
    "<texture type='bitmap' name='" name "'><string name='filename' value='" file "'/></texture>"
#define LEAF "<bsdf type='diffuse'>" BITMAP("reflectance", "leaf.ppm") "</bsdf>"
    struct satin_scene *scene = test_load(
        SCENE_TEXT("<shape type='disk'>" LEAF "</shape>"
                   "<shape type='disk'><bsdf type='mask'>" BITMAP("opacity", "mask.ppm") LEAF
                   "</bsdf></shape>"
                   "<shape type='disk'><bsdf type='blendbsdf'>" BITMAP(
                       "weight", "mask.ppm") "<bsdf type='null'/>" LEAF "</bsdf></shape>"
                                             "<shape type='disk'><bsdf type='mask'><float "
                                             "name='opacity' value='.5'/>" LEAF "</bsdf>"
                                             "</shape>"));
    const float shown = 0.0452f, mean = 0.5f * (shown + 1.0f);
    assert_float_equal(averaged_red(scene, 0), mean, 0.05f);
    assert_float_equal(averaged_red(scene, 1), shown, 1e-3f);
    assert_float_equal(averaged_red(scene, 2), shown, 1e-3f);
    assert_float_equal(averaged_red(scene, 3), mean, 0.05f);
    satin_scene_free(scene);
}

static void materials_are_built(void **state) {
    (void)state;
    struct satin_scene *scene = test_load(SCENE_TEXT(
        "<bsdf type='roughconductor' id='m'><string name='distribution' value='ggx'/>"
        "<float name='alpha_u' value='.1'/><float name='alpha_v' value='0'/>"
        "<string name='material' value='Al'/></bsdf>"
        "<shape type='cube'><ref id='m'/></shape><shape type='sphere'><ref id='m'/></shape>"
        "<shape type='disk'><bsdf type='twosided'><bsdf type='diffuse'/>"
        "<bsdf type='plastic'><texture type='checkerboard' name='diffuse_reflectance'/></bsdf>"
        "</bsdf></shape><shape type='rectangle' id='r'/>"
        "<shape type='cube'><emitter type='area'/></shape>"
        "<shape type='cube'><bsdf type='dielectric'><float name='int_ior' value='1.5'/>"
        "<string name='ext_ior' value='vacuum'/></bsdf></shape>"
        "<shape type='sphere'><bsdf type='ward'><string name='variant' value='ward-duer'/>"
        "</bsdf></shape>"));
    assert_int_equal(scene->shape_count, 7);
    assert_int_equal(scene->material_count, 6);
    const struct material *m = &scene->material[scene->shape[0].material];
    assert_int_equal(scene->shape[0].material, scene->shape[1].material);
    assert_string_equal(m->name, "m");
    assert_true(m->tangent && !m->two_sided);
    assert_true(m->front.base.alpha_u == 0.1f && m->front.base.alpha_v == 1e-4f);
    assert_true(m->front.base.distribution == BRDF_GGX);
    assert_true(fabsf(m->front.base.k.r - 9.22381f) < 1e-5f);
    m = &scene->material[scene->shape[2].material];
    assert_true(m->two_sided && !m->tangent);
    assert_string_equal(m->front.base.model->name, "diffuse");
    assert_string_equal(m->back.base.model->name, "plastic");
    assert_true(fabsf(m->back.base.diffuse.r - 0.3f) < 1e-6f);
    assert_non_null(m->back.slot[BRDF_SLOT_DIFFUSE]);
    assert_true(scene->material[scene->shape[3].material].front.base.diffuse.g == 0.5f);
    assert_string_equal(scene->shape[3].name, "r");
    assert_true(scene->material[scene->shape[4].material].front.base.diffuse.g == 0.0f);
    assert_true(scene->material[scene->shape[5].material].front.base.ior == 1.5f);
    assert_true(scene->material[scene->shape[6].material].front.base.variant == BRDF_WARD_DUER);
    satin_scene_free(scene);
}

static void shapes_are_built(void **state) {
    (void)state;
    struct satin_scene *scene = test_load(SCENE_TEXT(
        "<shape type='sphere'><point name='center' x='1' y='2' z='3'/>"
        "<float name='radius' value='2'/><transform name='to_world'><scale value='3'/>"
        "<translate x='1'/></transform></shape>"
        "<shape type='sphere'><transform name='to_world'><scale x='-1'/></transform></shape>"
        "<shape type='cylinder'><point name='p0' value='1 0 0'/><point name='p1' value='1 4 0'/>"
        "<float name='radius' value='.5'/><boolean name='flip_normals' value='true'/></shape>"
        "<shape type='cube'><boolean name='face_normals' value='true'/></shape>"
        "<shape type='sphere'><float name='radius' value='-2'/></shape>"));
    const struct shape *s = scene->shape;
    assert_true(s[0].radius == 6.0f && v3_dist2(s[0].centre, v3(4, 6, 9)) == 0.0f);
    assert_false(s[0].flip_normals);
    assert_true(s[1].flip_normals && fabsf(s[1].area - 4 * PI_F) < 1e-5f);
    vec3 top = mat4_point(&s[2].to_world, v3(1, 0, 1));
    assert_true(fabsf(top.y - 4) < 1e-6f && fabsf(v3_dist2(top, v3(1, 4, 0)) - .25f) < 1e-6f);
    assert_true(s[2].flip_normals && fabsf(s[2].area - 4 * PI_F) < 1e-5f);
    assert_int_equal(s[3].mesh.triangle_count, 12);
    assert_true(s[4].flip_normals && s[4].radius == 2.0f);
    satin_scene_free(scene);
}

static void lights_are_built(void **state) {
    (void)state;
    struct satin_scene *scene = test_load(SCENE_TEXT(
        "<shape type='disk'><emitter type='area'><rgb name='radiance' value='3 2 1'/></emitter>"
        "</shape>"
        "<shape type='disk'><emitter type='area'><rgb name='radiance' value='0'/></emitter>"
        "</shape>"
        "<emitter type='point'><point name='position' x='1' y='2' z='3'/></emitter>"
        "<emitter type='spot'><float name='cutoff_angle' value='40'/><transform name='to_world'>"
        "<lookat origin='0 5 0' target='0 0 0' up='1 0 0'/></transform></emitter>"
        "<emitter type='directional'><vector name='direction' x='0' y='0' z='-7'/></emitter>"
        "<emitter type='constant'><rgb name='radiance' value='.5'/></emitter>"));
    assert_int_equal(scene->light_count, 5);
    const struct light *l = scene->light;
    assert_true(scene->shape[0].light == 0 && scene->shape[1].light == -1);
    assert_true(l[0].kind == LIGHT_AREA && l[0].shape == 0 && l[0].value.g == 2.0f);
    assert_true(l[1].position.y == 2.0f && l[1].value.r == 1.0f);
    assert_true(v3_dist2(l[2].direction, v3(0, -1, 0)) < 1e-12f && l[2].position.y == 5.0f);
    assert_true(fabsf(l[2].cos_beam - cosf(PI_F / 6)) < 1e-6f);
    assert_true(v3_dist2(l[3].direction, v3(0, 0, -1)) < 1e-12f);
    assert_int_equal(scene->environment, 4);
    satin_scene_free(scene);
}

static void hints_are_kept(void **state) {
    (void)state;
    struct satin_scene *scene = test_load(
        "<scene version='3.0.0'><integrator type='aov'><string name='aovs' value='a:depth'/>"
        "<integrator type='path'><integer name='max_depth' value='9'/>"
        "<boolean name='hide_emitters' value='true'/></integrator></integrator>"
        "<sensor type='perspective'><sampler type='multijitter'>"
        "<integer name='sample_count' value='49'/></sampler>"
        "<film type='hdrfilm'><integer name='width' value='60'/><integer name='height' value='40'/>"
        "<integer name='crop_offset_x' value='10'/><integer name='crop_width' value='50'/>"
        "<rfilter type='tent'/></film></sensor></scene>");
    assert_string_equal(scene->hints.integrator, "aov");
    assert_int_equal(scene->hints.max_depth, 9);
    assert_int_equal(scene->hints.rr_depth, 0);
    assert_int_equal(scene->hints.hide_emitters, 1);
    assert_int_equal(scene->hints.spp, 49);
    int w, h;
    satin_scene_film_size(scene, &w, &h);
    assert_true(w == 50 && h == 40 && scene->film.width == 60 && scene->film.crop_x == 10);
    assert_true(scene->film.filter == FILTER_TENT && scene->film.radius == 1.0f);
    satin_scene_free(scene);
    scene =
        test_load(SCENE_TEXT("<integrator type='satin'><integer name='photons' value='100'/>"
                             "<string name='first-pass' value='none'/></integrator>"));
    assert_int_equal(scene->hints.option_count, 2);
    assert_string_equal(scene->hints.option[1].name, "first-pass");
    assert_string_equal(scene->hints.option[0].value, "100");
    assert_int_equal(scene->hints.max_depth, -2);
    satin_scene_free(scene);
    scene = test_load(SCENE_TEXT("<integrator type='direct'/>"));
    assert_int_equal(scene->hints.max_depth, 2);
    satin_scene_free(scene);
}

#define OBJ "v 0 0 0\nv 1 0 0\nv 0 1 0\n"

static void the_hash_covers_all_that_is_read(void **state) {
    (void)state;
    const char *text =
        SCENE_TEXT("<shape type='obj'><string name='filename' value='a.obj'/></shape>");
    scene_case_file("a.obj", OBJ "f 1 2 3\n");
    struct satin_scene *a = test_load(text), *b = test_load(text);
    scene_case_file("a.obj", OBJ "f 1 3 2\n");
    struct satin_scene *c = test_load(text);
    assert_true(satin_scene_hash(a) == satin_scene_hash(b));
    assert_true(satin_scene_hash(a) != satin_scene_hash(c));
    assert_true(a->world == b->world && a->world != c->world);
    satin_scene_free(a);
    satin_scene_free(b);
    satin_scene_free(c);
}

struct load_refusal {
    const char *text, *error;
};

#define FILM(parameters)                                                                       \
    "<scene version='3.0.0'>\n<sensor type='perspective'>\n<film type='hdrfilm'>\n" parameters \
    "</film></sensor></scene>"

#define SHAPE(parts) SCENE_TEXT("<shape type='sphere'>" parts "</shape>")

static const struct load_refusal load_refusals[] = {
    {SHAPE("<bsdf type='phng'/>"), "scene.xml:3:22: unknown BRDF 'phng' (did you mean 'phong'?)"},
    {SCENE_TEXT("<shape type='sphere'><bsdf type='hair'/></shape>"),
     "scene.xml:3:22: BRDF 'hair' is not supported"},
    {SCENE_TEXT("<emitter type='timed_sunsky'/>"),
     "scene.xml:3:1: emitter 'timed_sunsky' is not supported"},
    {SCENE_TEXT("<emitter type='sunsky'><float name='turbidity' value='.9'/></emitter>"),
     "scene.xml:3:1: emitter 'sunsky': its turbidity is not in [1, 10]"},
    {SCENE_TEXT("<emitter type='sunsky'><vector name='sun_direction' value='0'/></emitter>"),
     "scene.xml:3:1: emitter 'sunsky': its sun_direction is zero, too small or too large"},
    {SCENE_TEXT("<emitter type='sky'><integer name='month' value='13'/></emitter>"),
     "scene.xml:3:21: month is 13, but must be 1 to 12"},
    {SCENE_TEXT("<emitter type='sun'><float name='latitude' value='-90.5'/></emitter>"),
     "scene.xml:3:21: latitude is -90.5, but must be -90 to 90"},
    {SCENE_TEXT("<integrator type='path'><integer name='max_dept' value='3'/></integrator>"),
     "scene.xml:3:25: integrator 'path' has no parameter 'max_dept' (did you mean 'max_depth'?)"},
    {SHAPE("<float name='radius' value='1e25'/>"),
     "scene.xml:3:1: shape 'sphere': it is too small or too large"},
    {SHAPE("<float name='radius' value='1e-45'/>"),
     "scene.xml:3:1: shape 'sphere': it is too small or too large"},
    {SHAPE("<float name='radius' value='1e20'/><transform name='to_world'><scale value='1e20'/>"
           "</transform>"),
     "scene.xml:3:1: shape 'sphere': it is too small or too large"},
    {SHAPE("<transform name='to_world'><scale x='2'/></transform>"),
     "scene.xml:3:1: shape 'sphere': to_world stretches or shears it, but it must stay round"},
    {SHAPE("<transform name='to_world'><scale value='0'/></transform>"),
     "scene.xml:3:1: shape 'sphere': to_world is singular"},
    {SHAPE("<emitter type='directionalarea'/>"),
     "scene.xml:3:1: shape 'sphere': a directionalarea emitter needs a rectangle or a disk"},
    {SCENE_TEXT("<shape type='zzzzzzzzz'/>"),
     "scene.xml:3:1: unknown shape 'zzzzzzzzz' (`satin help plugins` lists all)"},
    {"<scene version='3.0.0'/>", "scene.xml:1:1: the scene has no <sensor>"},
    {SHAPE("<ref id='nothing'/>"), "scene.xml:3:22: reference to unknown id 'nothing'"},
    {SHAPE("<bsdf type='roughconductor'><float name='alpha' value='-.1'/></bsdf>"),
     "scene.xml:3:50: alpha is -0.1, but must be 0 to 1e6"},
    {SHAPE("<bsdf type='roughconductor'><float name='alpha_u' value='.1'/></bsdf>"),
     "scene.xml:3:22: roughness is either alpha, or both alpha_u and alpha_v"},
    {SHAPE("<bsdf type='diffuse'><rgb name='reflectance' value='2 1 1'/></bsdf>"),
     "scene.xml:3:43: reflectance is 2, but must be in [0, 1]"},
    {SHAPE("<bsdf type='diffuse'><texture type='mesh_attribute' name='reflectance'>"
           "<string name='name' value='vertex_color'/></texture></bsdf>"),
     "scene.xml:3:1: shape 'sphere' has no attribute 'vertex_color' for its texture"},
    {SHAPE("<bsdf type='diffuse'><texture type='mesh_attribute' name='reflectance'>"
           "<string name='name' value='color'/></texture></bsdf>"),
     "scene.xml:3:93: the name of a mesh attribute begins with vertex_ or face_, not 'color'"},
    {SHAPE("<bsdf type='diffuse'><texture type='checkerboard' id='a' name='reflectance'>"
           "<ref id='a' name='color0'/></texture></bsdf>"),
     "scene.xml:3:43: textures are nested too deep, or contain themselves"},
    {SHAPE("<bsdf type='conductor'><string name='material' value='Unobtainium'/></bsdf>"),
     "scene.xml:3:45: material: unknown value 'Unobtainium'; known are a-C, Ag, Al, AlAs, AlSb, "
     "Au, Be, Cr, "
     "CsI, Cu, Cu_palik, Cu2O, CuO, d-C, Hg, HgTe, Ir, K, Li, MgO, Mo, Na_palik, Nb, Ni_palik, Rh, "
     "Se, SiC, SnTe, Ta, Te, ThF4, TiC, TiN, TiO2, VC, V_palik, VN, W, none"},
    {SHAPE("<bsdf type='plastic'><integrator type='path'/></bsdf>"),
     "scene.xml:3:43: BRDF 'plastic' takes no <integrator>; its place is <scene>"},
    {SHAPE("<bsdf type='conductor'><string name='material' value='Al'/>"
           "<rgb name='k' value='1'/></bsdf>"),
     "scene.xml:3:45: a metal is either a material, or eta and k"},
    {SHAPE("<bsdf type='twosided'><bsdf type='dielectric'/></bsdf>"),
     "scene.xml:3:22: 'dielectric' transmits, so it cannot be twosided"},
    {SHAPE("<bsdf type='plastic'><float name='int_ior' value='1e30'/></bsdf>"),
     "scene.xml:3:22: int_ior / ext_ior is 9.9972e+29, but must be in [0.01, 100]"},
    {SHAPE("<emitter type='area'><float name='radiance' value='1e38'/></emitter>"),
     "scene.xml: the lights' power is too large to count"},
    {SHAPE("<bsdf type='twosided'/>"), "scene.xml:3:22: twosided takes one or two <bsdf>s"},
    {SHAPE("<bsdf type='twosided' id='a'><ref id='a'/></bsdf>"),
     "scene.xml:3:22: twosided contains itself, or over 32 BRDFs in each other"},
    {SHAPE("<bsdf type='blendbsdf'><float name='weight' value='.5'/><bsdf type='null'/></bsdf>"),
     "scene.xml:3:22: blendbsdf takes two <bsdf>s"},
    {SHAPE("<bsdf type='twosided'><bsdf type='mask'><bsdf type='diffuse'/></bsdf></bsdf>"),
     "scene.xml:3:22: twosided cannot wrap a mask; wrap it by one"},
    {SHAPE("<bsdf type='lafortune'><string name='lobes' value='-1 -1 1 5'/></bsdf>"),
     "scene.xml:3:45: 'lobes' has 4 numbers, but needs seven for each of one to 8 lobes"},
    {SHAPE("<bsdf type='lafortune'><string name='lobes' value='-1 -1 1 5 2 2 2'/></bsdf>"),
     "scene.xml:3:22: it reflects 2.29 times the light that it gets"},
    {SHAPE("<bsdf type='principled'><float name='eta' value='2'/><float name='specular' "
           "value='.5'/></bsdf>"),
     "scene.xml:3:22: the reflectance is either eta or specular"},
    {SHAPE("<bsdf type='principled'><float name='specular' value='12.5'/></bsdf>"),
     "scene.xml:3:46: specular is 12.5, but must be in [0, 12]"},
    {SHAPE("<bsdf type='principledthin'><float name='diff_trans' value='3'/></bsdf>"),
     "scene.xml:3:50: diff_trans is over 2"},
    {SHAPE("<bsdf type='principledthin'><float name='eta' value='1e30'/></bsdf>"),
     "scene.xml:3:50: eta is 1e+30, but must be in [0.01, 100]"},
    {SHAPE("<bsdf type='principled'><float name='eta' value='.001'/></bsdf>"),
     "scene.xml:3:46: eta is 0.001, but must be in [0.01, 100]"},
    {SHAPE("<bsdf type='bumpmap'><bsdf type='diffuse'/></bsdf>"),
     "scene.xml:3:22: bumpmap needs a <texture>"},
    {SHAPE("<bsdf type='normalmap'><texture name='normalmap' type='checkerboard'/>"
           "<bsdf type='normalmap'><texture name='normalmap' type='checkerboard'/>"
           "<bsdf type='bumpmap'><texture type='checkerboard'/>"
           "<bsdf type='diffuse'/></bsdf></bsdf></bsdf>"),
     "scene.xml:3:22: normalmap cannot wrap two more bumpmaps or normalmaps"},
    {SHAPE("<bsdf type='diffuse'/><bsdf type='diffuse'/>"),
     "scene.xml:3:44: shape 'sphere' has two <bsdf>s"},
    {SHAPE("<emitter type='point'/>"),
     "scene.xml:3:22: emitter 'point': it cannot be part of a shape; area lights are"},
    {SHAPE("<transform name='toWorld'/>"),
     "scene.xml:3:22: shape 'sphere' has no parameter 'toWorld' (did you mean 'to_world'?)"},
    {SHAPE("<transform name='to_world'><scale x='2'/></transform>"),
     "scene.xml:3:1: shape 'sphere': to_world stretches or shears it, but it must stay round"},
    {SHAPE("<float name='radius' value='0'/>"), "scene.xml:3:1: shape 'sphere': its radius is 0"},
    {SCENE_TEXT("<shape type='disk'><transform name='to_world'><scale x='0'/></transform></shape>"),
     "scene.xml:3:1: shape 'disk': to_world is singular"},
    {SCENE_TEXT("<shape type='cube'><transform name='to_world'><scale value='1e30'/></transform>"
                "</shape>"),
     "scene.xml:3:1: shape 'cube': to_world makes it too large"},
    {SCENE_TEXT("<shape type='cube'><transform name='to_world'><scale value='1e-13'/></transform>"
                "<emitter type='area'/></shape>"),
     "scene.xml:3:1: shape 'cube': it emits but has no area"},
    {SCENE_TEXT("<emitter type='constant'/><emitter type='constant'/>"),
     "scene.xml:3:27: emitter 'constant': the scene has another environment"},
    {SCENE_TEXT("<integrator type='path'><integer name='max_depth' value='-2'/></integrator>"),
     "scene.xml:3:25: max_depth is -2, but must be -1 or more"},
    {SCENE_TEXT("<integrator type='aov'><string name='aovs' value='a:uv'/>"
                "<integrator type='depth'/></integrator>"),
     "scene.xml:3:58: integrator 'depth' is not supported"},
    {SCENE_TEXT("<integrator type='path'/><integrator type='direct'/>"),
     "scene.xml:3:26: the scene has another integrator"},
    {"<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='180'/>"
     "</sensor></scene>",
     "scene.xml:1:51: fov is 180, but must be in [1e-05, 180)"},
    {"<scene version='3.0.0'><sensor type='perspective'><string name='focal_length' "
     "value='mm'/></sensor></scene>",
     "scene.xml:1:51: focal_length is 'mm', but must be like 50mm"},
    {"<scene version='3.0.0'><sensor type='perspective'><transform name='to_world'>"
     "<scale value='2'/></transform></sensor></scene>",
     "scene.xml:1:24: sensor 'perspective': to_world has a scale"},
    {FILM("<integer name='width' value='2147483648'/>"),
     "scene.xml:4:1: width: '2147483648' is not an integer, or too large"},
    {FILM("<integer name='width' value='2147483647'/>"),
     "scene.xml:4:1: width is 2147483647, but at most 1048576 pixels are supported"},
    {FILM("<integer name='width' value='1048576'/><integer name='height' value='1048576'/>"),
     "scene.xml:3:1: film 'hdrfilm': it has 1048576 x 1048576 pixels, but at most 268435456 are "
     "supported"},
    {FILM("<integer name='height' value='0'/>"),
     "scene.xml:4:1: height is 0, but must be positive"},
    {FILM("<integer name='crop_width' value='769'/>"),
     "scene.xml:3:1: film 'hdrfilm': its crop window is not inside of it"},
    {FILM("<rfilter type='lanczos'><float name='lobes' value='.5'/></rfilter>"),
     "scene.xml:4:1: filter 'lanczos': it has less than one lobe, or over 100"},
};

static void test_load_refuse(const char *error) {
    struct scene_case c;
    struct log log = scene_case_begin(&c);
    satin_scene *scene = NULL;
    assert_int_equal(satin_scene_load("scene.xml", NULL, 0, log.fn, log.user, &scene),
                     SATIN_ERROR_INPUT);
    assert_string_equal(c.error, error);
    assert_int_equal(c.errors, 1);
    assert_null(scene);
}

static void errors_of_scenes_name_their_line(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof load_refusals / sizeof *load_refusals; i++) {
        scene_case_file("scene.xml", load_refusals[i].text);
        test_load_refuse(load_refusals[i].error);
    }
}

static void bad_files_are_refused(void **state) {
    (void)state;
    scene_case_file("scene.xml", SCENE_TEXT("<shape type='obj'>\n"
                                            "<string name='filename' value='a.obj'/></shape>"));
    remove("a.obj");
    test_load_refuse("scene.xml:4:1: cannot read 'a.obj': No such file or directory");
    scene_case_file("a.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
    struct scene_case c;
    struct log log = scene_case_begin(&c);
    satin_scene *scene = NULL;
    assert_int_equal(satin_scene_load("scene.xml", NULL, 0, log.fn, log.user, &scene),
                     SATIN_ERROR_INPUT);
    assert_int_equal(strncmp(c.error, "a.obj:2", 7), 0);
    scene_case_file("a.obj", OBJ "f 1 2 4\n");
    log = scene_case_begin(&c);
    assert_int_equal(satin_scene_load("scene.xml", NULL, 0, log.fn, log.user, &scene),
                     SATIN_ERROR_INPUT);
    assert_int_equal(strncmp(c.error, "a.obj:4", 7), 0);
    assert_int_equal(c.errors, 1);
}

static void parameters_without_effect_are_reported(void **state) {
    (void)state;
    scene_case_file("scene.xml",
                    SCENE_TEXT("<sensor type='thinlens'><float name='aperture_radius' value='1'/>"
                               "</sensor>"));
    struct scene_case c;
    struct log log = scene_case_begin(&c);
    satin_scene *scene = NULL;
    assert_int_equal(satin_scene_load("scene.xml", NULL, 0, log.fn, log.user, &scene), SATIN_OK);
    assert_int_equal(c.warnings, 1);
    assert_string_equal(c.warning,
                        "scene.xml:3:1: only the first sensor of a scene is used; "
                        "--sensor chooses another");
    assert_true(scene->camera.aperture == 0.0f);
    satin_scene_free(scene);
    assert_int_equal(satin_scene_load(NULL, NULL, 0, log.fn, log.user, &scene),
                     SATIN_ERROR_ARGUMENT);
}

static void a_raw_constant_is_read(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c, SCENE_TEXT("<shape type='cube'><bsdf type='diffuse'><texture type='rawconstant' "
                       "name='reflectance'><rgb name='value' value='.2 .4 .6'/></texture></bsdf>"
                       "</shape>"));
    assert_non_null(scene);
    const struct texture *texture = scene->material[0].front.slot[BRDF_SLOT_DIFFUSE];
    const struct texture_lookup at = scene_texture_at((vec2){.3f, .7f});
    const rgb value = scene_texture_eval(texture, &at);
    assert_true(value.r == .2f && value.g == .4f && value.b == .6f && c.warnings == 0);
    satin_scene_free(scene);
    assert_null(scene_case_load(
        &c, SHAPE("<bsdf type='diffuse'><texture type='rawconstant' name='reflectance'/></bsdf>")));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_raw_constant_is_read),
        cmocka_unit_test(materials_are_built),
        cmocka_unit_test(masks_nest),
        cmocka_unit_test(hidden_colours_do_not_bleed),
        cmocka_unit_test(twosided_materials_nest),
        cmocka_unit_test(shapes_are_built),
        cmocka_unit_test(lights_are_built),
        cmocka_unit_test(hints_are_kept),
        cmocka_unit_test(the_hash_covers_all_that_is_read),
        cmocka_unit_test(errors_of_scenes_name_their_line),
        cmocka_unit_test(bad_files_are_refused),
        cmocka_unit_test(parameters_without_effect_are_reported),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
