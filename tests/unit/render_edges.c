// SPDX-License-Identifier: Apache-2.0
// Pixels at the edges of surfaces show what eye rays for the surfaces alone find, and no others
// change.
#include "satin/render.h"

#include "film/film.h"
#include "scene/scene.h"
#include "scene_case.h"

enum { SIDE = 48, PIXELS = SIDE * SIDE };

#define LOOKING_DOWN                                                                          \
    "<sensor type='perspective'><float name='fov' value='40'/><transform name='to_world'>"    \
    "<lookat origin='0 0 5' target='0 0 0' up='0 1 0'/></transform><film type='hdrfilm'>"     \
    "<integer name='width' value='48'/><integer name='height' value='48'/></film></sensor>"   \
    "<emitter type='directional'><rgb name='irradiance' value='3'/><vector name='direction' " \
    "value='0 0 -1'/></emitter>"
#define GROUND                                                                          \
    "<shape type='rectangle'><transform name='to_world'><scale value='9'/></transform>" \
    "<bsdf type='diffuse'><rgb name='reflectance' value='.8 .7 .6'/></bsdf></shape>"
#define TILE(lift, reflectance)                                                     \
    "<shape type='rectangle'><transform name='to_world'><rotate z='1' angle='20'/>" \
    "<translate z='" lift                                                           \
    "'/></transform><bsdf type='diffuse'>"                                          \
    "<rgb name='reflectance' value='" reflectance "'/></bsdf></shape>"

// A plate that leans so that it is half as bright.
#define LEANING                                                                       \
    "<shape type='rectangle'><transform name='to_world'><scale x='.8' y='.4'/>"       \
    "<rotate x='1' angle='60'/><rotate z='1' angle='20'/><translate z='1.5'/>"        \
    "</transform><bsdf type='twosided'><bsdf type='diffuse'><rgb name='reflectance' " \
    "value='.8 .7 .6'/></bsdf></bsdf></shape>"

// Between them and the eye.
#define PANE                                                                                  \
    "<shape type='rectangle'><transform name='to_world'><scale value='9'/><translate z='3'/>" \
    "</transform><bsdf type='thindielectric'/></shape>"

static int tiled_seed;
static const char *tiled_depth = "2";
static const char *tiled_filter = "off";  // of noise
static float tiled_albedo[PIXELS];        // red, of the last image

// Renders without the caches and, but for that of noise, filters, whose errors are not those of
// edges.
static void render_tiled(const char *body, const char *spp, const char *edge_rays, int threads,
                         float *beauty) {
    char text[2048];
    struct scene_case c;
    snprintf(text, sizeof text, "<scene version='3.0.0'>" LOOKING_DOWN "%s</scene>", body);
    satin_scene *scene = scene_case_load(&c, text);
    assert_non_null(scene);
    const satin_setting settings[] = {{"quality", "draft"},           {"spp", spp},
                                      {"max-depth", tiled_depth},     {"photons", "2000"},
                                      {"light-samples", "16"},        {"adaptive-sampling", "off"},
                                      {"noise-filter", tiled_filter}, {"edge-rays", edge_rays}};
    satin_options options;
    assert_int_equal(satin_options_resolve(scene, settings, sizeof settings / sizeof *settings,
                                           NULL, NULL, &options),
                     SATIN_OK);
    options.threads = threads;
    options.seed = (uint64_t)tiled_seed;
    satin_film *film = NULL;
    assert_int_equal(satin_render(scene, &options, NULL, &film), SATIN_OK);
    const float *plane[3] = {film_channel(film, "R"), film_channel(film, "G"),
                             film_channel(film, "B")};
    for (int i = 0; i < 3; i++) {
        assert_non_null(plane[i]);
        memcpy(beauty + i * PIXELS, plane[i], PIXELS * sizeof *beauty);
    }
    const float *albedo = film_channel(film, "albedo.R");
    assert_non_null(albedo);
    memcpy(tiled_albedo, albedo, sizeof tiled_albedo);
    satin_film_free(film);
    satin_scene_free(scene);
}

// The mean square of the difference; *bias is its mean.
static double edge_difference(const float *a, const float *b, double *bias) {
    double squares = 0.0, sum = 0.0;
    for (int i = 0; i < 3 * PIXELS; i++) {
        const double d = (double)a[i] - (double)b[i];
        squares += d * d;
        sum += d;
    }
    *bias = sum / (3 * PIXELS);
    return squares / (3 * PIXELS);
}

// With two samples a pixel at the edge of a dark tile is covered by none, half or all of it.
static void edges_have_the_light_of_what_they_show(void **state) {
    (void)state;
    static const char *const tiles[] = {GROUND TILE("1", ".1 .2 .1"),
                                        GROUND TILE(".01", ".1 .2 .1")};
    static float exact[3 * PIXELS], without[3 * PIXELS], with[3 * PIXELS];
    for (size_t i = 0; i < sizeof tiles / sizeof *tiles; i++) {
        double bias, before, after;
        render_tiled(tiles[i], "512", "0", 2, exact);
        render_tiled(tiles[i], "2", "0", 2, without);
        render_tiled(tiles[i], "2", "16", 2, with);
        before = edge_difference(without, exact, &bias);
        after = edge_difference(with, exact, &bias);
        assert_true(before > 1e-3);
        assert_true(after < 0.1 * before);
        assert_true(fabs(bias) < 2e-3);
    }
}

