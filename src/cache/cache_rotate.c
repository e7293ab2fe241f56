// SPDX-License-Identifier: Apache-2.0
// Aligns the frames of a record and a point [K05 3.3, 5.4]. Deviation: the coefficients of the
// point's BRDF are rotated into the record's frame, because that is one vector, while the record's
// value and gradients are nine.
#include <string.h>

#include "cache/cache_value.h"
#include "rsh/rsh.h"

static void frame_rows(const struct frame *f, float rows[9]) {
    const vec3 axis[3] = {f->u, f->v, f->n};
    for (int i = 0; i < 3; i++) {
        rows[3 * i] = axis[i].x;
        rows[3 * i + 1] = axis[i].y;
        rows[3 * i + 2] = axis[i].z;
    }
}

void cache_rotate(const struct cache *cache, const struct frame *from, const struct frame *to,
                  struct cache_lobe *lobe, float *rotated) {
    const satin_options *o = cache->options;
    float point[9], record[9];
    frame_rows(from, point);
    frame_rows(to, record);
    // The thesis uses the fast rotation up to 1.25 a [K05 5.4]. There its error is several per cent
    // at order 10, which is more than that of the records, and exact rotation takes no measurable
    // time, so the default is 0.
    const rsh_alignment alignment = {.basis = brdf_rsh_basis(o->radiance_basis),
                                     .from = record,
                                     .to = point,
                                     .beta_limit = o->radiance_rotation};
    if (!rsh_align_transposed(&alignment, lobe->order, lobe->channels, lobe->C, rotated))
        memcpy(rotated, lobe->C,
               sizeof *rotated * (size_t)(lobe->channels * lobe->order * lobe->order));
    lobe->C = rotated;
}
