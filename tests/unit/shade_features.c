// SPDX-License-Identifier: Apache-2.0
// Features of a plane whose albedo and normal are known, seen directly, in a mirror and through a
// pane: by rays for these alone, and by the samples of two integrators. And the surface that is
// shown.
#include "shade/shade_eye.h"

#include "scene_case.h"

// The camera looks along -z.
#define CAMERA                                                                                  \
    "<sensor type='perspective'><float name='fov' value='20'/><transform name='to_world'>"      \
    "<lookat origin='0, 0, 4' target='0, 0, 0' up='0, 1, 0'/></transform><film type='hdrfilm'>" \
    "<integer name='width' value='4'/><integer name='height' value='4'/></film></sensor>"
#define PLATE(size, transform, bsdf)                                                         \
    "<shape type='rectangle'><transform name='to_world'><scale value='" size "'/>" transform \
    "</transform>" bsdf "</shape>"
#define DIFFUSE "<bsdf type='diffuse'><rgb name='reflectance' value='.2, .4, .6'/></bsdf>"
#define BEHIND PLATE("50", "<translate z='-9'/>", DIFFUSE)
#define ABOVE PLATE("50", "<rotate x='1' angle='90'/><translate y='9'/>", DIFFUSE)
// What it reflects to the eye is above of it.
#define TILTED(bsdf) PLATE("5", "<rotate x='1' angle='-45'/>", bsdf)
#define PANE PLATE("5", "", "<bsdf type='thindielectric'/>")
#define METAL                                                       \
    "<bsdf type='conductor'><string name='material' value='none'/>" \
    "<rgb name='specular_reflectance' value='.5, .8, .8'/></bsdf>"

enum { FEATURES_BY_RAYS, FEATURES_BY_PATHS, FEATURES_BY_SAMPLES, FEATURES_KINDS };

// What is found: features in each way, and the surface that a sample shows.
struct features_found {
    struct shade_features f[FEATURES_KINDS];
    struct shade_surface shown;
};

// The mean over samples of a pixel.
static struct shade_features sampled_features(const struct shade *shade,
                                              struct shade_surface *shown) {
    enum { SAMPLES = 256 };
    struct shade_features sum = {0};
    struct shade_worker worker = {.gather = shade->worker[0]};
    shade_tile_begin(&worker);
    shade_pixel_begin(&worker);
    for (uint32_t i = 0; i < SAMPLES; i++) {
        struct shade_sample s;
        shade_pixel(shade, &worker, 1, 2, i,
                    (struct shade_sample_counts){{1, i}, {1, i}, {8, 8 * i}}, &s);
        sum.albedo = rgb_mad(sum.albedo, s.features.albedo, 1.0f / SAMPLES);
        sum.normal = rgb_mad(sum.normal, s.features.normal, 1.0f / SAMPLES);
        *shown = s.shown;
    }
    return sum;
}

static void find_all_features(const char *body, struct features_found *out) {
    struct scene_case c;
    char text[4096];
    snprintf(text, sizeof text, "<scene version='3.0.0'>%s%s<emitter type='constant'/></scene>",
             CAMERA, body);
    satin_scene *scene = scene_case_load(&c, text);
    if (!scene) fail_msg("%s", c.error);
    satin_options options = satin_options_default;
    options.denoise = options.noise_filter = true;
    struct parallel *pool = parallel_new(1);
    for (int i = 0; i < FEATURES_KINDS; i++) {
        struct shade shade;
        options.integrator = i == FEATURES_BY_PATHS ? SATIN_PATH : SATIN_DIRECT;
        const struct gather g = gather_make(scene, &options, NULL);
        const struct cache_tables none = {0};
        assert_int_equal(shade_init(&shade, &g, cache_reader_make(NULL, &none, &options),
                                    (struct shade_missing){1, 1.0f}, pool),
                         SATIN_OK);
        if (i == FEATURES_BY_RAYS)
            (void)shade_find_features(&shade, 1, 2, 0, &out->f[i]);
        else
            out->f[i] = sampled_features(&shade, &out->shown);
        shade_destroy(&shade);
    }
    parallel_free(pool);
    satin_scene_free(scene);
}

static void assert_feature(rgb a, float x, float y, float z, float most) {
    assert_true(fabsf(a.r - x) < most && fabsf(a.g - y) < most && fabsf(a.b - z) < most);
}

static void assert_shown(const struct shade_surface *s, rgb albedo, vec3 n, float distance) {
    assert_feature(s->albedo, albedo.r, albedo.g, albedo.b, .002f);
    assert_feature(s->normal, n.x, n.y, n.z, 1e-4f);
    assert_true(fabsf(s->depth / distance - 1.0f) < .05f);
}

static void a_wall_has_its_own_features(void **state) {
    (void)state;
    struct features_found found;
    find_all_features(BEHIND, &found);
    for (int i = 0; i < FEATURES_KINDS; i++) {
        assert_feature(found.f[i].albedo, .2f, .4f, .6f, 1e-5f);
        assert_feature(found.f[i].normal, 0, 0, 1, 1e-5f);
    }
    assert_shown(&found.shown, rgb_make(.2f, .4f, .6f), v3(0, 0, 1), 13.0f);
}

static void a_mirror_has_those_of_what_it_shows(void **state) {
    (void)state;
    struct features_found found;
    find_all_features(ABOVE TILTED(METAL), &found);
    for (int i = 0; i < FEATURES_KINDS; i++) {
        // A path may end by Russian roulette.
        const float most = i == FEATURES_BY_PATHS ? .01f : 1e-4f;
        assert_feature(found.f[i].albedo, .1f, .32f, .48f, most);
        assert_feature(found.f[i].normal, 0, -.8f, 0, most);
    }
    assert_shown(&found.shown, rgb_make(.1f, .32f, .48f), v3(0, -1, 0), 13.0f);
}

// A pane of index 1.5046 transmits (1 - R) / (1 + R) with R = .0406 of each of its sides, and
// reflects the sky, which has no features.
static void a_pane_has_those_of_what_is_behind(void **state) {
    (void)state;
    struct features_found found;
    const float t = .9220f;
    find_all_features(BEHIND PANE, &found);
    for (int i = 0; i < FEATURES_KINDS; i++) {
        // A path is either transmitted or reflected: four standard deviations.
        const float most = i == FEATURES_BY_PATHS ? .07f : .002f;
        assert_feature(found.f[i].albedo, .2f * t, .4f * t, .6f * t, most);
        assert_feature(found.f[i].normal, 0, 0, t, most);
    }
    assert_shown(&found.shown, rgb_make(.2f * t, .4f * t, .6f * t), v3(0, 0, 1), 13.0f);
}

// One that has a diffuse lobe has its own features, whatever it mirrors.
static void plastic_has_its_own_features(void **state) {
    (void)state;
    struct features_found found;
    find_all_features(ABOVE TILTED("<bsdf type='plastic'/>"), &found);
    for (int i = 0; i < FEATURES_KINDS; i++) {
        assert_feature(found.f[i].albedo, .5f, .5f, .5f, .05f);
        assert_feature(found.f[i].normal, 0, .70711f, .70711f, 1e-4f);
    }
    assert_true(fabsf(found.shown.depth / 4.0f - 1.0f) < .1f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_wall_has_its_own_features),
        cmocka_unit_test(a_mirror_has_those_of_what_it_shows),
        cmocka_unit_test(a_pane_has_those_of_what_is_behind),
        cmocka_unit_test(plastic_has_its_own_features),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
