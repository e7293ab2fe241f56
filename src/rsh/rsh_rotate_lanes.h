// SPDX-License-Identifier: Apache-2.0
// The kernels that work on lanes. rsh_kernel.h describes them.
#ifndef RSH_ROTATE_LANES_H
#define RSH_ROTATE_LANES_H

#include "rsh/rsh_kernel.h"

void rsh_rotate_lanes_avx2(const struct rsh_rotation *rotation, int order, int channels,
                           const float *in, float *out);
void rsh_rotate_lanes_avx512(const struct rsh_rotation *rotation, int order, int channels,
                             const float *in, float *out);
void rsh_rotate_pairs_avx2(const struct rsh_rotation *rotation, int order, int channels,
                           const float *in, float *out);
void rsh_rotate_pairs_avx512(const struct rsh_rotation *rotation, int order, int channels,
                             const float *in, float *out);
void rsh_convert_avx2(const struct rsh_rows *rows, bool transposed, const int bands[2],
                      const float *in, float *out);
void rsh_convert_avx512(const struct rsh_rows *rows, bool transposed, const int bands[2],
                        const float *in, float *out);
// Without permutations of lanes by variable indices, scalars are as fast (rsh_batch.c).
void rsh_rotate_lanes_scalar(const struct rsh_rotation *rotation, int order, int channels,
                             const float *in, float *out);
#define rsh_rotate_lanes_sse2 rsh_rotate_lanes_scalar
#define rsh_rotate_lanes_native rsh_rotate_lanes_scalar
#define rsh_convert_sse2 rsh_plain_convert
#define rsh_convert_native rsh_plain_convert

#endif
