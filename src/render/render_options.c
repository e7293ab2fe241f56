// SPDX-License-Identifier: Apache-2.0
// Resolves the options with the scene: options that the caller left open are taken from the scene,
// or else from a default.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "render/options_quality.h"
#include "render/options_table.h"
#include "render/render.h"
#include "render/render_state.h"

static int resolve_value(int value, int open, int scene, int scene_open, int fallback) {
    if (value != open) return value;
    return scene != scene_open ? scene : fallback;
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
    if (status == SATIN_OK) status = render_window(&r->scene, o, r->log);
    if (status != SATIN_OK) return status;
    o->width = r->scene.film.crop_width;
    o->height = r->scene.film.crop_height;
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
    r->second_pass.lights_chosen = !options_quality_chooses_lights(o);
    if (o->time > 0.0)
        options_quality_seconds(o, render_core_seconds(r), (double)o->width * (double)o->height);
    o->spp = resolve_value(o->spp, 0, scene_spp, 0, options_quality_spp(o->quality));
    return SATIN_OK;
}

satin_status render_used_options(const satin_scene *scene, const satin_options *options,
                                 struct log log, satin_options *out) {
    struct render *r = calloc(1, sizeof *r);
    satin_options used = *options;
    if (!r) return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory");
    r->log = log;
    const satin_status status = render_resolve(r, scene, options);
    used.max_depth = r->options.max_depth;
    used.rr_depth = r->options.rr_depth;
    used.hide_emitters = r->options.hide_emitters;
    used.adaptive_sampling = r->options.adaptive_sampling;
    if (!(used.time > 0.0)) used.spp = r->options.spp;
    free(r);
    if (status == SATIN_OK) *out = used;
    return status;
}
