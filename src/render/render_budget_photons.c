// SPDX-License-Identifier: Apache-2.0
// How many photons a render traces, and by how many samples it finds where light is: by the
// options, by what the first photons have shown, and by the time limit.
#include "render/render_budget.h"

#include "render/render_state.h"

// The time per photon varies a hundredfold between scenes; this fraction of them measures it.
static const double FIRST_PHOTONS = 1.0 / 16.0;
// The fraction of the time limit until which photons are made, without and with caustics. There
// are up to TIMED_CAUSTICS times as many of these as the options have where the first photons bring
// CAUSTIC_LIGHT of all light, and fewer where they bring less: they bring .08 in caustic, .3 in a
// bathroom whose lamps are in glass, and .003 to .006 in rooms with some glass. In these more of
// them only take time. In caustic (200x200) they leave .9, .6, .7 and .9 of the error at 5, 11, 14
// and 40 core seconds, and in the bathroom .92 of the variance at 20. Until .6 and 8 times as many
// leave .92 of these errors in caustic, but 1.8 instead of 1.05 times the error in caustic-gloss,
// as records do not get done. What has passed before is not given again: in the bathroom loading
// and the visibility of lights take .19 of 20 CPU seconds, and samples four times as long as those
// of caustic; photons until .3 of the limit leave .6 of the variance there (320x180, four seeds).
static const double PHOTONS_UNTIL = 0.3, CAUSTICS_UNTIL = 0.45;
static const double TIMED_CAUSTICS = 4.0, CAUSTIC_LIGHT = 0.075;
// There are at least this many of them over those of the options. In living-room (640x360, 60 CPU
// seconds) a quarter instead of all leaves .88 of the error: that of caustics rises from .00006 to
// .0001, and the image has 5 seconds more.
static const double CAUSTICS_LEAST = 0.25;
// Without a time limit there are as many of them where caustics are this much of the light, but no
// more than half a photon per sample of the image, whose time grows with its size while that of
// photons does not. In the bathroom, where 1.5 million photons take 7 s and an image of 960x960
// takes 540, four times as many leave half of the error of all light.
static const double CAUSTICS_PER_SAMPLE = 0.5;
// The fraction that is used of the number of photons that fit by the time of the first ones, and
// the factor of their number from which on another pass gains more than it costs.
static const double PHOTONS_CAUTION = 0.9, PHOTONS_AGAIN = 3.0;
// The first photons of integrators photons and sppm, both maps, which are traced whatever the time
// limit: a few ms. The next ones are at most FIT_GROWTH times as many, as the time of few is not
// exact, and are traced from FIT_AGAIN times as many on. The photons of a pass of sppm take at most
// PASS_FRACTION of the remaining time, so that some passes follow.
static const double FIT_PATHS = 1024.0, FIT_GROWTH = 16.0, FIT_AGAIN = 2.0, PASS_FRACTION = 0.1;
// The number of photons of indirect light per path: .5 to 2 in closed rooms; .07 in a room lit by
// the sky, where ten times the paths made gather rays read the map instead of continuing as paths:
// a tenth less time in all, and half of the error of indirect light. Without a time limit another
// pass is made if the paths are to grow by STARVED_AGAIN; STARVED_MOST limits its time and memory.
static const double KEPT_LEAST = 0.5, STARVED_AGAIN = 1.5, STARVED_MOST = 8.0;
// A map that would have fewer photons than this is not read, however far it grows: with a time
// limit no more than the first photons are traced. Of 54 rooms and outdoor scenes 7 have fewer, and
// there at most .22 of the gather rays read photons, else .46 or more.
static const double SPARSE = 15000.0;
// With a time limit the global map has this many times the photons of the options, if they fit. In
// a room whose floor reflects single lookups, they leave .6 of the error at 30 CPU seconds; in
// three closed rooms 1.0, .93 and .90 of the variance at 8 CPU seconds. A denoised image follows
// the rays that would show single lookups. Limits as long as production or longer, whose options
// have PRODUCTION_PHOTONS or more, have those. Rooms that keep few photons get no more than before.
static const double TIMED_PHOTONS = 2.5, PRODUCTION_PHOTONS = 2.5e6;
// Without a time limit they are as many in large images, whose time photons hardly change: up to
// PHOTONS_PER_SAMPLE of the samples. At preview 2.5 times as many leave .52 of the variance in
// veach-ajar (480x270), whose floor reflects single lookups, and .77 to 1.0 in four rooms of
// 400x400, for 1.0 to 1.08 times the CPU time, and 1.19 times in indirect-room.
static const double PHOTONS_PER_SAMPLE = 0.15;
enum {
    // The number of paths for photon clusters, a sample of all photons: a fraction of those of the
    // global map, within limits. More of them show nothing new on any machine: at 3 million photons
    // 2^15 to 2^20 of these paths left the same error in a room with a spot and in one lit through
    // a window, as did different seeds.
    CLUSTER_LEAST = 1 << 15,
    CLUSTER_MOST = 1 << 18,
    CLUSTER_DIVISOR = 3,
    DIRECT_DIVISOR = 2,  // one in DIRECT_DIVISOR paths is of those whose direct photons are summed
    // Paths from the eye. Of 1024 a tenth is a hundred points, which show the ends of the boxes of
    // what is seen. In the case window at preview (150x150, 4 samples per pixel, 6.1 core seconds)
    // a quarter of the paths and cells of the visibility of lights gave 1.10 times the relMSE
    // between two seeds, in .7 core seconds less; four times as many gave .91 times, in 3.6 core
    // seconds more.
    SEEN_PATHS = GUIDE_SEEN_PATHS_MAX,
    VISIBILITY_PATHS = 4096,
    // Paths of the pilot of caustics from each light, and those from the eye that show where
    // caustics are visible: of the latter a cell of the region has 16. With 2^16 instead of 2^15 of
    // the former, caustics of six scenes have 1.6 to .94 times the variance at 4 CPU seconds.
    EMISSION_PATHS = 1 << 15,
    REGION_PATHS = 1 << 14,
    // Paths of that pilot from all lights, which bounds its time however many there are: in a
    // bathroom they take .5 of 20 CPU seconds.
    EMISSION_MOST = 1 << 17,
    // The number of rays per bin of the visible environment grows with the option `photons`, which
    // grows with effort: by one per BIN_PER photons. With 1, 3, 4 and 8 rays, light samples leave a
    // variance of .0111, .0100, .0095 and .0088 in a room with windows, for .9, 1.9, 2.4 and 3.9 s
    // of CPU time.
    BIN_RAYS = 4,  // the largest number
    BIN_PER = 100000,
    // The largest number of bins through which a cell traces all rays. 512 leave 1.08 times the
    // variance of direct light in a room with windows, for .64 times the CPU time.
    OPEN_BINS = 1024,
    // Per path, to find the box with the bins: half and double leave 1.02 and .99 times the
    // variance of direct light in the case window, and .99 and 1.00 times in living-room.
    BOX_RAYS = 8,
    // From a cell to each light. They hardly matter: in two rooms with four lamps outside, 1, 8 and
    // 64 leave 1.01, 1.00 and 1.00 times the variance, for .01, .02 and .08 seconds instead of .04.
    LIGHT_RAYS = 32
};
// With a time limit the visibility of lights is measured by this fraction of its paths, and then by
// VISIBILITY_MORE times as many while these are expected to take less than VISIBILITY_MOST of the
// limit: all of them take 1.6 CPU seconds in living-room and .2 in a room with a hole. Where the
// process has a third of two cores for 8 s, relMSE x 10^4 of the case panes is 21 to 24 and once
// 71; by all paths, as eight seconds of both cores allow, it was 91 and 144.
static const double VISIBILITY_FIRST = 1.0 / 16.0, VISIBILITY_MORE = 4.0, VISIBILITY_MOST = 0.1;
// Light that comes through small openings alone is found by many paths only: with half of them at 2
// core seconds, one of six images of a room with a hole of 10 cm had half of its direct light.
static const double VISIBILITY_SMALL = 0.4;
// With a time limit of less than this many core seconds, the paths for the pilot of caustics fall
// in proportion, down to MEASURED_LEAST of them. In living-room and bathroom (320x180, 4 CPU
// seconds) they take .75. With a quarter and a tenth, scenes of caustics have .83 to 1.1 times the
// error at 4 and 8 s, and eight rooms and gardens .7 to 1.3 times the variance at 4 and 10, 1.0 in
// the mean. Fewer paths for clusters gain nothing, and a room lit by a spot had 2.7 times the error
// with a quarter of them at half a second.
static const double MEASURED_SECONDS = 20.0, MEASURED_LEAST = 1.0 / 16.0;

