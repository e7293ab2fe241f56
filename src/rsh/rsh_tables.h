// SPDX-License-Identifier: Apache-2.0
// Constants of the harmonics, written by rsh_tables.py when the library is built.
#ifndef RSH_TABLES_H
#define RSH_TABLES_H

#include <stdint.h>

#include "rsh/rsh.h"

// For m >= 0 the basis is Y_l^m = norm_lm p_l^m(z) Re (x + i y)^m, and Im for -m, where p is the
// monic polynomial p_m = 1, p_(m+1) = z, p_l = z p_(l-1) - recurrence_lm p_(l-2).
// Both tables are indexed m * RSH_MAX_ORDER + l.
extern const float rsh_norm[RSH_MAX_ORDER * RSH_MAX_ORDER];
extern const float rsh_recurrence[RSH_MAX_ORDER * RSH_MAX_ORDER];
extern const double rsh_recurrence_d[RSH_MAX_ORDER * RSH_MAX_ORDER];  // rsh_recurrence in double

// The functions for m < RSH_STEEP by differences, which lose nothing to cancellation near the
// poles, where these functions are steep [after Reinsch]: with u = 1 - |z| and q_m = 1, d_m = 0,
//   d_l = d_(l-1) - curvature_lm u q_(l-1),  q_l = q_(l-1) + keep_lm d_l,
//   Y_l^m = pole_lm q_l sign(z)^(l-m) Re (x + i y)^m.
enum { RSH_STEEP = 8 };
extern const float rsh_pole[RSH_STEEP * RSH_MAX_ORDER];
extern const float rsh_curvature[RSH_STEEP * RSH_MAX_ORDER];
extern const float rsh_keep[RSH_STEEP * RSH_MAX_ORDER];

// The functions for l < RSH_GENTLE by their roots in z^2: Y_l^m is norm_lm times z^2 - root for
// each of the (l - m) / 2 roots, times Re (x + i y)^m, times z for odd l - m. The largest roots are
// first. The first half of them, rounded down, is stored as 1 - root, which is to be subtracted
// from 1 - z^2. Both tables are indexed m * RSH_GENTLE + l; the norms of the hemisphere include its
// factor sqrt 2.
enum { RSH_GENTLE = 10, RSH_GENTLE_ROOTS = 4 };
extern const float rsh_gentle_norm[2 * RSH_GENTLE * RSH_GENTLE];  // sphere, then hemisphere
extern const float rsh_gentle_root[RSH_GENTLE * RSH_GENTLE][RSH_GENTLE_ROOTS];

// Y of all m from one set of functions of z: f_0 = 1, f_(-1) = 0, f_k = 2 step_k z f_(k-1) -
// f_(k-2), and norm_lm p_l^m = sum over j = k, k - 2 .. of mix[m][k][j / 2] f_j, k = l - m. Set 0
// is Chebyshev's polynomials of the second kind, whose steps are all 1; set 1 is the Legendre
// functions of m = 5.
extern const float rsh_mix_step[2][RSH_MAX_ORDER];
extern const float rsh_mix[2][RSH_MAX_ORDER][RSH_MAX_ORDER][RSH_MAX_ORDER / 2];

// D, the derivative of the rotation about y at angle 0, is antisymmetric and couples neighbours
// only: entry (i, i - 1) is rsh_slope[i], and 0 between bands [K05 C; errata 4].
extern const float rsh_slope[RSH_MAX_COEFFICIENTS + 2];

// The diagonal of D^2.
extern const float rsh_d2_diagonal[RSH_MAX_COEFFICIENTS];

// The exchange of y and z, a symmetric orthogonal matrix per band, rows and columns m = -l .. l;
// band l begins at l (2 l - 1) (2 l + 1) / 3. Three of four entries vanish by parity.
extern const float rsh_swap[];

// The rotation about x by 90 degrees, (x, y, z) -> (x, -z, y), by rows: row i of all rows ends
// before entry rsh_quarter_end[i], and entry k is in column rsh_quarter_column[k] - l. Its inverse
// is the transpose.
extern const uint16_t rsh_quarter_end[RSH_MAX_COEFFICIENTS];
extern const uint8_t rsh_quarter_column[];
extern const float rsh_quarter[], rsh_quarter_back[];

// The coefficients u, v and w of entry (m1, m2) [Ivanic and Ruedenberg 1996, 1998] are
// rsh_ivanic_row[l (l + 1) + m1] times rsh_ivanic_column[l (l + 1) + m2].
extern const float rsh_ivanic_row[RSH_MAX_COEFFICIENTS][3];
extern const float rsh_ivanic_column[RSH_MAX_COEFFICIENTS];

// Rotation works on 16 lanes at a time: lane |m| of a band, with the coefficients +m and -m in two
// vectors. The component that is even in x holds +m for even m and -m for odd m; the odd component
// holds the others. Small bands are in one vector, so order n has the sets {0 1 2 3} {4 5} {6 7}
// {8} {9} ... {15}. Even m are in the lower eight lanes and odd m in the upper eight.
//
// About z by a: with s = (-1)^m sin(m a) and c = cos(m a), even' = c even - s odd and odd' = c odd
// + s even.
//
// The exchange of y and z keeps the parity in x. It maps each half of the even component to itself
// for even l and to the other half for odd l, and the reverse for the odd component. Between two
// exchanges the lanes therefore have the "inner" layout, in which the halves of odd l are
// exchanged: then every lane of the even component depends on its own half, and every lane of the
// odd component on the other half.
//
// About y, D couples |m| with |m| - 1 and |m| + 1, which are in the other half of the other
// component.
enum { RSH_LANES = 16, RSH_LANE_SETS = 11 };

