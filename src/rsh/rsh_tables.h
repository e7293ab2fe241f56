// SPDX-License-Identifier: Apache-2.0
// Constants of the harmonics, written by rsh_tables.py when the library is built.
#ifndef RSH_TABLES_H
#define RSH_TABLES_H

#include "rsh/rsh.h"

// For m >= 0 the basis is Y_l^m = norm_lm p_l^m(z) Re (x + i y)^m, and Im for -m, where p is the
// monic polynomial p_m = 1, p_(m+1) = z, p_l = z p_(l-1) - recurrence_lm p_(l-2).
// Both tables are indexed m * RSH_MAX_ORDER + l.
extern const float rsh_norm[RSH_MAX_ORDER * RSH_MAX_ORDER];
extern const float rsh_recurrence[RSH_MAX_ORDER * RSH_MAX_ORDER];

#endif