// The light samples of an entry where a part of the environment is visible. With a time limit there
// are fewer, down to SKY_LEAST, where all entries would take more than DIRECT_FRACTION of it. In a
// bathroom they took .12 of 30 CPU seconds (640x360, denoised): with a quarter of them and as many
// more photons it has .80 of the error (four seeds). In hall they take .015 of 2 to 8 CPU seconds,
// and a quarter of them leave 1.25 times the error.
static const double SKY_SAMPLES = 64.0, SKY_LEAST = 16.0, DIRECT_FRACTION = 0.04;

static double photons_end(const struct render *r, double caustics) {
    if (!(r->options.time > 0.0)) return INFINITY;
    const double usable = render_budget_usable(r);
    const double passed = render_elapsed(r) / usable;
    const double longer = fmax(CAUSTICS_UNTIL - PHOTONS_UNTIL - passed, 0.0);
    return (PHOTONS_UNTIL + longer * caustics) * usable;
}

struct gather_entry_samples render_budget_entry_samples(const struct render *r, double seconds) {
    const bool fit = !(r->options.time > 0.0) || !(seconds > DIRECT_FRACTION * r->options.time);
    const double few = fit ? 1.0 : DIRECT_FRACTION * r->options.time / seconds;
    return (struct gather_entry_samples){.sky = (int)fmax(SKY_SAMPLES * few, SKY_LEAST),
                                         .others = 8};
}

