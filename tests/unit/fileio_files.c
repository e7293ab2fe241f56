// SPDX-License-Identifier: Apache-2.0
// Files are recognised under any name.
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/fileio_files.h"
#include "folder_case.h"

static void touch(const char *path) {
    const int fd = open(path, O_WRONLY | O_CREAT | O_EXCL, 0666);
    assert_true(fd >= 0);
    close(fd);
}

static int setup(void **state) {
    if (folder_case_setup(state) != 0) return -1;
    touch("a");
    touch("b");
    return mkdir("sub", 0777) || link("a", "hard") || symlink("../a", "sub/soft") ||
           symlink("sub", "other") || symlink("sub/none", "dangling");
}

static void files_that_were_read_are_known(void **state) {
    (void)state;
    struct fileio_files files = {0};
    assert_false(fileio_files_have(&files, "a"));
    for (int i = 0; i < 100; i++) assert_true(fileio_files_add(&files, "b"));
    assert_true(fileio_files_add(&files, "a"));
    assert_true(fileio_files_add(&files, "none"));
    assert_int_equal(files.count, 101);
    static const char *const same[] = {"a", "./a", "hard", "sub/soft", "other/soft", "b"};
    for (size_t i = 0; i < sizeof same / sizeof *same; i++)
        assert_true(fileio_files_have(&files, same[i]));
    assert_false(fileio_files_have(&files, "sub"));
    assert_false(fileio_files_have(&files, "none"));
    assert_false(fileio_files_have(&files, "/dev/null"));
    fileio_files_free(&files);
    assert_int_equal(files.count, 0);
}

static void names_of_one_file_are_equal(void **state) {
    (void)state;
    static const struct {
        const char *a, *b;
        bool same;
    } cases[] = {
        {"a", "a", true},
        {"a", "sub/../a", true},
        {"a", "hard", true},
        {"a", "other/soft", true},
        {"a", "b", false},
        {"a", "none", false},
        // The file does not exist yet.
        {"none", "none", true},
        {"none", "./none", true},
        {"sub/none", "other/none", true},
        {"sub/none", "dangling", true},
        {"none", "sub/none", false},
        {"none", "more", false},
        {"missing/none", "missing/none", false},  // no file, refused for another reason
        // Devices are not protected, as they lose nothing.
        {"/dev/null", "/dev/null", false},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_equal(fileio_same(cases[i].a, cases[i].b), cases[i].same);
        assert_int_equal(fileio_same(cases[i].b, cases[i].a), cases[i].same);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_that_were_read_are_known),
        cmocka_unit_test(names_of_one_file_are_equal),
    };
    return cmocka_run_group_tests(tests, setup, folder_case_teardown);
}
