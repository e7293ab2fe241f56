// SPDX-License-Identifier: Apache-2.0
// A thread pool on pthreads: workers sleep between loops and take chunks from an atomic counter.
// The CPU time of every chunk is measured, by a call of about .2 us. From the times of a loop's
// chunks the time is computed that many threads would need, by a list schedule, as they too take
// chunks in order.
#include "base/parallel.h"

#include <math.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include "base/parallel_pool.h"
#include "base/stats.h"

enum { THREADS_MAX = 1024 };

// The seconds of loops after which it is known how many cores the threads have: processes alternate
// within some ms, and limits of CPU time are for tenths of a second.
static const double HAD_KNOWN = 0.1;

// Sets FTZ and DAZ: denormals cost hundreds of cycles each, and Embree asks for both flags on every
// thread that traces rays.
static void flush_denormals(void) {
#if defined(__SSE__)
    _mm_setcsr(_mm_getcsr() | 0x8040);
#endif
}

bool parallel_cancelled(struct parallel *pool, int worker) {
    if (atomic_load(&pool->cancelled) || pool->division.status != SATIN_OK) {
        atomic_store(&pool->cancelled, true);
        return true;
    }
    if (worker != 0 || !pool->progress) return false;
    const struct satin_ranks *ranks = pool->division.running ? pool->division.ranks : NULL;
    const double before = (double)pool->loop.before, all = before + (double)pool->loop.chunks;
    const double finished = (double)atomic_load(&pool->finished) * (ranks ? ranks->count : 1);
    const double fraction = all > 0.0 ? fmin((before + finished) / all, 1.0) : 1.0;
    if (!pool->progress(pool->progress_user, fraction)) return false;
    atomic_store(&pool->cancelled, true);
    return true;
}

bool parallel_stopped(const struct parallel *pool) { return atomic_load(&pool->cancelled); }

static size_t noted_chunks(const struct parallel *pool) {
    return pool->loop.chunks < CHUNKS_NOTED ? pool->loop.chunks : CHUNKS_NOTED;
}

// Whether this rank begins no further chunks, which the calling thread decides after a chunk of its
// own.
static bool pauses(struct parallel *pool, int worker) {
    const struct parallel_journal *journal = pool->division.journal;
    if (worker == 0 && pool->loop.state && journal && journal->due && journal->due(journal->user))
        atomic_store(&pool->paused, true);
    return atomic_load(&pool->paused);
}

static void run_chunk(struct parallel *pool, size_t chunk, int worker) {
    const struct parallel_loop *loop = &pool->loop;
    const size_t begin = chunk * loop->chunk_size;
    const size_t end = loop->n - begin > loop->chunk_size ? begin + loop->chunk_size : loop->n;
    loop->fn(loop->ctx, begin, end, worker);
    // A chunk that was cancelled may be unfinished.
    if (loop->state && !atomic_load(&pool->cancelled)) loop->state[chunk] = CHUNK_DONE;
    atomic_fetch_add(&pool->finished, 1);
}

static void run_chunks(struct parallel *pool, int worker) {
    const double begun = stats_wall();
    double sum = 0.0, before = stats_thread();
    while (!parallel_cancelled(pool, worker)) {
        const size_t position = pool->division.running ? parallel_take_chunk(pool)
                                                       : atomic_fetch_add(&pool->next_chunk, 1);
        if (position >= pool->loop.chunks) break;
        run_chunk(pool, parallel_chunk_at(pool, position), worker);
        const double after = stats_thread();
        if (position < CHUNKS_NOTED) pool->spent[position] = (float)(after - before);
        sum += after - before;
        before = after;
        if (pauses(pool, worker)) break;
    }
    const bool ends = atomic_load(&pool->cancelled) || atomic_load(&pool->paused);
    if (pool->division.running && ends) parallel_close_chunks(pool);
    pool->worker_spent[worker] = sum;
    pool->worker_busy[worker] = stats_wall() - begun;
}

