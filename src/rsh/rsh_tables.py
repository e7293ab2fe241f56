#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the constants of the harmonics as C, in double precision rounded once to float.

usage: rsh_tables.py OUTPUT.c        (the declarations and meanings are in rsh_tables.h)
"""
import math
import sys

ORDER = 16


def norm(l, m):
    """Factor of the monic Legendre function z^(l-m) + ... in Y_l^m (m >= 0), sqrt 2 included."""
    k = (2 * l + 1) * math.factorial(l - m) / (4 * math.pi * math.factorial(l + m))
    leading = math.factorial(2 * l) / (2**l * math.factorial(l) * math.factorial(l - m))
    return math.sqrt(k * (2 if m else 1)) * leading


def recurrence(l, m):
    """b in p_l = z p_(l-1) - b p_(l-2), for monic associated Legendre functions of one m."""
    return ((l - 1) ** 2 - m * m) / (4.0 * (l - 1) ** 2 - 1) if l >= m + 2 else 0.0


def number(x):
    return ("%.9gf" % x) if "." in "%.9g" % x or "e" in "%.9g" % x else "%.9g.0f" % x


def array(out, head, values):
    out.append("const float %s = {" % head)
    for i in range(0, len(values), 6):
        out.append("    " + ", ".join(number(v) for v in values[i:i + 6]) + ",")
    out.append("};")


def main():
    out = ["// Written by rsh_tables.py.", '#include "rsh/rsh_tables.h"']
    grid = [(l, m) for m in range(ORDER) for l in range(ORDER)]
    array(out, "rsh_norm[RSH_MAX_ORDER * RSH_MAX_ORDER]",
          [norm(l, m) if l >= m else 0.0 for l, m in grid])
    array(out, "rsh_recurrence[RSH_MAX_ORDER * RSH_MAX_ORDER]",
          [recurrence(l, m) for l, m in grid])
    with open(sys.argv[1], "w") as f:
        f.write("\n".join(out) + "\n")


main()
