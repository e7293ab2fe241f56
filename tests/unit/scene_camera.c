// SPDX-License-Identifier: Apache-2.0
// The camera's rays and the pixel filters' samples. Corner rays were compared with Mitsuba 3.9 over
// all fov axes, crops, lenses and shifts: they agree to 1e-6.
#include "base/rng.h"
#include "scene/scene.h"
#include "scene_case.h"

static struct satin_scene *scene_camera_load(const char *sensor) {
    char text[1024];
    snprintf(text, sizeof text, "<scene version='3.0.0'>%s</scene>", sensor);
    scene_case_file("scene.xml", text);
    struct scene_case c;
    struct log log = scene_case_begin(&c);
    satin_scene *scene = NULL;
    assert_int_equal(satin_scene_load("scene.xml", NULL, 0, log.fn, log.user, &scene), SATIN_OK);
    return scene;
}

#define FILM                                                   \
    "<film type='hdrfilm'><integer name='width' value='400'/>" \
    "<integer name='height' value='200'/></film>"

static void expect_tan(const char *parameters, float x) {
    char text[512];
    snprintf(text, sizeof text, "<sensor type='perspective'>%s" FILM "</sensor>", parameters);
    struct satin_scene *scene = scene_camera_load(text);
    assert_true(fabsf(scene->camera.tan_x - x) < 1e-6f * x);
    assert_true(fabsf(scene->camera.tan_y - 0.5f * x) < 1e-6f * x);
    satin_scene_free(scene);
}

static void the_field_of_view_is_right(void **state) {
    (void)state;
    float t = tanf(30.0f * PI_F / 180.0f);
    expect_tan("<float name='fov' value='60'/>", t);
    expect_tan("<float name='fov' value='60'/><string name='fov_axis' value='y'/>", 2 * t);
    expect_tan("<float name='fov' value='60'/><string name='fov_axis' value='smaller'/>", 2 * t);
    expect_tan("<float name='fov' value='60'/><string name='fov_axis' value='larger'/>", t);
    expect_tan("<float name='fov' value='60'/><string name='fov_axis' value='diagonal'/>",
               t / sqrtf(1.25f));
    float half = hypotf(36, 24) / 2;
    expect_tan("", half / 50 / sqrtf(1.25f));
    expect_tan("<string name='focal_length' value='35mm'/>", half / 35 / sqrtf(1.25f));
    expect_tan("<string name='focal_length' value='35 mm'/>", half / 35 / sqrtf(1.25f));
}

static void rays_of_a_pinhole_start_at_the_eye(void **state) {
    (void)state;
    struct satin_scene *scene = scene_camera_load(
        "<sensor type='perspective'><float name='fov' value='90'/>"
        "<float name='near_clip' value='.5'/><float name='far_clip' value='8'/>"
        "<transform name='to_world'><lookat origin='1 2 3' target='1 2 9' up='0 1 "
        "0'/></transform>" FILM "</sensor>");
    float spread;
    struct ray r = scene_camera_ray(scene, &scene->camera, (vec2){200, 100}, (vec2){0, 0}, &spread);
    assert_true(r.o.x == 1 && r.o.y == 2 && r.o.z == 3 && r.tnear == 0.5f && r.tfar == 8.0f);
    assert_true(v3_dist2(r.d, v3(0, 0, 1)) < 1e-12f);
    assert_true(fabsf(spread - 2.0f / 400.0f) < 1e-8f);
    // The ray is that of the top left corner, where left is +x and up is +y.
    r = scene_camera_ray(scene, &scene->camera, (vec2){0, 0}, (vec2){0, 0}, &spread);
    vec3 corner = v3_unit(v3(1, 0.5f, 1));
    assert_true(v3_dist2(r.d, corner) < 1e-12f);
    assert_true(fabsf(r.tnear - 0.5f / corner.z) < 1e-6f);
    // The spread is the root of the solid angle of a pixel.
    struct ray dx = scene_camera_ray(scene, &scene->camera, (vec2){1, 0}, (vec2){0, 0}, NULL),
               dy = scene_camera_ray(scene, &scene->camera, (vec2){0, 1}, (vec2){0, 0}, NULL);
    float area = v3_len(v3_cross(v3_sub(dx.d, r.d), v3_sub(dy.d, r.d)));
    assert_true(fabsf(spread * spread - area) < 0.01f * area);
    satin_scene_free(scene);
}

