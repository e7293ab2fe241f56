// SPDX-License-Identifier: Apache-2.0
// The file of a checkpoint: passing entries are read by their own loop alone.
#include "render/render_checkpoint_file.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "folder_case.h"

static const char *const checkpoint_path = "state.checkpoint";
enum { FIRST_LOOP = 5, SECOND_LOOP = 7 };
static const unsigned PIECE = CHECKPOINT_PIECE | CHECKPOINT_PASSING,
                      LAST = CHECKPOINT_LOOP | CHECKPOINT_PASSING;

static struct bytes bytes_of(const char *text) {
    return (struct bytes){(unsigned char *)text, strlen(text) + 1, 0, false};
}

static struct checkpoint_file *open_checkpoint(bool resume) {
    struct checkpoint_file *file = NULL;
    bool resumed;
    const struct bytes identity = bytes_of("version=1");
    assert_int_equal(render_checkpoint_file_open(checkpoint_path, &identity, resume,
                                                 (struct log){0}, &resumed, &file),
                     SATIN_OK);
    assert_int_equal(resumed, resume);
    return file;
}

static void append_entry(struct checkpoint_file *file, unsigned kind, uint32_t passing,
                         const char *text) {
    const struct bytes entry = bytes_of(text);
    assert_int_equal(render_checkpoint_file_append(file, kind, passing, &entry, (struct log){0}),
                     SATIN_OK);
}

static void assert_read(struct checkpoint_file *file, unsigned kind, uint32_t passing,
                        const char *text) {
    struct bytes found = {0};
    assert_int_equal(render_checkpoint_file_read(file, kind, passing, &found), text != NULL);
    if (text) assert_string_equal((const char *)found.data, text);
    bytes_free(&found);
}

// A loop that has written nothing is followed by one that has: its results must not be read by the
// first one, and remain for the second.
static void passing_entries_are_those_of_their_loop(void **state) {
    (void)state;
    struct checkpoint_file *file = open_checkpoint(false);
    append_entry(file, CHECKPOINT_LOOP, 0, "loop");
    append_entry(file, PIECE, SECOND_LOOP, "one");
    append_entry(file, LAST, SECOND_LOOP, "two");
    render_checkpoint_file_close(file);
    file = open_checkpoint(true);
    assert_read(file, CHECKPOINT_IDENTITY, 0, "version=1");
    assert_read(file, CHECKPOINT_LOOP, 0, "loop");
    assert_read(file, PIECE, FIRST_LOOP, NULL);
    assert_read(file, LAST, FIRST_LOOP, NULL);
    assert_read(file, PIECE, SECOND_LOOP, "one");
    assert_read(file, PIECE, SECOND_LOOP, NULL);
    assert_read(file, LAST, SECOND_LOOP, "two");
    assert_read(file, LAST, SECOND_LOOP, NULL);
    render_checkpoint_file_close(file);
}

// If the first loop takes long this time, its results replace those of the later one.
static void later_entries_are_replaced(void **state) {
    (void)state;
    struct checkpoint_file *file = open_checkpoint(false);
    append_entry(file, PIECE, SECOND_LOOP, "one");
    render_checkpoint_file_close(file);
    file = open_checkpoint(true);
    assert_read(file, CHECKPOINT_IDENTITY, 0, "version=1");
    assert_read(file, PIECE, FIRST_LOOP, NULL);
    append_entry(file, LAST, FIRST_LOOP, "other");
    assert_read(file, PIECE, SECOND_LOOP, NULL);
    render_checkpoint_file_close(file);
    file = open_checkpoint(true);
    assert_read(file, CHECKPOINT_IDENTITY, 0, "version=1");
    assert_read(file, LAST, FIRST_LOOP, "other");
    assert_read(file, PIECE, SECOND_LOOP, NULL);
    render_checkpoint_file_close(file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(passing_entries_are_those_of_their_loop),
        cmocka_unit_test(later_entries_are_replaced),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
