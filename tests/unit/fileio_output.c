// SPDX-License-Identifier: Apache-2.0
// Files written: whole or absent, links followed, devices and pipes written to, never replaced.
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/fileio.h"
#include "base/fileio_output.h"
#include "folder_case.h"
#include "message_case.h"

static const struct log silent = {0};

static satin_status fileio_output_put(const char *path, const char *text) {
    return fileio_write(silent, path, text, strlen(text));
}

static void expect_text(const char *path, const char *text) {
    char *data;
    size_t size;
    assert_int_equal(fileio_read(silent, (struct log_place){0}, path, 1 << 20, &data, &size),
                     SATIN_OK);
    assert_string_equal(data, text);
    free(data);
}

// No new file stays behind in the working directory.
static void expect_tidy(void) { assert_int_not_equal(system("ls -a . | grep -q '[.]tmp'"), 0); }

static void expect_link(const char *path, const char *to) {
    char text[PATH_MAX] = "";
    assert_true(readlink(path, text, sizeof text - 1) > 0);
    assert_string_equal(text, to);
}

// Both the check and the opening refuse it with one message that ends so; nothing is left.
static void expect_refused(const char *path, enum fileio_need need, const char *why) {
    struct message message = {0};
    const struct log log = {keep, &message};
    struct fileio_output out;
    assert_int_equal(fileio_output_check(log, path, need), SATIN_ERROR_INPUT);
    assert_int_equal(message.count, 1);
    assert_non_null(strstr(message.text, why));
    assert_int_equal(fileio_output_open(log, path, need, &out), SATIN_ERROR_IO);
    assert_int_equal(message.count, 2);
    assert_non_null(strstr(message.text, ": cannot write: "));
    expect_tidy();
}

static void a_file_appears_whole_or_not_at_all(void **state) {
    (void)state;
    struct fileio_output out;
    assert_int_equal(fileio_output_open(silent, "a", FILEIO_SEEK, &out), SATIN_OK);
    assert_true(fileio_output_write_at(&out, "cd", 2, 2));
    assert_true(fileio_output_write_at(&out, "ab", 2, 0));
    assert_int_not_equal(access("a", F_OK), 0);
    assert_int_equal(fileio_output_commit(silent, &out), SATIN_OK);
    expect_text("a", "abcd");
    // Whether writing was given up or failed, the file stays as it was.
    assert_int_equal(fileio_output_open(silent, "a", FILEIO_SEEK, &out), SATIN_OK);
    assert_true(fileio_output_append(&out, "new", 3));
    fileio_output_discard(&out);
    expect_text("a", "abcd");
    assert_int_equal(fileio_output_open(silent, "a", FILEIO_SEEK, &out), SATIN_OK);
    struct message message = {0};
    close(out.fd);
    assert_false(fileio_output_append(&out, "new", 3));
    assert_int_equal(out.error, EBADF);
    assert_false(fileio_output_append(&out, "new", 3));
    assert_int_equal(fileio_output_commit((struct log){keep, &message}, &out), SATIN_ERROR_IO);
    assert_string_equal(message.text, "a: cannot write: Bad file descriptor");
    expect_text("a", "abcd");
    expect_tidy();
}

static void the_temporary_name_is_unused(void **state) {
    (void)state;
    struct fileio_output one, two;
    assert_int_equal(fileio_output_open(silent, "twice", FILEIO_APPEND, &one), SATIN_OK);
    assert_int_equal(fileio_output_open(silent, "twice", FILEIO_APPEND, &two), SATIN_OK);
    assert_string_not_equal(one.temporary, two.temporary);
    assert_true(fileio_output_append(&one, "1", 1));
    assert_true(fileio_output_append(&two, "2", 1));
    assert_int_equal(fileio_output_commit(silent, &one), SATIN_OK);
    assert_int_equal(fileio_output_commit(silent, &two), SATIN_OK);
    expect_text("twice", "2");
    // The longest possible name has a new name too.
    char name[NAME_MAX + 1] = "";
    memset(name, 'n', NAME_MAX);
    assert_int_equal(fileio_output_put(name, "long"), SATIN_OK);
    expect_text(name, "long");
    expect_tidy();
}

static void permissions_are_kept(void **state) {
    (void)state;
    struct stat st;
    assert_int_equal(fileio_output_put("mode", "1"), SATIN_OK);
    assert_int_equal(chmod("mode", 0640), 0);
    assert_int_equal(fileio_output_put("mode", "2"), SATIN_OK);
    assert_int_equal(stat("mode", &st), 0);
    assert_int_equal(st.st_mode & 0777, 0640);
    expect_text("mode", "2");
    // Root may write to every file.
    if (geteuid() == 0) return;
    assert_int_equal(chmod("mode", 0440), 0);
    expect_refused("mode", FILEIO_APPEND, strerror(EACCES));
    expect_text("mode", "2");
}

