// SPDX-License-Identifier: Apache-2.0
// Refined lookups: a narrow lobe, as of a glossy floor, reads few entries of irradiance, and shows
// their noise as blotches that no number of samples removes. A pilot of the image finds the entries
// by which it has most of its error; they are gathered anew, as the records of a next bounce would
// be [K05 2.1], and entries around them take their mean. Measured in
// docs/experiments/first-passes.md.
#include <stdlib.h>

#include "base/array.h"
#include "render/render_image.h"

enum {
    PILOT_MOST = 16384,  // samples of the image; four times as many find the same error within 6 %
    PILOT_LEAST = 512,   // with less time there is no pilot
    PILOT_FIRST = 8,     // one sample in this number shows whether the others are worth their time
    PILOT_CHUNK = 64,
    PILOT_OF_SAMPLES = 64,  // without a time limit: samples of the image for each of the pilot
    SITE_RAYS = 1024,       // of an entry; with four times as many the image has the same error
    RAYS_OF_SAMPLES = 4,    // without a time limit: samples of the image for each of these rays
    SITES_FIRST = 16,       // entries that show the speed
    SITES_MOST = 4096
};

// With a time limit: samples of the pilot per core second, which take 1 to 2 % of it, or more where
// samples are slow; the most of the time for them, and for gathering, which shows its speed by the
// first entries.
static const double PILOT_OF_SECONDS = 1000.0, PILOT_TIME = 0.04, SITES_TIME = 0.05;

// What is worth it: the relative squared error of the image by all lookups together, and by those
// around one entry. Below the first, other noise has ten times as much error.
static const double WORTH_ALL = 2e-5, WORTH_ONE = 2e-8;

// The distance between entries that are gathered, and up to which others take their light, in radii
// of the discs of their photons. With half the distance the error is the same.
static const float SITE_SPACING = 0.5f, SITE_INFLUENCE = 0.75f;
static const float ALIKE = 0.9f;  // least cosine between the normals of entries that go together

// Errors are relative to at least this fraction of the mean squared luminance of the pilot.
static const float DARK_FRACTION = 0.01f;

// A sample of the pilot.
struct refine_sample {
    float Y;     // luminance of the pixel
    float read;  // of what its glossy lobes read, by one lookup; 0: nothing
    float common;
    int entry;
};

// An entry that may be gathered anew.
struct refine_site {
    int entry;
    float error;   // sum of the relative squared errors of the samples that read it
    float radius;  // of its disc
    vec3 p, n;
};

struct refine_pilot {
    const struct shade *shade;
    const satin_options *image;
    struct shade_worker *worker;
    struct refine_sample *sample;
    size_t first;
};

static void sample_pilot(void *ctx, size_t begin, size_t end, int worker) {
    const struct refine_pilot *pilot = ctx;
    const uint64_t width = (uint64_t)pilot->image->width, height = (uint64_t)pilot->image->height;
    struct shade_worker *w = &pilot->worker[worker];
    for (size_t i = begin; i < end; i++) {
        const size_t at = pilot->first + i;
        struct rng rng = rng_make(pilot->image->seed, RNG_REFINE, at);
        const int x = (int)(rng_u32(&rng) * width >> 32), y = (int)(rng_u32(&rng) * height >> 32);
        struct shade shade = *pilot->shade;
        shade.camera = scene_camera_sample(shade.g->scene, (uint32_t)at);
        struct refine_sample *out = &pilot->sample[at];
        *out = (struct refine_sample){.entry = -1};
        struct shade_lookup lookup;
        struct shade_sample eye;
        const struct gather_light_samples direct = {pilot->image->light_samples, 0};
        if (!shade_look_up(&shade, x, y, (uint32_t)at, &lookup)) continue;
        shade_tile_begin(w);
        shade_pixel_begin(w);
        const struct gather_light_samples gather = {render_budget_first_gathers(pilot->image), 0};
        shade_pixel(&shade, w, x, y, (uint32_t)at,
                    (struct shade_sample_counts){direct, direct, gather}, &eye);
        *out = (struct refine_sample){fmaxf(rgb_luminance(eye.beauty), lookup.Y), lookup.Y,
                                      lookup.read.common, lookup.read.entry};
    }
}

// Samples [first, end) of the pilot.
static satin_status advance_pilot(struct render *r, struct refine_pilot *pilot, size_t end) {
    const struct parallel_results sampled = {
        .slot = {{pilot->sample + pilot->first, sizeof *pilot->sample}}};
    const bool whole = parallel_for_results(r->pool, end - pilot->first, PILOT_CHUNK, sample_pilot,
                                            pilot, &sampled);
    pilot->first = end;
    return whole ? SATIN_OK : SATIN_CANCELLED;
}

// The variance of a lookup of k photons is 1 / k of its square, and a pixel averages over
// 1 / common of them.
static float sample_error(const struct refine_sample *s, float dark2, int k) {
    if (!(s->read > 0.0f)) return 0.0f;
    return sqrf(s->read) / (sqrf(s->Y) + dark2) * s->common / (float)k;
}

