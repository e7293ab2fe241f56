// SPDX-License-Identifier: Apache-2.0
// Loops whose results can be computed elsewhere: ranks, which are threads here, have all results of
// a loop that they divide; one that is cancelled ends on all of them; and a journal replaces the
// loops of a later process, unless its results are not those of the loop.
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>
#include <pthread.h>
#include <unistd.h>

#include "base/parallel.h"

enum { ITEMS = 1000, CHUNK = 7, RANKS_MOST = 4, LOOPS = 5 };

// ---- Ranks that are threads ---------------------------------------------------------------------

struct meeting {
    pthread_barrier_t barrier;
    void *sent;
    bool value[RANKS_MOST];
    _Atomic uint64_t counter[SATIN_RANKS_COUNTERS];
    int ranks;
};

struct member {
    struct meeting *meeting;
    satin_ranks ranks;
    int threads, cancels_at;  // item whose chunk cancels the loop on this rank; negative: none
    bool whole, agreed;
    const struct parallel_journal *journal;  // of rank 0; others have any that is not NULL
    atomic_int computed;
    uint32_t square[ITEMS];
    uint32_t cube[ITEMS];  // by pack and unpack
};

static void send(void *user, int root, void *data, size_t size) {
    const struct member *m = user;
    if (m->ranks.rank == root) m->meeting->sent = data;
    pthread_barrier_wait(&m->meeting->barrier);
    if (m->ranks.rank != root) memcpy(data, m->meeting->sent, size);
    pthread_barrier_wait(&m->meeting->barrier);
}

static void send_blocks(void *user, void *blocks, size_t size) {
    const struct member *m = user;
    for (int root = 0; root < m->meeting->ranks; root++)
        send(user, root, (char *)blocks + (size_t)root * size, size);
}

static bool any_of(void *user, bool value) {
    const struct member *m = user;
    bool all = false;
    m->meeting->value[m->ranks.rank] = value;
    pthread_barrier_wait(&m->meeting->barrier);
    for (int i = 0; i < m->meeting->ranks; i++) all |= m->meeting->value[i];
    pthread_barrier_wait(&m->meeting->barrier);
    return all;
}

static uint64_t add_to(void *user, int counter, uint64_t add) {
    const struct member *m = user;
    return atomic_fetch_add(&m->meeting->counter[counter], add);
}

static void reset(void *user, int counter) {
    const struct member *m = user;
    atomic_store(&m->meeting->counter[counter], 0);
}

static bool agree_with_all(void *user, bool cancelled) {
    struct member *m = user;
    return any_of(m, cancelled);
}

static bool cancel_when_asked(void *user, double done) {
    const struct member *m = user;
    (void)done;
    return m->cancels_at >= 0 && atomic_load(&m->computed) >= m->cancels_at;
}

// ---- The loop -----------------------------------------------------------------------------------

static void compute(void *ctx, size_t begin, size_t end, int worker) {
    struct member *m = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        m->square[i] = (uint32_t)(i * i);
        m->cube[i] = (uint32_t)(i * i * i);
    }
    atomic_fetch_add(&m->computed, (int)(end - begin));
    if (m->journal) usleep(200);  // so that each rank gets chunks
}

// So many that ranks exchange several pieces.
enum { CUBE_COPIES = 256 };

static void pack_cubes(void *ctx, size_t begin, size_t end, struct bytes *out) {
    const struct member *m = ctx;
    for (size_t i = begin; i < end; i++)
        for (int k = 0; k < CUBE_COPIES; k++) bytes_put(out, &m->cube[i], sizeof m->cube[i]);
}

static bool unpack_cubes(void *ctx, size_t begin, size_t end, struct bytes_reader *in) {
    struct member *m = ctx;
    bool equal = true;
    for (size_t i = begin; i < end; i++)
        for (int k = 0; k < CUBE_COPIES; k++) {
            const uint32_t before = m->cube[i];
            bytes_get(in, &m->cube[i], sizeof m->cube[i]);
            equal = equal && (k == 0 || m->cube[i] == before);
        }
    return equal;
}

static bool run_test_loop(struct parallel *pool, struct member *m) {
    const struct parallel_results results = {.slot = {{m->square, sizeof *m->square}},
                                             .pack = pack_cubes,
                                             .unpack = unpack_cubes,
                                             .journaled = true};
    memset(m->square, 0, sizeof m->square);
    memset(m->cube, 0, sizeof m->cube);
    return parallel_for_results(pool, ITEMS, CHUNK, compute, m, &results);
}

