// SPDX-License-Identifier: Apache-2.0
// For tests of the scene loader: files in a folder of their own, messages caught.
#ifndef SCENE_CASE_H
#define SCENE_CASE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "folder_case.h"
#include "load/load_params.h"
#include "satin/scene.h"

// The messages of one run.
struct scene_case {
    int errors, warnings;
    char error[1024], warning[1024];  // the last of each
};

static inline void scene_case_log(void *user, satin_log_severity severity, const char *message) {
    struct scene_case *c = user;
    char *last = severity == SATIN_LOG_ERROR ? c->error : c->warning;
    if (severity == SATIN_LOG_ERROR)
        c->errors++;
    else
        c->warnings++;
    snprintf(last, sizeof c->error, "%s", message);
}

static inline struct log scene_case_begin(struct scene_case *c) {
    *c = (struct scene_case){0};
    return (struct log){scene_case_log, c};
}

static inline void scene_case_bytes(const char *name, const void *data, size_t size) {
    assert_true(folder_case_made());  // the tests have folder_case_setup
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static inline void scene_case_file(const char *name, const char *text) {
    scene_case_bytes(name, text, strlen(text));
}

// Loads the text as a scene. Returns a scene, or NULL with one error.
static inline satin_scene *scene_case_load(struct scene_case *c, const char *text) {
    satin_scene *scene = NULL;
    struct log log = scene_case_begin(c);
    scene_case_file("scene.xml", text);
    satin_status status = satin_scene_load("scene.xml", NULL, 0, log.fn, log.user, &scene);
    assert_true((status == SATIN_OK) == (scene != NULL) && c->errors == (scene == NULL));
    return scene;
}

// The body of a scene with a sensor, so that it loads.
#define SCENE_TEXT(body) \
    "<scene version=\"3.0.0\">\n<sensor type=\"perspective\"/>\n" body "</scene>"

#endif
