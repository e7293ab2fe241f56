// SPDX-License-Identifier: Apache-2.0
// Loops whose results can be computed elsewhere. As the result of an item depends on nothing but
// the scene, the options and its index, a loop can be divided between processes in any way, and it
// need not run at all if its results are in the journal of an earlier process.
//
// Ranks take ranges of chunks from a counter that they have in common, which are the smaller the
// fewer chunks are left, so that a slow rank delays the others by one chunk at most. After the loop
// each rank in turn sends the results of its chunks to all others.
//
// Results as bytes: the number of chunks, then for each its index, its size, and the result.
#include "base/parallel_pool.h"
#include "base/stats.h"

// A loop with results.
struct results_loop {
    struct parallel *pool;
    size_t n, chunk_size, chunks;
    void *ctx;
    const struct parallel_results *results;
};

void parallel_set_ranks(struct parallel *pool, const struct satin_ranks *ranks,
                        bool (*agree)(void *user, bool cancelled), void *user) {
    pool->division.ranks = ranks && ranks->count > 1 ? ranks : NULL;
    pool->division.agree = pool->division.ranks ? agree : NULL;
    pool->division.agree_user = user;
}

const struct satin_ranks *parallel_ranks(const struct parallel *pool) {
    return pool->division.ranks;
}

void parallel_set_journal(struct parallel *pool, const struct parallel_journal *journal, bool any) {
    pool->division.journal = journal;
    pool->division.has_journal = any;
}

satin_status parallel_status(const struct parallel *pool) { return pool->division.status; }

struct parallel_traffic parallel_get_traffic(const struct parallel *pool) {
    return pool->division.traffic;
}

// ---- Division of the chunks ---------------------------------------------------------------------

enum { RANGES_PER_RANK = 4 };  // a range is the fraction 1 / (ranks * this) of what is left

size_t parallel_take_chunk(struct parallel *pool) {
    struct parallel_division *division = &pool->division;
    const struct satin_ranks *ranks = division->ranks;
    pthread_mutex_lock(&division->mutex);
    if (division->next == division->end && division->end < pool->chunks) {
        const size_t left = pool->chunks - division->end;
        const size_t fair = left / (RANGES_PER_RANK * (size_t)ranks->count);
        const size_t range = fair > 1 ? fair : 1;
        const uint64_t first = ranks->fetch_add(ranks->user, division->counter, range);
        division->next = first < pool->chunks ? (size_t)first : pool->chunks;
        division->end =
            pool->chunks - division->next > range ? division->next + range : pool->chunks;
    }
    size_t chunk = pool->chunks;
    if (division->next < division->end)
        chunk = division->own[division->own_count++] = division->next++;
    pthread_mutex_unlock(&division->mutex);
    return chunk;
}

void parallel_close_chunks(struct parallel *pool) {
    struct parallel_division *division = &pool->division;
    pthread_mutex_lock(&division->mutex);
    division->ranks->fetch_add(division->ranks->user, division->counter, pool->chunks);
    division->next = division->end = pool->chunks;
    pthread_mutex_unlock(&division->mutex);
}

// Runs the loop, divided between the ranks, whose own chunks are in pool->division then. If it was
// cancelled, no rank begins a further chunk. The two counters are used in turn: one is set to 0
// when all ranks have left its loop, and used again after they have left another.
static bool run_divided(const struct results_loop *loop, parallel_fn fn) {
    struct parallel_division *division = &loop->pool->division;
    const struct satin_ranks *ranks = division->ranks;
    division->next = division->end = division->own_count = 0;
    division->running = true;
    const bool whole = parallel_for(loop->pool, loop->n, loop->chunk_size, fn, loop->ctx);
    division->running = false;
    if (ranks->rank == 0) ranks->reset(ranks->user, division->counter);
    division->counter = (division->counter + 1) % SATIN_RANKS_COUNTERS;
    return whole;
}

// ---- Results as bytes ---------------------------------------------------------------------------

static size_t chunk_end(const struct results_loop *loop, size_t begin) {
    return loop->n - begin > loop->chunk_size ? begin + loop->chunk_size : loop->n;
}