struct rsh_lane_set {
    // The index of each lane's coefficient, minus `first`; 31 is none. All rows are aligned to
    // cache lines.
    _Alignas(64) int32_t even[RSH_LANES];
    int32_t odd[RSH_LANES];
    int32_t natural[2 * RSH_LANES];  // lane of coefficient first + k, + 16 if it is odd in x
    int32_t power[2][RSH_LANES];     // index of m among 0 2 .. 14 1 3 .. 15: outer, inner
    int32_t source[2][RSH_LANES];    // lane at step 0: outer to inner, inner to outer
    int32_t down[RSH_LANES], up[RSH_LANES];                // lane of |m| - 1 and |m| + 1
    float from_down[2][RSH_LANES], from_up[2][RSH_LANES];  // entries of D, into even and odd
    float d2_diagonal[2][RSH_LANES];                       // the diagonal of D^2, even and odd
    int first;                                             // index of its first coefficient
    int steps;                                             // number of steps of the exchange
    int offset;  // index of its first step in rsh_lane_steps
};
extern const struct rsh_lane_set rsh_lane_sets[RSH_LANE_SETS];

// One step of the exchange: out[lane] += factor[lane] * in[source[lane] + step], where the source
// wraps around within its half.
struct rsh_lane_step {
    _Alignas(64) float factor[2][2][RSH_LANES];  // [outer to inner, inner to outer][even, odd]
};
extern const struct rsh_lane_step rsh_lane_steps[];

// Orders up to 6 have another layout, in which a vector holds whole bands: order 4 fills one vector
// with its 16 coefficients, and bands 2 to 5 of order 6 fill two, {2 5} and {3 4}. Lanes 2 i and 2
// i + 1 have the coefficients +m and -m of a band; the last lanes have those of m = 0.
enum { RSH_PAIR_STEPS = 3 };
struct rsh_pair_lanes {
    _Alignas(64) int32_t index[RSH_LANES];      // of the coefficient, minus that of the set's first
    int32_t multiple[3][RSH_LANES];             // index in rsh_pair_multiples: alpha, beta, gamma
    int32_t source[RSH_PAIR_STEPS][RSH_LANES];  // the exchange of y and z: lanes and factors
    float factor[RSH_PAIR_STEPS][RSH_LANES];
    int32_t down[RSH_LANES], up[RSH_LANES];          // lane of m - 1 and m + 1
    float from_down[RSH_LANES], from_up[RSH_LANES];  // entries of D
    float d2_diagonal[RSH_LANES];                    // the diagonal of D^2
};
struct rsh_pair_set {
    struct rsh_pair_lanes lanes[2];
    int32_t natural[2 * RSH_LANES];  // lane of the set's k-th coefficient, + 16 in vector 1
};
// Set 0 is for orders up to 4 and uses vector 0 alone; set 1 is for orders 5 and 6, without
// bands 0 and 1.
extern const struct rsh_pair_set rsh_pair_sets[2];

// Multiples of three angles alpha, beta, gamma: m = 1 .. 5 of each in turn, then m = 0. With t =
// cos 2 a,
//   cos(m a) = (cosine[0] + t (cosine[1] + t cosine[2])) (cos a where m is odd, 1 elsewhere)
//   sin(m a) = (sine[0] + t (sine[1] + t sine[2])) sin a (1 where m is odd, cos a elsewhere).
struct rsh_pair_multiples {
    _Alignas(64) float cosine[3][RSH_LANES];
    float sine[3][RSH_LANES];
};
extern const struct rsh_pair_multiples rsh_pair_multiples;
// Bit masks of the lanes of the first two angles and of odd m.
enum { RSH_PAIR_ALPHA = 0x001f, RSH_PAIR_BETA = 0x03e0, RSH_PAIR_ODD = 0x56b5 };

// A linear map between coefficients of equal m, from order `inputs` to order `outputs`. The factor
// of input (i, +-m) in output (o, +-m) is low[(o * inputs + i) * 8 + m] for m < 8 and, for o and i
// >= 8, high[((o - 8) * (inputs - 8) + i - 8) * 8 + m - 8] for m >= 8.
struct rsh_rows {
    const float *low, *high;
    int outputs, inputs;
};

// From hemispherical to spherical harmonics. The extension, [n - 1] for order n, continues a
// function over the sphere: it is the least squares fit, of order n + 2 but at most 16, to the
// function above the horizon and, with a tenth of the weight, to its mirror image below. Two more
// orders than n hold a function of the hemisphere's basis nearly without loss; the mirror image
// keeps the fit bounded.
extern const struct rsh_rows rsh_extension[RSH_MAX_ORDER];
// From spherical to hemispherical harmonics, for any order up to 16: projects the function above
// the horizon.
extern const struct rsh_rows rsh_restriction;

#endif
