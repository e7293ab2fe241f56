// SPDX-License-Identifier: Apache-2.0
// A render by several processes, its ranks. All of them run all steps, with the same decisions; the
// loops that take long are divided between them (base/parallel_results.c).
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/fileio.h"
#include "render/render_state.h"

bool render_is_first(const struct render *r) {
    return !r->callbacks.ranks || r->callbacks.ranks->rank == 0;
}

// Waits for the others, of which one may have been killed: if that or a caller cancels the render,
// the checkpoint gets what this rank has.
static void wait_for_ranks(struct render *r) {
    const satin_ranks *ranks = r->callbacks.ranks;
    if (render_cancelled(r)) render_checkpoint_interrupt(r);
    while (ranks->here && !ranks->here(ranks->user)) {
        render_progress_report(r, 1.0);
        if (render_cancelled(r)) render_checkpoint_interrupt(r);
    }
}

// For the pool: whether a loop was stopped on any rank. If that was because a caller has cancelled,
// the render is cancelled on all ranks.
static bool stopped_anywhere(void *user, bool stopped) {
    struct render *r = user;
    const satin_ranks *ranks = r->callbacks.ranks;
    wait_for_ranks(r);
    if (!ranks->any(ranks->user, stopped || render_cancelled(r))) return false;
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
    satin_status agreed = SATIN_OK;
    for (int rank = 0; rank < ranks->count && agreed == SATIN_OK; rank++) {
        agreed = status;
        ranks->broadcast(ranks->user, rank, &agreed, sizeof agreed);
    }
    return agreed;
}

// ---- The same render on all ranks ---------------------------------------------------------------

// One line about the first word that rank `root` has otherwise than this one.
static void report_unequal(const struct render *r, int root, const char *here, const char *there) {
    struct identity_word a, b;
    bool same = true;
    while (same && render_identity_next(&here, &a))
        same = render_identity_next(&there, &b) && a.length == b.length &&
               memcmp(a.at, b.at, a.length) == 0;
    if (same) return;
    if (a.name == 5 && strncmp(a.at, "scene", 5) == 0)
        log_message(r->log, SATIN_LOG_ERROR, "rank %d has read another scene than rank 0", root);
    else
        log_message(r->log, SATIN_LOG_ERROR, "rank %d has %.*s, but rank 0 has %.*s", root,
                    (int)b.length, b.at, (int)a.length, a.at);
}

// Sends the identities of all ranks to rank 0, which names the first that differs.
static void find_unequal(const struct render *r, const char *own) {
    const satin_ranks *ranks = r->callbacks.ranks;
    enum { IDENTITY_BYTES = 1 << 14 };  // some 3000 are used
    bool found = false;
    for (int root = 1; root < ranks->count; root++) {
        char other[IDENTITY_BYTES] = "";
        if (root == ranks->rank) snprintf(other, sizeof other, "%s", own);
        ranks->broadcast(ranks->user, root, other, sizeof other);
        other[sizeof other - 1] = 0;
        if (found || strcmp(own, other) == 0) continue;
        found = true;
        report_unequal(r, root, own, other);
    }
}

satin_status render_ranks_compare(const struct render *r) {
    const satin_ranks *ranks = r->callbacks.ranks;
    if (!ranks) return SATIN_OK;
    char *words = render_identity(r);
    const satin_animation *animation = r->callbacks.animation;
    const int first = animation ? animation->first : 0, last = animation ? animation->last : 0;
    const size_t size = words ? strlen(words) + sizeof " checkpoint=1 frames=+-" + 24 : 0;
    char *own = words ? malloc(size) : NULL;
    if (own)
        snprintf(own, size, "%s checkpoint=%d frames=%d-%d", words, r->callbacks.checkpoint != NULL,
                 first, last);
    free(words);
    if (ranks->any(ranks->user, !own)) {
        free(own);
        return SATIN_ERROR_MEMORY;
    }
    const uint64_t hash = fileio_hash(FILEIO_HASH, own, strlen(own));
    uint64_t root = hash;
    ranks->broadcast(ranks->user, 0, &root, sizeof root);
    const bool differ = ranks->any(ranks->user, root != hash);
    if (differ) find_unequal(r, own);
    free(own);
    return differ ? SATIN_ERROR_INPUT : SATIN_OK;
}