static void pack_chunk(const struct results_loop *loop, size_t chunk, struct bytes *out) {
    const size_t begin = chunk * loop->chunk_size, end = chunk_end(loop, begin);
    bytes_put_u64(out, chunk);
    const size_t size_at = out->count;
    bytes_put_u64(out, 0);
    for (int i = 0; i < PARALLEL_SLOTS; i++) {
        const struct parallel_slot *slot = &loop->results->slot[i];
        if (slot->items)
            bytes_put(out, (const char *)slot->items + begin * slot->size,
                      (end - begin) * slot->size);
    }
    if (loop->results->pack) loop->results->pack(loop->ctx, begin, end, out);
    if (out->failed) return;
    const uint64_t size = out->count - size_at - sizeof size;
    memcpy(out->data + size_at, &size, sizeof size);
}

// SATIN_ERROR_INPUT if the bytes are not results of the loop, or those of a chunk before
// *next, which becomes the chunk after this one.
static satin_status unpack_chunk(const struct results_loop *loop, struct bytes_reader *in,
                                 uint64_t *next) {
    const uint64_t chunk = bytes_get_u64(in), size = bytes_get_u64(in);
    if (in->failed || chunk < *next || chunk >= loop->chunks || size > in->left)
        return SATIN_ERROR_INPUT;
    *next = chunk + 1;
    struct bytes_reader one = {in->at, (size_t)size, false};
    in->at += size;
    in->left -= (size_t)size;
    const size_t begin = (size_t)chunk * loop->chunk_size, end = chunk_end(loop, begin);
    for (int i = 0; i < PARALLEL_SLOTS; i++) {
        const struct parallel_slot *slot = &loop->results->slot[i];
        if (slot->items)
            bytes_get(&one, (char *)slot->items + begin * slot->size, (end - begin) * slot->size);
    }
    const bool taken =
        one.failed || !loop->results->unpack || loop->results->unpack(loop->ctx, begin, end, &one);
    if (one.failed || (taken && one.left > 0)) return SATIN_ERROR_INPUT;
    return taken ? SATIN_OK : SATIN_ERROR_MEMORY;
}

// Chunks have rising indices: those of a rank, or all of them if there are `least`.
static satin_status unpack_chunks(const struct results_loop *loop, const struct bytes *bytes,
                                  size_t least) {
    struct bytes_reader in = {bytes->data, bytes->count, false};
    const uint64_t count = bytes_get_u64(&in);
    uint64_t next = 0;
    satin_status status = count < least || count > loop->chunks ? SATIN_ERROR_INPUT : SATIN_OK;
    for (uint64_t i = 0; i < count && status == SATIN_OK; i++)
        status = unpack_chunk(loop, &in, &next);
    return status == SATIN_OK && (in.failed || in.left > 0) ? SATIN_ERROR_INPUT : status;
}

// ---- Exchange and journal -----------------------------------------------------------------------

// Sends the bytes of rank `root` to all others.
static satin_status broadcast_bytes(const struct satin_ranks *ranks, int root,
                                    struct bytes *bytes) {
    enum { MESSAGE_BYTES = 1 << 28 };
    uint64_t size = bytes->count;
    ranks->broadcast(ranks->user, root, &size, sizeof size);
    if (ranks->rank != root) {
        bytes->count = 0;
        if (size > SIZE_MAX ||
            !array_reserve((void **)&bytes->data, &bytes->capacity, (size_t)size, 1))
            return SATIN_ERROR_MEMORY;
        bytes->count = (size_t)size;
    }
    for (size_t at = 0; at < bytes->count; at += MESSAGE_BYTES) {
        const size_t left = bytes->count - at;
        ranks->broadcast(ranks->user, root, bytes->data + at,
                         left < MESSAGE_BYTES ? left : MESSAGE_BYTES);
    }
    return SATIN_OK;
}

// Gives all ranks the results of all chunks.
static satin_status exchange_results(const struct results_loop *loop) {
    struct parallel_division *division = &loop->pool->division;
    const struct satin_ranks *ranks = division->ranks;
    const double start = stats_wall();
    struct bytes own = {0}, other = {0};
    bytes_put_u64(&own, division->own_count);
    for (size_t i = 0; i < division->own_count; i++) pack_chunk(loop, division->own[i], &own);
    satin_status status = own.failed ? SATIN_ERROR_MEMORY : SATIN_OK;
    for (int root = 0; root < ranks->count && status == SATIN_OK; root++) {
        const bool is_own = root == ranks->rank;
        status = broadcast_bytes(ranks, root, is_own ? &own : &other);
        division->traffic.bytes += (double)(is_own ? own.count : other.count);
        if (status == SATIN_OK && !is_own) status = unpack_chunks(loop, &other, 0);
    }
    division->traffic.loops += 1.0;
    division->traffic.seconds += stats_wall() - start;
    bytes_free(&own);
    bytes_free(&other);
    return status;
}

