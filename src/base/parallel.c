// SPDX-License-Identifier: Apache-2.0
// A thread pool on pthreads: workers sleep between loops and take chunks from an atomic counter.
#include "base/parallel.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <unistd.h>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

enum { THREADS_MAX = 1024 };

struct parallel {
    int threads;
    int started;  // helper threads that run; at most threads - 1
    pthread_t *helpers;
    pthread_mutex_t mutex;
    pthread_cond_t wake, done;
    uint64_t generation;  // guarded by mutex: counts loops
    int busy;             // guarded by mutex: helpers still in the current loop
    bool quit;            // guarded by mutex
    int next_worker;      // guarded by mutex: hands out worker numbers at start

    parallel_fn fn;
    void *ctx;
    size_t n, chunk_size, chunks;
    atomic_size_t next_chunk, finished;
    atomic_bool cancelled;
    parallel_progress_fn progress;
    void *progress_user;
};

// Denormals cost hundreds of cycles each and Embree asks for FTZ and DAZ on every thread that
// traces.
static void flush_denormals(void) {
#if defined(__SSE__)
    _mm_setcsr(_mm_getcsr() | 0x8040);
#endif
}

bool parallel_cancelled(struct parallel *pool, int worker) {
    if (atomic_load(&pool->cancelled)) return true;
    if (worker != 0 || !pool->progress) return false;
    const double fraction =
        pool->chunks ? (double)atomic_load(&pool->finished) / (double)pool->chunks : 1.0;
    if (!pool->progress(pool->progress_user, fraction)) return false;
    atomic_store(&pool->cancelled, true);
    return true;
}

bool parallel_stopped(const struct parallel *pool) { return atomic_load(&pool->cancelled); }

static void run_chunks(struct parallel *pool, int worker) {
    while (!parallel_cancelled(pool, worker)) {
        size_t chunk = atomic_fetch_add(&pool->next_chunk, 1);
        if (chunk >= pool->chunks) return;
        size_t begin = chunk * pool->chunk_size;
        size_t end = pool->n - begin > pool->chunk_size ? begin + pool->chunk_size : pool->n;
        pool->fn(pool->ctx, begin, end, worker);
        atomic_fetch_add(&pool->finished, 1);
    }
}

static void *helper_main(void *arg) {
    struct parallel *pool = arg;
    flush_denormals();
    pthread_mutex_lock(&pool->mutex);
    int worker = pool->next_worker++;
    uint64_t seen = 0;
    for (;;) {
        while (!pool->quit && pool->generation == seen)
            pthread_cond_wait(&pool->wake, &pool->mutex);
        if (pool->quit) break;
        seen = pool->generation;
        pthread_mutex_unlock(&pool->mutex);
        run_chunks(pool, worker);
        pthread_mutex_lock(&pool->mutex);
        if (--pool->busy == 0) pthread_cond_signal(&pool->done);
    }
    pthread_mutex_unlock(&pool->mutex);
    return NULL;
}

static int cores_available(void) {
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0) return CPU_COUNT(&set);
    long n = sysconf(_SC_NPROCESSORS_ONLN);
    return n > 0 ? (int)n : 1;
}

int parallel_cores(int threads) {
    if (threads <= 0) threads = cores_available();
    return threads < THREADS_MAX ? threads : THREADS_MAX;
}

struct parallel *parallel_new(int threads) {
    threads = parallel_cores(threads);
    struct parallel *pool = calloc(1, sizeof *pool);
    if (!pool) return NULL;
    pool->threads = threads;
    pool->next_worker = 1;
    pthread_mutex_init(&pool->mutex, NULL);
    pthread_cond_init(&pool->wake, NULL);
    pthread_cond_init(&pool->done, NULL);
    flush_denormals();
    pool->helpers = calloc((size_t)threads, sizeof *pool->helpers);
    if (!pool->helpers) {
        parallel_free(pool);
        return NULL;
    }
    for (int i = 0; i + 1 < threads; i++) {
        if (pthread_create(&pool->helpers[i], NULL, helper_main, pool) != 0) {
            parallel_free(pool);
            return NULL;
        }
        pool->started++;
    }
    return pool;
}

void parallel_free(struct parallel *pool) {
    if (!pool) return;
    pthread_mutex_lock(&pool->mutex);
    pool->quit = true;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->mutex);
    for (int i = 0; i < pool->started; i++) pthread_join(pool->helpers[i], NULL);
    pthread_cond_destroy(&pool->done);
    pthread_cond_destroy(&pool->wake);
    pthread_mutex_destroy(&pool->mutex);
    free(pool->helpers);
    free(pool);
}

int parallel_threads(const struct parallel *pool) { return pool->threads; }

void parallel_set_progress(struct parallel *pool, parallel_progress_fn fn, void *user) {
    pool->progress = fn;
    pool->progress_user = user;
}

bool parallel_for(struct parallel *pool, size_t n, size_t chunk_size, parallel_fn fn, void *ctx) {
    if (n == 0) return true;
    pool->fn = fn;
    pool->ctx = ctx;
    pool->n = n;
    pool->chunk_size = chunk_size ? chunk_size : 1;
    pool->chunks = n / pool->chunk_size + (n % pool->chunk_size != 0);
    atomic_store(&pool->next_chunk, 0);
    atomic_store(&pool->finished, 0);
    atomic_store(&pool->cancelled, false);
    if (pool->chunks > 1 && pool->started > 0) {
        pthread_mutex_lock(&pool->mutex);
        pool->busy = pool->started;
        pool->generation++;
        pthread_cond_broadcast(&pool->wake);
        pthread_mutex_unlock(&pool->mutex);
        run_chunks(pool, 0);
        pthread_mutex_lock(&pool->mutex);
        while (pool->busy > 0) pthread_cond_wait(&pool->done, &pool->mutex);
        pthread_mutex_unlock(&pool->mutex);
    } else {
        run_chunks(pool, 0);
    }
    return !atomic_load(&pool->cancelled);
}
