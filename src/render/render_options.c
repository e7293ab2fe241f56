// SPDX-License-Identifier: Apache-2.0
// Resolves the options with the scene: options that the caller left open are taken from the scene,
// or else from a default.
#include <stdio.h>
#include <string.h>

#include "base/text.h"
#include "render/options_quality.h"
#include "render/options_table.h"
#include "render/render_state.h"

static int resolve_value(int value, int open, int scene, int scene_open, int fallback) {
    if (value != open) return value;
    return scene != scene_open ? scene : fallback;
}

// Sets another film size: if only one number is given, the aspect ratio is kept, else the
// horizontal field of view. A crop window keeps its position.
static void resize(struct satin_scene *scene, int width, int height) {
    struct scene_film *film = &scene->film;
    if (width <= 0 && height <= 0) return;
    double aspect = (double)film->crop_height / film->crop_width;
    if (width <= 0) width = (int)fmax(1.0, floor(height / aspect + 0.5));
    if (height <= 0) height = (int)fmax(1.0, floor(width * aspect + 0.5));
    double sx = (double)width / film->crop_width, sy = (double)height / film->crop_height;
    scene->camera.tan_y *= (float)(sy / sx);
    film->crop_x = (int)floor(film->crop_x * sx + 0.5);
    film->crop_y = (int)floor(film->crop_y * sy + 0.5);
    film->width = (int)fmax(film->crop_x + width, floor(film->width * sx + 0.5));
    film->height = (int)fmax(film->crop_y + height, floor(film->height * sy + 0.5));
    film->crop_width = width;
    film->crop_height = height;
}

// Replaces the scene's crop window by that of the options, after the film has got its size. If they
// have one, *o gets its whole size.
static satin_status set_film(struct satin_scene *scene, satin_options *o, struct log log) {
    struct scene_film *film = &scene->film;
    const bool crop = o->crop_x > 0 || o->crop_y > 0 || o->crop_width > 0 || o->crop_height > 0;
    if (crop) {
        film->crop_x = film->crop_y = 0;
        film->crop_width = film->width;
        film->crop_height = film->height;
    }
    resize(scene, o->width, o->height);
    if (!crop) return SATIN_OK;
    // At least 1, so that a position outside of the film is refused.
    if (o->crop_width == 0) o->crop_width = (int)fmax(film->width - o->crop_x, 1.0);
    if (o->crop_height == 0) o->crop_height = (int)fmax(film->height - o->crop_y, 1.0);
    if ((int64_t)o->crop_x + o->crop_width > film->width ||
        (int64_t)o->crop_y + o->crop_height > film->height)
        return log_fail(log, SATIN_ERROR_INPUT,
                        "the crop of %dx%d pixels at (%d, %d) is not inside of the film of %dx%d",
                        o->crop_width, o->crop_height, o->crop_x, o->crop_y, film->width,
                        film->height);
    film->crop_x = o->crop_x;
    film->crop_y = o->crop_y;
    film->crop_width = o->crop_width;
    film->crop_height = o->crop_height;
    return SATIN_OK;
}

// Checks that every name in material_cache is that of a material, whether or not this render uses
// caches.
static satin_status check_materials(const struct satin_scene *scene, const satin_options *o,
                                    struct log log) {
    char name[sizeof o->material_cache];
    for (const char *at = o->material_cache; *at;) {
        size_t word = strcspn(at, ",");
        snprintf(name, sizeof name, "%.*s", (int)strcspn(at, "="), at);
        struct text_nearest search = {.word = name};
        bool known = false;
        for (uint32_t i = 0; i < scene->material_count && !known; i++) {
            known = strcmp(scene->material[i].name, name) == 0;
            text_nearest_try(&search, scene->material[i].name);
        }
        if (!known && search.best)
            return log_fail(log, SATIN_ERROR_INPUT,
                            "option material-cache: no material '%s' (did you mean '%s'?)", name,
                            search.best);
        if (!known)
            return log_fail(log, SATIN_ERROR_INPUT, "option material-cache: no material '%s'",
                            name);
        at += word + (at[word] == ',');
    }
    return SATIN_OK;
}

satin_status render_resolve(struct render *r, const struct satin_scene *scene,
                            const satin_options *options) {
    const struct scene_hints *hints = &scene->hints;
    satin_options *o = &r->options;
    r->scene = *scene;
    *o = *options;
    satin_status status = options_check(options, r->log);
    if (status == SATIN_OK) status = set_film(&r->scene, o, r->log);
    if (status != SATIN_OK) return status;
    o->width = r->scene.film.crop_width;
    o->height = r->scene.film.crop_height;
    if ((int64_t)o->width * o->height > INT32_MAX)
        return log_fail(r->log, SATIN_ERROR_INPUT, "a film of %d x %d pixels is too large",
                        o->width, o->height);
    status = check_materials(scene, o, r->log);
    if (status != SATIN_OK) return status;
    o->max_depth = resolve_value(o->max_depth, -2, hints->max_depth, -2, -1);
    o->rr_depth = resolve_value(o->rr_depth, 0, hints->rr_depth, 0, 5);
    o->hide_emitters = resolve_value(o->hide_emitters, -1, hints->hide_emitters, -1, 0);
    // A render with a time limit takes as many samples as fit. The number of samples that a scene
    // has for a path tracer would be wasteful for two passes.
    int scene_spp = gather_traces_paths(o) ? hints->spp : 0;
    // With negative weights a smooth image needs many samples too.
    if (scene_film_filter_has_lobes(&scene->film)) o->adaptive_sampling = false;
    if (o->spp == 0 && o->time > 0.0) o->spp = RENDER_TIMED_SPP;
    r->first_pass.wanted = o->photons;
    r->first_pass.photons_chosen = !options_quality_chooses_photons(o);
    r->first_pass.caustics_chosen = !options_quality_chooses_caustics(o);
    if (o->time > 0.0)
        options_quality_seconds(o, render_core_seconds(r), (double)o->width * (double)o->height);
    o->spp = resolve_value(o->spp, 0, scene_spp, 0, options_quality_spp(o->quality));
    return SATIN_OK;
}
