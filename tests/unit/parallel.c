// SPDX-License-Identifier: Apache-2.0
// Loops over an index range: every item once, and a cancellation that reaches into long chunks.
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <time.h>

#include <cmocka.h>

#include "base/parallel.h"

enum { ITEMS = 1000, THREADS = 3 };

static void count_items(void *ctx, size_t begin, size_t end, int worker) {
    atomic_int *seen = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) atomic_fetch_add(&seen[i], 1);
}

static void every_item_once(void **state) {
    (void)state;
    static atomic_int seen[ITEMS];
    for (int threads = 1; threads <= THREADS; threads++) {
        struct parallel *pool = parallel_new(threads);
        for (int i = 0; i < ITEMS; i++) atomic_store(&seen[i], 0);
        assert_true(parallel_for(pool, ITEMS, 7, count_items, seen));
        for (int i = 0; i < ITEMS; i++) assert_int_equal(atomic_load(&seen[i]), 1);
        parallel_free(pool);
    }
}

struct endless {
    struct parallel *pool;
    atomic_int begun, ended;  // chunks
    int asked;                // times that the progress function was called
};

// A chunk that has no end but a cancellation.
static void never_ends(void *ctx, size_t begin, size_t end, int worker) {
    struct endless *e = ctx;
    (void)begin;
    (void)end;
    atomic_fetch_add(&e->begun, 1);
    const struct timespec moment = {.tv_nsec = 100000};
    while (!parallel_cancelled(e->pool, worker)) nanosleep(&moment, NULL);
    atomic_fetch_add(&e->ended, 1);
}

static bool cancel_when_all_run(void *user, double done) {
    struct endless *e = user;
    assert_true(done == 0.0);
    e->asked++;
    return atomic_load(&e->begun) == parallel_threads(e->pool);
}

// Without a chunk that asks, the loop would hang here.
static void cancellation_ends_long_chunks(void **state) {
    (void)state;
    for (int threads = 1; threads <= THREADS; threads++) {
        struct endless e = {.pool = parallel_new(threads)};
        parallel_set_progress(e.pool, cancel_when_all_run, &e);
        assert_false(parallel_for(e.pool, 1000000, 1, never_ends, &e));
        assert_int_equal(atomic_load(&e.begun), threads);
        assert_int_equal(atomic_load(&e.ended), threads);
        assert_true(e.asked >= 2);
        // The next loop is not cancelled.
        static atomic_int seen[ITEMS];
        parallel_set_progress(e.pool, NULL, NULL);
        assert_true(parallel_for(e.pool, ITEMS, 1, count_items, seen));
        parallel_free(e.pool);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_item_once),
        cmocka_unit_test(cancellation_ends_long_chunks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
