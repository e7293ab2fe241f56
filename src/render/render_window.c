// SPDX-License-Identifier: Apache-2.0
// The film of a render and the part of it that is rendered, of the scene's film and of the options
// of its size and crop.
#include <math.h>

#include "render/render.h"
#include "render/render_state.h"

// More would let counts of rows and columns overflow.
static const double FILM_SIDE = 1 << 20;

// The pixels of a film of `now` pixels that show what those of a film of `before` pixels show: from
// the edge next to that of the first one to the edge next to that of the last one, at least one.
static void scale_window(int before, int now, int *first, int *count) {
    const double scale = (double)now / (double)before;
    int begin = (int)floor((double)*first * scale + 0.5);
    int end = (int)floor((double)(*first + *count) * scale + 0.5);
    if (begin > now - 1) begin = now - 1;
    if (end <= begin) end = begin + 1;
    *first = begin;
    *count = end - begin;
}

// Sets another size of the whole film, of which a crop window shows the same region. If only one
// number is given, the aspect ratio is kept, else the horizontal field of view.
static satin_status set_size(struct satin_scene *scene, int width, int height, struct log log) {
    struct scene_film *film = &scene->film;
    if (width <= 0 && height <= 0) return SATIN_OK;
    const double aspect = (double)film->height / (double)film->width;
    const double w = width > 0 ? (double)width : fmax(1.0, floor((double)height / aspect + 0.5));
    const double h = height > 0 ? (double)height : fmax(1.0, floor((double)width * aspect + 0.5));
    if (w > FILM_SIDE || h > FILM_SIDE)
        return log_fail(log, SATIN_ERROR_INPUT, "a film of %.0f x %.0f pixels is too large", w, h);
    scale_window(film->width, (int)w, &film->crop_x, &film->crop_width);
    scale_window(film->height, (int)h, &film->crop_y, &film->crop_height);
    const double sx = w / (double)film->width, sy = h / (double)film->height;
    film->width = (int)w;
    film->height = (int)h;
    if (!scene->camera.spherical) scene->camera.tan_y *= (float)(sy / sx);
    return SATIN_OK;
}

static bool has_crop(const satin_options *o) {
    return o->crop_x > 0 || o->crop_y > 0 || o->crop_width > 0 || o->crop_height > 0;
}

// Replaces the scene's crop window by that of the options.
static satin_status set_crop(struct scene_film *film, const satin_options *o, struct log log) {
    // At least 1, so that a position outside of the film is refused.
    const int width = o->crop_width > 0 ? o->crop_width : (int)fmax(film->width - o->crop_x, 1.0);
    const int height =
        o->crop_height > 0 ? o->crop_height : (int)fmax(film->height - o->crop_y, 1.0);
    if ((int64_t)o->crop_x + width > film->width || (int64_t)o->crop_y + height > film->height)
        return log_fail(log, SATIN_ERROR_INPUT,
                        "the crop of %dx%d pixels at (%d, %d) is not inside of the film of %dx%d",
                        width, height, o->crop_x, o->crop_y, film->width, film->height);
    film->crop_x = o->crop_x;
    film->crop_y = o->crop_y;
    film->crop_width = width;
    film->crop_height = height;
    return SATIN_OK;
}

satin_status render_window(struct satin_scene *scene, satin_options *o, struct log log) {
    struct scene_film *film = &scene->film;
    satin_status status = set_size(scene, o->width, o->height, log);
    if (status == SATIN_OK && has_crop(o)) status = set_crop(film, o, log);
    if (status != SATIN_OK) return status;
    if ((int64_t)film->crop_width * film->crop_height > INT32_MAX)
        return log_fail(log, SATIN_ERROR_INPUT, "a film of %d x %d pixels is too large",
                        film->crop_width, film->crop_height);
    const bool whole = film->crop_width == film->width && film->crop_height == film->height;
    if (whole && !has_crop(o)) return SATIN_OK;
    o->crop_x = film->crop_x;
    o->crop_y = film->crop_y;
    o->crop_width = film->crop_width;
    o->crop_height = film->crop_height;
    return SATIN_OK;
}

satin_status render_size(const satin_scene *scene, const satin_options *options, struct log log,
                         int *width, int *height) {
    struct satin_scene sized = *scene;
    satin_options o = *options;
    const satin_status status = render_window(&sized, &o, log);
    if (status != SATIN_OK) return status;
    *width = sized.film.crop_width;
    *height = sized.film.crop_height;
    return SATIN_OK;
}
