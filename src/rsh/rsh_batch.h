// SPDX-License-Identifier: Apache-2.0
// The kernels that process as many records or directions at once as a vector has lanes, with one
// declaration per instruction set. rsh_kernel.h describes them.
#ifndef RSH_BATCH_H
#define RSH_BATCH_H

#include "rsh/rsh_kernel.h"

#define RSH_BATCH(name)                                                                            \
    void rsh_eval_many_##name(rsh_basis basis, int order, size_t count, const float *x,            \
                              const float *y, const float *z, float *out);                         \
    void rsh_project_##name(rsh_basis basis, int order, size_t count,                              \
                            const float *const direction[3], const float *const value[3],          \
                            float *out);                                                           \
    void rsh_angles_##name(const float r[9][RSH_MAX_WIDTH], bool stretch,                          \
                           struct rsh_rotations *t);                                               \
    void rsh_rotate_many_##name(const struct rsh_rotations *t, int order, int channels,            \
                                size_t stride, const float *in, float *out);                       \
    void rsh_convert_many_##name(const struct rsh_rows *rows, bool transposed, const int bands[2], \
                                 const size_t strides[2], const float *in, float *out);
RSH_BATCH(scalar)
RSH_BATCH(sse2)
RSH_BATCH(avx2)
RSH_BATCH(avx512)
RSH_BATCH(native)
#undef RSH_BATCH

#endif
