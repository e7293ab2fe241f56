// SPDX-License-Identifier: Apache-2.0
// parallel_for over an index range. Threads are started, progress is reported and cancellation is
// checked only here. Chunks depend on n and chunk_size, never on the number of threads; the result
// must not depend on which worker runs a chunk.
#ifndef BASE_PARALLEL_H
#define BASE_PARALLEL_H

#include <stdbool.h>
#include <stddef.h>

struct parallel;

// Does items [begin, end) of one chunk; `worker` in [0, parallel_threads()) names its scratch.
typedef void (*parallel_fn)(void *ctx, size_t begin, size_t end, int worker);

// Called on the calling thread between chunks with the fraction of the loop that is done, in [0,
// 1]; returning true cancels the loop.
typedef bool (*parallel_progress_fn)(void *user, double done);

// The threads of a pool of `threads`: at most 1024; 0 means one per core that the process may use.
int parallel_cores(int threads);
// A pool of `threads` workers, the calling thread among them; 0 means one per core that the process
// may use. NULL if threads could not be started. Free with parallel_free.
struct parallel *parallel_new(int threads);
void parallel_free(struct parallel *pool);  // NULL is allowed
int parallel_threads(const struct parallel *pool);

// Sets the function that is asked between chunks; NULL for none.
void parallel_set_progress(struct parallel *pool, parallel_progress_fn fn, void *user);

// Runs fn over [0, n) in chunks of `chunk_size` items; 0 means 1. True if all chunks ran, false
// if cancelled: then chunks that started have returned and the others have not begun. Not
// reentrant.
bool parallel_for(struct parallel *pool, size_t n, size_t chunk_size, parallel_fn fn, void *ctx);

// Runs all chunks without asking the progress function: for what is short and must be whole. A NULL
// pool is one thread.
void parallel_for_all(struct parallel *pool, size_t n, size_t chunk_size, parallel_fn fn,
                      void *ctx);

// For a chunk that may take longer than a tenth of a second: whether the loop under way is
// cancelled, when the chunk should return, whatever is missing of it. To be asked now and then by
// the worker that runs the chunk; on the calling thread it calls the progress function.
bool parallel_cancelled(struct parallel *pool, int worker);
// Whether that was found, without calling anything.
bool parallel_stopped(const struct parallel *pool);

// ---- Where the CPU time goes ------------------------------------------------------------------

// A part of the work that a pool does: CPU seconds, which other processes on the machine do not
// change, so that they say what runs on one thread and what on all.
struct parallel_part {
    const char *name;   // static storage
    double wall_s;      // wall time
    double serial_s;    // of the thread that calls parallel_for, outside of loops
    double parallel_s;  // in loops, of all threads
    double uneven_s;    // by which PARALLEL_MODEL threads take longer than parallel_s /
                        // PARALLEL_MODEL, as chunks differ; see parallel_for
    double loops;       // of more than one chunk
};
enum { PARALLEL_PARTS = 32, PARALLEL_MODEL = 64 };

// What follows is accounted for as part `name` (static storage), until the next call; returns the
// name of the part before, with which a nested part ends. To be called by the thread that calls
// parallel_for, outside of loops. A pool begins with the part "other", which also takes what more
// than PARALLEL_PARTS names would need.
const char *parallel_begin_part(struct parallel *pool, const char *name);
// The parts so far, in the order of their beginning; *count of them, owned by the pool.
const struct parallel_part *parallel_parts(struct parallel *pool, int *count);

#endif
