// SPDX-License-Identifier: Apache-2.0
// The first pass: as many photons as render_budget.h allows. If not even the first of them fit into
// a time limit, as among thousands of surfaces at one position, render.c traces paths instead of
// two passes. Integrators photons and sppm have what fits, however little (render_fit_photons.c).
#include "render/render_image.h"

// Whether the global map is read.
static bool reads_photons(const satin_options *o) {
    return o->integrator == SATIN_PHOTONS || photon_precomputes(o) ||
           o->first_pass == SATIN_FIRST_PHOTONS;
}

// With a time limit, the first photons and what they need have a part of it. If that is too short,
// paths are traced instead.
static void begin_pilot(struct render *r) {
    if (r->options.time > 0.0 && render_can_trace_paths(r)) render_limit_photon_pilot(r);
}

static satin_status end_pilot(struct render *r, satin_status status) {
    if (status == SATIN_CANCELLED && !render_cancelled(r)) render_take_course(r, COURSE_PATHS);
    return render_limit_end(r, status);
}

// Measures the visibility of the lights by a fraction of the paths. Returns that for another
// attempt, or the same one.
static double measure_visibility(struct render *r, double fraction, satin_status *status) {
    const double start = stats_wall();
    struct guide_visibility **made = &r->first_pass.visibility;
    guide_visibility_free(*made);
    *status = guide_visibility_build(
        &r->scene, r->options.seed, render_budget_visibility(&r->options, fraction), r->pool, made);
    if (*status != SATIN_OK || !*made) return fraction;
    return render_budget_more_visibility(&r->options, fraction,
                                         render_agreed(r, stats_wall() - start),
                                         guide_visibility_small(*made));
}

satin_status render_visibility(struct render *r) {
    if (!r->options.guide_visibility || r->options.integrator != SATIN_TWO_PASS ||
        r->first_pass.visibility)
        return SATIN_OK;
    const double start = stats_wall();
    double fraction, more = render_budget_first_visibility(&r->options);
    satin_status status;
    parallel_begin_part(r->pool, "visibility");
    begin_pilot(r);
    do {
        fraction = more;
        more = measure_visibility(r, fraction, &status);
    } while (more > fraction);
    stats_add(&r->stats, "photons.visibility_s", stats_wall() - start);
    return end_pilot(r, status);
}

satin_status render_photon_emission(struct render *r, struct photon_request *request) {
    satin_status status = SATIN_OK;
    if (!r->first_pass.emission) {
        const double start = stats_wall();
        parallel_begin_part(r->pool, "emission");
        struct photon_request whole = *request;
        whole.paths = render_budget_paths(&r->options, render_core_seconds(r));
        status = photon_emission_build(&whole, r->pool, r->log, &r->first_pass.emission);
        stats_add(&r->stats, "photons.emission_s", stats_wall() - start);
    }
    request->emission = r->first_pass.emission;
    return status;
}

// The factor by which the photons of the global map should grow, after so many paths were traced.
static double starved(const struct render *r, double paths) {
    const satin_options *o = &r->options;
    if (r->first_pass.photons_chosen || !reads_photons(o) || o->integrator != SATIN_TWO_PASS)
        return 1.0;
    return render_budget_starved(o, paths, stats_get(&r->stats, "photons.stored_indirect"));
}

// How much of the light is caustics, if there may be more photons of these.
static double caustics(const struct render *r) {
    if (r->first_pass.caustics_chosen) return 0.0;
    return render_budget_caustics(photon_caustic_fraction(r->first_pass.maps));
}

// Entries of irradiance whose direct light shows how long it takes.
enum { ENTRIES_TIMED = 512 };

static void set_made(struct render *r, int64_t photons) {
    r->first_pass.made =
        r->first_pass.wanted ? (double)photons / (double)r->first_pass.wanted : 0.0;
}

// Without a time limit: whether the global map shall be traced again, as it is starved.
static bool grow_paths(void *ctx, struct photon_paths *paths) {
    struct render *r = ctx;
    satin_options o = r->options;
    const double factor = render_budget_grow(starved(r, (double)paths->batch)),
                 present = (double)paths->global / fmax((double)o.photons, 1.0);
    if (!(factor > fmax(present, 1.0))) return false;
    const double caustic = (double)paths->caustic / fmax((double)o.caustic_photons, 1.0);
    struct render_photon_counts counts = {1.0, factor, fmax(caustic, 1.0)};
    render_memory_grow(r, &counts);
    o.photons = (int64_t)ceil((double)o.photons * counts.global);
    o.caustic_photons = render_fraction(o.caustic_photons, counts.caustic);
    set_made(r, o.photons);
    *paths = render_budget_paths(&o, render_core_seconds(r));
    return true;
}

