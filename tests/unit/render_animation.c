// SPDX-License-Identifier: Apache-2.0
// Animations through the library: its functions are called for each frame in order, their status
// ends the render, and what cannot be an animation is refused.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "satin/render.h"

static const char *scene_path;

static const satin_view VIEWS[4] = {{{0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 0},
                                    {{1, 0, 5}, {0, 0, 0}, {0, 1, 0}, 50},
                                    {{2, 0, 4}, {0, 0, 0}, {0, 1, 0}, 60},
                                    {{3, 0, 4}, {0, 0, 0}, {0, 1, 0}, 60}};

// What the functions of an animation are to do, and what they were called for.
struct animated {
    int fail_at, complete_at;  // numbers of frames; 0: none
    char calls[64], message[256];
    int frames;  // of the last report
};

static satin_status take_image(void *user, int number, const satin_film *film) {
    struct animated *a = user;
    int width, height;
    satin_film_size(film, &width, &height);
    assert_true(width == 8 && height == 6 && satin_film_channel(film, "R"));
    snprintf(a->calls + strlen(a->calls), 8, " %d", number);
    return number == a->fail_at ? SATIN_ERROR_MEMORY : SATIN_OK;
}

static satin_status find_complete(void *user, int number, const char *job, bool *complete) {
    const struct animated *a = user;
    assert_true(strncmp(job, "version=", 8) == 0 && strstr(job, " scene=") &&
                strstr(job, " views="));
    *complete = number == a->complete_at || a->complete_at < 0;
    return SATIN_OK;
}

static void keep_error(void *user, satin_log_severity severity, const char *message) {
    struct animated *a = user;
    if (severity == SATIN_LOG_ERROR) snprintf(a->message, sizeof a->message, "%s", message);
}

static bool keep_frames(void *user, const satin_progress *now) {
    struct animated *a = user;
    assert_true(now->frame >= 0 && now->frame <= now->frames);
    a->frames = now->frames;
    return false;
}

// Renders, with `change` replacing what it has of the animation of frames 5 to 7 of 5 to 8.
static satin_status animate(struct animated *a, const satin_animation *change, unsigned flags,
                            const char *integrator) {
    satin_scene *scene = NULL;
    const satin_scene_request request = {.flags = flags};
    assert_int_equal(satin_scene_load_request(scene_path, &request, NULL, NULL, &scene), SATIN_OK);
    assert_int_equal(satin_scene_sensor_count(scene), flags ? 1 : 0);
    satin_options options = satin_options_default;
    satin_options_preset(&options, SATIN_DRAFT);
    options.spp = 2;
    options.photons = options.caustic_photons = 1000;
    assert_int_equal(satin_options_set(&options, "integrator", integrator, NULL, NULL), SATIN_OK);
    satin_animation animation = {VIEWS, 4, 5, 5, 7, take_image, find_complete, a, NULL, 0};
    if (change) animation = *change;
    animation.user = a;
    const satin_callbacks callbacks = {.log = keep_error,
                                       .log_user = a,
                                       .progress = keep_frames,
                                       .progress_user = a,
                                       .animation = &animation};
    satin_film *film = NULL;
    const satin_status status = satin_render(scene, &options, &callbacks, &film);
    assert_null(film);
    satin_scene_free(scene);
    return status;
}

static void frames_come_in_their_order(void **state) {
    (void)state;
    struct animated a = {0}, failing = {.fail_at = 6}, some = {.complete_at = 6},
                    all = {.complete_at = -1};
    assert_int_equal(animate(&a, NULL, 0, "two-pass"), SATIN_OK);
    assert_string_equal(a.calls, " 5 6 7");
    assert_int_equal(a.frames, 3);
    assert_int_equal(animate(&failing, NULL, 0, "two-pass"), SATIN_ERROR_MEMORY);
    assert_string_equal(failing.message, "");  // the function reports it
    assert_string_equal(failing.calls, " 5 6");
    assert_int_equal(animate(&some, NULL, 0, "two-pass"), SATIN_OK);
    assert_string_equal(some.calls, " 5 7");
    assert_int_equal(some.frames, 2);
    assert_int_equal(animate(&all, NULL, 0, "two-pass"), SATIN_OK);
    assert_string_equal(all.calls, "");
}

static void sensors_are_frames(void **state) {
    (void)state;
    const satin_animation sensors = {NULL, 0, 3, 3, 3, take_image, NULL, NULL, NULL, 0};
    struct animated a = {0}, none = {0};
    assert_int_equal(animate(&a, &sensors, SATIN_SCENE_ALL_SENSORS, "direct"), SATIN_OK);
    assert_string_equal(a.calls, " 3");
    assert_int_equal(animate(&none, &sensors, 0, "direct"), SATIN_ERROR_ARGUMENT);
}

// A satin_moved_fn: the same scene in all frames, until one that it fails for.
static satin_status load_moved(void *user, int number, satin_scene **scene) {
    struct animated *a = user;
    snprintf(a->calls + strlen(a->calls), 8, " (%d)", number);
    if (number == a->complete_at) return SATIN_ERROR_INTERNAL;
    return satin_scene_load(scene_path, NULL, 0, NULL, NULL, scene);
}

static void moved_frames_have_scenes_of_their_own(void **state) {
    (void)state;
    const satin_animation moved = {VIEWS, 4, 5, 5, 7, take_image, NULL, NULL, load_moved, 1};
    struct animated a = {0}, failing = {.complete_at = 6};
    assert_int_equal(animate(&a, &moved, 0, "two-pass"), SATIN_OK);
    assert_string_equal(a.calls, " (5) 5 (6) 6 (7) 7");
    assert_int_equal(a.frames, 3);
    assert_int_equal(animate(&failing, &moved, 0, "two-pass"), SATIN_ERROR_INTERNAL);
    assert_string_equal(failing.calls, " (5) 5 (6)");
    assert_string_equal(failing.message, "");
}

static void wrong_animations_are_refused(void **state) {
    (void)state;
    const satin_view flat[1] = {{{0, 0, 1}, {0, 0, 1}, {0, 1, 0}, 0}};
    const satin_view wide[1] = {{{0, 0, 1}, {0, 0, 0}, {0, 1, 0}, 180}};
    const struct {
        satin_animation animation;
        satin_status status;
        const char *message;
    } cases[] = {
        {{VIEWS, 0, 5, 5, 7, take_image, NULL, NULL, NULL, 0}, SATIN_ERROR_ARGUMENT, "no frames"},
        {{VIEWS, 4, 5, 5, 7, NULL, NULL, NULL, NULL, 0}, SATIN_ERROR_ARGUMENT, "no function"},
        {{VIEWS, 4, 5, 4, 7, take_image, NULL, NULL, NULL, 0},
         SATIN_ERROR_INPUT,
         "frames 4 to 7 are not"},
        {{VIEWS, 4, 5, 5, 9, take_image, NULL, NULL, NULL, 0},
         SATIN_ERROR_INPUT,
         "of the frames 5 to 8"},
        {{VIEWS, 4, 5, 7, 6, take_image, NULL, NULL, NULL, 0}, SATIN_ERROR_INPUT, "frames 7 to 6"},
        {{flat, 1, 5, 5, 5, take_image, NULL, NULL, NULL, 0},
         SATIN_ERROR_INPUT,
         "frame 5 has no view"},
        {{wide, 1, 5, 5, 5, take_image, NULL, NULL, NULL, 0},
         SATIN_ERROR_INPUT,
         "the angle of view is 180"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct animated a = {0};
        assert_int_equal(animate(&a, &cases[i].animation, 0, "two-pass"), cases[i].status);
        assert_non_null(strstr(a.message, cases[i].message));
        assert_string_equal(a.calls, "");
    }
    struct animated a = {0};
    assert_int_equal(animate(&a, NULL, 0, "sppm"), SATIN_ERROR_INPUT);
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_come_in_their_order),
        cmocka_unit_test(sensors_are_frames),
        cmocka_unit_test(moved_frames_have_scenes_of_their_own),
        cmocka_unit_test(wrong_animations_are_refused),
    };
    if (argc != 2) return 2;
    scene_path = argv[1];
    return cmocka_run_group_tests(tests, NULL, NULL);
}
