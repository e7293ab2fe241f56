// SPDX-License-Identifier: Apache-2.0
// For tests of budgets: a render that has a time limit or none. It is included after cmocka.h.
#ifndef BUDGET_CASE_H
#define BUDGET_CASE_H

#include "render/render_state.h"

// A render of 100x100 pixels that began now, so that all but milliseconds of its time are left.
static inline struct render budget_case(double time) {
    struct render r = {.options = {.time = time,
                                   .width = 100,
                                   .height = 100,
                                   .spp = time > 0.0 ? 1 << 20 : 36,
                                   .adaptive_sampling = true}};
    r.progress = (struct render_progress){.start = stats_wall(), .deadline = INFINITY};
    r.pool = parallel_new(1);
    assert_non_null(r.pool);
    return r;
}

#endif