static void links_are_followed(void **state) {
    (void)state;
    assert_int_equal(mkdir("sub", 0777), 0);
    assert_int_equal(fileio_output_put("sub/real", "old"), SATIN_OK);
    assert_int_equal(symlink("sub/real", "first"), 0);
    assert_int_equal(symlink("first", "second"), 0);
    assert_int_equal(fileio_output_put("second", "new"), SATIN_OK);
    expect_text("sub/real", "new");
    expect_link("first", "sub/real");
    expect_link("second", "first");
    // A link to a file that does not exist makes that file.
    assert_int_equal(symlink("made", "sub/dangling"), 0);
    assert_int_equal(fileio_output_put("sub/dangling", "made"), SATIN_OK);
    expect_text("sub/made", "made");
    expect_link("sub/dangling", "made");
    assert_int_equal(symlink("round", "round"), 0);
    expect_refused("round", FILEIO_APPEND, strerror(ELOOP));
    assert_int_equal(symlink("none/file", "astray"), 0);
    expect_refused("astray", FILEIO_APPEND, strerror(ENOENT));
}

static void what_is_no_file_is_refused(void **state) {
    (void)state;
    assert_int_equal(mkdir("folder", 0777), 0);
    expect_refused("folder", FILEIO_APPEND, "it is a directory");
    expect_refused("folder/", FILEIO_APPEND, "it is a directory");
    expect_refused(".", FILEIO_SEEK, "it is a directory");
    expect_refused("none/file", FILEIO_APPEND, strerror(ENOENT));
    expect_refused("none/", FILEIO_APPEND, strerror(ENOENT));
    expect_refused("", FILEIO_APPEND, strerror(ENOENT));
    assert_int_equal(fileio_output_put("plain", ""), SATIN_OK);
    expect_refused("plain/file", FILEIO_APPEND, strerror(ENOTDIR));
    expect_refused("/dev/null", FILEIO_SEEK, "it is not a regular file");
    const struct sockaddr_un address = {AF_UNIX, "socket"};
    const int server = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(server, (const struct sockaddr *)&address, sizeof address), 0);
    expect_refused("socket", FILEIO_APPEND, "it is not a regular file");
    close(server);
}

static void devices_and_pipes_are_not_replaced(void **state) {
    (void)state;
    struct stat st;
    char got[8] = "";
    assert_int_equal(symlink("/dev/null", "null"), 0);
    assert_int_equal(fileio_output_check(silent, "null", FILEIO_APPEND), SATIN_OK);
    assert_int_equal(fileio_output_put("null", "gone"), SATIN_OK);
    expect_link("null", "/dev/null");
    assert_true(stat("/dev/null", &st) == 0 && S_ISCHR(st.st_mode));
    // The check of a pipe does not wait for its reader.
    assert_int_equal(mkfifo("pipe", 0666), 0);
    assert_int_equal(fileio_output_check(silent, "pipe", FILEIO_APPEND), SATIN_OK);
    const int reader = open("pipe", O_RDONLY | O_NONBLOCK);
    assert_int_equal(fileio_output_put("pipe", "through"), SATIN_OK);
    assert_int_equal(read(reader, got, sizeof got - 1), 7);
    assert_string_equal(got, "through");
    close(reader);
    assert_true(lstat("pipe", &st) == 0 && S_ISFIFO(st.st_mode));
}

static void open_files_are_written_to(void **state) {
    (void)state;
    char name[32];
    const int fd = open("open", O_RDWR | O_CREAT, 0666);
    assert_int_equal(write(fd, "before ", 7), 7);
    snprintf(name, sizeof name, "/dev/fd/%d", fd);
    assert_int_equal(fileio_output_check(silent, name, FILEIO_APPEND), SATIN_OK);
    assert_int_equal(fileio_output_put(name, "during"), SATIN_OK);
    assert_int_equal(write(fd, " after", 6), 6);
    expect_text("open", "before during after");
    // They are opened by a link, such as /dev/stdout, which stays.
    snprintf(name, sizeof name, "/proc/self/fd/%d", fd);
    assert_int_equal(symlink(name, "standard"), 0);
    assert_int_equal(fileio_output_put("standard", "."), SATIN_OK);
    expect_text("open", "before during after.");
    expect_link("standard", name);
    expect_refused("standard", FILEIO_SEEK, "it is not a regular file");
    close(fd);
    expect_refused("standard", FILEIO_APPEND, strerror(EBADF));
    const int reading = open("open", O_RDONLY);
    snprintf(name, sizeof name, "/dev/fd/%d", reading);
    expect_refused(name, FILEIO_APPEND, "it is not open for writing");
    close(reading);
}

// A directory that has replaced the file meanwhile is not replaced.
static void the_target_is_checked_again_before_the_rename(void **state) {
    (void)state;
    struct fileio_output out;
    struct message message = {0};
    assert_int_equal(fileio_output_open(silent, "changing", FILEIO_APPEND, &out), SATIN_OK);
    assert_int_equal(symlink("/dev/null", "changing"), 0);
    assert_int_equal(fileio_output_commit((struct log){keep, &message}, &out), SATIN_ERROR_IO);
    assert_string_equal(message.text, "changing: cannot write: it is not a regular file");
    expect_link("changing", "/dev/null");
    expect_tidy();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_appears_whole_or_not_at_all),
        cmocka_unit_test(the_temporary_name_is_unused),
        cmocka_unit_test(permissions_are_kept),
        cmocka_unit_test(links_are_followed),
        cmocka_unit_test(what_is_no_file_is_refused),
        cmocka_unit_test(devices_and_pipes_are_not_replaced),
        cmocka_unit_test(open_files_are_written_to),
        cmocka_unit_test(the_target_is_checked_again_before_the_rename),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