static void *helper_main(void *arg) {
    struct parallel *pool = arg;
    flush_denormals();
    pthread_mutex_lock(&pool->mutex);
    int worker = pool->next_worker++;
    uint64_t last = 0;
    for (;;) {
        while (!pool->quit && pool->generation == last)
            pthread_cond_wait(&pool->wake, &pool->mutex);
        if (pool->quit) break;
        last = pool->generation;
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
    pthread_mutex_init(&pool->division.mutex, NULL);
    flush_denormals();
    pool->part[pool->part_count++].name = "other";
    pool->wall = stats_wall();
    pool->cpu = stats_thread();
    pool->helpers = calloc((size_t)threads, sizeof *pool->helpers);
    pool->worker_spent = calloc((size_t)threads, sizeof *pool->worker_spent);
    pool->worker_busy = calloc((size_t)threads, sizeof *pool->worker_busy);
    if (!pool->helpers || !pool->worker_spent || !pool->worker_busy) {
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
    pthread_mutex_destroy(&pool->division.mutex);
    free(pool->division.read.state);
    free(pool->helpers);
    free(pool->worker_spent);
    free(pool->worker_busy);
    free(pool);
}

int parallel_threads(const struct parallel *pool) { return pool->threads; }

void parallel_set_progress(struct parallel *pool, parallel_progress_fn fn, void *user) {
    pool->progress = fn;
    pool->progress_user = user;
}

// ---- Parts --------------------------------------------------------------------------------------

// Adds to the current part the time that the calling thread has spent since the last call.
static void account_serial(struct parallel *pool) {
    struct parallel_part *part = &pool->part[pool->current];
    const double wall = stats_wall(), cpu = stats_thread();
    part->wall_s += wall - pool->wall;
    if (cpu > pool->cpu) part->serial_s += cpu - pool->cpu;  // otherwise it is another thread
    pool->wall = wall;
    pool->cpu = cpu;
}

// Seconds that PARALLEL_MODEL threads need for chunks of these times, if each chunk in turn is
// taken by the thread that becomes free first.
static double schedule(const float *spent, size_t chunks) {
    double busy[PARALLEL_MODEL] = {0.0}, last = 0.0;
    for (size_t i = 0; i < chunks; i++) {
        int first = 0;
        for (int k = 1; k < PARALLEL_MODEL; k++)
            if (busy[k] < busy[first]) first = k;
        busy[first] += (double)spent[i];
        if (busy[first] > last) last = busy[first];
    }
    return last;
}

// Adds the times of the loop that has ended to the current part.
static void account_loop(struct parallel *pool) {
    struct parallel_part *part = &pool->part[pool->current];
    const size_t noted = noted_chunks(pool);
    double sum = 0.0, noted_sum = 0.0;
    for (int i = 0; i < pool->threads; i++) {
        sum += pool->worker_spent[i];
        pool->busy_s += pool->worker_busy[i];
        pool->worker_spent[i] = pool->worker_busy[i] = 0.0;
    }
    for (size_t i = 0; i < noted; i++) noted_sum += (double)pool->spent[i];
    part->parallel_s += sum;
    pool->loops_s += sum;
    part->imbalance_s += schedule(pool->spent, noted) - noted_sum / PARALLEL_MODEL;
    part->loops += pool->loop.chunks > 1;
    const double wall = stats_wall();
    part->wall_s += wall - pool->wall;
    pool->wall = wall;
    pool->cpu = stats_thread();
}

const char *parallel_begin_part(struct parallel *pool, const char *name) {
    const char *before = pool->part[pool->current].name;
    account_serial(pool);
    int i = 0;
    while (i < pool->part_count && strcmp(pool->part[i].name, name) != 0) i++;
    if (i == PARALLEL_PARTS_MAX)
        i = 0;
    else if (i == pool->part_count)
        pool->part[pool->part_count++].name = name;
    pool->current = i;
    return before;
}

const char *parallel_work_name(const struct parallel *pool) {
    return pool->part[pool->current].name;
}

const struct parallel_part *parallel_parts(struct parallel *pool, int *count) {
    account_serial(pool);
    *count = pool->part_count;
    return pool->part;
}

double parallel_loop_seconds(const struct parallel *pool) { return pool->loops_s; }

int parallel_cores_of(int threads) {
    const int all = parallel_cores(threads), available = cores_available();
    return all < available ? all : available;
}

double parallel_cores_had(const struct parallel *pool) {
    const bool known = pool->busy_s >= HAD_KNOWN && pool->loops_s > 0.0;
    if (!known) return parallel_cores_of(pool->threads);
    return pool->threads * fmin(pool->loops_s / pool->busy_s, 1.0);
}

// ---- Loops --------------------------------------------------------------------------------------

bool parallel_run(struct parallel *pool, const struct parallel_loop *loop) {
    account_serial(pool);
    pool->loop = *loop;
    atomic_store(&pool->next_chunk, 0);
    atomic_store(&pool->finished, 0);
    atomic_store(&pool->cancelled, false);
    atomic_store(&pool->paused, false);
    memset(pool->spent, 0, noted_chunks(pool) * sizeof *pool->spent);
    if (loop->chunks > 1 && pool->started > 0) {
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
    if (pool->division.agree && pool->progress)
        atomic_store(&pool->cancelled, pool->division.agree(pool->division.agree_user,
                                                            atomic_load(&pool->cancelled)));
    account_loop(pool);
    return !atomic_load(&pool->cancelled);
}

bool parallel_for(struct parallel *pool, size_t n, size_t chunk_size, parallel_fn fn, void *ctx) {
    if (n == 0) return true;
    struct parallel_loop loop = {
        .fn = fn, .ctx = ctx, .n = n, .chunk_size = chunk_size ? chunk_size : 1};
    loop.chunks = n / loop.chunk_size + (n % loop.chunk_size != 0);
    return parallel_run(pool, &loop);
}

void parallel_for_all(struct parallel *pool, size_t n, size_t chunk_size, parallel_fn fn,
                      void *ctx) {
    if (pool) {
        const parallel_progress_fn progress = pool->progress;
        pool->progress = NULL;
        parallel_for(pool, n, chunk_size, fn, ctx);
        pool->progress = progress;
        return;
    }
    if (chunk_size == 0) chunk_size = 1;
    for (size_t begin = 0; begin < n; begin += chunk_size)
        fn(ctx, begin, n - begin > chunk_size ? begin + chunk_size : n, 0);
}
