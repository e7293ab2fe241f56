#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares the harmonics of librsh with scipy, pyshtools and spherical, all in double precision.

usage: check_harmonics.py LIBRSH.so [ROTATIONS]
       (status 77, skipped, where a package is missing)

Basis values: 10^5 directions, orders to 16; errors count relative to each function's largest value.
Rotations: random ones at orders 10 and 16, 50 unless said; errors count relative to the vector's
length. Ends with the largest errors as a table in Markdown.
"""
import ctypes
import sys

try:
    import numpy as np
    import pyshtools
    import quaternionic
    import spherical
    from scipy.special import sph_harm_y
except ImportError as missing:
    print(missing)
    sys.exit(77)

ORDER, DIRECTIONS = 16, 100000
FLOATS = ctypes.POINTER(ctypes.c_float)
BASES = "sphere", "hemisphere"


def pointer(array):
    return array.ctypes.data_as(FLOATS)


def complex_of(v, n):
    """Coefficients of the complex harmonics with Condon-Shortley phase from real ones without."""
    c = np.zeros(n * n, complex)
    for l in range(n):
        i = l * (l + 1)
        c[i] = v[i]
        for m in range(1, l + 1):
            c[i + m] = (-1) ** m * (v[i + m] - 1j * v[i - m]) / np.sqrt(2)
            c[i - m] = (v[i + m] + 1j * v[i - m]) / np.sqrt(2)
    return c


def real_of(c, n):
    v = np.zeros(n * n)
    for l in range(n):
        i = l * (l + 1)
        v[i] = c[i].real
        for m in range(1, l + 1):
            v[i + m] = np.sqrt(2) * (-1) ** m * c[i + m].real
            v[i - m] = -np.sqrt(2) * (-1) ** m * c[i + m].imag
    return v


def scipy_basis(theta, phi):
    y = np.zeros((ORDER * ORDER, len(theta)))
    for l in range(ORDER):
        for m in range(l + 1):
            value = (-1) ** m * sph_harm_y(l, m, theta, phi) * (np.sqrt(2) if m else 1)
            y[l * (l + 1) - m] = value.imag
            y[l * (l + 1) + m] = value.real
    return y


def angles(w, hemisphere):
    """Of the float directions. The hemisphere's theta' with cos theta' = 2 cos theta - 1 comes from
    sin(theta' / 2) = sqrt 2 sin(theta / 2), which loses nothing at the pole."""
    w = w.astype(float)
    theta = np.arctan2(np.hypot(w[0], w[1]), w[2])
    if hemisphere:
        theta = 2 * np.arcsin(np.minimum(np.sqrt(2) * np.sin(theta / 2), 1))
    return theta, np.arctan2(w[1], w[0])


def check_basis(lib, rng, table):
    good = True
    for hemisphere in (0, 1):
        w = rng.normal(size=(3, DIRECTIONS))
        w /= np.linalg.norm(w, axis=0)
        w[2] = np.abs(w[2]) if hemisphere else w[2]
        w = np.ascontiguousarray(w, dtype=np.float32)
        want = scipy_basis(*angles(w, hemisphere)) * (np.sqrt(2) if hemisphere else 1)
        largest = np.abs(want).max(axis=1)[:, None]
        many = np.zeros((ORDER * ORDER, DIRECTIONS), np.float32)
        lib.rsh_eval_many(hemisphere, ORDER, ctypes.c_size_t(DIRECTIONS), pointer(w[0]),
                          pointer(w[1]), pointer(w[2]), pointer(many))
        one, each = np.zeros((DIRECTIONS, ORDER * ORDER), np.float32), np.ascontiguousarray(w.T)
        for i in range(DIRECTIONS):
            lib.rsh_eval(hemisphere, ORDER, pointer(each[i]), pointer(one[i]))
        # Orders up to 10 are evaluated at many directions by code of their own.
        few = np.zeros((100, DIRECTIONS), np.float32)
        lib.rsh_eval_many(hemisphere, 10, ctypes.c_size_t(DIRECTIONS), pointer(w[0]), pointer(w[1]),
                          pointer(w[2]), pointer(few))
        for name, got, order in (("rsh_eval", one.T, 16), ("rsh_eval", one.T[:100], 10),
                                 ("rsh_eval_many", many, 16), ("rsh_eval_many", few, 10)):
            error = np.abs(got - want[:len(got)]) / largest[:len(got)]
            rms = np.sqrt((error**2).mean())
            print("%-15s %-10s  order %2d  largest error %.1e, rms %.1e, limit 1e-06" % (
                name, BASES[hemisphere], order, error.max(), rms))
            good &= bool(error.max() < 1e-6)
            cell = f"{error.max():.1e} ({rms:.0e})"
            table.setdefault((f"`{name}`, {BASES[hemisphere]} (rms)", "scipy"), {})[order] = cell
    return good


def check_pyshtools(lib, rng):
    worst = 0.0
    for _ in range(100):
        w = rng.normal(size=3)
        w = np.ascontiguousarray(w / np.linalg.norm(w), dtype=np.float32)
        theta, phi = angles(w, False)
        got = np.zeros(ORDER * ORDER, np.float32)
        lib.rsh_eval(0, ORDER, pointer(w), pointer(got))
        want = pyshtools.expand.spharm(ORDER - 1, np.degrees(theta), np.degrees(phi),
                                       normalization="ortho", kind="real", csphase=1)
        for l in range(ORDER):
            for m in range(-l, l + 1):
                worst = max(worst, abs(got[l * (l + 1) + m] - want[int(m < 0), l, abs(m)]))
    print("rsh_eval against pyshtools: largest error %.1e, limit 1e-06" % worst)
    return worst < 1e-6


def check_rotation(lib, rng, rotations, table):
    good = True
    forms = ["rsh_rotate", "rsh_rotate_zxzxz", "rsh_rotate_ivanic"]
    for n in (10, 16):
        wigner, worst = spherical.Wigner(n - 1), dict.fromkeys(forms + ["rsh_rotate_many"], 0.0)
        matrices, ins, wants = [], [], []
        indices = [[[wigner.Dindex(l, a, b) for b in range(-l, l + 1)] for a in range(-l, l + 1)]
                  for l in range(n)]
        for _ in range(rotations):
            q = rng.normal(size=4)
            rotor = quaternionic.array(q / np.linalg.norm(q))
            r = np.ascontiguousarray(rotor.to_rotation_matrix, dtype=np.float32)
            v = rng.normal(size=n * n)
            v = (v / np.linalg.norm(v)).astype(np.float32)
            # The rotation is that of the float matrix; spherical ones use the
            # conjugate of its D.
            d = np.conj(wigner.D(quaternionic.array.from_rotation_matrix(r.astype(float))))
            c, rotated = complex_of(v, n), np.zeros(n * n, complex)
            for l in range(n):
                rotated[l * l:(l + 1) ** 2] = d[indices[l]] @ c[l * l:(l + 1) ** 2]
            want = real_of(rotated, n)
            for form in forms:
                got = np.zeros(n * n, np.float32)
                getattr(lib, form)(n, 1, pointer(r), pointer(v), pointer(got))
                worst[form] = max(worst[form], np.linalg.norm(got - want))
            matrices.append(r.ravel()), ins.append(v), wants.append(want)
        rows = [np.ascontiguousarray(column) for column in np.array(matrices).T]
        columns = (FLOATS * 9)(*[pointer(row) for row in rows])
        many_in, many_out = np.ascontiguousarray(np.array(ins).T), np.zeros_like(np.array(ins).T)
        many_out = np.ascontiguousarray(many_out)
        lib.rsh_rotate_many(n, 1, ctypes.c_size_t(rotations), columns, pointer(many_in),
                            pointer(many_out))
        worst["rsh_rotate_many"] = np.linalg.norm(many_out.T - np.array(wants), axis=1).max()
        for form, error in worst.items():
            print("%-18s order %2d  largest error %.1e, limit 3e-06" % (form, n, error))
            good &= bool(error < 3e-6)
            table.setdefault((f"`{form}`", "spherical"), {})[n] = f"{error:.2e}"
    return good


def main():
    lib, rng, table = ctypes.CDLL(sys.argv[1]), np.random.default_rng(5), {}
    good = check_basis(lib, rng, table)
    good &= check_pyshtools(lib, rng)
    good &= check_rotation(lib, rng, int(sys.argv[2]) if len(sys.argv) > 2 else 50, table)
    print("\n| what | oracle | order 10 | order 16 |\n|---|---|---|---|")
    for (what, oracle), cells in table.items():
        print(f"| {what} | {oracle} | {cells[10]} | {cells[16]} |")
    return 0 if good else 1


sys.exit(main())
