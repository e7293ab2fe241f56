// SPDX-License-Identifier: Apache-2.0
// parallel_for over an index range. All threads are started here, and the callback of the pool's
// owner, which reports progress and asks for cancellation, is called during loops. Chunks depend on
// n and chunk_size, never on the number of threads; the result must not depend on which worker runs
// a chunk.
#ifndef BASE_PARALLEL_H
#define BASE_PARALLEL_H

#include <stdbool.h>
#include <stddef.h>

struct parallel;

// Processes items [begin, end) of one chunk; `worker` in [0, parallel_threads()) selects its
// scratch.
typedef void (*parallel_fn)(void *ctx, size_t begin, size_t end, int worker);

// Called on the calling thread between chunks with the fraction of the loop that is done, in [0,
// 1]; returning true cancels the loop.
typedef bool (*parallel_progress_fn)(void *user, double done);

// The number of threads of a pool of `threads`: at most 1024; 0 is one per core that the process
// may use.
int parallel_cores(int threads);
// A pool of `threads` workers, including the calling thread; 0 is one per core that the process may
// use. NULL if threads could not be started. Free it with parallel_free.
struct parallel *parallel_new(int threads);
void parallel_free(struct parallel *pool);  // NULL is allowed
int parallel_threads(const struct parallel *pool);

// Sets the function that is called between chunks; NULL is none.
void parallel_set_progress(struct parallel *pool, parallel_progress_fn fn, void *user);

// Runs fn over [0, n) in chunks of `chunk_size` items; 0 means 1. True if all chunks ran, false if
// the loop was cancelled: then chunks that had started have returned, and the others were not
// started. Not reentrant.
bool parallel_for(struct parallel *pool, size_t n, size_t chunk_size, parallel_fn fn, void *ctx);

// Runs all chunks without calling the progress function, for short loops that must not be
// cancelled. A NULL pool is one thread.
void parallel_for_all(struct parallel *pool, size_t n, size_t chunk_size, parallel_fn fn,
                      void *ctx);

// For chunks that may take longer than a tenth of a second: whether the current loop is cancelled,
// in which case the chunk should return at once, unfinished. The worker that runs the chunk should
// call it now and then; on the calling thread it calls the progress function.
bool parallel_cancelled(struct parallel *pool, int worker);
// Whether a cancellation was found, without calling the progress function.
bool parallel_stopped(const struct parallel *pool);

// ---- Where the CPU time goes --------------------------------------------------------------------

// Times of a part of the work that a pool does. CPU seconds are not affected by other processes on
// the machine, so they show how much work runs on one thread and how much on all.
struct parallel_part {
    const char *name;    // static storage
    double wall_s;       // wall time
    double serial_s;     // CPU time of the thread that calls parallel_for, outside of loops
    double parallel_s;   // CPU time of all threads in loops
    double imbalance_s;  // by how much PARALLEL_MODEL threads take longer than parallel_s /
                         // PARALLEL_MODEL, because chunks differ; see parallel_for
    double loops;        // number of loops with more than one chunk
};
enum { PARALLEL_MODEL = 64, PARALLEL_PARTS_MAX = 64 };

// Accounts for all following work as the part of this name (static storage), until the next call.
// Returns the name of the part before, to which the end of a nested part returns. Call it from the
// thread that calls parallel_for, outside of loops. A pool begins with the part "other"; work of
// names beyond PARALLEL_PARTS_MAX is accounted for there too.
const char *parallel_begin_part(struct parallel *pool, const char *name);
// The parts so far, in the order in which they first began, owned by the pool. Sets *count.
const struct parallel_part *parallel_parts(struct parallel *pool, int *count);

#endif
