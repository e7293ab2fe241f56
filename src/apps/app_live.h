// SPDX-License-Identifier: Apache-2.0
// The live view of satin render: a picture that is rewritten, and a viewer.
#ifndef APP_LIVE_H
#define APP_LIVE_H

#include "apps/app.h"
#include "apps/app_display.h"

struct app_live {
    const char *preview;  // PNG that is rewritten while the image is rendered; NULL: none
    const satin_tonemap *tonemap;
    struct app_display display;
    struct app_progress *progress;
    bool failed;  // the preview could not be written, which was reported
};

// A satin_progress_fn and a satin_snapshot_fn; `user` is a struct app_live. The first does what
// app_progress_update does, too.
bool app_live_progress(void *user, const satin_progress *now);
void app_live_snapshot(void *user, const satin_film *film);
// Shows the finished image. The snapshots are not valid any more; `film` is NULL if there is none.
void app_live_finish(struct app_live *live, const satin_film *film);

#endif
