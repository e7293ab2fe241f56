// SPDX-License-Identifier: Apache-2.0
// Common to all rotations of many records: bands of records, and multiples of angles.
#ifndef RSH_BATCH_BAND_H
#define RSH_BATCH_BAND_H

#include <math.h>
#include <stddef.h>

#include "rsh/rsh.h"
#include "rsh/rsh_vector.h"

// Channels that are rotated at once, so that values that depend only on the angles are computed
// once.
enum { CHANNELS = 3 };

// cos(m a) and sin(m a), a record per lane.
struct band_powers {
    vf cosine[RSH_MAX_ORDER], sine[RSH_MAX_ORDER];
};

INLINE void powers_of(const float *cosine, const float *sine, int order, struct band_powers *p) {
    vf c1 = load(cosine), s1 = load(sine), c = splat(1.0f), s = {0};
    for (int m = 0; m < order; m++) {
        p->cosine[m] = c;
        p->sine[m] = s;
        vf t = c * c1 - s * s1;
        s = c * s1 + s * c1;
        c = t;
    }
}

// A band of one vector of records: coefficient (l, m) of channel c is at p + m step + c channel.
struct band {
    float *p;
    ptrdiff_t step, channel;
};

#endif
