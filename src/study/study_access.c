// SPDX-License-Identifier: Apache-2.0
// The renders of a plan by scene, point and seed, and a render and a point as text.
#include <stdlib.h>

#include "study/study_plan.h"
#include "study/study_text.h"

struct study_render *study_plan_image(const struct study_plan *plan, size_t scene, size_t point,
                                      size_t seed) {
    const struct study *s = &plan->study;
    return &plan->render[plan->image[(scene * s->points + point) * s->seeds + seed]];
}

struct study_render *study_plan_first_pass(const struct study_plan *plan, size_t scene,
                                           size_t point, size_t seed) {
    const struct study *s = &plan->study;
    const size_t at = plan->first_pass[(scene * s->points + point) * s->seeds + seed];
    return at == STUDY_NONE ? NULL : &plan->render[at];
}

uint64_t study_piece_spp(const struct study *study) {
    const uint64_t pieces = study->reference_pieces;
    return pieces ? (study->reference_spp + pieces - 1) / pieces : 0;
}

char *study_command(const struct study_render *render) {
    struct study_text text = {0};
    study_text_add(&text, "satin render");
    for (const char *const *a = render->argument; *a; a++) {
        study_text_add(&text, " ");
        study_text_shell(&text, *a);
        if (a == render->argument) study_text_add(&text, " -o image.exr --float");
    }
    if (!text.failed) return text.data;
    free(text.data);
    return NULL;
}

char *study_point_label(const struct study *study, const struct study_point *point) {
    struct study_text text = {0};
    study_text_add(&text, "%s", point->name ? point->name : "");
    for (size_t c = 0; c < study->columns && !point->name; c++) {
        if (!point->cell[c] || !*point->cell[c]) continue;
        if (study->column[c].is_option)
            study_text_add(&text, "%s%s=%s", text.size ? " " : "", study->column[c].name,
                           point->cell[c]);
        else
            study_text_add(&text, "%s%s", text.size ? " " : "", point->cell[c]);
    }
    if (text.size == 0) study_text_add(&text, "defaults");
    if (!text.failed) return text.data;
    free(text.data);
    return NULL;
}
