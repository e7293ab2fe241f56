// SPDX-License-Identifier: Apache-2.0
// The time of a render may end at any moment: it makes an image, whose values are finite.
#include "satin/render.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

// Moments of each kind of render, evenly distributed over it.
enum { MOMENTS = 40, KIND_SETTINGS = 3 };
// The longest time limit [s], within which a render of this size does all of its steps.
static const double LAST_MOMENT = 0.2;

static const char *timed_scene_folder;  // of the command line

// A kind of renders.
struct timed_render {
    const char *scene;
    satin_setting set[KIND_SETTINGS];  // ended by a name of NULL
};

static const struct timed_render timed_renders[] = {
    {"cornell-glossy.xml", {{NULL, NULL}}},
    {"caustic.xml", {{NULL, NULL}}},
    {"cases/window.xml", {{"denoise", "on"}}},
    {"cases/spot-lamp.xml", {{"first-pass", "recursive"}, {"recursive-bounces", "1"}}},
    {"cases/corner.xml", {{"first-pass", "recursive"}, {"final-gather", "off"}}},
    {"cases/spot-lamp.xml", {{"integrator", "sppm"}, {"spp", "3"}}},
    {"cases/corner.xml", {{"integrator", "path"}}},
    {"cases/corner.xml", {{"integrator", "photons"}}},
};

static void drop_message(void *user, satin_log_severity severity, const char *message) {
    (void)user, (void)severity, (void)message;
}

static void check_film(const satin_film *film) {
    int width, height;
    const char *name;
    satin_film_size(film, &width, &height);
    for (int i = 0; (name = satin_film_channel_name(film, i)); i++) {
        const float *value = satin_film_channel(film, name);
        for (int k = 0; k < width * height; k++) assert_true(isfinite(value[k]));
    }
}

static void render_for(const struct timed_render *kind, const satin_scene *scene, double seconds) {
    const satin_setting set[] = {{"quality", "draft"},
                                 {"width", "20"},
                                 {"height", "16"},
                                 {"photons", "2000"},
                                 {"caustic-photons", "2000"},
                                 {"radiance-order", "3"},
                                 {"irradiance-rays", "50"},
                                 {"radiance-rays", "50"},
                                 {"threads", "2"}};
    satin_options options;
    assert_int_equal(
        satin_options_resolve(scene, set, sizeof set / sizeof *set, NULL, NULL, &options),
        SATIN_OK);
    for (int i = 0; i < KIND_SETTINGS && kind->set[i].name; i++)
        assert_int_equal(
            satin_options_set(&options, kind->set[i].name, kind->set[i].value, NULL, NULL),
            SATIN_OK);
    options.time = seconds;
    const satin_callbacks callbacks = {.log = drop_message};
    satin_film *film = NULL;
    assert_int_equal(satin_render(scene, &options, &callbacks, &film), SATIN_OK);
    check_film(film);
    satin_film_free(film);
}

static satin_scene *load_timed(const struct timed_render *kind) {
    char path[4096];
    satin_scene *scene = NULL;
    snprintf(path, sizeof path, "%s/%s", timed_scene_folder, kind->scene);
    assert_int_equal(satin_scene_load(path, NULL, 0, NULL, NULL, &scene), SATIN_OK);
    return scene;
}

static void time_can_end_anywhere(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof timed_renders / sizeof *timed_renders; i++) {
        satin_scene *scene = load_timed(&timed_renders[i]);
        for (int k = 1; k <= MOMENTS; k++)
            render_for(&timed_renders[i], scene, LAST_MOMENT * (double)k / MOMENTS);
        satin_scene_free(scene);
    }
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(time_can_end_anywhere)};
    if (argc < 2) return 1;
    timed_scene_folder = argv[1];
    return cmocka_run_group_tests(tests, NULL, NULL);
}
