// SPDX-License-Identifier: Apache-2.0
// The hot functions, one table per instruction set. The plain table defines each function, the
// others agree with it to rounding. Arguments were checked by the caller.
#ifndef RSH_KERNEL_H
#define RSH_KERNEL_H

#include "rsh/rsh.h"
#include "rsh/rsh_tables.h"

// How the part about y of a rotation is done.
enum rsh_method {
    RSH_METHOD_Z = 0,  // no y part: `gamma` alone
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

// Records that a kernel takes at once, at most.
enum { RSH_MAX_WIDTH = 16 };

// The sine up to which an angle counts as 0. The entries of a product of two float matrices are no
// better than this.
#define RSH_NO_ANGLE 3e-7f

// A rotation per record; the method is that of all and not RSH_METHOD_Z.
struct rsh_rotations {
    enum rsh_method method;
    float beta[RSH_MAX_WIDTH];
    float cos_alpha[RSH_MAX_WIDTH], sin_alpha[RSH_MAX_WIDTH];
    float cos_beta[RSH_MAX_WIDTH], sin_beta[RSH_MAX_WIDTH];
    float cos_gamma[RSH_MAX_WIDTH], sin_gamma[RSH_MAX_WIDTH];
};

// What rsh.h says of rsh_eval_many, rsh_project and rsh_accumulate; `rotate` applies a rotation to
// each channel, out == in allowed.
struct rsh_kernels {
    const char *name;
    void (*eval_many)(rsh_basis basis, int order, size_t count, const float *x, const float *y,
                      const float *z, float *out);
    void (*project)(rsh_basis basis, int order, size_t count, const float *x, const float *y,
                    const float *z, const float *const value[3], float *out);
    void (*accumulate)(size_t count, size_t coefficients, const float *matrix,
                       const float *const value[3], float *out);
    // rsh_dot3 with the step between the channels of a, 0 or n, for vectors of n numbers.
    void (*dot3)(int n, int step, const float *a, const float *b, float out[3]);
    void (*rotate)(const struct rsh_rotation *rotation, int order, int channels, const float *in,
                   float *out);
    // One channel from order bands[1] to order bands[0], or the transposed map, whose outputs are
    // the rows' inputs; neither order is above what the rows have. out != in.
    void (*convert)(const struct rsh_rows *rows, bool transposed, const int bands[2],
                    const float *in, float *out);

    // Records as structures of arrays, `width` at once: coefficient k of a channel of record i is
    // [k * stride + i], and channels follow each other.
    int width;
    // The rotations of the matrices r[entry][record]; with `stretch`, by beta' instead of beta. The
    // caller sets their method.
    void (*angles)(const float r[9][RSH_MAX_WIDTH], bool stretch, struct rsh_rotations *t);
    void (*rotate_many)(const struct rsh_rotations *t, int order, int channels, size_t stride,
                        const float *in, float *out);
    // `convert` for one channel with the strides of out and in.
    void (*convert_many)(const struct rsh_rows *rows, bool transposed, const int bands[2],
                         const size_t strides[2], const float *in, float *out);
};

extern const struct rsh_kernels rsh_kernels_plain;
#if defined(__x86_64__)
extern const struct rsh_kernels rsh_kernels_sse2, rsh_kernels_avx2, rsh_kernels_avx512;
#else
extern const struct rsh_kernels rsh_kernels_native;
#endif

// The tables that this processor can run, best first, ended by NULL.
const struct rsh_kernels *const *rsh_kernels_usable(void);
// The best of them, found at the first call.
const struct rsh_kernels *rsh_kernels_best(void);
// For tests: makes another usable table the best from now on.
void rsh_kernels_choose(const struct rsh_kernels *kernels);

static inline bool rsh_order_ok(int order) { return order >= 1 && order <= RSH_MAX_ORDER; }
static inline bool rsh_basis_ok(rsh_basis basis) {
    return basis == RSH_SPHERE || basis == RSH_HEMISPHERE;
}

// The rotations whose product is the rotation r, rows first; RSH_METHOD_Z where that suffices.
struct rsh_rotation rsh_rotation_of_matrix(const float r[9]);
// Its angle about y, 0 .. pi.
float rsh_rotation_angle(const struct rsh_rotation *rotation);
// Whether floats cannot distinguish it from the identity.
bool rsh_rotation_is_identity(const struct rsh_rotation *rotation);
// Replaces beta by beta' = arccos(2 cos beta - 1), but for the field `beta`.
void rsh_rotation_stretch(struct rsh_rotation *rotation);
// False for a kind that there is not.
bool rsh_method_of_taylor(rsh_taylor kind, enum rsh_method *method);
// Whether all are numbers of at most RSH_MAX_ENTRY in magnitude, so that no square overflows.
#define RSH_MAX_ENTRY 1e9f
bool rsh_in_range(const float *v, int count);
void rsh_copy(int order, int channels, const float *in, float *out);

// The plain forms, for instruction sets that cannot permute lanes.
void rsh_plain_rotate(const struct rsh_rotation *rotation, int order, int channels, const float *in,
                      float *out);
void rsh_plain_convert(const struct rsh_rows *rows, bool transposed, const int bands[2],
                       const float *in, float *out);

#endif
