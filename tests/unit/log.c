// SPDX-License-Identifier: Apache-2.0
// Messages begin with the line that they are about, are one line themselves, and are not lost
// behind what stands before them.
#include "base/log.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "message_case.h"

static void errors_begin_with_their_line(void **state) {
    (void)state;
    struct message message = {0};
    const struct log log = {keep, &message};
    log_error_at(log, (struct log_place){"a.xml", 12, 5}, "%d is wrong", 7);
    assert_string_equal(message.text, "a.xml:12:5: 7 is wrong");
    log_error_at(log, (struct log_place){"a.xml", 12, 0}, "%d is wrong", 7);
    assert_string_equal(message.text, "a.xml:12: 7 is wrong");
    log_warning_at(log, (struct log_place){0}, "a\nb");
    assert_string_equal(message.text, "input: a?b");
    assert_int_equal(message.count, 3);
    log_error_at((struct log){0}, (struct log_place){0}, "nobody reads this");
}

static void log_with_key(struct log log, const char *key, const char *format, ...) {
    va_list args;
    va_start(args, format);
    log_error_at_args(log, (struct log_place){"a.toml", 3, 1}, key, format, args);
    va_end(args);
}

static void keys_stand_before_messages(void **state) {
    (void)state;
    struct message message = {0};
    const struct log log = {keep, &message};
    log_with_key(log, "seeds", "%d is there twice", 4);
    assert_string_equal(message.text, "a.toml:3:1: seeds: 4 is there twice");
    log_with_key(log, NULL, "%d is there twice", 4);
    assert_string_equal(message.text, "a.toml:3:1: 4 is there twice");
    // A key of any length leaves the message readable.
    char key[5000];
    memset(key, 'k', sizeof key - 1);
    key[sizeof key - 1] = 0;
    message = (struct message){0};
    log_with_key(log, key, "%d is there twice", 4);
    assert_non_null(strstr(message.text, "kk: 4 is there twice"));
    log_with_key((struct log){0}, key, "nobody reads this");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_begin_with_their_line),
        cmocka_unit_test(keys_stand_before_messages),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
