// SPDX-License-Identifier: Apache-2.0
// The kernels that take a vector's width of records at once, one declaration per instruction set;
// rsh_kernel.h says what they do.
#ifndef RSH_BATCH_H
#define RSH_BATCH_H

#include "rsh/rsh_kernel.h"

#define RSH_BATCH(name)                                                                            \
    void rsh_angles_##name(const float r[9][RSH_MAX_WIDTH], bool stretch, struct rsh_turns *t);    \
    void rsh_turn_many_##name(const struct rsh_turns *t, int order, int channels, size_t stride,   \
                              const float *in, float *out);                                        \
    void rsh_convert_many_##name(const struct rsh_rows *rows, bool transposed, const int bands[2], \
                                 const size_t strides[2], const float *in, float *out);
RSH_BATCH(scalar)
RSH_BATCH(sse2)
RSH_BATCH(avx2)
RSH_BATCH(avx512)
RSH_BATCH(native)
#undef RSH_BATCH

#endif
