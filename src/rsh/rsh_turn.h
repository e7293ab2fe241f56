// SPDX-License-Identifier: Apache-2.0
// The rotation kernels; rsh_kernel.h says what they do.
#ifndef RSH_TURN_H
#define RSH_TURN_H

#include "rsh/rsh_kernel.h"

void rsh_turn_avx2(const struct rsh_turn *turn, int order, int channels, const float *in,
                   float *out);
void rsh_turn_avx512(const struct rsh_turn *turn, int order, int channels, const float *in,
                     float *out);
// Without permutations of lanes by variable places, plain C is as good.
#define rsh_turn_sse2 rsh_plain_turn
#define rsh_turn_native rsh_plain_turn

#endif
