// SPDX-License-Identifier: Apache-2.0
// Films: channels, attributes, refused sizes.
#include "film/film.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "satin/render.h"

static void channels_are_found_by_name(void **state) {
    (void)state;
    const char *const names[] = {"R", "direct.R"};
    struct satin_film *film = film_new(3, 2, names, 2);
    assert_non_null(film);
    int width = 0, height = 0;
    satin_film_size(film, &width, &height);
    assert_int_equal(width, 3);
    assert_int_equal(height, 2);
    assert_string_equal(satin_film_channel_name(film, 1), "direct.R");
    assert_null(satin_film_channel_name(film, 2));
    assert_null(satin_film_channel_name(film, -1));
    film_channel(film, "direct.R")[5] = 4.0f;
    assert_true(satin_film_channel(film, "direct.R")[5] == 4.0f);
    assert_true(satin_film_channel(film, "R")[5] == 0.0f);
    assert_null(satin_film_channel(film, "r"));
    assert_null(satin_film_stats(film));
    satin_film_free(film);
    satin_film_free(NULL);
}

static void attributes_replace_earlier_ones(void **state) {
    (void)state;
    struct satin_film *film = film_new(1, 1, NULL, 0);
    assert_true(film_attribute_set(film, "a", "1"));
    assert_true(film_attribute_set(film, "b", "2"));
    assert_true(film_attribute_set(film, "a", "3"));
    assert_int_equal(film->attribute_count, 2);
    assert_string_equal(film_attribute_get(film, "a"), "3");
    assert_null(film_attribute_get(film, "c"));
    satin_film_free(film);
}

static void attributes_are_removed(void **state) {
    (void)state;
    static const char *const name[] = {"a", "b", "c"};
    struct satin_film *film = film_new(1, 1, NULL, 0);
    for (int i = 0; i < 3; i++) assert_true(film_attribute_set(film, name[i], name[i]));
    film_attribute_remove(film, "b");
    assert_null(film_attribute_get(film, "b"));
    assert_string_equal(film_attribute_get(film, "a"), "a");
    film_attribute_remove(film, "c");
    assert_string_equal(film_attribute_get(film, "a"), "a");
    film_attribute_remove(film, "a");
    assert_int_equal(film->attribute_count, 0);
    satin_film_free(film);
}

static void sizes_are_bounded(void **state) {
    (void)state;
    assert_null(film_new(0, 1, NULL, 0));
    assert_null(film_new(1, -1, NULL, 0));
    assert_null(film_new(65536, 32768, NULL, 0));
    struct satin_film *film = film_new(65535, 32768, NULL, 0);
    assert_non_null(film);
    satin_film_free(film);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(channels_are_found_by_name),
        cmocka_unit_test(attributes_replace_earlier_ones),
        cmocka_unit_test(attributes_are_removed),
        cmocka_unit_test(sizes_are_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
