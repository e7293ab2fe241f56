// SPDX-License-Identifier: Apache-2.0
// Numbers are read strictly, names are compared loosely, and the nearest name is suggested.
#include "base/text.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void numbers_are_read_strictly(void **state) {
    (void)state;
    static const char *const bad[] = {"",    " 1",   "1 ",  "0x10", "inf",   "nan", "1e999",
                                      "1,5", "1.5f", "--1", "e5",   "1e5e5", "."};
    double value = 7;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_false(text_double(bad[i], &value));
        assert_true(value == 7);
    }
    assert_true(text_double("-1.25e2", &value) && value == -125);
    assert_true(text_double(".5", &value) && value == 0.5);
    assert_true(text_double("3.", &value) && value == 3);
}

static void names_are_compared_loosely(void **state) {
    (void)state;
    assert_true(text_same_name("two-pass", "Two_Pass"));
    assert_false(text_same_name("two", "two-pass"));
    assert_false(text_same_name("two-pass", "two"));
    assert_true(text_same_name("", ""));
    const char *const list[] = {"path", "two-pass", NULL}, *const empty[] = {NULL};
    assert_true(text_is_one_of("Two_Pass", list));
    assert_false(text_is_one_of("two", list) || text_is_one_of("path", empty));
}

static const char *test_text_nearest(const char *word) {
    static const char *const names[] = {"phong", "plastic", "diffuse", "ward"};
    struct text_nearest search = {.word = word};
    for (int i = 0; i < 4; i++) text_nearest_try(&search, names[i]);
    return search.best;
}

static void the_nearest_name_is_suggested(void **state) {
    (void)state;
    assert_string_equal(test_text_nearest("phng"), "phong");
    assert_string_equal(test_text_nearest("pohng"), "phong");
    assert_string_equal(test_text_nearest("difuse"), "diffuse");
    assert_string_equal(test_text_nearest("Ward"), "ward");
    assert_null(test_text_nearest("checkerboard"));
    assert_null(test_text_nearest("zzzz"));
    // A word with half of its letters is another word.
    assert_null(test_text_nearest("wood"));
    char longest[400];
    for (int i = 0; i < 399; i++) longest[i] = 'a';
    longest[399] = 0;
    assert_null(test_text_nearest(longest));
}

static void characters_of_utf8_are_known(void **state) {
    (void)state;
    static const char *const good[] = {
        "a", "\xc3\xa9", "\xe2\x82\xac", "\xed\x9f\xbf", "\xf0\x9f\x98\x80", "\xf4\x8f\xbf\xbf"};
    // Cut, of too many bytes, a surrogate, and beyond U+10FFFF.
    static const char *const bad[] = {
        "\x80",         "\xc3",         "\xc3(",        "\xe2\x82",         "\xc1\x81",
        "\xe0\x9f\xbf", "\xed\xa0\x80", "\xf0\x9f\x98", "\xf4\x90\x80\x80", "\xff"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        assert_int_equal(text_utf8_bytes(good[i]), strlen(good[i]));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(text_utf8_bytes(bad[i]), 0);
}

static void json_has_no_other_bytes(void **state) {
    (void)state;
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    text_print_json(out, "a\xff\xc3\xa9\"\\\n<");
    assert_int_equal(fclose(out), 0);
    assert_string_equal(text, "\"a\xef\xbf\xbd\xc3\xa9\\u0022\\u005c\\u000a\\u003c\"");
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_read_strictly),
        cmocka_unit_test(names_are_compared_loosely),
        cmocka_unit_test(the_nearest_name_is_suggested),
        cmocka_unit_test(characters_of_utf8_are_known),
        cmocka_unit_test(json_has_no_other_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
