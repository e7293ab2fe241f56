// SPDX-License-Identifier: Apache-2.0
// The metadata of a film: version, scene hash, all options with the integrator that sampled the
// image, statistics.
#include <stdio.h>
#include <stdlib.h>

#include "render/options_table.h"
#include "render/render_image.h"

char *render_options_text(const satin_options *options) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    options_print_words(out, options, NULL);
    if (fclose(out) == 0) return text;
    free(text);
    return NULL;
}

static struct stats_span span_without(struct stats_span a, struct stats_span b) {
    return (struct stats_span){a.wall_s - b.wall_s, a.thread_s - b.thread_s,
                               a.process_s - b.process_s};
}

// Sets the matrices of the camera. A point p of world space is at p * to_ndc on the film.
static void set_camera(const struct satin_scene *scene, struct film_camera *out) {
    const struct camera *camera = &scene->camera;
    const float near = camera->near_clip, far = camera->far_clip, depth = far / (far - near);
    struct mat4 to_camera, to_film = {{{0}}};
    // No matrix maps directions to longitude and latitude.
    if (camera->spherical || !mat4_inverse(&camera->to_world, &to_camera)) return;
    // As scene_camera_ray maps film positions to the plane z = 1, or for parallel rays to any.
    const int at = camera->orthographic ? 3 : 2;  // the column of what the offset multiplies
    to_film.m[0][0] = -0.5f / camera->tan_x;
    to_film.m[1][1] = -0.5f / camera->tan_y;
    to_film.m[0][at] = 0.5f - camera->shift.x;
    to_film.m[1][at] = 0.5f - camera->shift.y;
    to_film.m[2][2] = camera->orthographic ? depth / far : depth;
    to_film.m[2][3] = camera->orthographic ? -near * depth / far : -near * depth;
    to_film.m[3][at] = 1.0f;
    const struct mat4 to_ndc = mat4_mul(&to_film, &to_camera);
    for (int i = 0; i < 16; i++) {
        out->to_camera[i] = to_camera.m[i % 4][i / 4];
        out->to_ndc[i] = to_ndc.m[i % 4][i / 4];
    }
    out->known = true;
}

static void set_ranks(struct render *r) {
    const satin_ranks *ranks = r->callbacks.ranks;
    if (!ranks) return;
    const struct parallel_traffic traffic = parallel_get_traffic(r->pool);
    stats_set(&r->stats, "ranks.count", ranks->count);
    stats_set(&r->stats, "ranks.loops", traffic.loops);
    stats_set(&r->stats, "ranks.results_bytes", traffic.bytes);
    stats_set(&r->stats, "ranks.exchange_s", traffic.seconds);
}

bool render_metadata(struct render *r, struct satin_film *film) {
    stats_set(&r->stats, "time.total_s", render_elapsed(r));
    const bool frame = r->frames.view || r->motion.at_rest;
    if (frame) stats_set(&r->stats, "time.frame_s", render_elapsed(r) - r->frames.start);
    stats_set(&r->stats, "time.load_s", r->scene.load_span.wall_s);
    stats_set(&r->stats, "time.cpu_s", stats_cpu());
    stats_set(&r->stats, "render.threads", parallel_threads(r->pool));
    stats_set(&r->stats, "render.replaced", r->progress.replaced);
    set_ranks(r);
    render_memory_end(r);
    stats_set(&r->stats, "memory.peak_bytes", stats_peak_memory());
    stats_set_span(&r->stats, "load", span_without(r->scene.load_span, r->scene.bvh_span));
    stats_set_span(&r->stats, "bvh", r->scene.bvh_span);
    stats_set_parts(&r->stats, r->pool);
    set_camera(&r->scene, &film->camera);
    char hash[20], number[20];
    snprintf(hash, sizeof hash, "%016llx", (unsigned long long)r->scene.hash);
    satin_options used = r->options;
    // With a crop, these two options are the size of the whole film, so that --set takes them back.
    if (used.crop_width > 0 && used.crop_height > 0) {
        used.width = r->scene.film.width;
        used.height = r->scene.film.height;
    }
    char *options = render_options_text(&used);
    free(film->stats);
    film->stats = stats_json(&r->stats);
    bool ok = options && film->stats && film_attribute_set(film, "satin:version", SATIN_VERSION) &&
              film_attribute_set(film, "satin:scene_hash", hash) &&
              film_attribute_set(film, "satin:options", options);
    if (ok) ok = render_cryptomatte_describe(&r->scene, &r->options, film);
    snprintf(number, sizeof number, "%d", r->frames.next - 1);
    if (ok && frame)
        ok = film_attribute_set(film, "satin:frame", number) &&
             film_attribute_set(film, "satin:job", r->frames.job);
    if (ok && film_channel(film, "variance.R"))
        ok = film_attribute_set(film, FILM_VARIANCE_ATTRIBUTE, FILM_VARIANCE_BOUND);
    if (ok && r->image->denoised)
        ok = film_attribute_set(film, "satin:denoiser", film_denoiser_name(r->denoiser));
    if (ok && render_cancelled(r))
        ok = film_attribute_set(film, "satin:cancelled",
                                render_stage_name(r->progress.cancelled_in));
    free(options);
    return ok;
}
