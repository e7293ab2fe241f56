// SPDX-License-Identifier: Apache-2.0
// Real spherical and hemispherical harmonics: evaluation, projection, products, rotation. This
// library is independent: it needs nothing but this header, allocates no memory and keeps no state,
// so every function may be called from any thread at any time. All arrays are the caller's.
//
// Conventions
//   order    n = number of bands, 1 to RSH_MAX_ORDER; a vector has n * n coefficients
//   index    of degree l = 0 .. n - 1 and m = -l .. l: l (l + 1) + m
//   sphere   Y_l^m = s K_l^|m| P_l^|m|(cos theta) t, with t = cos(m phi) for m >= 0 and
//            sin(|m| phi) for m < 0, s = sqrt 2 for m != 0 and 1 for m = 0,
//            K_l^m = sqrt((2 l + 1) (l - m)! / (4 pi (l + m)!)).
//   phase    No Condon-Shortley phase: P_m^m = +(2 m - 1)!! sin^m, so band 1 is
//            sqrt(3 / (4 pi)) (y, z, x). rsh_export and rsh_import convert to and from others.
//   hemisphere (z >= 0; Gautron et al. 2004)
//            H_l^m = s sqrt(2) K_l^|m| P_l^|m|(2 cos theta - 1) t. A direction below the horizon
//            is treated as the horizon under it. All H with m != 0 vanish at the horizon.
//   norm     Both bases are orthonormal over their domain; integral L F = dot(Lambda, Phi).
//   channels Vectors of several channels lie one after another: out[channel * n * n + index].
//   units    Directions are unit vectors without unit, angles [rad]; coefficients have the unit of
//            the function times [sr^1/2], so that rsh_dot3 of radiance and a BRDF [sr^-1] in
//            harmonics is radiance. What converts or rotates coefficients leaves their unit as it
//            is. A direction that is not unit, zero or NaN gives values without meaning and does no
//            other harm.
//
// Functions that take an order return false, and write nothing, if it is not 1 .. RSH_MAX_ORDER; so
// do those that take a basis, if it is neither of the two.
#ifndef RSH_RSH_H
#define RSH_RSH_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define RSH_API __attribute__((visibility("default")))
#else
#define RSH_API
#endif

#define RSH_MAX_ORDER 16
#define RSH_MAX_COEFFICIENTS (RSH_MAX_ORDER * RSH_MAX_ORDER)

typedef enum rsh_basis { RSH_SPHERE = 0, RSH_HEMISPHERE } rsh_basis;

// y[n * n]: all basis functions in direction w, accurate to 1e-6 of each function's largest value
// (1e-7 measured) if |w| is 1 up to the rounding of floats. Values of both bases have the unit
// [sr^-1/2]. Thread-safe.
RSH_API bool rsh_eval(rsh_basis basis, int order, const float w[3], float *y);

// Does what rsh_eval does, with the derivatives by theta and phi; all three arrays have n * n
// entries. At the pole phi counts as 0. The hemisphere's d/dtheta grows as 1 / sqrt(cos theta)
// towards the horizon and is constant below cos theta = 1e-6. Units are [sr^-1/2] of y, and
// [sr^-1/2 rad^-1] of the derivatives. Thread-safe.
RSH_API bool rsh_eval_derivatives(rsh_basis basis, int order, const float w[3], float *y,
                                  float *dtheta, float *dphi);

// All basis functions in `count` directions, given as three arrays: out[k * count + i] is function
// k in direction i, with the accuracy and the unit [sr^-1/2] of rsh_eval. Thread-safe.
RSH_API bool rsh_eval_many(rsh_basis basis, int order, size_t count, const float *x, const float *y,
                           const float *z, float *out);

// Samples of a function, as arrays of `count` entries each.
typedef struct rsh_samples {
    size_t count;
    const float *x, *y, *z;  // directions
    const float *r, *g, *b;  // values times the samples' weights [sr]; g and b NULL: one channel, r
} rsh_samples;
// Adds sum_i value_i H(w_i) to out[3 * n * n], or to out[n * n] if there is one channel. With
// values in the unit of the function times [sr], `out` has the unit of the function times [sr^1/2].
// Thread-safe.
RSH_API bool rsh_project(rsh_basis basis, int order, const rsh_samples *samples, float *out);

// Projects onto a basis that is given as a constant matrix: out[c * coefficients + k] +=
// sum_i matrix[i * coefficients + k] * value_c[i], c = r, g, b. With g and b NULL: one channel.
// Any number of coefficients. `out` has the product of the units of matrix and values.
// Thread-safe.
RSH_API void rsh_accumulate(size_t count, size_t coefficients, const float *matrix, const float *r,
                            const float *g, const float *b, float *out);