static bool is_right(const struct member *m) {
    bool right = true;
    for (uint32_t i = 0; i < ITEMS; i++)
        right = right && m->square[i] == i * i && m->cube[i] == i * i * i;
    return right;
}

static void *be_a_rank(void *arg) {
    struct member *m = arg;
    struct parallel *pool = parallel_new(m->threads);
    parallel_set_progress(pool, cancel_when_asked, m);
    parallel_set_ranks(pool, &m->ranks, agree_with_all, m);
    if (m->journal)
        parallel_set_journal(pool, m->ranks.rank == 0 ? m->journal : NULL, PARALLEL_ALL_LOOPS);
    m->agreed = true;
    for (int i = 0; i < LOOPS && m->agreed; i++) {
        m->whole = run_test_loop(pool, m);
        m->agreed = m->whole && is_right(m);
    }
    uint64_t sum[2] = {(uint64_t)m->ranks.rank, 1};
    parallel_sum(pool, sum, 2);
    if (sum[1] != (uint64_t)m->ranks.count) m->agreed = false;
    parallel_free(pool);
    return NULL;
}

static struct member member_list[RANKS_MOST];

static void meet(int ranks, int cancelling, const struct parallel_journal *journal) {
    struct meeting meeting = {.ranks = ranks};
    pthread_t thread[RANKS_MOST];
    pthread_barrier_init(&meeting.barrier, NULL, (unsigned)ranks);
    for (int i = 0; i < ranks; i++) {
        struct member *m = &member_list[i];
        *m = (struct member){
            .meeting = &meeting, .threads = 1 + i % 2, .cancels_at = -1, .journal = journal};
        if (i == cancelling) m->cancels_at = 0;
        m->ranks = (satin_ranks){i, ranks, m, send, send_blocks, any_of, add_to, reset, NULL};
        assert_int_equal(pthread_create(&thread[i], NULL, be_a_rank, m), 0);
    }
    for (int i = 0; i < ranks; i++) pthread_join(thread[i], NULL);
    pthread_barrier_destroy(&meeting.barrier);
}

static void all_ranks_have_all_results(void **state) {
    (void)state;
    for (int ranks = 2; ranks <= RANKS_MOST; ranks++) {
        meet(ranks, -1, NULL);
        int computed = 0;
        for (int i = 0; i < ranks; i++) {
            assert_true(member_list[i].agreed);
            computed += atomic_load(&member_list[i].computed);
        }
        assert_int_equal(computed, LOOPS * ITEMS);  // each item once
    }
}

static void a_loop_is_cancelled_on_all_ranks(void **state) {
    (void)state;
    meet(3, 1, NULL);
    for (int i = 0; i < 3; i++) assert_false(member_list[i].whole);
}

// ---- The journal --------------------------------------------------------------------------------

enum { ENTRIES_MOST = 2 * ITEMS };

struct journal {
    struct bytes loop[ENTRIES_MOST];
    bool last[ENTRIES_MOST];
    int written, read;
    bool due;
};

static bool read_journal(void *user, struct parallel_entry *entry, struct bytes *out) {
    struct journal *j = user;
    if (j->read == j->written) return false;
    entry->last = j->last[j->read];
    const struct bytes *in = &j->loop[j->read++];
    out->count = 0;
    bytes_put(out, in->data, in->count);
    return !out->failed;
}

static void write_journal(void *user, struct parallel_entry entry, const struct bytes *results) {
    struct journal *j = user;
    assert_true(j->written < ENTRIES_MOST);
    j->last[j->written] = entry.last;
    bytes_put(&j->loop[j->written++], results->data, results->count);
    j->read = j->written;
}

static bool is_journal_due(void *user) {
    const struct journal *j = user;
    return j->due;
}

static void results_are_taken_from_the_journal(void **state) {
    (void)state;
    static struct journal j;
    const struct parallel_journal journal = {&j, read_journal, write_journal, NULL};
    struct parallel *pool = parallel_new(2);
    struct member *m = &member_list[0];
    *m = (struct member){.cancels_at = -1};
    parallel_set_journal(pool, &journal, PARALLEL_ALL_LOOPS);
    for (int i = 0; i < 3; i++) assert_true(run_test_loop(pool, m));
    assert_int_equal(j.written, 3);
    assert_int_equal(atomic_load(&m->computed), 3 * ITEMS);
    j.read = 0;
    for (int i = 0; i < 4; i++) {  // the last loop is not in it
        assert_true(run_test_loop(pool, m));
        assert_true(is_right(m));
    }
    assert_int_equal(atomic_load(&m->computed), 4 * ITEMS);
    assert_int_equal(j.written, 4);
    // Results that end early, or that have more than the loop.
    for (int more = 0; more < 2; more++) {
        j.read = 0;
        const size_t count = j.loop[0].count;
        if (more)
            bytes_put_u64(&j.loop[0], 0);
        else
            j.loop[0].count -= 8;
        assert_false(run_test_loop(pool, m));
        assert_int_equal(parallel_status(pool), SATIN_ERROR_INPUT);
        assert_false(run_test_loop(pool, m));  // all later loops are cancelled
        j.loop[0].count = count;
        parallel_free(pool);
        pool = parallel_new(2);
        parallel_set_journal(pool, &journal, PARALLEL_ALL_LOOPS);
    }
    parallel_free(pool);
    for (int i = 0; i < j.written; i++) bytes_free(&j.loop[i]);
}

