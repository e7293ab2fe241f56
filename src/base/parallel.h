// SPDX-License-Identifier: Apache-2.0
// parallel_for over an index range. All threads are started here, and the callback of the pool's
// owner, which reports progress and asks for cancellation, is called during loops. Chunks depend on
// n and chunk_size, never on the number of threads; the result must not depend on which worker runs
// a chunk.
#ifndef BASE_PARALLEL_H
#define BASE_PARALLEL_H

#include <stdbool.h>
#include <stddef.h>

#include "base/bytes.h"
#include "satin/ranks.h"
#include "satin/types.h"

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
// The number of cores that such a pool can have.
int parallel_cores_of(int threads);
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

// ---- Loops whose results can be computed elsewhere (parallel_results.c) -------------------------

// An array that has an element for each item of a loop.
struct parallel_slot {
    void *items;  // NULL: no array
    size_t size;  // of an element in bytes
};
enum { PARALLEL_SLOTS = 7 };

// All that the items of a loop leave behind: elements of arrays, or what two functions convert.
struct parallel_results {
    struct parallel_slot slot[PARALLEL_SLOTS];
    // Appends the results of items [begin, end), a chunk of the loop that has been run. NULL: all
    // results are in the slots.
    void (*pack)(void *ctx, size_t begin, size_t end, struct bytes *out);
    // Does what running the chunk would do. False if there is no memory.
    bool (*unpack)(void *ctx, size_t begin, size_t end, struct bytes_reader *in);
    bool if_cancelled;  // whether the chunks that were begun are of use if the loop is cancelled
    bool journaled;     // whether the results are written to the journal
    // Not 0: results that serve only until those of a later loop are written, and are written only
    // if this loop takes long. The number is one that other such loops before do not have.
    uint32_t passing;
};

// An entry of the journal: results of some chunks of a loop.
struct parallel_entry {
    uint32_t passing;  // as in struct parallel_results
    bool last;         // no further entry of this loop follows
};

// Keeps the results of loops, so that a later process need not run them again.
struct parallel_journal {
    void *user;
    // Sets *out to the next results, and entry->last, and returns true; or returns false if there
    // are no further ones. `entry->passing` says which are asked for.
    bool (*read)(void *user, struct parallel_entry *entry, struct bytes *out);
    // Appends results.
    void (*write)(void *user, struct parallel_entry entry, const struct bytes *results);
    // Whether it is time to write what the running loop has done so far. NULL: it never is.
    bool (*due)(void *user);
};
// Which loops the journal has.
enum parallel_journaled { PARALLEL_NO_LOOPS, PARALLEL_PASSING_LOOPS, PARALLEL_ALL_LOOPS };

// Sets the ranks that divide the loops with results; NULL: this process is alone. A loop is
// cancelled on all of them if it is on one. `agree` is called by all ranks after each loop that can
// be cancelled, and returns whether it is cancelled on any.
void parallel_set_ranks(struct parallel *pool, const struct satin_ranks *ranks,
                        bool (*agree)(void *user, bool cancelled), void *user);
const struct satin_ranks *parallel_ranks(const struct parallel *pool);
// Only rank 0 has a journal; `loops` is equal on all ranks. The struct must stay valid.
void parallel_set_journal(struct parallel *pool, const struct parallel_journal *journal,
                          enum parallel_journaled loops);
// SATIN_ERROR_MEMORY if there was no memory for the results of a loop, SATIN_ERROR_INPUT if those
// of the journal are not of that loop; else SATIN_OK. After a failure all loops are cancelled.
satin_status parallel_status(const struct parallel *pool);

// Does what parallel_for does, but a chunk may be run by another rank, or its results may be read
// from the journal. In the end all ranks have the results of all chunks. Chunks must read nothing
// that other chunks of the loop write.
bool parallel_for_results(struct parallel *pool, size_t n, size_t chunk_size, parallel_fn fn,
                          void *ctx, const struct parallel_results *results);
// Takes the results of a loop from the journal, which saves what only chunks of that loop need.
// False if the journal does not have all of them: then parallel_for_results is to be called for the
// loop, with the same `ctx` and `results`, and runs the chunks that are missing.
// If it has, parallel_status reports whether they could be read.
bool parallel_read_results(struct parallel *pool, size_t n, size_t chunk_size, void *ctx,
                           const struct parallel_results *results);
// What the ranks have exchanged so far.
struct parallel_traffic {
    double loops;    // that were divided
    double bytes;    // results of all ranks
    double seconds;  // in which this rank sent and received results, and waited for others
};
struct parallel_traffic parallel_get_traffic(const struct parallel *pool);
// Returns `found` of rank 0 on all ranks, and if it is true copies the bytes of rank 0 to them.
bool parallel_broadcast(struct parallel *pool, bool found, struct bytes *bytes);
// Replaces each of the values by its sum over all ranks.
void parallel_sum(struct parallel *pool, uint64_t *values, size_t count);

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
// The name of the current part.
const char *parallel_work_name(const struct parallel *pool);
// The CPU seconds of all threads in loops so far.
double parallel_loop_seconds(const struct parallel *pool);
// The number of cores that the threads have had in loops so far: their CPU time per second, times
// their number. It is less than that where other processes run, or the CPU time of this one is
// limited; that of parallel_cores_of while it is not known.
double parallel_cores_had(const struct parallel *pool);
// The parts so far, in the order in which they first began, owned by the pool. Sets *count.
const struct parallel_part *parallel_parts(struct parallel *pool, int *count);

#endif