// out[c] = a_c . b_c for three channels of b[3 * n * n]. a has `a_channels` channels: 3, or 1 for
// all. `out` has the product of the units of a and b: that of the integral of the two functions
// over directions. Thread-safe.
RSH_API bool rsh_dot3(int order, int a_channels, const float *a, const float *b, float out[3]);

// out[channels]: the function's value in direction w, in the unit of `in` times [sr^-1/2].
// Thread-safe.
RSH_API bool rsh_value(rsh_basis basis, int order, int channels, const float *in, const float w[3],
                       float *out);

// Convolves a function on the sphere with a kernel that is symmetric about an axis, given by its
// coefficients zonal[order] at m = 0 when the axis is z. out == in is allowed here and below.
// The result has the product of both units. Thread-safe.
RSH_API bool rsh_convolve(int order, int channels, const float *zonal, const float *in, float *out);

// Converts between this library's convention and that with the Condon-Shortley phase, in both
// directions: negates the coefficients of odd m. Keeps the unit. Thread-safe.
RSH_API bool rsh_flip_phase(int order, int channels, const float *in, float *out);

// Other conventions. Their harmonics are those of this library times a factor, so coefficients are
// multiplied by its inverse.
typedef enum rsh_normalisation {
    RSH_ORTHONORMAL = 0,  // integral of Y^2 over the sphere is 1 (this library's)
    RSH_FOUR_PI,          // it is 4 pi: "N3D", geodesy
    RSH_SCHMIDT,          // it is 4 pi / (2 l + 1): "SN3D", magnetics, ambisonics
    RSH_UNNORMALISED      // P_l^|m|(cos theta) cos(m phi) or sin(|m| phi)
} rsh_normalisation;
// Complex harmonics have exp(i m phi). That of -m is the conjugate of that of m, times (-1)^m if
// there is a phase.
typedef enum rsh_layout {
    RSH_BY_DEGREE = 0,  // n * n numbers, l (l + 1) + m (ours; "ACN")
    RSH_COSINE_SINE,    // [2][n][n]: [0][l][m] of cos(m phi), [1][l][m] of sin(m phi), as in
                        // pyshtools
    RSH_COMPLEX         // n * n pairs of real and imaginary part, l (l + 1) + m
} rsh_layout;
typedef struct rsh_convention {
    rsh_normalisation norm;
    bool phase;  // Condon and Shortley's (-1)^m
    rsh_layout layout;
} rsh_convention;
// Numbers per channel in a layout; 0 for orders out of range. Without unit. Thread-safe.
RSH_API int rsh_convention_size(int order, rsh_layout layout);
// Converts from this library's convention to another one, and back; in and out must not overlap.
// Functions are real: only the complex coefficients of m >= 0 are read. False also if the
// convention is invalid. Keeps the unit. Thread-safe.
RSH_API bool rsh_export(const rsh_convention *to, int order, int channels, const float *in,
                        float *out);
// Converts from another convention to this library's. What rsh_export requires holds here too.
// Numbers keep their unit. Thread-safe.
RSH_API bool rsh_import(const rsh_convention *from, int order, int channels, const float *in,
                        float *out);

// Rotations of functions on the sphere. Rotating L by R gives the function L(R^-1 w); R is a proper
// orthonormal matrix in row-major order. Every call below allows out == in, and takes any number of
// channels at once: a record with two derivative vectors of three colours has 9 channels. If a
// matrix, a frame or an angle has a NaN or an entry beyond 1e9, false is returned and nothing is
// written. A matrix that is not orthonormal gives finite values without meaning.

// About z by `angle` [rad] [K05 D]. Thread-safe.
RSH_API bool rsh_rotate_z(int order, int channels, float angle, const float *in, float *out);
// About y by `angle` [rad], exact to rounding. Thread-safe.
RSH_API bool rsh_rotate_y(int order, int channels, float angle, const float *in, float *out);

// Truncations of the rotation about y at small angles [rad] [K05 5.3]: the series to first order,
// with the diagonal of the second order ("1.5th"), and to second order.
typedef enum rsh_taylor { RSH_TAYLOR_1 = 0, RSH_TAYLOR_1_5, RSH_TAYLOR_2 } rsh_taylor;
// Rotates about y by `angle` [rad], a small one, by a truncated series. Thread-safe.
RSH_API bool rsh_rotate_y_taylor(rsh_taylor kind, int order, int channels, float angle,
                                 const float *in, float *out);

// Rotates by any rotation, exact to rounding, with the form that is fastest, which is that of
// rsh_rotate_pinchon_hoggan. Keeps the unit. Thread-safe.
RSH_API bool rsh_rotate(int order, int channels, const float r[9], const float *in, float *out);

