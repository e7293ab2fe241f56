// SPDX-License-Identifier: Apache-2.0
// The coarse image of a render that the caller cancels: one sample of a few pixels, from which the
// film is filled.
#include "render/render_image.h"

static satin_status sample_coarse(struct render *r, enum render_course course) {
    struct render_second_pass *pass = &r->second_pass;
    render_take_course(r, course);
    if (course == COURSE_COARSE_DIRECT) {
        shade_destroy(&pass->shade);
        pass->gather = gather_make(&r->scene, &r->options, NULL);
        satin_status status = render_shading(r, NULL);
        if (status != SATIN_OK) return status;
    }
    render_limit_coarse(r);
    satin_status status = render_image_fill(r);
    return status == SATIN_OK ? SATIN_CANCELLED : status;
}

satin_status render_coarse(struct render *r) {
    satin_status status = SATIN_CANCELLED;
    if (r->progress.stage == STAGE_RECORDS) status = sample_coarse(r, COURSE_COARSE);
    if (status == SATIN_CANCELLED && r->image->state == IMAGE_EMPTY)
        status = sample_coarse(r, COURSE_COARSE_DIRECT);
    return status;
}