// A loop that is cancelled again and again goes on each time behind the chunks that it has done.
static void a_loop_goes_on_after_each_cancellation(void **state) {
    (void)state;
    static struct journal j;
    const struct parallel_journal journal = {&j, read_journal, write_journal, NULL};
    struct member *m = &member_list[0];
    int runs = 0, computed = 0;
    for (bool whole = false; !whole; runs++) {
        struct parallel *pool = parallel_new(1);
        *m = (struct member){.cancels_at = 10 * CHUNK};
        parallel_set_progress(pool, cancel_when_asked, m);
        parallel_set_journal(pool, &journal, PARALLEL_ALL_LOOPS);
        j.read = 0;
        whole = run_test_loop(pool, m);
        computed += atomic_load(&m->computed);
        parallel_free(pool);
        assert_true(runs < ITEMS);
    }
    assert_true(is_right(m));
    assert_true(runs > 5);
    assert_in_range(computed, ITEMS, ITEMS + 2 * CHUNK * runs);
    for (int i = 0; i < j.written; i++) {
        assert_int_equal(j.last[i], i + 1 == j.written);
        bytes_free(&j.loop[i]);
    }
}

// Results that are due are written while the loop runs, and each chunk is run once.
static void results_that_are_due_are_written(void **state) {
    (void)state;
    static struct journal j;
    const struct parallel_journal journal = {&j, read_journal, write_journal, is_journal_due};
    struct parallel *pool = parallel_new(1);
    struct member *m = &member_list[0];
    *m = (struct member){.cancels_at = -1};
    j.due = true;
    parallel_set_journal(pool, &journal, PARALLEL_ALL_LOOPS);
    assert_true(run_test_loop(pool, m));
    assert_true(is_right(m));
    assert_int_equal(atomic_load(&m->computed), ITEMS);
    assert_true(j.written > 1);
    const int computed = atomic_load(&m->computed);
    j.read = 0;
    assert_true(run_test_loop(pool, m));
    assert_true(is_right(m));
    assert_int_equal(atomic_load(&m->computed), computed);
    // The last entry is missing, and so are its chunks: they alone are run.
    j.read = 0;
    bytes_free(&j.loop[--j.written]);
    assert_true(run_test_loop(pool, m));
    assert_true(is_right(m));
    assert_in_range(atomic_load(&m->computed) - computed, 1, CHUNK);
    parallel_free(pool);
    for (int i = 0; i < j.written; i++) bytes_free(&j.loop[i]);
}

// Ranks that divide a loop stop together when results are due, and go on with the chunks that none
// of them has run.
static void ranks_write_what_is_due(void **state) {
    (void)state;
    static struct journal j;
    const struct parallel_journal journal = {&j, read_journal, write_journal, is_journal_due};
    j.due = true;
    int entries = 0;
    for (int ranks = 2; ranks <= RANKS_MOST; ranks++) {
        int computed = 0, last = 0;
        meet(ranks, -1, &journal);
        for (int i = 0; i < ranks; i++) {
            assert_true(member_list[i].agreed);
            computed += atomic_load(&member_list[i].computed);
        }
        assert_int_equal(computed, LOOPS * ITEMS);
        entries += j.written;
        for (int i = 0; i < j.written; i++) {
            last += j.last[i];
            bytes_free(&j.loop[i]);
        }
        assert_int_equal(last, LOOPS);
        j.written = j.read = 0;
    }
    assert_true(entries > (RANKS_MOST - 1) * LOOPS);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_ranks_have_all_results),
        cmocka_unit_test(a_loop_is_cancelled_on_all_ranks),
        cmocka_unit_test(results_are_taken_from_the_journal),
        cmocka_unit_test(a_loop_goes_on_after_each_cancellation),
        cmocka_unit_test(results_that_are_due_are_written),
        cmocka_unit_test(ranks_write_what_is_due),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
