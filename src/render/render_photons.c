// SPDX-License-Identifier: Apache-2.0
// The first pass within a time limit. How long a photon takes varies a hundredfold between scenes:
// a sixteenth of the photons tells, and serves itself if there is no time for many more.
#include "render/render_state.h"

enum {
    PILOT = 16,      // part of the photons that is tried first
    WORTH_MORE = 3,  // times the pilot's photons: fewer are not worth another pass
};

// Of the time limit; and what of the time that the pilot foretells is used.
static const double PHOTON_SHARE = 0.3, CAUTION = 0.9;

// Whether the global map is looked at.
static bool reads_photons(const satin_options *o) {
    return o->integrator == SATIN_PHOTONS || o->first_pass == SATIN_FIRST_PRECOMPUTED ||
           o->first_pass == SATIN_FIRST_PHOTONS;
}

static satin_status build(struct render *r, double share) {
    satin_options o = r->options;
    o.photons = (int64_t)ceil((double)o.photons * share);
    o.caustic_photons = (int64_t)ceil((double)o.caustic_photons * share);
    if (!reads_photons(&o)) o.photons = 0;
    r->photons_share = r->photons_wanted ? (double)o.photons / (double)r->photons_wanted : 0.0;
    return photon_maps_build(&r->scene, &o, r->pool, r->log, &r->stats, &r->maps);
}

satin_status render_photons(struct render *r) {
    if (!(r->options.time > 0.0)) return build(r, 1.0);
    const struct stats before = r->stats;
    double start = render_elapsed(r);
    satin_status status = build(r, 1.0 / PILOT);
    if (status != SATIN_OK) return status;
    double seconds = render_elapsed(r) - start;
    double left = PHOTON_SHARE * r->options.time - render_elapsed(r);
    double share = fmin(CAUTION * left / seconds / PILOT, 1.0);
    if (share * PILOT < WORTH_MORE) return SATIN_OK;
    photon_maps_free(r->maps);
    r->maps = NULL;
    r->stats = before;
    return build(r, share);
}

struct gather render_gather(const struct render *r) {
    struct gather g = gather_make(&r->scene, &r->options, r->maps);
    // The radius of a lookup falls as the root of the number of photons.
    if (r->photons_share > 0.0 && r->photons_share < 1.0) g.trust /= (float)sqrt(r->photons_share);
    return g;
}
