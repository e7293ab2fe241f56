// SPDX-License-Identifier: Apache-2.0
// The results of loops in the journal. Those of a loop are in one or several entries, each with
// chunks that no entry before has, and the last one says so. So what a loop has done can be written
// while it runs, and entries of a limited size need little memory.
#include "base/parallel_pool.h"

// Results of an entry, but for its last chunk. A process that is killed while it writes loses one.
enum { ENTRY_BYTES = 1 << 24 };

bool parallel_is_journaled(const struct parallel *pool, const struct parallel_results *results) {
    const enum parallel_journaled least =
        results->passing ? PARALLEL_PASSING_LOOPS : PARALLEL_ALL_LOOPS;
    return results->journaled && pool->division.journaled >= least;
}

size_t parallel_chunks_done(const struct results_loop *loop) {
    size_t done = 0;
    for (size_t i = 0; i < loop->chunks; i++) done += loop->state[i] != CHUNK_OPEN;
    return done;
}

static size_t count_unwritten(const struct results_loop *loop) {
    size_t count = 0;
    for (size_t i = 0; i < loop->chunks; i++) count += loop->state[i] == CHUNK_DONE;
    return count;
}

// ---- Reading ------------------------------------------------------------------------------------

// Takes the results of the next entry of the loop. False if there is none.
static bool read_entry(const struct results_loop *loop, bool *last) {
    struct parallel_division *division = &loop->pool->division;
    const struct parallel_journal *journal = division->journal;
    struct parallel_entry entry = {.passing = loop->results->passing};
    struct bytes bytes = {0};
    bool found = journal && journal->read(journal->user, &entry, &bytes);
    found = parallel_broadcast(loop->pool, found, &bytes);
    *last = parallel_broadcast(loop->pool, entry.last, &(struct bytes){0});
    if (found && division->status == SATIN_OK)
        division->status =
            parallel_unpack_chunks(loop, &(struct bytes_reader){bytes.data, bytes.count, false});
    bytes_free(&bytes);
    for (size_t i = 0; found && i < loop->chunks; i++)
        if (loop->state[i] == CHUNK_DONE) loop->state[i] = CHUNK_WRITTEN;
    return found && division->status == SATIN_OK;
}

void parallel_journal_begin(struct results_loop *loop) {
    struct parallel_division *division = &loop->pool->division;
    if (division->read.state && division->read.ctx == loop->ctx &&
        division->read.results == loop->results) {
        loop->state = division->read.state;
        division->read.state = NULL;
        return;
    }
    loop->state = array_new(loop->chunks, 1);
    if (!loop->state) division->status = SATIN_ERROR_MEMORY;
    bool last = false, found = true;
    while (found && !last && division->status == SATIN_OK) found = read_entry(loop, &last);
    if (division->status != SATIN_OK) return;
    const bool whole = parallel_chunks_done(loop) == loop->chunks;
    if (last && !whole) division->status = SATIN_ERROR_INPUT;
    // The process before was killed when it was going to say that this is all.
    if (!last && whole) parallel_journal_write(loop);
}

// ---- Writing ------------------------------------------------------------------------------------

// Packs results that are not written yet, from *chunk on, until the entry is full. Returns how many
// chunks these are.
static uint64_t pack_entry(const struct results_loop *loop, size_t *chunk, struct bytes *out) {
    uint64_t count = 0;
    out->count = 0;
    bytes_put_u64(out, 0);
    for (; *chunk < loop->chunks && out->count < ENTRY_BYTES; ++*chunk) {
        if (loop->state[*chunk] != CHUNK_DONE) continue;
        parallel_pack_chunk(loop, *chunk, out);
        loop->state[*chunk] = CHUNK_WRITTEN;
        count++;
    }
    if (out->failed)
        out->count = 0;
    else
        memcpy(out->data, &count, sizeof count);
    return count;
}

void parallel_journal_write(const struct results_loop *loop) {
    const struct parallel_journal *journal = loop->pool->division.journal;
    const size_t done = parallel_chunks_done(loop);
    size_t left = count_unwritten(loop), chunk = 0;
    const bool whole = done == loop->chunks;
    const uint32_t passing = loop->results->passing;
    // Passing results of a loop that no entry has were made in a short time.
    if (!journal || (passing && whole && left == done) || (left == 0 && !whole)) return;
    struct bytes bytes = {0};
    do {
        left -= pack_entry(loop, &chunk, &bytes);
        const struct parallel_entry entry = {passing, whole && left == 0};
        journal->write(journal->user, entry, &bytes);
    } while (left > 0 && !bytes.failed);
    bytes_free(&bytes);
}
