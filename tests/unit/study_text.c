// SPDX-License-Identifier: Apache-2.0
// Values as CSV, JSON, shells and base 64 have them.
#include "study/study_text.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void assert_text(struct study_text *text, const char *expected) {
    assert_false(text->failed);
    assert_string_equal(text->data, expected);
    assert_int_equal(text->size, strlen(expected));
    free(text->data);
    *text = (struct study_text){0};
}

static void texts_are_quoted(void **state) {
    (void)state;
    struct study_text text = {0};
    study_text_json(&text, "a \"b\" \\ </script>\n");
    assert_text(&text, "\"a \\\"b\\\" \\\\ \\u003c/script>\\u000a\"");
    study_text_json(&text, "\xc3\xa9 \xff.xml");
    assert_text(&text, "\"\xc3\xa9 \xef\xbf\xbd.xml\"");
    study_text_csv(&text, "plain");
    study_text_add(&text, ",");
    study_text_csv(&text, "a,\"b\"");
    assert_text(&text, "plain,\"a,\"\"b\"\"\"");
    study_text_shell(&text, "a=b/c.xml");
    study_text_add(&text, " ");
    study_text_shell(&text, "it's $(x)");
    study_text_add(&text, " ");
    study_text_shell(&text, "");
    assert_text(&text, "a=b/c.xml 'it'\\''s $(x)' ''");
}

static void numbers_that_are_not_finite_are_left_out(void **state) {
    (void)state;
    struct study_text text = {0};
    study_text_json_number(&text, 0.5);
    study_text_json_number(&text, (double)NAN);
    study_text_csv_number(&text, (double)INFINITY);
    study_text_csv_number(&text, -2.0);
    assert_text(&text, "0.5null-2");
}

static void counts_keep_all_digits(void **state) {
    (void)state;
    struct study_text text = {0};
    study_text_json_number(&text, 12345678901.0);
    study_text_csv_number(&text, -9007199254740991.0);
    assert_text(&text, "12345678901-9007199254740991");
    study_text_json_number(&text, 0.12345678912);
    assert_text(&text, "0.123456789");
}

// The examples of RFC 4648.
static void bytes_are_encoded(void **state) {
    (void)state;
    static const char *const pair[][2] = {{"f", "Zg=="},         {"fo", "Zm8="},
                                          {"foo", "Zm9v"},       {"foob", "Zm9vYg=="},
                                          {"fooba", "Zm9vYmE="}, {"foobar", "Zm9vYmFy"}};
    struct study_text text = {0};
    for (size_t i = 0; i < sizeof pair / sizeof *pair; i++) {
        study_text_base64(&text, pair[i][0], strlen(pair[i][0]));
        assert_text(&text, pair[i][1]);
    }
    study_text_base64(&text, "\xff\xfe\xfd", 3);
    assert_text(&text, "//79");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texts_are_quoted),
        cmocka_unit_test(numbers_that_are_not_finite_are_left_out),
        cmocka_unit_test(counts_keep_all_digits),
        cmocka_unit_test(bytes_are_encoded),
    };
    return cmocka_run_group_tests_name("study_text", tests, NULL, NULL);
}
