// SPDX-License-Identifier: Apache-2.0
// Estimates of memory, and what follows from them (render_memory.h). tests/cli/memory compares
// them with the memory that renders take.
#include "render/render_memory.h"

#include <math.h>
#include <stdio.h>

#include "base/process.h"
#include "render/render_image.h"

// Embree's BVH takes up to 86 bytes per triangle, beside the scene's own arrays.
static const double TRIANGLE_BYTES = 86.0;
// A thread takes .5 MB, and if it gathers 300 bytes for each ray of the largest hemisphere.
static const double THREAD_BYTES = 0.6e6, RAY_BYTES = 300.0;
// The least for photons, records and the BRDF tables, below which a render is refused.
static const double WORK_LEAST = 9e6;
// The least number of photon paths, if the options have as many.
static const double PATHS_LEAST = 1000.0;
// Adaptive caching has octrees of its own over all records, when the sites are found.
static const double ADAPTIVE_RECORDS = 2.0;
// The fractions of what is not fixed.
static const double FOR_THREADS = 0.25, FOR_PHOTONS = 0.65, FOR_PASSES = 0.75;

static double bytes_of_scene(const struct satin_scene *scene) {
    return (double)scene->arena.bytes + TRIANGLE_BYTES * (double)scene->triangle_count;
}

// What the film and the counts of samples take before there is an image. The sums of the pixels,
// which system pages are assigned to when they are first written, take more, but not before the
// sites of the records are freed.
static double bytes_of_film(const struct satin_scene *scene, const satin_options *o) {
    return (double)scene->film.crop_width * (double)scene->film.crop_height *
           (sizeof(float) * render_film_channels(scene, o) + sizeof(struct adaptive_pixel));
}

// Adaptive caching compares up to 24 records at a site.
static const double COMPARED_BYTES = 500.0;
// Sites of a pixel, on average; there are more of what is seen through glass.
static const double PIXEL_SITES = 1.25;

static double adapted_sites(const satin_options *o) {
    const double stride = render_budget_adaptive_stride(o->width, o->height);
    return PIXEL_SITES * o->width * o->height / (stride * stride);
}

// The pixels whose sites are found, and a batch of records.
static double batch_bytes(const satin_options *o) {
    const double pixels = (double)o->width * (double)o->height;
    const double block = fmin(pixels, RENDER_BLOCK_PIXELS);
    const double order = o->radiance_cache ? o->radiance_order : 0.0;
    return 4.0 * pixels + fmin(fmax(block / 128.0, 128.0), 1024.0) * order * order * 88.0;
}

// The sites of a block of pixels or, after it, of adaptive caching, beside those that are traced.
static double found_bytes(const satin_options *o) {
    const double pixels = (double)o->width * (double)o->height;
    const double traced = 4.0 * fmin(pixels, RENDER_TRACED_PIXELS),
                 block = PIXEL_SITES * fmin(pixels, RENDER_BLOCK_PIXELS);
    const double adapted = o->adaptive_cache ? adapted_sites(o) : 0.0;
    return batch_bytes(o) + (traced + fmax(block, adapted)) * sizeof(struct fill_site);
}

static double compared_bytes(const satin_options *o) {
    if (!o->adaptive_cache) return 0.0;
    return batch_bytes(o) + adapted_sites(o) * (sizeof(struct fill_site) + COMPARED_BYTES);
}

static double rays_of_hemisphere(const satin_options *o) {
    const double E = o->irradiance_rays * (o->irradiance_noise > 0.0f ? 4.0 : 1.0);
    const double L =
        o->radiance_cache ? o->radiance_rays * (o->radiance_noise > 0.0f ? 4.0 : 1.0) : 0.0;
    return fmax(E, L);
}

// Prints bytes as the option is written, rounded up to three digits.
static const char *print_size(double bytes, char out[16]) {
    int unit = 0;
    for (; bytes >= 1024.0 && unit < 4; unit++) bytes /= 1024.0;
    const double step = bytes >= 100.0 ? 1.0 : bytes >= 10.0 ? 0.1 : 0.01;
    snprintf(out, 16, "%.4g%.*s", ceil(bytes / step) * step, unit > 0, " KMGT" + unit);
    return out;
}

// Where objects move, the render of the scene at rest and that of a frame are in memory at once.
// Each has half of the limit, whatever the other one takes.
static double renders_at_once(const struct render *r) {
    const satin_animation *a = r->callbacks.animation;
    return r->motion.at_rest || (a && a->moved) ? 2.0 : 1.0;
}

// For warnings of what the limit costs: the scene at rest has warned of it for all frames.
static struct log limit_log(const struct render *r) {
    return r->motion.at_rest ? (struct log){0} : r->log;
}

