// SPDX-License-Identifier: Apache-2.0
// What a process that was killed has left of an output is removed when that is written again;
// nothing else is.
#include <limits.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/fileio.h"
#include "base/fileio_output.h"
#include "folder_case.h"

static const struct log no_log = {0};

static int count_left(void) {
    FILE *list = popen("ls -a . | grep -c '[.]tmp'", "r");
    int count = -1;
    assert_non_null(list);
    assert_int_equal(fscanf(list, "%d", &count), 1);
    pclose(list);
    return count;
}

// A process that writes half of a file and is killed.
static void kill_writer(const char *path) {
    const pid_t pid = fork();
    if (pid == 0) {
        struct fileio_output out;
        if (fileio_output_open(no_log, path, FILEIO_APPEND, &out) == SATIN_OK)
            fileio_output_append(&out, "half", 4);
        raise(SIGKILL);
    }
    assert_int_equal(waitpid(pid, NULL, 0), pid);
}

static void write_whole(const char *path) {
    assert_int_equal(fileio_write(no_log, path, "whole", 5), SATIN_OK);
}

static void what_was_left_is_removed(void **state) {
    (void)state;
    char name[NAME_MAX + 1];
    memset(name, 'n', NAME_MAX);
    name[NAME_MAX] = 0;
    const char *const paths[] = {"left.exr", "./left.exr", "folder/left.exr", name};
    assert_int_equal(system("mkdir folder"), 0);
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
        kill_writer(paths[i]);
        if (i != 2) assert_int_equal(count_left(), 1);
        write_whole("other.exr");
        if (i != 2) assert_int_equal(count_left(), 1);
        write_whole(paths[i]);
        assert_int_equal(count_left(), 0);
    }
    assert_int_not_equal(system("ls folder | grep -q '[.]tmp'"), 0);
}

static void what_is_written_is_not(void **state) {
    (void)state;
    struct fileio_output out;
    assert_int_equal(fileio_output_open(no_log, "slow.exr", FILEIO_APPEND, &out), SATIN_OK);
    write_whole("slow.exr");
    assert_int_equal(count_left(), 1);
    assert_int_equal(fileio_output_commit(no_log, &out), SATIN_OK);
    assert_int_equal(count_left(), 0);
}

// Files of the user, and those of another machine.
static void what_others_have_is_not(void **state) {
    (void)state;
    assert_int_equal(system("touch user.exr.tmp user.exr.tmp1 user.exr.tmp0123456789abcdeg "
                            "user.exr.tmp0123456789abcdef"),
                     0);
    write_whole("user.exr");
    assert_int_equal(count_left(), 4);
    assert_int_equal(system("rm user.exr.tmp*"), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_was_left_is_removed),
        cmocka_unit_test(what_is_written_is_not),
        cmocka_unit_test(what_others_have_is_not),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
