// SPDX-License-Identifier: Apache-2.0
// Pictures of a study's page, as PNG in data URIs: the reference of each scene, and of each point
// the image of the first seed, that of its first pass, and the difference from the
// reference. All pictures of a scene have the exposure of its reference. A difference is a grey
// picture of (Y - Y_r) / sqrt(Y_r^2 + 0.01), which the page colours: with d of [-1, 1], the grey is
// 128 + 127 sign(d) sqrt(|d|).
#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "study/study_report.h"

static const double DARK_FLOOR = 0.01;  // as in relMSE
enum { PAGE_BYTES = 24000000, PICTURE_WIDTH_MIN = 96, PICTURE_WIDTH_MAX = 480 };
// The bytes of a pixel of a noisy image, of its first pass and of its difference, in base 64.
static const double PIXEL_BYTES = 8.0;

struct pictures {
    const struct study_report *report;
    struct study_text *out;
    int width, height;  // of the pictures of the current scene
    const satin_film *reference;
    double exposure;
    float *light;          // scratch: three planes of the picture's size
    unsigned char *pixel;  // scratch: three bytes per pixel
};

// A plane of a film at the size of the pictures: the mean over the pixels that a pixel covers.
static void shrink_plane(const struct pictures *p, const satin_film *film, const float *from,
                         float *to) {
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++) {
            const int x0 = x * film->width / p->width, x1 = (x + 1) * film->width / p->width;
            const int y0 = y * film->height / p->height, y1 = (y + 1) * film->height / p->height;
            double sum = 0.0, count = 0.0;
            for (int v = y0; v < (y1 > y0 ? y1 : y0 + 1); v++)
                for (int u = x0; u < (x1 > x0 ? x1 : x0 + 1); u++, count++)
                    sum += (double)from[(size_t)v * (size_t)film->width + (size_t)u];
            to[(size_t)y * (size_t)p->width + (size_t)x] = (float)(sum / count);
        }
}

// The luminance of a film at the size of the pictures, or R, G and B if `planes` is 3.
static void shrink_film(const struct pictures *p, const satin_film *film, int planes, float *to) {
    static const char *const name[3] = {"R", "G", "B"};
    const size_t count = (size_t)p->width * (size_t)p->height;
    for (int c = 0; c < 3; c++)
        shrink_plane(p, film, satin_film_channel(film, name[c]), p->light + (size_t)c * count);
    for (size_t i = 0; i < count && planes == 1; i++)
        to[i] = rgb_luminance(rgb_make(p->light[i], p->light[count + i], p->light[2 * count + i]));
}

static satin_status add_png(struct pictures *p, int channels) {
    void *data = NULL;
    size_t size = 0;
    const struct film_pixels picture = {p->width, p->height, channels, p->pixel};
    const satin_status status =
        film_encode_pixels("study.html", &picture, p->report->log, &data, &size);
    if (status != SATIN_OK) return status;
    study_text_add(p->out, "\"data:image/png;base64,");
    study_text_base64(p->out, data, size);
    study_text_add(p->out, "\"");
    free(data);
    return SATIN_OK;
}

static satin_status add_picture(struct pictures *p, const satin_film *film) {
    const size_t count = (size_t)p->width * (size_t)p->height;
    shrink_film(p, film, 3, NULL);
    for (size_t i = 0; i < 3 * count; i++)
        p->pixel[3 * (i % count) + i / count] =
            film_encode_srgb((float)(p->exposure * (double)p->light[i]));
    return add_png(p, 3);
}

static satin_status add_difference_picture(struct pictures *p, const satin_film *film) {
    const size_t count = (size_t)p->width * (size_t)p->height;
    float *before = p->light + 3 * count, *now = p->light + 4 * count;
    shrink_film(p, p->reference, 1, before);
    shrink_film(p, film, 1, now);
    for (size_t i = 0; i < count; i++) {
        const double r = (double)before[i];
        const double d = ((double)now[i] - r) / sqrt(r * r + DARK_FLOOR);
        const double root = isfinite(d) ? copysign(sqrt(fmin(fabs(d), 1.0)), d) : 1.0;
        p->pixel[i] = (unsigned char)(128.5 + 127.0 * root);
    }
    return add_png(p, 1);
}

// ---- Points -------------------------------------------------------------------------------------

// The image of a render, or NULL in *film if there is none.
static satin_status open_image(const struct pictures *p, const struct study_render *render,
                               satin_film **film) {
    *film = NULL;
    if (!render || !render->result.done || render->result.status != 0 || render->result.signal != 0)
        return SATIN_OK;
    return study_store_image(p->report->store, p->report->log, render, film);
}