static bool run_loop(const struct results_loop *loop, parallel_fn fn) {
    struct parallel *pool = loop->pool;
    if (!pool->division.ranks || loop->chunks < 2)
        return parallel_for(pool, loop->n, loop->chunk_size, fn, loop->ctx);
    struct parallel_division *division = &pool->division;
    division->own = array_new(loop->chunks, sizeof *division->own);
    if (!division->own) division->status = SATIN_ERROR_MEMORY;
    const bool whole = division->own && run_divided(loop, fn);
    if (division->status == SATIN_OK && (whole || loop->results->if_cancelled))
        division->status = exchange_results(loop);
    free(division->own);
    return whole && division->status == SATIN_OK;
}

bool parallel_broadcast(struct parallel *pool, bool found, struct bytes *bytes) {
    const struct satin_ranks *ranks = pool->division.ranks;
    if (!ranks) return found;
    ranks->broadcast(ranks->user, 0, &found, sizeof found);
    if (found) pool->division.status = broadcast_bytes(ranks, 0, bytes);
    return found;
}

// Takes the results from the journal, if it has them.
static bool read_back(const struct results_loop *loop) {
    struct parallel_division *division = &loop->pool->division;
    struct bytes bytes = {0};
    bool found = division->journal && division->journal->read(division->journal->user, &bytes);
    found = parallel_broadcast(loop->pool, found, &bytes);
    if (found && division->status == SATIN_OK)
        division->status = unpack_chunks(loop, &bytes, loop->chunks);
    bytes_free(&bytes);
    return found;
}

static void write_down(const struct results_loop *loop) {
    const struct parallel_journal *journal = loop->pool->division.journal;
    if (!journal) return;
    struct bytes bytes = {0};
    bytes_put_u64(&bytes, loop->chunks);
    for (size_t i = 0; i < loop->chunks; i++) pack_chunk(loop, i, &bytes);
    if (bytes.failed) bytes.count = 0;
    journal->write(journal->user, &bytes);
    bytes_free(&bytes);
}

static struct results_loop loop_of(struct parallel *pool, size_t n, size_t chunk_size, void *ctx,
                                   const struct parallel_results *results) {
    if (chunk_size == 0) chunk_size = 1;
    const size_t chunks = n / chunk_size + (n % chunk_size != 0);
    return (struct results_loop){pool, n, chunk_size, chunks, ctx, results};
}

bool parallel_read_results(struct parallel *pool, size_t n, size_t chunk_size, void *ctx,
                           const struct parallel_results *results) {
    if (n == 0 || !results->journaled || !pool->division.has_journal) return false;
    const struct results_loop loop = loop_of(pool, n, chunk_size, ctx, results);
    return read_back(&loop);
}

bool parallel_for_results(struct parallel *pool, size_t n, size_t chunk_size, parallel_fn fn,
                          void *ctx, const struct parallel_results *results) {
    if (n == 0) return true;
    if (parallel_read_results(pool, n, chunk_size, ctx, results))
        return pool->division.status == SATIN_OK;
    const struct results_loop loop = loop_of(pool, n, chunk_size, ctx, results);
    const bool journaled = results->journaled && pool->division.has_journal;
    const bool whole = run_loop(&loop, fn);
    if (journaled && whole) write_down(&loop);
    return whole;
}

void parallel_sum(struct parallel *pool, uint64_t *values, size_t count) {
    const struct satin_ranks *ranks = pool->division.ranks;
    enum { SUMS = 16 };
    for (size_t at = 0; ranks && at < count; at += SUMS) {
        uint64_t sum[SUMS] = {0}, one[SUMS] = {0};
        const size_t here = count - at < SUMS ? count - at : SUMS;
        for (int root = 0; root < ranks->count; root++) {
            if (root == ranks->rank) memcpy(one, values + at, here * sizeof *one);
            ranks->broadcast(ranks->user, root, one, here * sizeof *one);
            for (size_t i = 0; i < here; i++) sum[i] += one[i];
        }
        memcpy(values + at, sum, here * sizeof *sum);
    }
}
