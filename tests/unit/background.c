// SPDX-License-Identifier: Apache-2.0
// A copy of the process does its work even if it is asked to end; its failure is logged here.
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/background.h"
#include "message_case.h"

// What the work gets: a pipe to which it writes, and whether it fails.
struct late_work {
    int pipe;
    bool fails;
};

// Writes a byte after the signals have come.
static bool write_late(void *ctx, struct log log) {
    const struct late_work *work = ctx;
    usleep(300000);
    if (work->fails) log_message(log, SATIN_LOG_ERROR, "the disk is full");
    return write(work->pipe, "x", 1) == 1 && !work->fails;
}

static void test_ends(void **state) {
    (void)state;
    int ends[2];
    char byte = 0;
    struct background background = {0};
    struct message message = {0};
    assert_int_equal(pipe(ends), 0);
    struct late_work work = {ends[1], false};
    assert_true(background_begin(&background, ends[1], write_late, &work));
    usleep(100000);
    assert_int_equal(kill(background.pid, SIGTERM), 0);
    assert_int_not_equal(getpgid(background.pid), getpgid(0));
    assert_true(background_end(&background, (struct log){keep, &message}));
    assert_int_equal(read(ends[0], &byte, 1), 1);
    assert_int_equal(message.count, 0);
    // There is no work any more.
    assert_true(background_end(&background, (struct log){keep, &message}));
}

static void test_fails(void **state) {
    (void)state;
    int ends[2];
    struct background background = {0};
    struct message message = {0};
    assert_int_equal(pipe(ends), 0);
    struct late_work work = {ends[1], true};
    assert_true(background_begin(&background, ends[1], write_late, &work));
    assert_false(background_end(&background, (struct log){keep, &message}));
    assert_int_equal(message.count, 1);
    assert_string_equal(message.text, "the disk is full");
}

static void test_stopped(void **state) {
    (void)state;
    int ends[2];
    char byte = 0;
    struct background background = {0};
    assert_int_equal(pipe(ends), 0);
    struct late_work work = {ends[1], false};
    assert_true(background_begin(&background, ends[1], write_late, &work));
    background_stop(&background);
    close(ends[1]);
    assert_int_equal(read(ends[0], &byte, 1), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_ends), cmocka_unit_test(test_fails),
                                       cmocka_unit_test(test_stopped)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
