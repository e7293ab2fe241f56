// SPDX-License-Identifier: Apache-2.0
// Several processes that render one image together. satin has no network of its own: the caller
// describes the processes, which are called ranks, and how they communicate. The command `satin`
// does so by MPI (src/apps/app_ranks_mpi.c).
#ifndef SATIN_RANKS_H
#define SATIN_RANKS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// The number of counters common to all ranks.
enum { SATIN_RANKS_COUNTERS = 2 };

// This process among all of them. Every rank calls satin_render with the same scene and options; in
// it all ranks call `broadcast`, `exchange` and `any` in the same order, on the thread that called
// satin_render. The functions do not return before they have succeeded: if one cannot, it ends the
// process. The struct is owned by the caller and must be valid until satin_render returns.
typedef struct satin_ranks {
    int rank, count;  // 0 <= rank < count
    void *user;       // the first argument of all functions
    // Copies `size` bytes at `data` of rank `root` to `data` of all others.
    void (*broadcast)(void *user, int root, void *data, size_t size);
    // Copies the block of each rank to all others: `blocks` has one of `size` bytes for every rank,
    // in order, of which this rank has set its own.
    void (*exchange)(void *user, void *blocks, size_t size);
    // Whether `value` is true on some rank; the same on all. No rank returns before all have
    // called.
    bool (*any)(void *user, bool value);
    // Adds to a counter in [0, SATIN_RANKS_COUNTERS), all of which are 0 at first, and returns its
    // value before. Called by any thread, by one at a time, at any time between calls of the other
    // functions.
    uint64_t (*fetch_add)(void *user, int counter, uint64_t add);
    // Sets a counter to 0. Called by rank 0 while no rank uses the counter.
    void (*reset)(void *user, int counter);
    // Waits for all ranks: true when all have called it, false after a moment if they have not, and
    // then this rank calls it again. Meanwhile satin asks whether the render is cancelled, and
    // keeps what there is in the checkpoint, as a rank may have been killed. NULL: `any` waits
    // alone.
    bool (*here)(void *user);
} satin_ranks;

#ifdef __cplusplus
}
#endif
#endif