satin_status render_photon_maps(struct render *r, const struct render_photon_counts *counts) {
    satin_options o = r->options;
    o.photons = render_fraction(o.photons, counts->fraction * counts->global);
    o.caustic_photons = render_fraction(o.caustic_photons, counts->fraction * counts->caustic);
    if (!reads_photons(&o)) o.photons = 0;
    const bool final = !(o.time > 0.0) && counts->fraction == 1.0;
    set_made(r, o.photons);
    struct photon_request request = {.scene = &r->scene,
                                     .options = &o,
                                     .paths = render_budget_paths(&o, render_core_seconds(r)),
                                     .aim = guide_visibility_aim(r->first_pass.visibility),
                                     .grow = final ? grow_paths : NULL,
                                     .grow_ctx = r};
    satin_status status = render_photon_emission(r, &request);
    if (status == SATIN_OK)
        status = photon_maps_build(&request, r->pool, r->log, &r->stats, &r->first_pass.maps);
    if (status == SATIN_OK)
        stats_add(&r->stats, "photons.bytes",
                  (double)guide_visibility_bytes(r->first_pass.visibility));
    return status;
}

void render_drop_photons(struct render *r, struct stats before) {
    const double emission = stats_get(&r->stats, "photons.emission_s");
    photon_maps_free(r->first_pass.maps);
    photon_sppm_free(r->first_pass.sppm);
    r->first_pass.maps = NULL;
    r->first_pass.sppm = NULL;
    r->stats = before;
    if (emission > 0.0) stats_set(&r->stats, "photons.emission_s", emission);
}

double render_photon_seconds(const struct render *r) {
    static const char *const step[] = {"photons.trace_s", "photons.build_s", "photons.clusters_s",
                                       "photons.precompute_s", "photons.radii_s"};
    double seconds = 0.0;
    for (size_t i = 0; i < sizeof step / sizeof *step; i++)
        seconds += stats_get(&r->stats, step[i]);
    return render_agreed(r, seconds);
}

// The paths that are traced for this fraction of the options' photons.
static double paths_traced(const struct render *r, double fraction) {
    satin_options o = r->options;
    o.photons = render_fraction(o.photons, fraction);
    o.caustic_photons = r->first_pass.emission ? render_fraction(o.caustic_photons, fraction) : 0;
    const struct photon_paths p = render_budget_paths(&o, render_core_seconds(r));
    return (double)(p.global + p.clusters + p.direct + p.caustic);
}

// The seconds that all photons of the options will take, by those of the first ones, which are this
// fraction of them: those for tracing as the number of paths, which has as many for clusters by few
// photons as by all; those for the clusters are the same; the others as the photons.
static double expected_seconds(const struct render *r, double first) {
    const double trace = render_agreed(r, stats_get(&r->stats, "photons.trace_s")),
                 clusters = render_agreed(r, stats_get(&r->stats, "photons.clusters_s"));
    const double others = fmax(render_photon_seconds(r) - trace - clusters, 0.0);
    return trace * paths_traced(r, 1.0) / fmax(paths_traced(r, first), 1.0) + clusters +
           others / first;
}

// Direct light at the entries of the first photons' estimate, a fraction of all: the seconds that
// it will take at all of them, by that at a few.
static satin_status expected_direct(const struct render *r, double first, double *seconds) {
    *seconds = 0.0;
    if (!photon_precomputes_direct(&r->options)) return SATIN_OK;
    const struct gather g = render_gather(r);
    const double before = parallel_loop_seconds(r->pool);
    double fraction;
    const satin_status status =
        gather_direct_try(&g, r->first_pass.samples, ENTRIES_TIMED, r->pool, &fraction);
    *seconds = render_loop_seconds(r, before) / (fraction * first);
    return status;
}

// Builds the maps from the first photons, a fraction of them. Others of all of them follow, or of
// up to `most` times as many.
static satin_status build_some(struct render *r, double fraction, double most) {
    const double done = fraction / (fraction + most);
    render_stage_range(r, 0.0, done);
    const satin_status status =
        render_photon_maps(r, &(struct render_photon_counts){fraction, 1.0, 1.0});
    render_stage_range(r, done, 1.0 - done);
    return status;
}

// Builds the maps from the first photons.
static satin_status build_first(struct render *r, double fraction) {
    begin_pilot(r);
    return end_pilot(r, build_some(r, fraction, 1.0));
}

satin_status render_pass_photons(struct render *r) {
    if (!render_steps(r)->passes) return SATIN_OK;
    const double start = stats_wall();
    satin_status status = photon_sppm_next(r->first_pass.sppm, r->pool, r->log, &r->stats);
    stats_add(&r->stats, "photons.passes", status == SATIN_OK ? 1.0 : 0.0);
    stats_add(&r->stats, "photons.passes_s", stats_wall() - start);
    return status;
}

void render_skip_photons(struct render *r) {
    const uint64_t pixels = (uint64_t)r->image->width * (uint64_t)r->image->height;
    if (render_steps(r)->passes)
        photon_sppm_skip(r->first_pass.sppm, (uint32_t)(r->image->taken / pixels));
}

