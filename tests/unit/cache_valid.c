// SPDX-License-Identifier: Apache-2.0
// The head of a record in which any one number is not finite, or out of its range, is refused.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cache/cache_records.h"

static void heads_are_checked(void **state) {
    (void)state;
    const struct cache_head good = {
        .n = {0, 0, 1}, .u = {1, 0, 0}, .R = 1, .search_radius = 2, .scale = 1};
    assert_true(cache_valid_head(&good));
    struct cache_head head = good;
    float *number[] = {&head.p.x,          &head.p.z,   &head.R,   &head.n.y,  &head.search_radius,
                       &head.anisotropy.x, &head.scale, &head.u.y, &head.clear};
    for (size_t i = 0; i < sizeof number / sizeof *number; i++) {
        *number[i] = NAN;
        assert_false(cache_valid_head(&head));
        head = good;
    }
    head.scale = 1.5f;
    assert_false(cache_valid_head(&head));
}

static void frames_are_checked(void **state) {
    (void)state;
    const struct frame good = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    assert_true(cache_valid_frame(&good));
    const struct frame wrong[] = {{{2, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                  {{1, 0, 0}, {0, 1e20f, 0}, {0, 0, 1}},
                                  {{1, 0, 0}, {0, 1, 0}, {0, 0, NAN}},
                                  {{1, 0, 0}, {1, 0, 0}, {0, 0, 1}},
                                  {{1, 0, 0}, {0, 1, 0}, {0, 1, 0}}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_false(cache_valid_frame(&wrong[i]));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(heads_are_checked),
                                       cmocka_unit_test(frames_are_checked)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
