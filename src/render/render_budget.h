// SPDX-License-Identifier: Apache-2.0
// Private to render/: what a render with a time limit does when. All seconds are of wall clocks.
// Without a limit every function gives INFINITY or sets no limit.
#ifndef RENDER_BUDGET_H
#define RENDER_BUDGET_H

#include <stdbool.h>

#include "satin/types.h"

struct render;

// Seconds since the render began.
double render_elapsed(const struct render *r);
// Seconds that are left of options.time.
double render_time_left(const struct render *r);

// What a pilot of a few pixels measured (render_pilot.c).
struct render_pace {
    double rays, samples;  // per second: gather rays of records, samples of the image
    double variance;       // V: the image's variance by n samples per pixel is V n^-1.5
    double indirect2;      // q: the mean square of the indirect part of a pixel's light
};

// ---- Limits. Each holds for the loops that follow, until the next one or render_limit_end.

void render_limit_pilot(struct render *r);   // a sixteenth of the photons
void render_limit_tables(struct render *r);  // BRDFs in harmonics
// Deeper records, which began at `start` [s since the render began], up to the part `done` of them.
void render_limit_bounces(struct render *r, double start, double done);
// Records: of the time that is left for them and for the image, the fraction that makes the error
// of the image least, its variance by n samples per pixel and ERROR_RAYS q / rays by the gather
// rays per pixel of its records together. NULL: before anything is measured.
void render_limit_records(struct render *r, const struct render_pace *measured);
void render_limit_image(struct render *r);
void render_limit_look(struct render *r);  // after a cancellation, also without a time limit
// Nothing ends the next loops, which are short, until the limit before is set again.
double render_limit_lift(struct render *r);
void render_limit_restore(struct render *r, double before);
// Ends the time limit, so that it does not stop later loops. Returns SATIN_OK instead of the
// SATIN_CANCELLED of a loop that the limit stopped, but a cancellation by the caller as it is.
satin_status render_limit_end(struct render *r, satin_status status);
// Whether the limit is not over.
bool render_time_remains(const struct render *r);

// ---- Divisions of what is left.

// How many times the photons of a pilot that took so long fit; 0: so few that the pilot's are kept.
double render_budget_photons(const struct render *r, double pilot_seconds);
// Seconds that the first round of records may still take.
double render_budget_first_round(const struct render *r);

// Samples that the next pass may take if one takes so long: at most half of those that fit, so that
// the last ones are well foreseen; 0: no further pass.
double render_budget_pass(const struct render *r, double sample_seconds);
// Whether there is time to denoise: always, unless the render is cancelled and it takes too long.
bool render_budget_denoises(const struct render *r);

#endif
