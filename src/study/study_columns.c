// SPDX-License-Identifier: Apache-2.0
// The columns that every study.csv has. No two columns have one name: statistics are not called as
// options are, and an axis that a study names must not have one of these names.
#include <stdio.h>

#include "base/text.h"
#include "study/study_file.h"
#include "study/study_plan.h"

const char *const study_columns_before[] = {"scene", "point", NULL};
const char *const study_columns_after[] = {"seed",
                                           "relmse",
                                           "mean_ratio",
                                           "bias2",
                                           "bias2_error",
                                           "variance",
                                           "first_pass_relmse",
                                           "first_pass_mean_ratio",
                                           "first_pass_bias2",
                                           "first_pass_variance",
                                           "reference_noise",
                                           "lookup_error",
                                           "status",
                                           "signal",
                                           "samples",
                                           "photon_paths",
                                           "records",
                                           "threads_used",
                                           "replaced",
                                           "command",
                                           "seconds_s",
                                           "cpu_s",
                                           NULL};
const char *const study_columns_last[] = {"memory_mb", NULL};

bool study_columns_have(const char *name) {
    if (text_is_one_of(name, study_columns_before) || text_is_one_of(name, study_columns_after) ||
        text_is_one_of(name, study_columns_last))
        return true;
    for (int i = 0; i < STUDY_STAGES; i++) {
        char stage[32];
        snprintf(stage, sizeof stage, "%s_s", study_stage_name[i]);
        if (text_same_name(name, stage)) return true;
    }
    return false;
}
