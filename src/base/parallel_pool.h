// SPDX-License-Identifier: Apache-2.0
// Private to base/: the state of a thread pool and of its current loop.
#ifndef BASE_PARALLEL_POOL_H
#define BASE_PARALLEL_POOL_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>

#include "base/parallel.h"

enum {
    CHUNKS_NOTED = 4096  // chunks of a loop whose times are kept; a loop of more chunks is balanced
                         // anyway
};

// The loop of all ranks that is running, and what ranks and journal are used for loops.
struct parallel_division {
    const struct satin_ranks *ranks;  // NULL: one process
    bool (*agree)(void *user, bool cancelled);
    void *agree_user;
    const struct parallel_journal *journal;  // NULL: none, or another rank has it
    enum parallel_journaled journaled;       // some rank has one for these loops
    // What was read of the results of a loop that has not all of them.
    struct {
        const void *ctx, *results;  // of the loop; NULL: there is none
        unsigned char *state;
    } read;
    satin_status status;  // the first failure
    struct parallel_traffic traffic;
    bool running;           // the chunks of the current loop are divided between the ranks
    int counter;            // from which they are taken
    pthread_mutex_t mutex;  // guards what follows
    size_t next, end;       // positions of chunks that this rank has taken, and not begun
    size_t *own;            // chunks that it has begun
    size_t own_count;
    double asked;  // wall clock when this rank asked last whether others take no more chunks
};

// The state of a chunk whose results are written to the journal.
enum { CHUNK_OPEN, CHUNK_DONE, CHUNK_WRITTEN };

// A loop, or what is left of one.
struct parallel_loop {
    parallel_fn fn;
    void *ctx;
    size_t n, chunk_size;
    size_t chunks;         // number of chunks that are run
    const size_t *list;    // their indices; NULL: 0 to chunks - 1
    unsigned char *state;  // set to CHUNK_DONE for each that was run to its end; NULL: is not
    size_t before;         // number of chunks of the loop that were run before
};

struct parallel {
    int threads;
    int started;  // number of helper threads that run; at most threads - 1
    pthread_t *helpers;
    pthread_mutex_t mutex;
    pthread_cond_t wake, done;
    uint64_t generation;  // guarded by mutex: number of loops so far
    int busy;             // guarded by mutex: helpers still in the current loop
    bool quit;            // guarded by mutex
    int next_worker;      // guarded by mutex: next worker number to assign at start

    struct parallel_loop loop;
    atomic_size_t next_chunk, finished;
    atomic_bool cancelled;
    atomic_bool paused;  // no further chunks are begun, as results are due to be written
    struct parallel_division division;
    parallel_progress_fn progress;
    void *progress_user;

    double *worker_spent;       // CPU seconds of each worker in the current loop
    double *worker_busy;        // seconds of each worker in the current loop
    double loops_s, busy_s;     // both, of all workers in all loops so far
    float spent[CHUNKS_NOTED];  // CPU seconds of its first chunks
    struct parallel_part part[PARALLEL_PARTS_MAX];
    int part_count, current;  // number of parts; index of the current one
    double wall, cpu;  // times of the two clocks up to which the current part is accounted for
};

// What parallel_for does. It may return with true before all chunks were run, as their state shows.
bool parallel_run(struct parallel *pool, const struct parallel_loop *loop);
// The index of a chunk that is at this position in the order of the loop.
static inline size_t parallel_chunk_at(const struct parallel *pool, size_t position) {
    return pool->loop.list ? pool->loop.list[position] : position;
}
// The position of the next chunk of the current loop for this rank; the number of chunks or more if
// there is none (parallel_results.c).
size_t parallel_take_chunk(struct parallel *pool);
// Keeps all ranks from taking further chunks of the current loop.
void parallel_close_chunks(struct parallel *pool);

// ---- Results as bytes ---------------------------------------------------------------------------

// A loop with results.
struct results_loop {
    struct parallel *pool;
    size_t n, chunk_size, chunks;
    void *ctx;
    const struct parallel_results *results;
    unsigned char *state;  // of its chunks; NULL: the loop is not journaled
};

// Appends the index, the size and the results of a chunk.
void parallel_pack_chunk(const struct results_loop *loop, size_t chunk, struct bytes *out);
// Takes the results of chunks with rising indices. SATIN_ERROR_INPUT if the bytes are not results
// of the loop, or if it has some of them; SATIN_ERROR_MEMORY.
satin_status parallel_unpack_chunks(const struct results_loop *loop, struct bytes_reader *in);

// ---- The journal (parallel_journal.c) -----------------------------------------------------------

// Whether the journal has the results of such a loop.
bool parallel_is_journaled(const struct parallel *pool, const struct parallel_results *results);
// Sets the state of all chunks, and takes what results there are, unless that was done before.
// SATIN_ERROR_MEMORY or SATIN_ERROR_INPUT: the status of the pool.
void parallel_journal_begin(struct results_loop *loop);
// The number of chunks whose results are there.
size_t parallel_chunks_done(const struct results_loop *loop);
// Writes the results of chunks that were run since this was called last.
void parallel_journal_write(const struct results_loop *loop);

#endif
