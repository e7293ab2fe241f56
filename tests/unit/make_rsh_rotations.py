#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes rsh_rotations.h: a vector of order 16 rotated by a few rotations, in double precision with
the Wigner matrices of the package spherical.

usage: make_rsh_rotations.py > rsh_rotations.h
"""
import math

import numpy as np
import quaternionic
import spherical

ORDER = 16
AXES = [((0, 0, 1), 1.0), ((0, 1, 0), 0.05), ((1, 0, 0), math.pi / 2), ((1, 2, -3), 2.5)]


def vector():
    v = np.array([math.sin(k + 1) for k in range(ORDER * ORDER)])
    return v / np.linalg.norm(v)


def rotated(r):
    """Real coefficients without phase to complex ones with phase, D, and back. The package rotates
    coefficients by the conjugate of its D."""
    v, wigner = vector(), spherical.Wigner(ORDER - 1)
    d = np.conj(wigner.D(quaternionic.array.from_rotation_matrix(r)))
    out = np.zeros(ORDER * ORDER)
    for l in range(ORDER):
        m = np.arange(-l, l + 1)
        band, flipped = v[l * l:(l + 1) ** 2], v[l * l:(l + 1) ** 2][::-1]
        plus = (-1.0) ** m * (band - 1j * flipped) / math.sqrt(2)
        minus = (flipped + 1j * band) / math.sqrt(2)
        c = np.where(m > 0, plus, minus)
        c[l] = band[l]
        block = np.array([[d[wigner.Dindex(l, a, b)] for b in m] for a in m])
        c = block @ c
        for a in range(1, l + 1):
            out[l * (l + 1) + a] = math.sqrt(2) * (-1) ** a * c[l + a].real
            out[l * (l + 1) - a] = -math.sqrt(2) * (-1) ** a * c[l + a].imag
        out[l * (l + 1)] = c[l].real
    return out


def main():
    print("// SPDX-License-Identifier: Apache-2.0")
    print("// Written by make_rsh_rotations.py: the vector sin(k + 1) / length, rotated by r.")
    print("// clang-format off")
    print("static const struct {")
    print("    float r[9];")
    print("    double rotated[%d];" % ORDER**2)
    print("} reference_rotations[] = {")
    for axis, angle in AXES:
        axis = np.array(axis) / np.linalg.norm(axis)
        rotor = quaternionic.array.from_axis_angle(axis * angle)
        # The rotation is that of the float matrix.
        r = rotor.to_rotation_matrix.astype(np.float32).astype(float)
        print("    {{%s},\n     {" % ", ".join("%.9ef" % x for x in r.ravel()))
        values = ["%.10g" % x for x in rotated(r)]
        for k in range(0, len(values), 8):
            print("      %s," % ", ".join(values[k:k + 8]))
        print("     }},")
    print("};")


main()
