// SPDX-License-Identifier: Apache-2.0
// The option --preview: a picture that is rewritten while the image is rendered.
#ifndef APP_PREVIEW_H
#define APP_PREVIEW_H

#include "apps/app.h"

struct app_preview {
    const char *path;  // of a PNG; NULL: there is none
    const satin_tonemap *tonemap;
    const satin_exr_format *format;  // of the file, which the finished image has too
    struct app_progress *progress;   // which prints warnings
    bool failed;                     // the picture could not be written, which was reported
};

// Writes a snapshot of the image. If that fails, once a warning is printed.
void app_preview_write(struct app_preview *preview, const satin_film *snapshot);
// Writes the finished image; NULL: there is none.
void app_preview_finish(const struct app_preview *preview, const satin_film *film);

#endif