// All rays of a film position meet in the plane of focus, for any position on the lens.
static void a_lens_focuses(void **state) {
    (void)state;
    struct satin_scene *scene = scene_camera_load(
        "<sensor type='thinlens'><float name='fov' value='50'/>"
        "<float name='aperture_radius' value='.2'/><float name='focus_distance' value='3'/>" FILM
        "</sensor>");
    struct rng rng = rng_make(1, RNG_TEST, 0);
    for (int i = 0; i < 100; i++) {
        float x = 400 * rng_float(&rng), y = 200 * rng_float(&rng);
        struct ray a = scene_camera_ray(scene, &scene->camera, (vec2){x, y},
                                        (vec2){rng_float(&rng), rng_float(&rng)}, NULL);
        struct ray b = scene_camera_ray(scene, &scene->camera, (vec2){x, y},
                                        (vec2){rng_float(&rng), rng_float(&rng)}, NULL);
        vec3 pa = v3_mad(a.o, 3.0f / a.d.z, a.d), pb = v3_mad(b.o, 3.0f / b.d.z, b.d);
        assert_true(v3_dist2(pa, pb) < 1e-11f);
        assert_true(v3_len(a.o) <= 0.2f && a.o.z == 0.0f);
    }
    satin_scene_free(scene);
}

// The numbers are those of Mitsuba 3.9.
static void rays_of_an_orthographic_camera_are_parallel(void **state) {
    (void)state;
    struct satin_scene *scene = scene_camera_load(
        "<sensor type='orthographic'><transform name='to_world'><scale x='3' y='2' z='5'/>"
        "<translate z='-4'/></transform><float name='near_clip' value='.5'/>"
        "<float name='far_clip' value='20'/>" FILM "</sensor>");
    float spread;
    struct ray r = scene_camera_ray(scene, &scene->camera, (vec2){0, 0}, (vec2){0, 0}, &spread);
    assert_true(v3_dist2(r.o, v3(3, 1, -1.5f)) < 1e-12f && v3_dist2(r.d, v3(0, 0, 1)) == 0.0f);
    assert_true(r.tnear == 0.0f && r.tfar == 19.5f);
    assert_true(fabsf(spread * 1.5f - 6.0f / 400.0f) < 1e-6f);  // the middle is at the origin
    r = scene_camera_ray(scene, &scene->camera, (vec2){100, 100}, (vec2){0, 0}, &spread);
    assert_true(v3_dist2(r.o, v3(1.5f, 0, -1.5f)) < 1e-12f);
    satin_scene_free(scene);
}

// At the plane in focus all rays of a film position meet where its parallel ray is; at another
// depth z they fill a disk of the radius a |z - f| / f. Lengths are in world space.
static void a_telecentric_lens_focuses(void **state) {
    (void)state;
    struct satin_scene *scene = scene_camera_load(
        "<sensor type='telecentric'><transform name='to_world'><scale x='3' y='3' z='5'/>"
        "<translate z='-4'/></transform><float name='near_clip' value='.5'/>"
        "<float name='far_clip' value='20'/><float name='aperture_radius' value='.6'/>"
        "<float name='focus_distance' value='2'/>" FILM "</sensor>");
    struct rng rng = rng_make(1, RNG_TEST, 0);
    float widest = 0.0f, spread;
    for (int i = 0; i < 1000; i++) {
        const vec2 film = {400 * rng_float(&rng), 200 * rng_float(&rng)};
        const struct ray r = scene_camera_ray(scene, &scene->camera, film,
                                              (vec2){rng_float(&rng), rng_float(&rng)}, &spread);
        const float x = 3.0f - 6.0f * film.x / 400.0f, y = 1.5f - 3.0f * film.y / 200.0f;
        const vec3 focus = v3_mad(r.o, 2.0f / r.d.z, r.d), far = v3_mad(r.o, 6.0f / r.d.z, r.d);
        assert_true(r.o.z == -4.0f && v3_dist2(focus, v3(x, y, -2)) < 1e-11f);
        widest = fmaxf(widest, sqrtf(v3_dist2(far, v3(x, y, 2))));
        assert_true(fabsf(r.tnear * r.d.z - 0.5f) < 1e-5f);
        assert_true(fabsf(r.tfar * r.d.z - 20.0f) < 1e-4f);
    }
    // The largest of 1000 radii of a uniform disk is below .99 with a probability of 2e-9.
    assert_true(widest > 0.99f * 1.2f && widest < 1.2f + 1e-5f);
    satin_scene_free(scene);
}

// Without a lens the rays are those of an orthographic camera, between planes of world space.
static void a_telecentric_camera_without_lens_is_orthographic(void **state) {
    (void)state;
    struct satin_scene *scene = scene_camera_load(
        "<sensor type='telecentric'><transform name='to_world'><scale x='3' y='2' z='5'/>"
        "<translate z='-4'/></transform><float name='near_clip' value='.5'/>"
        "<float name='far_clip' value='20'/>" FILM "</sensor>");
    float spread;
    const struct ray r =
        scene_camera_ray(scene, &scene->camera, (vec2){100, 100}, (vec2){0, 0}, &spread);
    assert_true(v3_dist2(r.o, v3(1.5f, 0, -3.5f)) < 1e-12f && v3_dist2(r.d, v3(0, 0, 1)) == 0.0f);
    assert_true(r.tnear == 0.0f && fabsf(r.tfar - 19.5f) < 1e-5f);
    satin_scene_free(scene);
}

