// SPDX-License-Identifier: Apache-2.0
// The option --preview: a picture of the image so far. If it cannot be written, that costs a
// warning, never the render.
#include "apps/app_preview.h"

#include "film/film.h"

static void warn(void *user, satin_log_severity severity, const char *message) {
    (void)severity;
    app_log(user, SATIN_LOG_WARNING, message);
}

void app_preview_write(struct app_preview *preview, const satin_film *snapshot) {
    if (!preview->path || preview->failed) return;
    const struct log log = {warn, preview->progress};
    preview->failed =
        film_write_preview(snapshot, preview->path, preview->tonemap, log) != SATIN_OK;
}

void app_preview_finish(const struct app_preview *preview, const satin_film *film) {
    if (preview->path && film)
        film_write_png_as(film, preview->path, preview->tonemap, preview->format,
                          (struct log){warn, preview->progress});
}
