// SPDX-License-Identifier: Apache-2.0
// Loops whose results can be computed elsewhere. As the result of an item depends on nothing but
// the scene, the options and its index, a loop can be divided between processes in any way, and it
// need not run at all if its results are in the journal of an earlier process.
//
// Ranks take ranges of chunks from a counter that they have in common, which are the smaller the
// fewer chunks are left, so that a slow rank delays the others by one chunk at most. After the loop
// all ranks exchange the results of their chunks.
//
// Results as bytes: the number of chunks, then for each its index, its size, and the result.
//
// A loop with a journal ends early when its results are due to be written, and then goes on with
// the chunks that are left.
#include "base/parallel_pool.h"
#include "base/stats.h"

void parallel_set_ranks(struct parallel *pool, const struct satin_ranks *ranks,
                        bool (*agree)(void *user, bool cancelled), void *user) {
    pool->division.ranks = ranks && ranks->count > 1 ? ranks : NULL;
    pool->division.agree = pool->division.ranks ? agree : NULL;
    pool->division.agree_user = user;
}

const struct satin_ranks *parallel_ranks(const struct parallel *pool) {
    return pool->division.ranks;
}

void parallel_set_journal(struct parallel *pool, const struct parallel_journal *journal,
                          enum parallel_journaled loops) {
    pool->division.journal = journal;
    pool->division.journaled = loops;
}

satin_status parallel_status(const struct parallel *pool) { return pool->division.status; }

struct parallel_traffic parallel_get_traffic(const struct parallel *pool) {
    return pool->division.traffic;
}

// ---- Division of the chunks ---------------------------------------------------------------------

enum { RANGES_PER_RANK = 4 };  // a range is the fraction 1 / (ranks * this) of what is left
// The counter of chunks that are closed is at least this, which no number of chunks is.
static const uint64_t CHUNKS_CLOSED = 1ull << 40;
// How often a rank that has a range asks whether the chunks were closed.
static const double ASK_SECONDS = 0.25;

// Takes the next range of chunks.
static void take_range(struct parallel *pool) {
    struct parallel_division *division = &pool->division;
    const struct satin_ranks *ranks = division->ranks;
    const size_t chunks = pool->loop.chunks, left = chunks - division->end;
    const size_t fair = left / (RANGES_PER_RANK * (size_t)ranks->count);
    const size_t range = fair > 1 ? fair : 1;
    const uint64_t first = ranks->fetch_add(ranks->user, division->counter, range);
    division->next = first < chunks ? (size_t)first : chunks;
    division->end = chunks - division->next > range ? division->next + range : chunks;
}

// Leaves a range whose chunks others want to be written to the journal first.
static void leave_range(struct parallel *pool) {
    struct parallel_division *division = &pool->division;
    const double now = stats_wall();
    if (now - division->asked < ASK_SECONDS) return;
    division->asked = now;
    const struct satin_ranks *ranks = division->ranks;
    if (ranks->fetch_add(ranks->user, division->counter, 0) >= CHUNKS_CLOSED)
        division->next = division->end = pool->loop.chunks;
}

size_t parallel_take_chunk(struct parallel *pool) {
    struct parallel_division *division = &pool->division;
    pthread_mutex_lock(&division->mutex);
    if (pool->loop.state && division->next < division->end) leave_range(pool);
    if (division->next == division->end && division->end < pool->loop.chunks) take_range(pool);
    size_t position = pool->loop.chunks;
    if (division->next < division->end) {
        position = division->next++;
        division->own[division->own_count++] = parallel_chunk_at(pool, position);
    }
    pthread_mutex_unlock(&division->mutex);
    return position;
}

void parallel_close_chunks(struct parallel *pool) {
    struct parallel_division *division = &pool->division;
    pthread_mutex_lock(&division->mutex);
    division->ranks->fetch_add(division->ranks->user, division->counter, CHUNKS_CLOSED);
    division->next = division->end = pool->loop.chunks;
    pthread_mutex_unlock(&division->mutex);
}

// Runs the loop, divided between the ranks, whose own chunks are in pool->division then. If it was
// cancelled, no rank begins a further chunk. The two counters are used in turn: one is set to 0
// when all ranks have left its loop, and used again after they have left another.
static bool run_divided(struct parallel *pool, const struct parallel_loop *loop) {
    struct parallel_division *division = &pool->division;
    const struct satin_ranks *ranks = division->ranks;
    division->next = division->end = division->own_count = 0;
    division->running = true;
    division->asked = stats_wall();
    const bool whole = parallel_run(pool, loop);
    division->running = false;
    if (ranks->rank == 0) ranks->reset(ranks->user, division->counter);
    division->counter = (division->counter + 1) % SATIN_RANKS_COUNTERS;
    return whole;
}

// ---- Results as bytes ---------------------------------------------------------------------------

