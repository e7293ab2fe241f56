// SPDX-License-Identifier: Apache-2.0
// How long this machine takes to compress a film, which is most of the time of writing one: zlib
// compresses a trial row of bytes as OpenEXR makes them. OpenEXR puts the low bytes of half floats
// behind the high ones and takes differences of neighbours. In a noisy image the high bytes are
// then nearly constant, and the low ones random.
#include <math.h>
#include <stdlib.h>
#include <zlib.h>

#include "base/rng.h"
#include "base/stats.h"
#include "film/film.h"

enum {
    TRIAL_VALUES = 1 << 15,  // takes 1 to 2 ms
    SPEED_TRIALS = 4,        // of which the fastest counts, as a busy machine slows some down
    HALF_BYTES = 2           // most channels are colours, which are half floats
};

// What full floats take over that: their other bytes are noise too. Measured with 27 channels.
static const double FULL_FLOAT = 2.1;

double film_exr_pixel_seconds(int channels, bool full_float) {
    const size_t bytes = HALF_BYTES * TRIAL_VALUES;
    unsigned char *trial = malloc(bytes);
    uLongf size = compressBound(bytes);
    unsigned char *out = malloc(size);
    double least = INFINITY;
    if (trial && out) {
        struct rng rng = rng_make(1, RNG_SITE, 0);
        for (int i = 0; i < TRIAL_VALUES; i++) {
            const uint32_t noise = rng_u32(&rng);
            trial[i] = (unsigned char)(128 + (noise >> 8 & 3) - 1);
            trial[TRIAL_VALUES + i] = (unsigned char)noise;
        }
        for (int i = 0; i < SPEED_TRIALS; i++) {
            const double start = stats_wall();
            size = compressBound(bytes);
            compress2(out, &size, trial, bytes, FILM_ZIP_EFFORT);
            least = fmin(least, stats_wall() - start);
        }
    }
    free(out);
    free(trial);
    return channels * (isinf(least) ? 0.0 : least) * (full_float ? FULL_FLOAT : 1.0) / TRIAL_VALUES;
}