// The limit with which a render that needs so much would not be refused. Images take half of what
// the process leaves of a limit, if they need it, and more while they are read.
static double limit_needed(const struct scene_images *images, double needed) {
    const double process = process_bytes(images->module);
    const double others = needed - images->bytes - process;
    return process + fmax(others + fmin(images->asked, others), images->needed);
}

satin_status render_memory_begin(struct render *r) {
    struct render_memory *m = &r->memory;
    satin_options *o = &r->options;
    const bool missing = r->scene.images.missing;
    if (o->memory <= 0 && missing)
        return log_fail(r->log, SATIN_ERROR_INPUT,
                        "option memory: the scene was loaded with a limit in which its images do "
                        "not fit");
    if (o->memory <= 0) return SATIN_OK;
    const bool records = render_has_stage(r, STAGE_RECORDS);
    m->limit = (double)o->memory / renders_at_once(r);
    const double film = bytes_of_film(&r->scene, o);
    m->kept = process_bytes(r->scene.images.module) + bytes_of_scene(&r->scene) + film;
    m->thread = THREAD_BYTES + (records ? RAY_BYTES * rays_of_hemisphere(o) : 0.0);
    if (records && o->guide_visibility) m->visibility = guide_visibility_most(&r->scene);
    m->kept += m->visibility;
    const double sums = render_image_bytes(&r->scene, o, &r->callbacks) - film;
    m->found = fmax(sums, records ? found_bytes(o) : 0.0);
    m->compared = records ? compared_bytes(o) : 0.0;
    m->fixed = m->kept + fmax(m->found, m->compared);
    const double work = render_has_stage(r, STAGE_PHOTONS) || records ? WORK_LEAST : 0.0;
    double least = m->fixed + fmax(m->thread / FOR_THREADS, work);
    // Where the sky is visible is learned if that fits.
    if (least > m->limit && m->visibility > 0.0) {
        char needed[16];
        print_size(renders_at_once(r) * limit_needed(&r->scene.images, least), needed);
        o->guide_visibility = false;
        m->kept -= m->visibility;
        m->fixed -= m->visibility;
        least -= m->visibility;
        m->visibility = 0.0;
        if (least <= m->limit && !missing)
            log_message(
                limit_log(r), SATIN_LOG_WARNING,
                "option memory: where the sky is visible is not learned, which needs about %s: "
                "its direct light is noisy",
                needed);
    }
    if (least > m->limit || missing) {
        char limit[16], needed[16];
        return log_fail(
            r->log, SATIN_ERROR_INPUT,
            "option memory: %s are too few: this scene and an image of %d x %d pixels "
            "need %s",
            print_size((double)o->memory, limit), o->width, o->height,
            print_size(renders_at_once(r) * limit_needed(&r->scene.images, least), needed));
    }
    const double threads = floor(FOR_THREADS * (m->limit - m->fixed) / m->thread);
    if (threads < parallel_cores(o->threads)) o->threads = (int)threads;
    return SATIN_OK;
}

// The option that limits the photons of the global map which are in memory at a time.
static int64_t *paths_together(satin_options *o) {
    return photon_streams(o) ? &o->photon_batch : &o->photons;
}

// The bytes of so many photons, of which those of a batch do not grow by their factor.
static double photons_bytes(const struct render *r, const struct render_photon_counts *counts) {
    satin_options o = r->options;
    int64_t *together = paths_together(&o);
    *together = (int64_t)ceil((double)*together * counts->fraction);
    o.photons = (int64_t)ceil((double)o.photons * counts->global);
    o.caustic_photons =
        (int64_t)ceil((double)o.caustic_photons * counts->fraction * counts->caustic);
    const struct photon_paths paths = render_budget_paths(&o, render_core_seconds(r));
    return photon_memory_bytes(&r->memory.per_path, &paths);
}

static double record_copies(const struct render *r) {
    return r->options.adaptive_cache && r->options.time == 0.0 ? ADAPTIVE_RECORDS : 1.0;
}

static double photons_most(const struct render *r) {
    const double fraction = render_steps(r)->passes ? FOR_PASSES : FOR_PHOTONS;
    return fraction * (r->memory.limit - r->memory.fixed);
}

// No photons, and those of the options.
static const struct render_photon_counts NONE = {0.0, 1.0, 1.0}, ALL = {1.0, 1.0, 1.0};

static struct render_photon_counts mix_counts(const struct render_photon_counts *a,
                                              const struct render_photon_counts *b, double x) {
    return (struct render_photon_counts){a->fraction + x * (b->fraction - a->fraction),
                                         a->global + x * (b->global - a->global),
                                         a->caustic + x * (b->caustic - a->caustic)};
}