// Among bright walls that let nothing out, paths of photons have hundreds of bounces, and the map
// has a photon at each. More of them than this per path are no better than as many of more paths:
// so a number that a quality has chosen is reduced. In a closed room that reflects .9 a path stores
// 10 of them, with .98 it is 50.
static const double STORED_MOST = 16.0;

satin_status render_reduce_photons(struct render *r) {
    satin_options *o = &r->options;
    if (r->first_pass.photons_chosen || !reads_photons(o)) return SATIN_OK;
    const struct photon_request request = {
        .scene = &r->scene, .options = o, .aim = guide_visibility_aim(r->first_pass.visibility)};
    double stored = 0.0;
    const satin_status status = photon_count_stored(&request, r->pool, r->log, &stored);
    if (status != SATIN_OK || stored <= STORED_MOST) return status;
    o->photons = (int64_t)ceil((double)o->photons * STORED_MOST / stored);
    r->first_pass.wanted = (int64_t)ceil((double)r->first_pass.wanted * STORED_MOST / stored);
    return SATIN_OK;
}

// The pixels of the whole film, so that a crop has the same photons.
static double whole_pixels(const struct render *r) {
    return (double)r->scene.film.width * (double)r->scene.film.height;
}

// Finds by the first photons how many of caustics are worth their time, as a factor of their
// number.
static satin_status measure_caustics(struct render *r, double *factor) {
    const struct stats before = r->stats;
    const double most = render_budget_caustics_most(&r->options, whole_pixels(r));
    *factor = 1.0;
    if (r->first_pass.caustics_chosen || !(most > 1.0)) return SATIN_OK;
    struct photon_request request = {.scene = &r->scene, .options = &r->options};
    satin_status status = render_photon_emission(r, &request);
    if (status != SATIN_OK || !request.emission) return status;
    status = build_some(r, render_budget_first_photons(), most);
    if (status != SATIN_OK) return status;
    *factor += (most - 1.0) * caustics(r);
    render_drop_photons(r, before);
    return SATIN_OK;
}

// All photons of the options, and more in large images.
static satin_status build_unlimited(struct render *r) {
    struct render_photon_counts counts = {1.0, 1.0, 1.0};
    if (!r->first_pass.photons_chosen && reads_photons(&r->options))
        counts.global = render_budget_photons_most(&r->options, whole_pixels(r));
    const satin_status status = measure_caustics(r, &counts.caustic);
    if (status != SATIN_OK) return status;
    render_memory_grow(r, &counts);
    return render_photon_maps(r, &counts);
}

satin_status render_photons(struct render *r) {
    if (!render_has_stage(r, STAGE_PHOTONS)) return SATIN_OK;
    r->first_pass.samples = render_budget_entry_samples(r, 0.0);
    if (r->options.integrator != SATIN_TWO_PASS) return render_fit_photons(r);
    if (!(r->options.time > 0.0)) return build_unlimited(r);
    const struct stats before = r->stats;
    const double first = render_budget_first_photons();
    satin_status status = build_first(r, first);
    const bool too_slow = !render_has_stage(r, STAGE_PHOTONS);
    if (too_slow) r->stats = before;
    if (status != SATIN_OK || too_slow) return status;
    double direct;
    status = expected_direct(r, first, &direct);
    if (status != SATIN_OK) return status;
    struct render_photon_counts more =
        render_budget_photons(r, expected_seconds(r, first) + render_budget_direct(r, direct),
                              starved(r, first * (double)r->options.photons), caustics(r));
    if (r->first_pass.caustics_chosen) more.caustic = 1.0;
    if (!(more.fraction > 0.0)) return SATIN_OK;
    r->first_pass.samples = render_budget_entry_samples(r, direct * more.fraction * more.global);
    render_memory_grow(r, &more);
    render_drop_photons(r, before);
    return render_photon_maps(r, &more);
}

satin_status render_direct(struct render *r) {
    if (!photon_precomputes_direct(&r->options) || !r->first_pass.maps) return SATIN_OK;
    const double start = stats_wall();
    parallel_begin_part(r->pool, "direct");
    satin_status status = gather_direct_build(&r->second_pass.gather, r->first_pass.samples,
                                              r->pool, &r->first_pass.direct);
    if (status != SATIN_OK) return status;
    r->second_pass.gather.direct = &r->first_pass.direct;
    stats_set(&r->stats, "photons.direct_s", stats_wall() - start);
    stats_add(&r->stats, "photons.bytes", (double)gather_direct_bytes(&r->first_pass.direct));
    return SATIN_OK;
}

struct gather render_gather(const struct render *r) {
    struct gather g = gather_make(&r->scene, &r->options, r->first_pass.maps);
    g.visibility = r->first_pass.visibility;
    g.lookup_max /= render_budget_lookup(r->first_pass.made);
    g.sppm = r->first_pass.sppm;
    return g;
}
