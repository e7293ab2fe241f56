// SPDX-License-Identifier: Apache-2.0
// Cleaning the text of scene files of what Mitsuba accepts and expat does not, and finding files by
// names that differ.
#include <stdlib.h>

#include "load/load_xml.h"
#include "scene_case.h"

// The text, cleaned; the caller frees it.
static char *cleaned(const char *text) {
    size_t size = strlen(text);
    char *data = strdup(text);
    assert_non_null(data);
    assert_true(load_xml_clean(&data, &size));
    assert_int_equal(size, strlen(data));
    return data;
}

static void what_is_not_xml_is_cleaned(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {"", ""},
        {"<a/>", "<a/>"},
        {"<!-- a -- b -->\n<a/>", "<!--        -->\n<a/>"},
        {"<!--\n\xe9\r\n--><!----><!-- & --><!--->-->", "<!--\n \r\n--><!----><!--   --><!--  -->"},
        {"<!-- a & b", "<!--      "},
        {"&<!-- && && && && &&", "&amp;<!--               "},
        {"&<!-- && -- & -->&", "&amp;<!--         -->&amp;"},
        {"<a b='c&d'/>", "<a b='c&amp;d'/>"},
        {"<a b='&amp;&#65;&#x41;&x.y;&'/>&", "<a b='&amp;&#65;&#x41;&x.y;&amp;'/>&amp;"},
        {"&; & &#; &a", "&amp;; &amp; &amp;#; &amp;a"},
        {"&1; &-a; &#x; &#a; &#xg; &#x1F600;",
         "&amp;1; &amp;-a; &amp;#x; &amp;#a; &amp;#xg; &#x1F600;"},
        {"<![CDATA[ & <!-- -- --> ]]>&", "<![CDATA[ & <!-- -- --> ]]>&amp;"},
        {"&<![CDATA[ & ", "&amp;<![CDATA[ & "},
        {"&<![CDATA[ && ]]>&&", "&amp;<![CDATA[ && ]]>&amp;&amp;"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char *data = cleaned(cases[i][0]);
        assert_string_equal(data, cases[i][1]);
        free(data);
    }
}

// Text of two bytes for each character is left to expat.
static void other_encodings_are_left_alone(void **state) {
    (void)state;
    static const char wide[] = "\xff\xfe<\0!\0-\0-\0&\0";
    size_t size = sizeof wide;
    char *data = malloc(size);
    assert_non_null(data);
    memcpy(data, wide, size);
    assert_true(load_xml_clean(&data, &size));
    assert_int_equal(size, sizeof wide);
    assert_memory_equal(data, wide, size);
    free(data);
}

static void names_of_windows_are_found(void **state) {
    (void)state;
    scene_case_file("Mesh.ply", "ply\n");
    char *found = load_path_any_case(".\\mesh.PLY");
    assert_non_null(found);
    assert_string_equal(found, "./Mesh.ply");
    free(found);
    assert_null(load_path_any_case("C:\\mesh.ply"));
    assert_null(load_path_any_case("Mesh.ply"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_not_xml_is_cleaned),
        cmocka_unit_test(other_encodings_are_left_alone),
        cmocka_unit_test(names_of_windows_are_found),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
