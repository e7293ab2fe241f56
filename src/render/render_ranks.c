// SPDX-License-Identifier: Apache-2.0
// A render by several processes, its ranks. All of them run all steps, with the same decisions; the
// loops that take long are divided between them (base/parallel_results.c).
#include "render/render_state.h"

bool render_is_first(const struct render *r) {
    return !r->callbacks.ranks || r->callbacks.ranks->rank == 0;
}

// For the pool: whether a loop was stopped on any rank. If that was because a caller has cancelled,
// the render is cancelled on all ranks.
static bool stopped_anywhere(void *user, bool stopped) {
    struct render *r = user;
    const satin_ranks *ranks = r->callbacks.ranks;
    if (!ranks->any(ranks->user, stopped)) return false;
    const bool cancelled = ranks->any(ranks->user, render_cancelled(r));
    if (cancelled && !render_cancelled(r)) r->progress.cancelled_in = r->progress.stage;
    return true;
}

void render_ranks_install(struct render *r) {
    if (r->callbacks.ranks) parallel_set_ranks(r->pool, r->callbacks.ranks, stopped_anywhere, r);
}

double render_agreed(const struct render *r, double value) {
    const satin_ranks *ranks = r->callbacks.ranks;
    if (ranks) ranks->broadcast(ranks->user, 0, &value, sizeof value);
    return value;
}

satin_status render_ranks_status(const struct render *r, satin_status status) {
    const satin_ranks *ranks = r->callbacks.ranks;
    if (ranks) ranks->broadcast(ranks->user, 0, &status, sizeof status);
    return status;
}

satin_status render_ranks_agree(const struct render *r, satin_status status) {
    const satin_ranks *ranks = r->callbacks.ranks;
    if (!ranks || !ranks->any(ranks->user, status != SATIN_OK)) return status;
    const satin_status first = render_ranks_status(r, status);
    if (status != SATIN_OK) return status;
    return first != SATIN_OK ? first : SATIN_ERROR_INTERNAL;
}
