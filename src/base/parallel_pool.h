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
    bool has_journal;                        // some rank has one
    satin_status status;                     // the first failure
    struct parallel_traffic traffic;
    bool running;           // the chunks of the current loop are divided between the ranks
    int counter;            // from which they are taken
    pthread_mutex_t mutex;  // guards what follows
    size_t next, end;       // chunks that this rank has taken, and not begun
    size_t *own;            // chunks that it has begun
    size_t own_count;
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

    parallel_fn fn;
    void *ctx;
    size_t n, chunk_size, chunks;
    atomic_size_t next_chunk, finished;
    atomic_bool cancelled;
    struct parallel_division division;
    parallel_progress_fn progress;
    void *progress_user;

    double *worker_spent;       // CPU seconds of each worker in the current loop
    float spent[CHUNKS_NOTED];  // CPU seconds of its first chunks
    struct parallel_part part[PARALLEL_PARTS_MAX];
    int part_count, current;  // number of parts; index of the current one
    double wall, cpu;  // times of the two clocks up to which the current part is accounted for
};

// The next chunk of the current loop for this rank; the number of chunks or more if there is none
// (parallel_results.c).
size_t parallel_take_chunk(struct parallel *pool);
// Keeps all ranks from taking further chunks of the current loop.
void parallel_close_chunks(struct parallel *pool);

#endif