static size_t chunk_end(const struct results_loop *loop, size_t begin) {
    return loop->n - begin > loop->chunk_size ? begin + loop->chunk_size : loop->n;
}

void parallel_pack_chunk(const struct results_loop *loop, size_t chunk, struct bytes *out) {
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

// SATIN_ERROR_INPUT if the bytes are not results of the loop, those of a chunk that is there, or
// those of a chunk before *next, which becomes the chunk after this one.
static satin_status unpack_chunk(const struct results_loop *loop, struct bytes_reader *in,
                                 uint64_t *next) {
    const uint64_t chunk = bytes_get_u64(in), size = bytes_get_u64(in);
    if (in->failed || chunk < *next || chunk >= loop->chunks || size > in->left)
        return SATIN_ERROR_INPUT;
    if (loop->state && loop->state[chunk] != CHUNK_OPEN) return SATIN_ERROR_INPUT;
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
    if (taken && loop->state) loop->state[chunk] = CHUNK_DONE;
    return taken ? SATIN_OK : SATIN_ERROR_MEMORY;
}

satin_status parallel_unpack_chunks(const struct results_loop *loop, struct bytes_reader *in) {
    const uint64_t count = bytes_get_u64(in);
    uint64_t next = 0;
    satin_status status = count > loop->chunks ? SATIN_ERROR_INPUT : SATIN_OK;
    for (uint64_t i = 0; i < count && status == SATIN_OK; i++)
        status = unpack_chunk(loop, in, &next);
    return status == SATIN_OK && (in->failed || in->left > 0) ? SATIN_ERROR_INPUT : status;
}

// ---- Exchange -----------------------------------------------------------------------------------

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

// Results of a piece, but for its last chunk: what was packed is in the processor's cache when it
// is sent and read.
enum { PIECE_BYTES = 1 << 17 };

// Pieces of the results of all ranks, one of each at a time.
struct results_exchange {
    const struct results_loop *loop;
    size_t at;           // own chunks that are packed
    struct bytes piece;  // of this rank
    struct bytes all;    // blocks of equal sizes, with the piece of each rank
    struct piece_head {
        uint64_t bytes, more;  // size of the piece, and whether another one follows
    } * head;                  // of each rank
};

// Packs the next chunks of this rank: of those that it has begun, or of a loop with a journal has
// ended.
static void pack_piece(struct results_exchange *e) {
    const struct results_loop *loop = e->loop;
    const struct parallel_division *division = &loop->pool->division;
    uint64_t count = 0;
    e->piece.count = 0;
    bytes_put_u64(&e->piece, 0);
    for (; e->at < division->own_count && e->piece.count < PIECE_BYTES; e->at++) {
        const size_t chunk = division->own[e->at];
        if (loop->state && loop->state[chunk] == CHUNK_OPEN) continue;
        parallel_pack_chunk(loop, chunk, &e->piece);
        count++;
    }
    if (!e->piece.failed) memcpy(e->piece.data, &count, sizeof count);
    e->head[division->ranks->rank] =
        (struct piece_head){e->piece.count, e->at < division->own_count};
}

// Gives all ranks the pieces of all.
static satin_status exchange_pieces(struct results_exchange *e) {
    struct parallel_division *division = &e->loop->pool->division;
    const struct satin_ranks *ranks = division->ranks;
    ranks->exchange(ranks->user, e->head, sizeof *e->head);
    size_t size = 0;
    for (int i = 0; i < ranks->count; i++) {
        if (e->head[i].bytes > size) size = (size_t)e->head[i].bytes;
        division->traffic.bytes += (double)e->head[i].bytes;
    }
    if (e->piece.failed ||
        !array_reserve((void **)&e->all.data, &e->all.capacity, (size_t)ranks->count * size, 1))
        return SATIN_ERROR_MEMORY;
    memcpy(e->all.data + (size_t)ranks->rank * size, e->piece.data, e->piece.count);
    ranks->exchange(ranks->user, e->all.data, size);
    satin_status status = SATIN_OK;
    for (int i = 0; i < ranks->count && status == SATIN_OK; i++) {
        struct bytes_reader in = {e->all.data + (size_t)i * size, (size_t)e->head[i].bytes, false};
        if (i != ranks->rank) status = parallel_unpack_chunks(e->loop, &in);
    }
    return status;
}

static bool has_more(const struct results_exchange *e) {
    bool more = false;
    for (int i = 0; i < e->loop->pool->division.ranks->count; i++) more |= e->head[i].more != 0;
    return more;
}

// Gives all ranks the results of all chunks.
static satin_status exchange_results(const struct results_loop *loop) {
    struct parallel_division *division = &loop->pool->division;
    const double start = stats_wall();
    struct results_exchange e = {.loop = loop};
    e.head = array_new((size_t)division->ranks->count, sizeof *e.head);
    satin_status status = e.head ? SATIN_OK : SATIN_ERROR_MEMORY;
    do {
        if (status == SATIN_OK) pack_piece(&e);
        if (status == SATIN_OK) status = exchange_pieces(&e);
    } while (status == SATIN_OK && has_more(&e));
    division->traffic.loops += 1.0;
    division->traffic.seconds += stats_wall() - start;
    free(e.head);
    bytes_free(&e.piece);
    bytes_free(&e.all);
    return status;
}

// Runs the chunks of a loop, or those of `run` of it.
static bool run_loop(const struct results_loop *loop, const struct parallel_loop *run) {
    struct parallel *pool = loop->pool;
    if (!pool->division.ranks || loop->chunks < 2) return parallel_run(pool, run);
    struct parallel_division *division = &pool->division;
    division->own = array_new(run->chunks, sizeof *division->own);
    if (!division->own) division->status = SATIN_ERROR_MEMORY;
    const bool whole = division->own && run_divided(pool, run);
    if (division->status == SATIN_OK && (whole || loop->results->if_cancelled || loop->state))
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

static struct results_loop loop_of(struct parallel *pool, size_t n, size_t chunk_size, void *ctx,
                                   const struct parallel_results *results) {
    if (chunk_size == 0) chunk_size = 1;
    const size_t chunks = n / chunk_size + (n % chunk_size != 0);
    return (struct results_loop){pool, n, chunk_size, chunks, ctx, results, NULL};
}

// Lists the chunks whose results are missing. NULL if there is no memory.
static size_t *list_open(const struct results_loop *loop, size_t count) {
    size_t *list = array_new(count, sizeof *list), at = 0;
    for (size_t i = 0; list && i < loop->chunks; i++)
        if (loop->state[i] == CHUNK_OPEN) list[at++] = i;
    return list;
}

// Runs the chunks that are missing, until all were run or results are due to be written. False if
// that was cancelled.
static bool run_open(const struct results_loop *loop, parallel_fn fn, size_t done) {
    struct parallel_loop run = {.fn = fn,
                                .ctx = loop->ctx,
                                .n = loop->n,
                                .chunk_size = loop->chunk_size,
                                .chunks = loop->chunks - done,
                                .state = loop->state,
                                .before = done};
    size_t *list = done ? list_open(loop, run.chunks) : NULL;
    if (done && !list) loop->pool->division.status = SATIN_ERROR_MEMORY;
    run.list = list;
    const bool whole = (!done || list) && run_loop(loop, &run);
    free(list);
    return whole;
}

static bool run_journaled(struct results_loop *loop, parallel_fn fn) {
    const struct parallel_division *division = &loop->pool->division;
    bool whole = true;
    parallel_journal_begin(loop);
    while (whole && division->status == SATIN_OK) {
        const size_t done = parallel_chunks_done(loop);
        if (done == loop->chunks) break;
        whole = run_open(loop, fn, done);
        parallel_journal_write(loop);
    }
    free(loop->state);
    return whole && division->status == SATIN_OK;
}

bool parallel_read_results(struct parallel *pool, size_t n, size_t chunk_size, void *ctx,
                           const struct parallel_results *results) {
    if (n == 0 || !parallel_is_journaled(pool, results)) return false;
    struct results_loop loop = loop_of(pool, n, chunk_size, ctx, results);
    parallel_journal_begin(&loop);
    struct parallel_division *division = &pool->division;
    const bool ends = division->status != SATIN_OK || parallel_chunks_done(&loop) == loop.chunks;
    if (ends) {
        free(loop.state);
        return true;
    }
    division->read.ctx = ctx;
    division->read.results = results;
    division->read.state = loop.state;
    return false;
}

bool parallel_for_results(struct parallel *pool, size_t n, size_t chunk_size, parallel_fn fn,
                          void *ctx, const struct parallel_results *results) {
    if (n == 0) return true;
    struct results_loop loop = loop_of(pool, n, chunk_size, ctx, results);
    if (parallel_is_journaled(pool, results)) return run_journaled(&loop, fn);
    const struct parallel_loop run = {
        .fn = fn, .ctx = ctx, .n = n, .chunk_size = loop.chunk_size, .chunks = loop.chunks};
    return run_loop(&loop, &run);
}

void parallel_sum(struct parallel *pool, uint64_t *values, size_t count) {
    const struct satin_ranks *ranks = pool->division.ranks;
    if (!ranks) return;
    const size_t all = (size_t)ranks->count * count;
    uint64_t *block = array_new_unset(all, sizeof *block);
    if (!block) {
        pool->division.status = SATIN_ERROR_MEMORY;
        return;
    }
    memcpy(block + (size_t)ranks->rank * count, values, count * sizeof *values);
    ranks->exchange(ranks->user, block, count * sizeof *values);
    memset(values, 0, count * sizeof *values);
    for (size_t i = 0; i < all; i++) values[i % count] += block[i];
    free(block);
}