static void wrong_lenses_are_refused(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {"<float name='aperture_radius' value='-1'/>",
         "scene.xml:2:28: aperture_radius is -1, but must be 0 or more"},
        {"<float name='focus_distance' value='0'/>",
         "scene.xml:2:28: focus_distance is 0, but must be positive"},
        {"<float name='near_clip' value='3'/><float name='far_clip' value='2'/>",
         "scene.xml:2:1: sensor 'telecentric': near_clip must be smaller than far_clip"},
        {"<transform name='to_world'><scale x='0'/></transform>",
         "scene.xml:2:1: sensor 'telecentric': to_world is singular"},
        {"<transform name='to_world'><scale value='1e-14'/></transform>"
         "<float name='aperture_radius' value='20'/>",
         "scene.xml:2:1: sensor 'telecentric': its lens is too large, or its focus too near"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        char text[512];
        snprintf(text, sizeof text,
                 "<scene version='3.0.0'>\n<sensor type='telecentric'>%s</sensor></scene>",
                 cases[i][0]);
        assert_null(scene_case_load(&c, text));
        assert_string_equal(c.error, cases[i][1]);
    }
}

// The middle of the film is +z of camera space, a quarter to the left +x, the upper side +y.
static void a_spherical_camera_sees_all_directions(void **state) {
    (void)state;
    static const struct {
        vec2 film;
        vec3 d;
    } known[] = {{{200, 100}, {0, 0, 1}},  {{100, 100}, {1, 0, 0}},
                 {{300, 100}, {-1, 0, 0}}, {{0, 100}, {0, 0, -1}},
                 {{400, 100}, {0, 0, -1}}, {{77, 0}, {0, 1, 0}},
                 {{77, 200}, {0, -1, 0}},  {{200, 50}, {0, .70710678f, .70710678f}}};
    struct satin_scene *scene = scene_camera_load(
        "<sensor type='spherical'><transform name='to_world'><rotate y='1' angle='90'/>"
        "<translate x='7'/></transform>" FILM "</sensor>");
    float spread;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        const vec3 d = known[i].d;
        const struct ray r =
            scene_camera_ray(scene, &scene->camera, known[i].film, (vec2){0, 0}, &spread);
        assert_true(v3_dist2(r.o, v3(7, 0, 0)) == 0.0f && r.tnear == 0.0f && isinf(r.tfar));
        assert_true(v3_dist2(r.d, v3(d.z, d.y, -d.x)) < 1e-12f);
        assert_float_equal(spread, PI_F / 200.0f, 1e-7f);  // pixels are squares at the equator
    }
    satin_scene_free(scene);
    scene = scene_camera_load("<sensor type='spherical'>" FILM "</sensor>");
    // A film twice as high has pixels that are twice as wide as high at the equator.
    scene->film.height *= 2;
    scene_camera_ray(scene, &scene->camera, (vec2){0, 200}, (vec2){0, 0}, &spread);
    assert_float_equal(spread, 2.0f * PI_F / 400.0f, 1e-7f);
    satin_scene_free(scene);
}

static void samples_are_distributed_evenly_to_all_cameras(void **state) {
    (void)state;
    enum { VIEWS = 7, SAMPLES = 700 };
    struct camera view[VIEWS] = {{.tan_x = 0}};
    struct satin_scene scene = {.camera = {.tan_x = 1}};
    for (uint32_t i = 0; i < 10; i++)
        assert_ptr_equal(scene_camera_sample(&scene, i), &scene.camera);
    scene.view = view;
    scene.view_count = VIEWS;
    int count[VIEWS] = {0};
    for (uint32_t i = 0; i < SAMPLES; i++) count[scene_camera_sample(&scene, i) - view]++;
    // A sequence by the golden ratio has a discrepancy of about log n / n.
    for (int i = 0; i < VIEWS; i++)
        assert_in_range(count[i], SAMPLES / VIEWS - 5, SAMPLES / VIEWS + 5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_are_distributed_evenly_to_all_cameras),
        cmocka_unit_test(the_field_of_view_is_right),
        cmocka_unit_test(rays_of_a_pinhole_start_at_the_eye),
        cmocka_unit_test(a_lens_focuses),
        cmocka_unit_test(rays_of_an_orthographic_camera_are_parallel),
        cmocka_unit_test(a_telecentric_lens_focuses),
        cmocka_unit_test(wrong_lenses_are_refused),
        cmocka_unit_test(a_spherical_camera_sees_all_directions),
        cmocka_unit_test(a_telecentric_camera_without_lens_is_orthographic),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
