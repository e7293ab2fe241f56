// SPDX-License-Identifier: Apache-2.0
// Values of the first surface, by formulas: on a plane whose texture coordinates are known, and the
// same for a shape and for an instance of it.
#include "shade/shade_aov.h"

#include "scene_case.h"

#define ALL                                                                                   \
    "<integrator type='aov'><string name='aovs' value='albedo:albedo,depth:depth,p:position," \
    "uv:uv,ng:geo_normal,n:sh_normal,u:dp_du,v:dp_dv,dx:duv_dx,dy:duv_dy,i:prim_index,"       \
    "s:shape_index'/></integrator>"
// The camera looks down the z axis from 4 above; at the middle of the film a pixel is 4 * 2 / 100
// wide.
#define CAMERA                                                                                  \
    "<sensor type='perspective'><float name='fov' value='90'/><transform name='to_world'>"      \
    "<lookat origin='0, 0, 4' target='0, 0, 0' up='0, 1, 0'/></transform><film type='hdrfilm'>" \
    "<integer name='width' value='100'/><integer name='height' value='100'/></film></sensor>"
#define PLATE                                                                       \
    "<shape type='rectangle'><bsdf type='plastic'><rgb name='diffuse_reflectance' " \
    "value='.1, .2, .3'/></bsdf><transform name='to_world'>" TILT "</transform></shape>"
#define TILT "<scale x='8' y='16'/><rotate z='1' angle='90'/>"

// The values at the film position, with 4 samples per pixel.
static void shade_aov_look(const char *body, vec2 film, float out[AOV_VALUES],
                           struct scene_aovs *aovs) {
    struct scene_case c;
    char text[4096];
    snprintf(text, sizeof text, "<scene version='3.0.0'>%s%s%s</scene>", ALL, CAMERA, body);
    satin_scene *scene = scene_case_load(&c, text);
    if (!scene) fail_msg("%s", c.error);
    satin_options options = satin_options_default;
    options.spp = 4;
    const struct gather g = {.scene = scene, .options = &options};
    const struct shade shade = {.g = &g, .camera = &scene->camera};
    const struct shade_camera_sample lens = {.film = film};
    const struct ray ray = scene_camera_ray(scene, &scene->camera, film, (vec2){0.0f, 0.0f}, NULL);
    struct interaction s;
    struct shading_point point;
    assert_true(scene_intersect(scene, &ray, &s));
    scene_shading_point_make(scene, &s, ray.d, &point);
    memset(out, 0, AOV_VALUES * sizeof *out);
    shade_aov(&shade, &point, &lens, out);
    *aovs = scene->hints.aovs;  // its names go with the scene
    satin_scene_free(scene);
}

static void near3(const float *a, float x, float y, float z) {
    assert_true(v3_dist2(v3(a[0], a[1], a[2]), v3(x, y, z)) < 1e-8f);
}

static void a_plane_has_known_values(void **state) {
    (void)state;
    float a[AOV_VALUES];
    struct scene_aovs at;
    shade_aov_look("<shape type='sphere'><point name='center' x='0' y='0' z='-90'/></shape>" PLATE,
                   (vec2){75, 50}, a, &at);
    // x = 2 on the plate, which is rotated by a quarter circle: u grows with y, v against x.
    near3(a + at.first[AOV_ALBEDO], .1f, .2f, .3f);
    assert_true(fabsf(a[at.first[AOV_DEPTH]] - sqrtf(20.0f)) < 1e-5f);
    near3(a + at.first[AOV_POSITION], 2, 0, 0);
    near3(a + at.first[AOV_GEO_NORMAL], 0, 0, 1);
    near3(a + at.first[AOV_SH_NORMAL], 0, 0, 1);
    near3(a + at.first[AOV_DP_DU], 0, 16, 0);
    near3(a + at.first[AOV_DP_DV], -32, 0, 0);
    const float *uv = a + at.first[AOV_UV];
    const float *dx = a + at.first[AOV_DUV_DX], *dy = a + at.first[AOV_DUV_DY];
    assert_true(fabsf(uv[0] - .5f) < 1e-5f && fabsf(uv[1] - (.5f - 2.0f / 32)) < 1e-5f);
    // A sample's footprint is half as wide as the pixel: .04 to the right, or down.
    assert_true(fabsf(dx[0]) < 1e-6f && fabsf(dx[1] + .04f / 32) < 1e-6f);
    assert_true(fabsf(dy[0] + .04f / 16) < 1e-6f && fabsf(dy[1]) < 1e-6f);
    assert_true(a[at.first[AOV_PRIM_INDEX]] == 0.0f || a[at.first[AOV_PRIM_INDEX]] == 1.0f);
    assert_true(a[at.first[AOV_SHAPE_INDEX]] == 2.0f);
}

static void instances_have_the_values_of_their_shapes(void **state) {
    (void)state;
#define ROTATION "<rotate x='1' angle='30'/><rotate y='1' angle='20'/><scale y='.7'/>"
    static const char *const pair[][2] = {
        {"<shape type='cube'><transform name='to_world'>" ROTATION "</transform></shape>",
         "<shape type='shapegroup' id='g'><shape type='cube'/></shape><shape type='instance'>"
         "<ref id='g'/><transform name='to_world'>" ROTATION "</transform></shape>"},
        {"<shape type='disk'><transform name='to_world'>" ROTATION "</transform></shape>",
         "<shape type='shapegroup' id='g'><shape type='disk'/></shape><shape type='instance'>"
         "<ref id='g'/><transform name='to_world'>" ROTATION "</transform></shape>"},
    };
    for (int i = 0; i < 2; i++) {
        float a[AOV_VALUES], b[AOV_VALUES];
        struct scene_aovs at;
        shade_aov_look(pair[i][0], (vec2){47, 54}, a, &at);
        shade_aov_look(pair[i][1], (vec2){47, 54}, b, &at);
        for (int k = 0; k < AOV_VALUES; k++)
            assert_true(k == at.first[AOV_SHAPE_INDEX] || fabsf(a[k] - b[k]) < 1e-4f);
    }
}

// Where the channels alone need dp/du, frames and images do not change.
static void channels_change_no_frame(void **state) {
    (void)state;
    struct interaction s[2];
    for (int i = 0; i < 2; i++) {
        struct scene_case c;
        char text[4096];
        snprintf(text, sizeof text, "<scene version='3.0.0'>%s%s%s</scene>", i ? ALL : "", CAMERA,
                 PLATE);
        satin_scene *scene = scene_case_load(&c, text);
        assert_non_null(scene);
        const struct ray ray =
            scene_camera_ray(scene, &scene->camera, (vec2){40, 40}, (vec2){0, 0}, NULL);
        assert_true(scene_intersect(scene, &ray, &s[i]));
        satin_scene_free(scene);
    }
    assert_memory_equal(&s[0].frame, &s[1].frame, sizeof s[0].frame);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plane_has_known_values),
        cmocka_unit_test(instances_have_the_values_of_their_shapes),
        cmocka_unit_test(channels_change_no_frame),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
