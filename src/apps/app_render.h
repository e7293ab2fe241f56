// SPDX-License-Identifier: Apache-2.0
// What `satin render` is asked for, as its arguments have it.
#ifndef APP_RENDER_H
#define APP_RENDER_H

#include <stdbool.h>
#include <stddef.h>

#include "apps/app_display.h"
#include "apps/app_ranks.h"
#include "satin/render.h"

// The texts are those of the arguments, except for those at the end.
struct app_render_request {
    const char *scene, *output, *png, *preview, *stats, *load, *save, *checkpoint, *sensor,
        *animation, *frames;
    bool toned, want_png, resume, quiet, help;
    double checkpoint_seconds;
    struct app_display display;
    satin_tonemap tonemap;
    satin_exr_format format;
    unsigned scene_flags;
    satin_define *define;
    satin_setting *setting;
    size_t define_count, setting_count;
    const struct app_ranks *ranks;
    // Names of outputs that were asked for without a name; owned.
    char *png_beside, *checkpoint_beside;
};

// Reads the arguments after `render` (app_render_args.c). `define` and `setting` have space for as
// many entries as there are arguments, `setting` for four times as many. Reports an error and
// returns APP_WRONG.
int app_render_read(int argc, char **argv, struct app_render_request *r);

#endif