double render_budget_direct(const struct render *r, double seconds) {
    return seconds * (double)render_budget_entry_samples(r, seconds).sky / SKY_SAMPLES;
}

double render_budget_first_photons(void) { return FIRST_PHOTONS; }

// The fraction of the paths of the pilot of caustics that a time limit allows.
static double measured_fraction(double core_seconds) {
    if (!(core_seconds > 0.0)) return 1.0;
    return fmin(fmax(core_seconds / MEASURED_SECONDS, MEASURED_LEAST), 1.0);
}

static uint64_t cluster_paths(const satin_options *o, uint64_t photons) {
    if (!o->guide_clusters || o->integrator != SATIN_TWO_PASS) return 0;
    const uint64_t paths = photons / CLUSTER_DIVISOR;
    return paths < CLUSTER_LEAST ? CLUSTER_LEAST : paths > CLUSTER_MOST ? CLUSTER_MOST : paths;
}

struct photon_paths render_budget_paths(const satin_options *o, double core_seconds) {
    const uint64_t all = o->photons > 0 ? (uint64_t)o->photons : 0;
    const uint64_t batch = o->photon_batch > 0 ? (uint64_t)o->photon_batch : 1;
    // What is made from the photons of the first batch alone does not grow with the others.
    const uint64_t photons = photon_streams(o) && batch < all ? batch : all;
    return (struct photon_paths){
        .seen = SEEN_PATHS,
        .global = all,
        .batch = photons,
        .clusters = cluster_paths(o, photons),
        .direct = photon_precomputes_direct(o) ? photons / DIRECT_DIVISOR : 0,
        .caustic = o->caustic_photons > 0 ? (uint64_t)o->caustic_photons : 0,
        .emission = (int)(EMISSION_PATHS * measured_fraction(core_seconds)),
        .emission_most = EMISSION_MOST,
        .region = (int)(REGION_PATHS * measured_fraction(core_seconds)),
    };
}

double render_budget_first_visibility(const satin_options *o) {
    return o->time > 0.0 ? VISIBILITY_FIRST : 1.0;
}

