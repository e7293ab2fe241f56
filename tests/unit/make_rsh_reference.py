#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes rsh_reference.h: values and derivatives of harmonics in double precision by scipy.

usage: make_rsh_reference.py > rsh_reference.h
"""
import math

import numpy as np
from scipy.special import gammaln, lpmv

PAIRS = [(0, 0), (1, -1), (1, 0), (1, 1), (2, -2), (2, 1), (3, -3), (3, 0), (4, 3), (5, -4),
         (6, 6), (7, -1), (8, 0), (9, -9), (9, 5), (10, 2), (12, -7), (13, 13), (15, -15),
         (15, -1), (15, 0), (15, 8)]
ANGLES = [(0.0, 0.0), (0.001, 2.0), (0.3, -1.0), (0.9, 0.5), (1.2, 3.0), (1.5, -2.2), (1.57, 1.0)]


def meridian(l, m, x):
    """s K P without the phase that scipy's P carries."""
    k = math.sqrt((2 * l + 1) / (4 * math.pi)
                  * math.exp(gammaln(l - m + 1) - gammaln(l + m + 1))) * (math.sqrt(2) if m else 1)
    return (-1) ** m * k * float(lpmv(m, l, x))


def value(hemisphere, l, m, theta, phi):
    x = math.cos(theta)
    f = math.sqrt(2) * meridian(l, abs(m), 2 * x - 1) if hemisphere else meridian(l, abs(m), x)
    return f * (math.cos(m * phi) if m >= 0 else math.sin(-m * phi))


def derivative(f, x, h=1e-3):
    """Central differences of sixth order."""
    return sum(c * (f(x + k * h) - f(x - k * h)) for k, c in ((1, .75), (2, -.15), (3, 1 / 60))) / h


def main():
    print("// SPDX-License-Identifier: Apache-2.0")
    print("// Written by make_rsh_reference.py: values, d/dtheta and d/dphi of harmonics.")
    print("// clang-format off")
    print("static const struct {")
    print("    int hemisphere, l, m;")
    print("    float w[3];")
    print("    double value, dtheta, dphi;")
    print("} rsh_reference[] = {")
    for hemisphere in (0, 1):
        for theta, phi in ANGLES:
            if hemisphere and theta > 1.55:
                continue
            # The direction in float is the direction: the angles are those of the float vector.
            w = np.float32([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi),
                            math.cos(theta)])
            t = math.atan2(math.hypot(float(w[0]), float(w[1])), float(w[2]))
            p = math.atan2(float(w[1]), float(w[0]))
            for l, m in PAIRS:
                # Differences across the pole: (-theta, phi) is (theta, phi + pi), whose m-fold
                # factor is (-1)^m.
                along = lambda s: value(hemisphere, l, m, abs(s), p) * (
                    (-1) ** m if s < 0 else 1)
                around = lambda a: value(hemisphere, l, m, t, a)
                print("    {%d, %d, %d, {%.9ef, %.9ef, %.9ef}, %.12g, %.9g, %.9g}," % (
                    hemisphere, l, m, *[float("%.9g" % v) for v in w], around(p),
                    derivative(along, t), derivative(around, p)))
    print("};")


main()