static float mean_dark2(const struct refine_sample *sample, size_t count) {
    double sum = 0.0;
    size_t read = 0;
    for (size_t i = 0; i < count; i++) {
        sum += (double)sqrf(sample[i].Y);
        read += sample[i].read > 0.0f;
    }
    return read ? DARK_FRACTION * (float)(sum / (double)read) : 0.0f;
}

// The relative squared error of the image by the noise of single lookups.
static double pilot_error(const struct refine_pilot *pilot, int k) {
    const float dark2 = mean_dark2(pilot->sample, pilot->first);
    double sum = 0.0;
    for (size_t i = 0; i < pilot->first; i++)
        sum += (double)sample_error(&pilot->sample[i], dark2, k);
    return sum / (double)pilot->first;
}

static int compare_sites(const void *a, const void *b) {
    const struct refine_site *x = a, *y = b;
    if (x->error != y->error) return x->error > y->error ? -1 : 1;
    return (x->entry > y->entry) - (x->entry < y->entry);
}

// The site near which an entry is; `count` if there is none.
static size_t nearest_site(const struct refine_site *site, size_t count,
                           const struct refine_site *of) {
    size_t best = count;
    float least = sqrf(SITE_SPACING * of->radius);
    for (size_t i = 0; i < count; i++) {
        const float d2 = v3_dist2(site[i].p, of->p);
        if (d2 < least && v3_dot(site[i].n, of->n) > ALIKE) {
            best = i;
            least = d2;
        }
    }
    return best;
}

// Chooses entries to gather from those that the pilot has read, and sorts them by their errors.
static size_t choose_sites(const struct photon_maps *maps, const struct refine_pilot *pilot,
                           struct refine_site *read, struct refine_site *site) {
    const float dark2 = mean_dark2(pilot->sample, pilot->first);
    size_t reads = 0, count = 0;
    for (size_t i = 0; i < pilot->first; i++) {
        const struct refine_sample *s = &pilot->sample[i];
        const float error = sample_error(s, dark2, pilot->image->photon_k);
        if (!(error > 0.0f)) continue;
        struct refine_site *out = &read[reads++];
        *out = (struct refine_site){.entry = s->entry, .error = error};
        out->radius = photon_irradiance_radius(maps, (size_t)s->entry);
        photon_irradiance_position(maps, (size_t)s->entry, &out->p, &out->n);
    }
    qsort(read, reads, sizeof *read, compare_sites);
    for (size_t i = 0; i < reads; i++) {
        const size_t near = nearest_site(site, count, &read[i]);
        if (near < count)
            site[near].error += read[i].error;
        else if (count < SITES_MOST)
            site[count++] = read[i];
    }
    qsort(site, count, sizeof *site, compare_sites);
    const float worth = (float)(WORTH_ONE * (double)pilot->first);
    while (count > 0 && site[count - 1].error < worth) count--;
    return count;
}

// The light of a site, for an entry near it.
struct refine_term {
    int entry;
    uint32_t site;
    float weight;
};

static int compare_terms(const void *a, const void *b) {
    const struct refine_term *x = a, *y = b;
    if (x->entry != y->entry) return x->entry < y->entry ? -1 : 1;
    return (x->site > y->site) - (x->site < y->site);
}

// Replaces the entries around the sites by weighted means of E, the light of the sites. Returns
// their number.
static size_t replace_entries(struct photon_maps *maps, const struct refine_site *site,
                              size_t count, const rgb *E, struct refine_term *term) {
    size_t terms = 0, replaced = 0;
    for (size_t i = 0; i < count; i++) {
        int row[PHOTON_NEAR];
        float distance2[PHOTON_NEAR];
        const float influence = SITE_INFLUENCE * site[i].radius;
        const size_t near =
            photon_irradiance_near(maps, (size_t)site[i].entry, influence, row, distance2);
        for (size_t k = 0; k < near; k++)
            term[terms++] =
                (struct refine_term){row[k], (uint32_t)i, 1.0f - sqrtf(distance2[k]) / influence};
    }
    qsort(term, terms, sizeof *term, compare_terms);
    for (size_t i = 0, next; i < terms; i = next) {
        rgb sum = rgb_grey(0.0f);
        float weight = 0.0f;
        for (next = i; next < terms && term[next].entry == term[i].entry; next++) {
            sum = rgb_add(sum, rgb_scale(E[term[next].site], term[next].weight));
            weight += term[next].weight;
        }
        if (!(weight > 0.0f)) continue;
        photon_irradiance_replace(maps, (size_t)term[i].entry, rgb_scale(sum, 1.0f / weight));
        replaced++;
    }
    return replaced;
}

// ---- Budgets ------------------------------------------------------------------------------------

static double image_samples(const satin_options *o) {
    return (double)o->spp * (double)o->width * (double)o->height;
}

static size_t pilot_samples(const struct render *r) {
    const satin_options *o = &r->options;
    const double fit = o->time > 0.0 ? PILOT_OF_SECONDS * render_core_seconds(r)
                                     : image_samples(o) / PILOT_OF_SAMPLES;
    return (size_t)fmin(fit, PILOT_MOST);
}