// A rotation as rotations about z by gamma, then y by beta, then z by alpha [rad].
typedef struct rsh_zyz {
    float alpha, beta, gamma;
} rsh_zyz;
// All angles are in [rad]; beta is 0 .. pi. If beta is 0 up to rounding, alpha is 0. Thread-safe.
RSH_API rsh_zyz rsh_zyz_of_matrix(const float r[9]);
// Rotates by three angles [rad], exact to rounding. Thread-safe.
RSH_API bool rsh_rotate_zyz(int order, int channels, rsh_zyz angles, const float *in, float *out);

// The forms by name, all for any r; numbers of products are per channel. This one is z, y, z with
// the series about y [K05 5.3], for small beta only: 9 n^2 products. Keeps the unit. Thread-safe.
RSH_API bool rsh_rotate_taylor(rsh_taylor kind, int order, int channels, const float r[9],
                               const float *in, float *out);
// z, y, z with the rotation about y as one about z between two exchanges of y and z, which are
// constant symmetric blocks [Pinchon and Hoggan 2007]: 2 n^3 / 3 + 6 n^2 products. Keeps the unit.
// Thread-safe.
RSH_API bool rsh_rotate_pinchon_hoggan(int order, int channels, const float r[9], const float *in,
                                       float *out);
// z, y, z with the rotation about y as one about z between two rotations about x by 90 degrees
// [Kautz et al. 2002], in plain C. Keeps the unit. Thread-safe.
RSH_API bool rsh_rotate_zxzxz(int order, int channels, const float r[9], const float *in,
                              float *out);
// Matrices band by band from r itself [Ivanic and Ruedenberg 1996, corrected 1998], in plain C: 4
// n^3 / 3 products to apply them, and several times as many to compute them. Keeps the unit.
// Thread-safe.
RSH_API bool rsh_rotate_ivanic(int order, int channels, const float r[9], const float *in,
                               float *out);

// Rotation matrices as blocks: the block of band l is (2 l + 1) x (2 l + 1) in row-major order,
// m = -l .. l, and begins at l (2 l - 1) (2 l + 1) / 3. All blocks have rsh_blocks_size(n) =
// n (2 n - 1) (2 n + 1) / 3 numbers, or 0 if the order is out of range.
#define RSH_MAX_BLOCKS (RSH_MAX_ORDER * (2 * RSH_MAX_ORDER - 1) * (2 * RSH_MAX_ORDER + 1) / 3)
// The number of values in all blocks; 0 if the order is out of range. Without unit. Thread-safe.
RSH_API int rsh_blocks_size(int order);
// Sets blocks[rsh_blocks_size(order)] to those of rotation r. Without unit. Thread-safe.
RSH_API bool rsh_rotation_blocks(int order, const float r[9], float *blocks);
// Derivatives 0 .. highest by beta [rad^-1 each] of the rotation about y, at beta [rad], one after
// another in blocks[(highest + 1) * rsh_blocks_size(order)] [K05 C]. Their rounding errors grow as
// order^highest. Thread-safe.
RSH_API bool rsh_rotation_y_derivatives(int order, float beta, int highest, float *blocks);
// Multiplies each band of each channel by its block, so that `in` is rotated. Keeps the unit.
// Thread-safe.
RSH_API bool rsh_apply_blocks(int order, int channels, const float *blocks, const float *in,
                              float *out);

// Rotates hemispherical harmonics by r with beta' = arccos(2 cos beta - 1) instead of the angle
// beta of the zyz decomposition, which is correct at the pole only [K05 5.4; Gautron et al. 2004];
// see rsh_align. The horizon stays where it is: if the pole rotates by 10 degrees, what is 60
// degrees from it rotates by 7.8 and what is 80 degrees from it by 4.8. Near the horizon the error
// can be larger than without rotation. Angles from 90 degrees on count as 90. Keeps the unit.
// Thread-safe.
RSH_API bool rsh_rotate_stretched(int order, int channels, const float r[9], const float *in,
                                  float *out);

// From which frame to which coefficients are aligned; a frame is the rows u, v, n of a right-handed
// orthonormal basis. Up to the angle `beta_limit` [rad] between the normals the fast form is used,
// beyond it the exact one. With a beta_limit of 0 or NaN the form is always exact, with 4 never.
typedef struct rsh_alignment {
    rsh_basis basis;
    const float *from, *to;  // [9 each]
    float beta_limit;
} rsh_alignment;
// Coefficients given in frame `from`, re-expressed in frame `to`. It is a copy if the frames agree
// and a rotation about z if the normals do.
//   sphere      fast: the second-order series, which adds an error of 1 % of radiance at 10 degrees
//               and 5 % at 15 for order 10, and saves a quarter of the time or less. Exact:
//               rsh_rotate.
//   hemisphere  fast: rotation by beta' = arccos(2 cos beta - 1), as a series [K05 5.4]. It is
//               correct at the pole only: radiance reflected by lobes up to 75 degrees is wrong by
//               1.3 % at 3 degrees, 2 % at 6, 3 % at 10 (without alignment 4, 7 and 12 %).
//               Exact: through the sphere, see below; the errors are .7 %, .8 % and 1 %, of which
//               .7 % is due to the order, 10 in this test.
// Coefficients keep their unit. Thread-safe.
RSH_API bool rsh_align(const rsh_alignment *alignment, int order, int channels, const float *in,
                       float *out);

