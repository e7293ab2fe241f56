// SPDX-License-Identifier: Apache-2.0
// The photons of integrators photons and sppm. A time limit lessens their number, but no other
// integrator replaces these: who asks for one of them wants to see its light.
#include "render/render_image.h"

// Makes the photon map from this fraction of the options' photons, or the photons from which sppm
// finds the radii of all passes.
static satin_status make_photons(struct render *r, double fraction) {
    if (!render_steps(r)->passes)
        return render_photon_maps(r, &(struct render_photon_counts){fraction, 1.0, 1.0});
    struct photon_request request = {.scene = &r->scene, .options = &r->options};
    satin_options o = r->options;
    o.photons = render_fraction(o.photons, fraction);
    o.caustic_photons = render_fraction(o.caustic_photons, fraction);
    request.paths = render_budget_paths(&o, render_core_seconds(r));
    const satin_status status = render_photon_emission(r, &request);
    if (status != SATIN_OK) return status;
    return photon_sppm_new(&request, r->pool, r->log, &r->stats, &r->first_pass.sppm);
}

// Sets the options to the photons that fit.
static void note_fraction(struct render *r, double fraction) {
    satin_options *o = &r->options;
    const int64_t photons = o->photons, caustic = o->caustic_photons;
    r->first_pass.fraction = fraction;
    o->photons = render_fraction(photons, fraction);
    o->caustic_photons = render_fraction(caustic, fraction);
    r->progress.items = (double)o->photons + (double)o->caustic_photons;
    if (!render_steps(r)->passes) return;
    stats_set(&r->stats, "photons.per_pass", r->progress.items);
    if (fraction < 1.0)
        log_message(r->log, SATIN_LOG_WARNING,
                    "the time allows %lld of %lld photons and %lld of %lld caustic photons in each "
                    "pass",
                    (long long)o->photons, (long long)photons, (long long)o->caustic_photons,
                    (long long)caustic);
}

satin_status render_fit_photons(struct render *r) {
    const struct stats before = r->stats;
    const bool known = r->first_pass.fraction > 0.0;
    double fraction = known ? r->first_pass.fraction : render_budget_least_photons(&r->options);
    for (;;) {
        const satin_status status = make_photons(r, fraction);
        if (status != SATIN_OK) return status;
        if (known) break;
        const double more = render_budget_more_photons(fraction, render_photon_seconds(r),
                                                       render_budget_photon_seconds(r));
        if (!(more > fraction)) break;
        render_drop_photons(r, before);
        fraction = more;
    }
    note_fraction(r, fraction);
    return SATIN_OK;
}
