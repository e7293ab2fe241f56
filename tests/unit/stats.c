// SPDX-License-Identifier: Apache-2.0
// Statistics as JSON: counts keep all their digits, numbers that JSON does not have are null, and
// entries are appended to an object that is there.
#include "base/stats.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

// The JSON of one entry of this value is exactly this number.
static void prints(double value, const char *number) {
    struct stats stats = {0};
    stats_set(&stats, "a.b", value);
    char *json = stats_json(&stats), wanted[64] = "{\n  \"a.b\": ";
    assert_non_null(json);
    strcat(strcat(wanted, number), "\n}\n");
    assert_string_equal(json, wanted);
    free(json);
}

static void integers_are_printed_exactly(void **state) {
    (void)state;
    prints(0.0, "0");
    prints(4294967297.0, "4294967297");
    prints(-1234567890123.0, "-1234567890123");
    prints(999999999999999.0, "999999999999999");
    // The largest integers of a double, up to 2^53.
    prints(9007199254740991.0, "9007199254740991");
    prints(9007199254740992.0, "9007199254740992");
    prints(1e18, "1e+18");
    prints(0.125, "0.125");
    prints(1234567.0625, "1234567.06");
    prints((double)NAN, "null");
    prints((double)-INFINITY, "null");
}

// Sums of counts are exact too.
static void counts_add_up(void **state) {
    (void)state;
    struct stats stats = {0};
    for (int i = 0; i < 3; i++) stats_add(&stats, "photons.emitted", 3333333333.0);
    stats_set(&stats, "b.c", 1.0);
    char *json = stats_json(&stats);
    assert_non_null(strstr(json, "\"photons.emitted\": 9999999999,"));
    struct stats more = {0};
    stats_set(&more, "time.whole_s", 2.5);
    char *both = stats_json_append(json, &more);
    assert_string_equal(both,
                        "{\n  \"photons.emitted\": 9999999999,\n  \"b.c\": 1,\n"
                        "  \"time.whole_s\": 2.5\n}\n");
    free(both);
    free(json);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(integers_are_printed_exactly),
        cmocka_unit_test(counts_add_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