double render_budget_more_visibility(const satin_options *o, double fraction, double seconds,
                                     bool small) {
    const double more = fmin(VISIBILITY_MORE * fraction, 1.0), all = seconds / fraction;
    const double most = (small ? VISIBILITY_SMALL : VISIBILITY_MOST) * o->time;
    if (VISIBILITY_MORE * all <= most) return 1.0;
    return more * all <= most ? more : fraction;
}

struct guide_visibility_samples render_budget_visibility(const satin_options *o, double fraction) {
    const int64_t rays = o->photons / BIN_PER < BIN_RAYS ? o->photons / BIN_PER : BIN_RAYS;
    return (struct guide_visibility_samples){.paths = (int)(VISIBILITY_PATHS * fraction),
                                             .box_rays = BOX_RAYS,
                                             .bin_rays = rays < 1 ? 1 : (int)rays,
                                             .open_bins = OPEN_BINS,
                                             .light_rays = LIGHT_RAYS};
}

// The factor of the photons of a map that is not starved, where there is time for it.
static double photons_more(const satin_options *o) {
    return fmax(fmin(PRODUCTION_PHOTONS / fmax((double)o->photons, 1.0), TIMED_PHOTONS), 1.0);
}

double render_budget_photons_most(const satin_options *o, double pixels) {
    const double wanted = PHOTONS_PER_SAMPLE * (double)o->spp * pixels;
    if (o->time > 0.0 || o->denoise || o->photons <= 0) return 1.0;
    return fmin(fmax(wanted / (double)o->photons, 1.0), photons_more(o));
}

double render_budget_starved(const satin_options *o, double paths, double kept) {
    const double more = photons_more(o);
    const double least = o->time > 0.0 && !o->denoise ? more : 1.0;
    const double per = more / TIMED_PHOTONS;  // photons that are needed over those of the options
    const double wanted = KEPT_LEAST * per * paths / fmax(kept, 1.0);
    if (kept / paths * (double)o->photons * STARVED_MOST * per < SPARSE) return FIRST_PHOTONS;
    return fmin(fmax(wanted, least), fmax(STARVED_MOST * per, least));
}

double render_budget_grow(double starved) { return starved < STARVED_AGAIN ? 1.0 : starved; }

double render_budget_caustics(double fraction) { return fmin(fraction / CAUSTIC_LIGHT, 1.0); }

double render_budget_caustics_most(const satin_options *o, double pixels) {
    const double wanted = CAUSTICS_PER_SAMPLE * (double)o->spp * pixels;
    if (o->time > 0.0 || o->caustic_photons <= 0) return 1.0;
    return fmin(fmax(wanted / (double)o->caustic_photons, 1.0), TIMED_CAUSTICS);
}

struct render_photon_counts render_budget_photons(const struct render *r, double seconds,
                                                  double starved, double caustics) {
    const double left = photons_end(r, caustics) - render_elapsed(r);
    const double fit = PHOTONS_CAUTION * left / seconds, most = fmax(fit, 1.0);
    if (fit < PHOTONS_AGAIN * FIRST_PHOTONS) return (struct render_photon_counts){0};
    const double caustic = fmax(TIMED_CAUSTICS * caustics, CAUSTICS_LEAST);
    return (struct render_photon_counts){fmin(fit, 1.0), fmin(starved, most), fmin(caustic, most)};
}

double render_budget_least_photons(const satin_options *o) {
    if (!(o->time > 0.0)) return 1.0;
    return fmin(FIT_PATHS / fmax((double)o->photons + (double)o->caustic_photons, 1.0), 1.0);
}

double render_budget_photon_seconds(const struct render *r) {
    if (r->options.integrator == SATIN_SPPM) return PASS_FRACTION * render_time_left(r);
    return photons_end(r, 0.0) - render_elapsed(r);
}

double render_budget_more_photons(double made, double seconds, double allowed) {
    const double fit = PHOTONS_CAUTION * made * fmin(allowed / seconds, FIT_GROWTH);
    if (made >= 1.0 || !(fit > FIT_AGAIN * made)) return made;
    return fmin(fit, 1.0);
}

float render_budget_lookup(double made) {
    return made > 0.0 && made < 1.0 ? (float)sqrt(made) : 1.0f;
}