// The transpose of rsh_align by the same alignment, applied to the other vector of a product:
// dot(c, align(lambda)) = dot(align_transposed(c), lambda). It rotates one BRDF into the frame of
// each record, instead of each record with its derivatives and colours. With a limit of pi or more
// it fails for nearly opposite normals, where rounding determines the axis of the series. Keeps the
// unit. Thread-safe.
RSH_API bool rsh_align_transposed(const rsh_alignment *alignment, int order, int channels,
                                  const float *in, float *out);

// What a BRDF in the frame `to` reflects of a record in `from`: out[c] = dot(BRDF, align(value +
// x d_dx + y d_dy)), c = r, g, b. The BRDF is rotated, not the record: one channel, or three,
// instead of the record's nine. False also if the number of channels is neither 1 nor 3.
typedef struct rsh_reflection {
    rsh_alignment alignment;
    int order;
    const float *value;        // [3 * n * n]
    const float *d_dx, *d_dy;  // the same size; NULL: none
    float x, y;                // displacement in the record's frame, in the derivatives' length
    const float *brdf;         // [brdf_channels * n * n]
    int brdf_channels;         // 3, or 1 for all colours
} rsh_reflection;
// Computes one such product; its unit is that of `value` times that of `brdf`. Thread-safe.
RSH_API bool rsh_reflect(const rsh_reflection *reflection, float out[3]);

// Rotation and alignment of `count` records at once, as structures of arrays: coefficient k of
// channel c of record i is in[(c * n * n + k) * count + i], entry e of its matrix or frame is
// r[e][i]. out == in is allowed. A record's result does not depend on the others. Blocks of 16 to
// 64 records stay in the first cache. These calls use up to 256 kB of the calling thread's stack.

// The alignments of many records, which are as rsh_alignment but for the frames.
typedef struct rsh_alignments {
    rsh_basis basis;
    const float *const *from, *const *to;  // [9] pointers to [count] numbers each
    float beta_limit;                      // [rad]
} rsh_alignments;

// Does for each record what rsh_rotate does. Keeps the unit. Thread-safe.
RSH_API bool rsh_rotate_many(int order, int channels, size_t count, const float *const r[9],
                             const float *in, float *out);
// Does for each record what rsh_rotate_taylor does. Keeps the unit. Thread-safe.
RSH_API bool rsh_rotate_taylor_many(rsh_taylor kind, int order, int channels, size_t count,
                                    const float *const r[9], const float *in, float *out);
// Does for each record what rsh_align does. Keeps the unit. Thread-safe.
RSH_API bool rsh_align_many(const rsh_alignments *alignments, int order, int channels, size_t count,
                            const float *in, float *out);
// Does for each record what rsh_align_transposed does. Keeps the unit. Thread-safe.
RSH_API bool rsh_align_transposed_many(const rsh_alignments *alignments, int order, int channels,
                                       size_t count, const float *in, float *out);

// Hemispherical harmonics are not closed under rotation: what rises above the horizon is unknown.
// `extend` continues a function over the whole sphere, as spherical harmonics of order
// rsh_sphere_order(n) = n + 2 (at most 16), close to its mirror image below the horizon. These
// rotate exactly, and `restrict` converts them back to order n. The transposes are for the other
// vector of a product: dot(c, restrict(R extend(lambda))) = dot(R^-1 restrict_transposed(c),
// extend(lambda)). So a caller with one c and many records, or one record and many c, converts each
// once and rotates on the sphere. `order` is that of the hemisphere; in and out must not overlap.

// The order of the functions on the sphere, as above; not checked. Without unit. Thread-safe.
RSH_API int rsh_sphere_order(int order);
// Continues a function over the whole sphere; its unit stays. Thread-safe.
RSH_API bool rsh_hemi_extend(int order, int channels, const float *in, float *out);
// Converts a function on the sphere back to the hemisphere. Keeps the unit. Thread-safe.
RSH_API bool rsh_hemi_restrict(int order, int channels, const float *in, float *out);
// The transpose of rsh_hemi_extend. Keeps the unit. Thread-safe.
RSH_API bool rsh_hemi_extend_transposed(int order, int channels, const float *in, float *out);
// The transpose of rsh_hemi_restrict. Keeps the unit. Thread-safe.
RSH_API bool rsh_hemi_restrict_transposed(int order, int channels, const float *in, float *out);

#ifdef __cplusplus
}
#endif
#endif