static size_t sites_most(const satin_options *o) {
    if (o->time > 0.0) return SITES_MOST;
    return (size_t)fmin(image_samples(o) / RAYS_OF_SAMPLES / SITE_RAYS, SITES_MOST);
}

// The number of items, at most `count`, that fit into a fraction of the time limit, if there is
// one, as `done` of them have taken the seconds since `start`.
static size_t items_that_fit(const struct render *r, size_t count, double fraction, size_t done,
                             double start) {
    if (!(r->options.time > 0.0)) return count;
    const double seconds = render_agreed(r, stats_wall() - start);
    const double fit = fraction * r->options.time * (double)done / fmax(seconds, 1e-9);
    return fit < (double)count ? (size_t)fit : count;
}

// ---- Refining -----------------------------------------------------------------------------------

// Gathers E at up to *count entries, and sets *count to the number for which there was time.
static satin_status refine_in_time(struct render *r, const int *entry, rgb *E, size_t *count) {
    const double start = stats_wall();
    satin_status status = SATIN_OK;
    size_t done = 0, next = r->options.time > 0.0 && *count > SITES_FIRST ? SITES_FIRST : *count;
    while (done < next && status == SATIN_OK) {
        status = gather_entries(&r->second_pass.gather, entry + done, next - done, SITE_RAYS,
                                r->pool, E + done);
        done = next;
        next = items_that_fit(r, *count, SITES_TIME, done, start);
        if (next > 2 * done) next = 2 * done;
    }
    *count = done;
    return status;
}

// Gathers the sites and replaces the entries around them.
static satin_status refine_sites(struct render *r, const struct refine_site *site, size_t count) {
    int *entry = array_new(count, sizeof *entry);
    rgb *E = array_new(count, sizeof *E);
    struct refine_term *term = array_new(PHOTON_NEAR * count, sizeof *term);
    satin_status status = entry && E && term ? SATIN_OK : SATIN_ERROR_MEMORY;
    for (size_t i = 0; entry && i < count; i++) entry[i] = site[i].entry;
    if (status == SATIN_OK) status = refine_in_time(r, entry, E, &count);
    if (status == SATIN_OK) {
        stats_set(&r->stats, "first_pass.refined_sites", (double)count);
        stats_set(&r->stats, "first_pass.refined",
                  (double)replace_entries(r->first_pass.maps, site, count, E, term));
    }
    free(entry);
    free(E);
    free(term);
    return status;
}

static satin_status refine_image(struct render *r, struct refine_pilot *pilot, size_t count) {
    const int k = r->options.photon_k;
    const double start = stats_wall();
    struct refine_site *read = array_new(count, sizeof *read);
    struct refine_site *site = array_new(SITES_MOST, sizeof *site);
    satin_status status = read && site ? SATIN_OK : SATIN_ERROR_MEMORY;
    if (status == SATIN_OK) status = advance_pilot(r, pilot, count / PILOT_FIRST);
    const bool worth = status == SATIN_OK && pilot_error(pilot, k) > WORTH_ALL;
    const size_t fit = worth ? items_that_fit(r, count, PILOT_TIME, pilot->first, start) : 0;
    if (fit > pilot->first) status = advance_pilot(r, pilot, fit);
    if (status == SATIN_OK)
        stats_set(&r->stats, "first_pass.error_shown", sqrt(pilot_error(pilot, k)));
    if (worth && status == SATIN_OK) {
        const size_t chosen = choose_sites(r->first_pass.maps, pilot, read, site);
        const size_t most = sites_most(&r->options);
        status = refine_sites(r, site, chosen < most ? chosen : most);
    }
    free(read);
    free(site);
    return status;
}

// Whether some light of the entries can be gathered: a path to the eye through an entry that has
// one more bounce.
static bool has_bounces(const satin_options *o) {
    return o->max_depth < 0 || o->max_depth - photon_hit_depth(o) > 1;
}

// Whether entries have indirect light alone, which can be gathered.
static bool has_entries(const struct render *r) {
    const satin_options *o = &r->options;
    return r->first_pass.maps && photon_precomputes_direct(o) && o->final_gather && has_bounces(o);
}

satin_status render_refine(struct render *r) {
    const satin_options *o = &r->options;
    const size_t count = pilot_samples(r);
    if (!o->refine_lookups || !has_entries(r) || count < PILOT_LEAST) return SATIN_OK;
    const double start = stats_wall();
    const char *part = parallel_begin_part(r->pool, "refine");
    const size_t threads = (size_t)parallel_threads(r->pool);
    struct refine_pilot pilot = {&r->second_pass.shade, o, array_new(threads, sizeof *pilot.worker),
                                 array_new(count, sizeof *pilot.sample), 0};
    satin_status status = pilot.worker && pilot.sample ? SATIN_OK : SATIN_ERROR_MEMORY;
    for (size_t i = 0; pilot.worker && i < threads; i++)
        pilot.worker[i].gather = r->second_pass.shade.worker[i];
    if (status == SATIN_OK) status = refine_image(r, &pilot, count);
    free(pilot.worker);
    free(pilot.sample);
    parallel_begin_part(r->pool, part);
    stats_set(&r->stats, "first_pass.refine_s", stats_wall() - start);
    return status;
}