// The most photons that fit, between `least` and `most`.
static struct render_photon_counts counts_that_fit(const struct render *r,
                                                   struct render_photon_counts least,
                                                   struct render_photon_counts most) {
    if (photons_bytes(r, &most) <= photons_most(r)) return most;
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 40; i++) {
        const double x = 0.5 * (low + high);
        const struct render_photon_counts counts = mix_counts(&least, &most, x);
        if (photons_bytes(r, &counts) <= photons_most(r))
            low = x;
        else
            high = x;
    }
    return mix_counts(&least, &most, low);
}

static int64_t limited(int64_t count, double fraction) {
    const double least = fmin((double)count, PATHS_LEAST);
    return (int64_t)fmax(floor((double)count * fraction), least);
}

satin_status render_memory_photons(struct render *r) {
    struct render_memory *m = &r->memory;
    satin_options *o = &r->options;
    if (m->limit == 0.0 || !render_has_stage(r, STAGE_PHOTONS)) return SATIN_OK;
    const struct photon_request request = {.scene = &r->scene,
                                           .options = o,
                                           .paths = render_budget_paths(o, render_core_seconds(r)),
                                           .aim = guide_visibility_aim(r->first_pass.visibility)};
    const satin_status status = photon_memory_measure(&request, r->pool, r->log, &m->per_path);
    if (status != SATIN_OK) return status;
    const double fraction = counts_that_fit(r, NONE, ALL).fraction;
    if (fraction < 1.0) {
        int64_t *together = paths_together(o);
        const int64_t photons = *together, caustic = o->caustic_photons;
        *together = limited(photons, fraction);
        o->caustic_photons = limited(caustic, fraction);
        log_message(limit_log(r), SATIN_LOG_WARNING,
                    "option memory: %lld of %lld photons%s and %lld of %lld caustic photons",
                    (long long)*together, (long long)photons,
                    photon_streams(o) ? " of a batch" : "", (long long)o->caustic_photons,
                    (long long)caustic);
    }
    m->photons = photons_bytes(r, &ALL);
    return SATIN_OK;
}

void render_memory_grow(struct render *r, struct render_photon_counts *counts) {
    if (r->memory.limit == 0.0 || counts->fraction < 1.0) return;
    *counts = counts_that_fit(r, ALL, *counts);
    r->memory.photons = fmax(r->memory.photons, photons_bytes(r, counts));
}

// What photons and threads leave when the maps are built.
static double bytes_left(const struct render *r) {
    const struct render_memory *m = &r->memory;
    const double kept = stats_get(&r->stats, "photons.bytes") - m->visibility;
    return m->limit - m->kept - FOR_THREADS * (m->limit - m->fixed) - fmax(kept, 0.0);
}

void render_memory_limit_cache(const struct render *r, struct cache *cache, int caches) {
    const struct render_memory *m = &r->memory;
    if (m->limit == 0.0) return;
    const double left = bytes_left(r);
    const double records = fmin(left - m->found, (left - m->compared) / record_copies(r));
    cache_limit(cache, fmax(records / caches, 1.0));
}

size_t render_memory_adapted(const struct render *r) {
    if (r->memory.limit == 0.0) return SIZE_MAX;
    // Half of what photons and records leave; the other half is for further records.
    const double rest =
        bytes_left(r) - r->memory.compared - record_copies(r) * cache_bytes(r->second_pass.cache);
    const double more = 0.5 * fmax(rest, 0.0) / (sizeof(struct fill_site) + COMPARED_BYTES);
    return (size_t)ceil(adapted_sites(&r->options) + more);
}

void render_memory_end(struct render *r) {
    const struct render_memory *m = &r->memory;
    if (m->limit == 0.0) return;
    const struct cache *cache = r->second_pass.cache;
    const double records = stats_get(&r->stats, "records.bytes");
    // While photons are traced there are no sites and sums, which come after them, but for passes.
    const double photons = render_steps(r)->passes
                               ? m->photons
                               : fmax(stats_get(&r->stats, "photons.bytes") - m->visibility, 0.0);
    const double later =
        fmax(m->found + records, m->compared + record_copies(r) * records) + photons;
    if (cache && cache_full(cache))
        log_message(limit_log(r), SATIN_LOG_WARNING,
                    "option memory: no records beyond %zu; where they are missing, samples gather",
                    cache_count_all(cache));
    const double unused = (double)guide_visibility_unused(&r->scene, r->first_pass.visibility);
    stats_set(&r->stats, "memory.estimate_bytes",
              renders_at_once(r) * (m->kept - unused + parallel_threads(r->pool) * m->thread +
                                    fmax(m->photons, later)));
}