// The picture of a render and its difference, or null.
static satin_status add_pair(struct pictures *p, const struct study_render *render,
                             const char *image, const char *difference) {
    satin_film *film;
    satin_status status = open_image(p, render, &film);
    study_text_add(p->out, "\"%s\": ", image);
    if (film)
        status = add_picture(p, film);
    else
        study_text_add(p->out, "null");
    study_text_add(p->out, ", \"%s\": ", difference);
    if (film && status == SATIN_OK)
        status = add_difference_picture(p, film);
    else
        study_text_add(p->out, "null");
    satin_film_free(film);
    return status;
}

// The first point before `point` that has the same image of its first pass, or `point`.
static size_t first_with_first_pass(const struct study_plan *plan, size_t scene, size_t point) {
    const struct study_render *first_pass = study_plan_first_pass(plan, scene, point, 0);
    for (size_t i = 0; first_pass && i < point; i++)
        if (study_plan_first_pass(plan, scene, i, 0) == first_pass) return i;
    return point;
}

static satin_status add_point_pictures(struct pictures *p, size_t scene, size_t point) {
    const struct study_plan *plan = p->report->plan;
    study_text_add(p->out, "%s\n{", point ? "," : "");
    satin_status status =
        add_pair(p, study_plan_image(plan, scene, point, 0), "image", "difference");
    const size_t first = first_with_first_pass(plan, scene, point);
    study_text_add(p->out, ", ");
    if (status == SATIN_OK && first == point)
        status = add_pair(p, study_plan_first_pass(plan, scene, point, 0), "first_pass",
                          "first_pass_difference");
    else
        study_text_add(p->out, "\"first_pass_of\": %zu", first);
    study_text_add(p->out, "}");
    return status;
}

// ---- Scenes -------------------------------------------------------------------------------------

// The width at which all pictures of the page stay within PAGE_BYTES.
static int choose_width(const struct study_report *report, int width, int height) {
    const struct study *s = &report->plan->study;
    const double pictures = (double)(s->scenes * s->points + s->scenes);
    const double pixels = (double)PAGE_BYTES / pictures / PIXEL_BYTES;
    double chosen = fmin(sqrt(pixels * (double)width / (double)height), (double)PICTURE_WIDTH_MAX);
    if (s->picture_width) chosen = (double)s->picture_width;
    return (int)fmin(fmax(chosen, (double)PICTURE_WIDTH_MIN), (double)width);
}

static satin_status add_scene_pictures(struct pictures *p, size_t scene) {
    const satin_film *r = p->reference;
    const size_t points = p->report->plan->study.points;
    const struct film_light light = {.plane = {satin_film_channel(r, "R"),
                                               satin_film_channel(r, "G"),
                                               satin_film_channel(r, "B")}};
    p->width = choose_width(p->report, r->width, r->height);
    p->height = (int)fmax(1.0, round((double)p->width * (double)r->height / (double)r->width));
    const size_t count = (size_t)p->width * (size_t)p->height;
    p->exposure = film_auto_exposure(r, &light);
    p->light = array_new(5 * count, sizeof *p->light);
    p->pixel = array_new(3 * count, 1);
    satin_status status = p->light && p->pixel ? SATIN_OK : SATIN_ERROR_MEMORY;
    study_text_add(p->out, "%s\n{\"width\": %d, \"height\": %d, \"reference\": ", scene ? "," : "",
                   p->width, p->height);
    if (status == SATIN_OK) status = add_picture(p, r);
    study_text_add(p->out, ", \"points\": [");
    for (size_t i = 0; i < points && status == SATIN_OK; i++)
        status = add_point_pictures(p, scene, i);
    study_text_add(p->out, "]}");
    free(p->light);
    free(p->pixel);
    return status;
}

satin_status study_pictures_add(const struct study_report *report, struct study_text *out) {
    satin_status status = SATIN_OK;
    study_text_add(out, "[");
    for (size_t i = 0; i < report->plan->study.scenes && status == SATIN_OK; i++) {
        struct study_reference reference;
        status = study_report_reference(report, i, &reference);
        struct pictures p = {.report = report, .out = out, .reference = reference.mean};
        if (status == SATIN_OK) status = add_scene_pictures(&p, i);
        study_reference_free(&reference);
    }
    study_text_add(out, "]");
    return status;
}