// The filter of noise mixes samples of pixels that have met a tile in other proportions.
static void edges_are_not_filtered(void **state) {
    (void)state;
    enum { SEEDS = 4 };
    static const char tile[] = GROUND TILE("1", ".8 .7 .6") LEANING;
    static float exact[3 * PIXELS], image[3 * PIXELS];
    double bias, plain = 0.0, filtered = 0.0;
    render_tiled(tile, "512", "0", 2, exact);
    for (tiled_seed = 0; tiled_seed < SEEDS; tiled_seed++) {
        render_tiled(tile, "2", "64", 2, image);
        plain += edge_difference(image, exact, &bias);
        tiled_filter = "on";
        render_tiled(tile, "2", "64", 2, image);
        filtered += edge_difference(image, exact, &bias);
        tiled_filter = "off";
    }
    tiled_seed = 0;
    assert_true(filtered < 1.2 * plain);
}

static void edges_behind_panes_are_found(void **state) {
    (void)state;
    static const char tiled[] = GROUND TILE("1", ".1 .2 .1") PANE;
    static float exact[3 * PIXELS], without[3 * PIXELS], with[3 * PIXELS];
    double bias;
    tiled_depth = "4";
    render_tiled(tiled, "512", "0", 2, exact);
    tiled_filter = "on";
    render_tiled(tiled, "2", "0", 2, without);
    render_tiled(tiled, "2", "16", 2, with);
    tiled_filter = "off";
    tiled_depth = "2";
    const double before = edge_difference(without, exact, &bias),
                 after = edge_difference(with, exact, &bias);
    assert_true(before > 1e-3);
    assert_true(after < 0.15 * before);
    assert_true(fabs(bias) < 2e-3);
}

// Compositing and denoisers need features that agree with the light.
static void features_are_corrected_with_the_light(void **state) {
    (void)state;
    static const char tiled[] = GROUND TILE("1", ".1 .2 .1");
    static float image[3 * PIXELS], exact[PIXELS];
    double squares[2] = {0.0, 0.0};
    render_tiled(tiled, "256", "0", 2, image);
    memcpy(exact, tiled_albedo, sizeof exact);
    for (int with = 0; with < 2; with++) {
        render_tiled(tiled, "2", with ? "16" : "0", 2, image);
        for (int i = 0; i < PIXELS; i++)
            squares[with] += pow((double)tiled_albedo[i] - (double)exact[i], 2.0);
    }
    assert_true(squares[1] < 0.1 * squares[0]);
}

// Strips of a hundredth of the ground, each a sixth of a pixel wide, which one sample meets or not.
#define STRIP(x)                                                                 \
    "<shape type='rectangle'><transform name='to_world'><scale x='.006' y='9'/>" \
    "<rotate z='1' angle='7'/><translate x='" x                                  \
    "' z='.01'/></transform>"                                                    \
    "<bsdf type='diffuse'><rgb name='reflectance' value='.9'/></bsdf></shape>"
#define DARK_GROUND                                                                     \
    "<shape type='rectangle'><transform name='to_world'><scale value='9'/></transform>" \
    "<bsdf type='diffuse'><rgb name='reflectance' value='.05'/></bsdf></shape>"

// If only pixels whose sample met a strip were corrected, strips would vanish.
static void thin_strips_stay_as_bright(void **state) {
    (void)state;
    enum { SEEDS = 8 };
    static const char strips[] =
        DARK_GROUND STRIP("-1.2") STRIP("-.7") STRIP("-.2") STRIP(".3") STRIP(".8") STRIP("1.3");
    static float exact[3 * PIXELS], image[3 * PIXELS];
    double whole = 0.0, bias, sum = 0.0;
    render_tiled(strips, "256", "0", 2, exact);
    for (int i = 0; i < 3 * PIXELS; i++) whole += (double)exact[i] / (3 * PIXELS);
    for (int seed = 0; seed < SEEDS; seed++) {
        tiled_seed = seed;
        render_tiled(strips, "1", "16", 2, image);
        for (int i = 0; i < 3 * PIXELS; i++) assert_true(image[i] >= 0.0f);
        (void)edge_difference(image, exact, &bias);
        sum += bias / SEEDS;
    }
    tiled_seed = 0;
    // It would be -.069 if the pixel itself decided.
    assert_true(fabs(sum) < 0.03 * whole);
}

static void changes_do_not_depend_on_threads(void **state) {
    (void)state;
    static float one[3 * PIXELS], three[3 * PIXELS];
    render_tiled(GROUND TILE("1", ".1 .2 .1"), "3", "16", 1, one);
    render_tiled(GROUND TILE("1", ".1 .2 .1"), "3", "16", 3, three);
    assert_memory_equal(one, three, sizeof one);
}

static void a_plain_surface_is_left_alone(void **state) {
    (void)state;
    static float without[3 * PIXELS], with[3 * PIXELS];
    render_tiled(GROUND, "2", "0", 2, without);
    render_tiled(GROUND, "2", "16", 2, with);
    assert_memory_equal(without, with, sizeof with);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edges_have_the_light_of_what_they_show),
        cmocka_unit_test(edges_are_not_filtered),
        cmocka_unit_test(edges_behind_panes_are_found),
        cmocka_unit_test(features_are_corrected_with_the_light),
        cmocka_unit_test(thin_strips_stay_as_bright),
        cmocka_unit_test(changes_do_not_depend_on_threads),
        cmocka_unit_test(a_plain_surface_is_left_alone),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
