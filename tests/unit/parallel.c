// SPDX-License-Identifier: Apache-2.0
// Loops over an index range: every item once, and a cancellation that ends long chunks.
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <time.h>

#include <cmocka.h>

#include "base/parallel.h"
#include "base/stats.h"

enum { ITEMS = 1000, THREADS = 3 };

static void count_items(void *ctx, size_t begin, size_t end, int worker) {
    atomic_int *seen = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++) atomic_fetch_add(&seen[i], 1);
}

static void every_item_is_computed_once(void **state) {
    (void)state;
    static atomic_int seen[ITEMS];
    for (int threads = 1; threads <= THREADS; threads++) {
        struct parallel *pool = parallel_new(threads);
        for (int i = 0; i < ITEMS; i++) atomic_store(&seen[i], 0);
        assert_true(parallel_for(pool, ITEMS, 7, count_items, seen));
        for (int i = 0; i < ITEMS; i++) assert_int_equal(atomic_load(&seen[i]), 1);
        parallel_for_all(pool, ITEMS, 7, count_items, seen);
        parallel_for_all(NULL, ITEMS, 7, count_items, seen);
        for (int i = 0; i < ITEMS; i++) assert_int_equal(atomic_load(&seen[i]), 3);
        parallel_free(pool);
    }
}

// A chunk size of 0 means 1, with a pool and without.
static void chunks_are_never_empty(void **state) {
    (void)state;
    static atomic_int seen[ITEMS];
    struct parallel *pool = parallel_new(1);
    assert_true(parallel_for(pool, ITEMS, 0, count_items, seen));
    parallel_for_all(pool, ITEMS, 0, count_items, seen);
    parallel_for_all(NULL, ITEMS, 0, count_items, seen);
    for (int i = 0; i < ITEMS; i++) assert_int_equal(atomic_load(&seen[i]), 3);
    parallel_free(pool);
}

struct endless {
    struct parallel *pool;
    atomic_int begun, ended;  // chunks
    int asked;                // times that the progress function was called
};

// A chunk that ends only by a cancellation.
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

static void work_for(double seconds) {
    struct timespec begin, now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &begin);
    do clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    while ((double)(now.tv_sec - begin.tv_sec) + 1e-9 * (double)(now.tv_nsec - begin.tv_nsec) <
           seconds);
}

// The first of the chunks takes ten times as long as another.
static void parallel_work(void *ctx, size_t begin, size_t end, int worker) {
    (void)ctx;
    (void)end;
    (void)worker;
    work_for(begin == 0 ? 0.01 : 0.001);
}

// CPU times do not depend on other processes, but a switch between processes can add to them; they
// cannot be less.
static void assert_seconds(double found, double expected) {
    assert_true(found >= 0.999 * expected);
    assert_true(found <= expected + 0.01);
}

static void parts_know_what_is_serial(void **state) {
    (void)state;
    for (int threads = 1; threads <= THREADS; threads++) {
        struct parallel *pool = parallel_new(threads);
        assert_string_equal(parallel_begin_part(pool, "view"), "other");
        work_for(0.004);
        assert_true(parallel_for(pool, 21, 1, parallel_work, NULL));
        assert_string_equal(parallel_begin_part(pool, "trace"), "view");
        assert_true(parallel_for(pool, 1, 1, parallel_work, NULL));
        assert_string_equal(parallel_begin_part(pool, "view"), "trace");
        work_for(0.003);
        int count;
        const struct parallel_part *part = parallel_parts(pool, &count);
        assert_int_equal(count, 3);
        const struct parallel_part *view = &part[1], *trace = &part[2];
        assert_string_equal(part[0].name, "other");
        assert_string_equal(view->name, "view");
        assert_string_equal(trace->name, "trace");
        assert_seconds(view->serial_s, 0.007);
        assert_seconds(view->parallel_s, 0.030);
        // 64 threads wait for the long chunk.
        assert_seconds(view->imbalance_s, 0.010 - 0.030 / PARALLEL_MODEL);
        assert_true(view->loops == 1.0);
        assert_seconds(trace->serial_s, 0.0);
        assert_seconds(trace->parallel_s, 0.010);
        assert_seconds(trace->imbalance_s, 0.010 - 0.010 / PARALLEL_MODEL);
        assert_true(trace->loops == 0.0);
        assert_true(view->wall_s >= 0.007 + 0.010);
        parallel_free(pool);
    }
}

static void many_parts_are_accounted_for(void **state) {
    (void)state;
    static char name[PARALLEL_PARTS_MAX + 8][8];
    struct parallel *pool = parallel_new(1);
    int count;
    for (int i = 0; i < PARALLEL_PARTS_MAX + 8; i++) {
        snprintf(name[i], sizeof name[i], "%d", i);
        parallel_begin_part(pool, name[i]);
    }
    work_for(0.004);
    const struct parallel_part *part = parallel_parts(pool, &count);
    assert_int_equal(count, PARALLEL_PARTS_MAX);
    assert_true(part[0].serial_s >= 0.004 && part[count - 1].serial_s < 0.004);
    parallel_free(pool);
}

// A chunk that works, and then waits for as long, as one of a process that has half of a core.
static void works_and_waits(void *ctx, size_t begin, size_t end, int worker) {
    const double wall = stats_wall(), cpu = stats_thread();
    (void)ctx;
    (void)begin;
    (void)end;
    (void)worker;
    while (stats_thread() - cpu < 0.005) continue;
    const double spent = stats_wall() - wall;
    nanosleep(&(struct timespec){.tv_nsec = (long)(1e9 * spent)}, NULL);
}

static void it_is_known_after_a_moment_how_many_cores_there_are(void **state) {
    (void)state;
    struct parallel *pool = parallel_new(1);
    assert_true(parallel_cores_had(pool) == 1.0);
    assert_true(parallel_loop_seconds(pool) == 0.0);
    assert_true(parallel_for(pool, 1, 1, works_and_waits, NULL));
    assert_true(parallel_cores_had(pool) == 1.0);
    assert_true(parallel_for(pool, 20, 1, works_and_waits, NULL));
    assert_true(parallel_loop_seconds(pool) >= 0.1);
    assert_true(parallel_cores_had(pool) > 0.0 && parallel_cores_had(pool) < 0.55);
    parallel_free(pool);
    assert_true(parallel_cores_of(1) == 1);
    assert_true(parallel_cores_of(1024) <= parallel_cores(0));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_item_is_computed_once),
        cmocka_unit_test(chunks_are_never_empty),
        cmocka_unit_test(cancellation_ends_long_chunks),
        cmocka_unit_test(parts_know_what_is_serial),
        cmocka_unit_test(many_parts_are_accounted_for),
        cmocka_unit_test(it_is_known_after_a_moment_how_many_cores_there_are),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
