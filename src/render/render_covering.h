// SPDX-License-Identifier: Apache-2.0
// Private to render/: the first round of records with a time limit, which must cover the image
// within its time, whatever the number of records: in furnished rooms it is some thousand. It gives
// them as many gather rays as fit.
#ifndef RENDER_COVERING_H
#define RENDER_COVERING_H

#include "render/render_budget.h"

// The state of the round.
struct render_covering {
    float rays;  // fraction of the options' gather rays for records of the coarsest level; from
                 // RENDER_COARSEST on, records of all levels get all
    double last, made;      // numbers of records of the last level, and so far of this one
    double full, seconds;   // records, each weighted by its fraction of the rays, and the time for
                            // them; earlier ones count less
    double pixels, search;  // pixels that were searched for sites, and the time for that [s]
};

// The fraction of the options' gather rays for records of the level of this stride.
float render_covering_rays(const satin_options *options, const struct render_covering *covering,
                           int stride);
// The seconds that the search for sites takes in `pixels` pixels.
double render_covering_search(const struct render_covering *covering, double pixels);
// Whether the level of this stride, of `pixels` pixels, is filled although its sites have to be
// searched, if `left` seconds remain for it and for the finer levels.
bool render_covering_pays(const struct render_covering *covering, double pixels, double left);
// Sets the rays of records of the level of this stride and of finer ones. At most `needed` more
// records cover this level, of `pixels` pixels; `left` seconds remain. Without a measured speed
// they get all.
void render_covering_plan(const satin_options *options, struct render_covering *covering,
                          int stride, double pixels, double needed, double left);
// To be called with the time for `made` records of the level of this stride [s].
void render_covering_filled(const satin_options *options, struct render_covering *covering,
                            int stride, double made, double seconds);
// To be called after a level.
void render_covering_next(struct render_covering *covering);
// To be called after a level whose records and rays were measured: whether the image is denoised
// and there is no time for records by all of their rays. Then it has none: records of few rays have
// noise that is not denoised.
bool render_covering_without_records(const satin_options *options,
                                     const struct render_covering *covering, int stride);

#endif
