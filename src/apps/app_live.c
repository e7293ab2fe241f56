// SPDX-License-Identifier: Apache-2.0
// The live view of satin render: shows snapshots of the image while it is rendered. A picture that
// cannot be written costs a warning, never the render.
#include <stdlib.h>

#include "apps/app_live.h"
#include "film/film.h"

static void warn(void *user, satin_log_severity severity, const char *message) {
    (void)severity;
    app_log(user, SATIN_LOG_WARNING, message);
}

bool app_live_progress(void *user, const satin_progress *now) {
    struct app_live *live = user;
    app_display_send(&live->display);
    return app_progress_update(live->progress, now);
}

void app_live_snapshot(void *user, const satin_film *film) {
    struct app_live *live = user;
    const struct log log = {warn, live->progress};
    app_display_show(&live->display, film);
    if (!live->preview || live->failed) return;
    live->failed = film_write_preview(film, live->preview, live->tonemap, log) != SATIN_OK;
}

void app_live_finish(struct app_live *live, const satin_film *film) {
    if (live->preview && film)
        satin_film_write_png(film, live->preview, live->tonemap, warn, live->progress);
    app_display_finish(&live->display, film);
}
