// SPDX-License-Identifier: Apache-2.0
// The functions that take most of the time, in one table per instruction set. The plain table
// defines each function, and the others agree with it to rounding. The caller has checked the
// arguments.
#ifndef RSH_KERNEL_H
#define RSH_KERNEL_H

#include "rsh/rsh.h"
#include "rsh/rsh_tables.h"

// How the rotation about y within a rotation is computed.
enum rsh_method {
    RSH_METHOD_Z = 0,  // no rotation about y: `gamma` alone
    RSH_METHOD_TAYLOR_1,
    RSH_METHOD_TAYLOR_1_5,
    RSH_METHOD_TAYLOR_2,
    RSH_METHOD_EXACT
};

// A rotation: about z by gamma, then about y by beta, then about z by alpha.
struct rsh_rotation {
    enum rsh_method method;
    float beta;  // for the series
    float cos_alpha, sin_alpha, cos_beta, sin_beta, cos_gamma, sin_gamma;
};

// The largest number of records that a kernel processes at once.
enum { RSH_MAX_WIDTH = 16 };

// The sine up to which an angle counts as 0. The entries of a product of two float matrices are not
// more accurate.
#define RSH_NO_ANGLE 3e-7f

// One rotation per record. All have the same method, which is not RSH_METHOD_Z.
struct rsh_rotations {
    enum rsh_method method;
    float beta[RSH_MAX_WIDTH];
    float cos_alpha[RSH_MAX_WIDTH], sin_alpha[RSH_MAX_WIDTH];
    float cos_beta[RSH_MAX_WIDTH], sin_beta[RSH_MAX_WIDTH];
    float cos_gamma[RSH_MAX_WIDTH], sin_gamma[RSH_MAX_WIDTH];
};

// rsh.h describes rsh_eval_many, rsh_project and rsh_accumulate. `rotate` applies a rotation to
// each channel; out == in is allowed.
struct rsh_kernels {
    const char *name;
    void (*eval_many)(rsh_basis basis, int order, size_t count, const float *x, const float *y,
                      const float *z, float *out);
    // `direction`: x, y and z.
    void (*project)(rsh_basis basis, int order, size_t count, const float *const direction[3],
                    const float *const value[3], float *out);
    void (*accumulate)(size_t count, size_t coefficients, const float *matrix,
                       const float *const value[3], float *out);
    // rsh_dot3, where `step` is the distance between the channels of a, 0 or n, for vectors of n
    // numbers.
    void (*dot3)(int n, int step, const float *a, const float *b, float out[3]);
    void (*rotate)(const struct rsh_rotation *rotation, int order, int channels, const float *in,
                   float *out);
    // Converts one channel from order bands[1] to order bands[0]. The transposed map has the rows'
    // inputs as outputs. Neither order is above that of the rows. out != in.
    void (*convert)(const struct rsh_rows *rows, bool transposed, const int bands[2],
                    const float *in, float *out);

    // The functions below process `width` records at once, as structures of arrays: coefficient k
    // of a channel of record i is [k * stride + i], and channels are consecutive.
    int width;
    // Computes the rotations of the matrices r[entry][record]; with `stretch`, by beta' instead of
    // beta. The caller sets their method.
    void (*angles)(const float r[9][RSH_MAX_WIDTH], bool stretch, struct rsh_rotations *t);
    void (*rotate_many)(const struct rsh_rotations *t, int order, int channels, size_t stride,
                        const float *in, float *out);
    // `convert` for one channel, with the strides of out and in.
    void (*convert_many)(const struct rsh_rows *rows, bool transposed, const int bands[2],
                         const size_t strides[2], const float *in, float *out);
};

extern const struct rsh_kernels rsh_kernels_plain;
#if defined(__x86_64__)
extern const struct rsh_kernels rsh_kernels_sse2, rsh_kernels_avx2, rsh_kernels_avx512;
#else
extern const struct rsh_kernels rsh_kernels_native;
#endif

// ---- rsh_dispatch.c
// The tables that this processor can run, best first, ended by NULL.
const struct rsh_kernels *const *rsh_kernels_usable(void);
// The best of them, which the first call determines.
const struct rsh_kernels *rsh_kernels_best(void);
// For tests: selects another usable table from now on.
void rsh_kernels_choose(const struct rsh_kernels *kernels);

static inline bool rsh_order_ok(int order) { return order >= 1 && order <= RSH_MAX_ORDER; }
static inline bool rsh_basis_ok(rsh_basis basis) {
    return basis == RSH_SPHERE || basis == RSH_HEMISPHERE;
}

// ---- rsh_rotate.c
// The rotations about z, y and z whose product is the matrix r, in row-major order. Their method is
// RSH_METHOD_Z if a rotation about z is enough.
struct rsh_rotation rsh_rotation_of_matrix(const float r[9]);
// The angle of the rotation about y, 0 .. pi.
float rsh_rotation_angle(const struct rsh_rotation *rotation);
// Whether the rotation is the identity within the rounding of floats.
bool rsh_rotation_is_identity(const struct rsh_rotation *rotation);
// Replaces beta by beta' = arccos(2 cos beta - 1), except in the field `beta`.
void rsh_rotation_stretch(struct rsh_rotation *rotation);
// False for an unknown kind.
bool rsh_method_of_taylor(rsh_taylor kind, enum rsh_method *method);
// Whether all are numbers of magnitude up to RSH_MAX_ENTRY, so that no square overflows.
#define RSH_MAX_ENTRY 1e9f
bool rsh_in_range(const float *v, int count);
void rsh_copy(int order, int channels, const float *in, float *out);

// ---- rsh_plain.c
// The plain functions, for instruction sets that cannot permute lanes.
void rsh_plain_rotate(const struct rsh_rotation *rotation, int order, int channels, const float *in,
                      float *out);
void rsh_plain_convert(const struct rsh_rows *rows, bool transposed, const int bands[2],
                       const float *in, float *out);

#endif
