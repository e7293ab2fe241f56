#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the constants of the harmonics as C, computed in double and rounded once to float.

usage: rsh_tables.py OUTPUT.c        (declarations and meanings stand in rsh_tables.h)
"""
import fractions
import functools
import math
import sys

ORDER = 16
LANES = 16
STEEP = 8
GENTLE, GENTLE_ROOTS = 10, 4
PAIR_STEPS = 3
# The m, whole or not, whose Legendre functions are the sets of rsh_mix: Chebyshev's polynomials of
# the second kind, and Gegenbauer's of 11 / 2.
MIXED = (fractions.Fraction(1, 2), fractions.Fraction(5))
BELOW = 0.1  # weight of the mirror image below the horizon, see rsh_tables.h
# Bands that are in one vector of lanes, see rsh_tables.h.
BAND_SETS = [[0, 1, 2, 3], [4, 5], [6, 7]] + [[l] for l in range(8, ORDER)]


def norm(l, m):
    """Factor of the monic Legendre function z^(l-m) + ... in Y_l^m (m >= 0), sqrt 2 included."""
    if l < m:
        return 0.0
    k = (2 * l + 1) * math.factorial(l - m) / (4 * math.pi * math.factorial(l + m))
    leading = math.factorial(2 * l) / (2**l * math.factorial(l) * math.factorial(l - m))
    return math.sqrt(k * (2 if m else 1)) * leading


def recurrence(l, m, number=float):
    """b in p_l = z p_(l-1) - b p_(l-2), for monic associated Legendre functions of one m."""
    return number((l - 1) ** 2 - m * m) / (4 * (l - 1) ** 2 - 1) if l >= m + 2 else number(0)


@functools.lru_cache(None)
def pole(l, m):
    """The monic Legendre function at z = 1."""
    if l <= m:
        return 1.0 if l == m else 0.0
    return pole(l - 1, m) - recurrence(l, m) * pole(l - 2, m)


def keep(l, m):
    """How much smaller the difference of two neighbours at the pole is than that of the first."""
    if l <= m + 1:
        return 1.0
    return keep(l - 1, m) * recurrence(l, m) * pole(l - 2, m) / pole(l, m)


def slope(l, m):
    """Entry (m, m - 1) of dR_y/dbeta at 0 in band l; entry (m - 1, m) is its negative."""
    if m in (0, -l):
        return 0.0
    if m == 1:
        return math.sqrt(l * (l + 1) / 2)
    return math.copysign(math.sqrt((l - m + 1) * (l + m)) / 2, m)


def d2_diagonal(l, m):
    """Entry (m, m) of the second derivative."""
    above = slope(l, m + 1) if m < l else 0.0
    return -(slope(l, m) ** 2 + above**2)


def wigner_quarter(l, a, b):
    """Wigner's d^l_ab(pi / 2): a sum of integers, so exact but for its factor."""
    f = math.factorial
    total = 0
    for s in range(max(0, b - a), min(l + b, l - a) + 1):
        term = f(2 * l)
        for k in (l + b - s, s, a - b + s, l - a - s):
            term //= f(k)
        total += (-1) ** (a - b + s) * term
    scale = f(l + a) * f(l - a) * f(l + b) * f(l - b)
    return math.sqrt(scale) * total / f(2 * l) / 2**l


def y_quarter(l, a, b):
    """Entry (a, b) of the rotation about y by +pi / 2 for real harmonics without phase."""
    if (a < 0) != (b < 0):
        return 0.0
    p, q = abs(a), abs(b)
    if p == 0 and q == 0:
        return wigner_quarter(l, 0, 0)
    if p == 0 or q == 0:
        return math.sqrt(2) * (-1) ** (p + q) * wigner_quarter(l, p, q)
    return (-1) ** p * ((-1) ** q * wigner_quarter(l, p, q)
                        + (1 if a > 0 else -1) * wigner_quarter(l, p, -q))


def z_quarter(m, quarters):
    """Rows (m, -m) of the rotation about z by quarters * pi / 2: {column: value}."""
    c, s = [(1, 0), (0, 1), (-1, 0), (0, -1)][(abs(m) * quarters) % 4]
    return {m: c} if m == 0 else {m: c, -m: -s if m > 0 else s}


@functools.lru_cache(None)
def swap(l, a, b):
    """Entry (a, b) of the exchange of y and z: R_z(-pi/2) R_y(pi/2) R_z(pi/2) after z -> -z."""
    total = 0.0
    for i, left in z_quarter(a, -1).items():
        for j in (b, -b) if b else (0,):
            right = z_quarter(j, 1).get(b, 0)
            if left and right:
                total += left * y_quarter(l, i, j) * right
    return total * (-1) ** (l + b)


def slots(bands):
    """The first lane of each band, the same in both halves."""
    result, lane = {}, 0
    for l in bands:
        result[l] = lane
        lane += l // 2 + 1
    assert lane <= LANES // 2
    return result


def layout(bands, inner):
    """(l, m) per lane, or None. Even m fill the lower half and odd m the upper; the inner layout
    exchanges the halves of odd l."""
    lanes, first = [None] * LANES, slots(bands)
    for l in bands:
        for m in range(l + 1):
            upper = (m + (l if inner else 0)) % 2
            lanes[8 * upper + first[l] + m // 2] = (l, m)
    return lanes


def index(l, m):
    return l * (l + 1) + m


def member(l, m, odd):
    """The m that the component which is even (0) or odd (1) in x keeps in lane |m|; None where it
    has none."""
    if odd and m == 0:
        return None
    return m if m % 2 == odd else -m


def steps(bands):
    return max(bands) // 2 + 1


class Writer:
    def __init__(self):
        self.lines = ["// Written by rsh_tables.py.", '#include "rsh/rsh_tables.h"', ""]

    def array(self, kind, head, values, storage=""):
        form = {"float": "%.9ef", "double": "%.17e"}.get(kind, "%d")
        text = [form % v for v in values]
        self.lines.append("%sconst %s %s = {" % (storage, kind, head))
        for i in range(0, len(text), 8):
            self.lines.append("    " + ", ".join(text[i:i + 8]) + ",")
        self.lines.append("};")


def plain_tables(w):
    grid = [(l, m) for m in range(ORDER) for l in range(ORDER)]
    w.array("float", "rsh_norm[RSH_MAX_ORDER * RSH_MAX_ORDER]", [norm(l, m) for l, m in grid])
    for kind, name in (("float", "rsh_recurrence"), ("double", "rsh_recurrence_d")):
        w.array(kind, name + "[RSH_MAX_ORDER * RSH_MAX_ORDER]", [recurrence(l, m) for l, m in grid])
    steep = [(l, m) for l, m in grid if m < STEEP]
    w.array("float", "rsh_pole[RSH_STEEP * RSH_MAX_ORDER]",
            [norm(l, m) * pole(l, m) for l, m in steep])
    w.array("float", "rsh_curvature[RSH_STEEP * RSH_MAX_ORDER]",
            [pole(l - 1, m) / (pole(l, m) * keep(l, m)) if l > m else 0.0 for l, m in steep])
    w.array("float", "rsh_keep[RSH_STEEP * RSH_MAX_ORDER]",
            [keep(l, m) if l > m else 0.0 for l, m in steep])
    flat = [(l, m) for l in range(ORDER) for m in range(-l, l + 1)]
    w.array("float", "rsh_slope[RSH_MAX_COEFFICIENTS + 2]",
            [slope(l, m) for l, m in flat] + [0.0, 0.0])
    w.array("float", "rsh_d2_diagonal[RSH_MAX_COEFFICIENTS]", [d2_diagonal(l, m) for l, m in flat])
    w.array("float", "rsh_swap[]", [swap(l, a, b) for l in range(ORDER)
                                    for a in range(-l, l + 1) for b in range(-l, l + 1)])
    quarter_tables(w, flat)
    ivanic_tables(w, flat)
    gentle_tables(w)
    mix_tables(w)


def gentle_tables(w):
    """Norms and roots of the Legendre functions of small orders, see rsh_tables.h."""
    norms, roots = [], []
    for m in range(GENTLE):
        for l in range(GENTLE):
            norms.append(norm(l, m))
            found = square_roots(monic(m)[l - m]) if l > m + 1 else []
            # The larger half as what is left to 1.
            found = [1 - r if i < len(found) // 2 else r for i, r in enumerate(found)]
            roots.append(braces("%.9ef", found + [0.0] * (GENTLE_ROOTS - len(found))))
    w.array("float", "rsh_gentle_norm[2 * RSH_GENTLE * RSH_GENTLE]",
            norms + [math.sqrt(2) * v for v in norms])
    w.lines.append("const float rsh_gentle_root[RSH_GENTLE * RSH_GENTLE][RSH_GENTLE_ROOTS] = {")
    w.lines += ["    %s," % row for row in roots] + ["};"]


def square_roots(polynomial):
    """The squares of the roots of an even or odd polynomial but 0, the largest first."""
    even = [float(c) for c in polynomial[(len(polynomial) - 1) % 2::2]]
    value = lambda t: functools.reduce(lambda sum, c: sum * t + c, reversed(even), 0.0)
    result, steps_in = [], 997  # no root is a multiple of 1 / 997
    for i in reversed(range(steps_in)):
        low, high = i / steps_in, (i + 1) / steps_in
        if value(low) * value(high) > 0:
            continue
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if value(low) * value(middle) <= 0 else (middle, high)
        result.append(0.5 * (low + high))
    assert len(result) == len(even) - 1
    return result


def monic(m):
    """Coefficients of the monic Legendre functions of one m, lowest power first, exact."""
    rows, one = [[fractions.Fraction(1)]], fractions.Fraction(0)
    for k in range(1, ORDER):
        b = recurrence(m + k, m, fractions.Fraction)
        before = rows[k - 2] if k > 1 else []
        rows.append([(rows[-1][i - 1] if i else one)
                     - (b * before[i] if i < len(before) else one) for i in range(k + 1)])
    return rows


def scales(m):
    """s_k, by which the monic functions of m are divided so that f_k = step z f_(k-1) - f_(k-2)."""
    b = [float(recurrence(m + k, m, fractions.Fraction)) for k in range(ORDER)]
    s = [1.0, math.sqrt(b[2])]
    for k in range(2, ORDER):
        s.append(b[k] * s[k - 2])
    return s


def mix_tables(w):
    """Y_(m+k)^m from the functions f_j of a set, see rsh_tables.h."""
    sets, steps_of = [], []
    for mixed in MIXED:
        f, s, rows = monic(mixed), scales(mixed), []
        for m in range(ORDER):
            p = monic(m)
            rows.append(pair([braces("%.9ef", mix_row(f, s, p[k], norm(m + k, m)))
                              for k in range(ORDER - m)]))
        sets.append(pair(rows))
        steps_of.append(braces("%.9ef", [0.0] + [s[k - 1] / s[k] / 2 for k in range(1, ORDER)]))
    w.lines.append("const float rsh_mix_step[2][RSH_MAX_ORDER] = %s;" % pair(steps_of))
    w.lines.append("const float rsh_mix[2][RSH_MAX_ORDER][RSH_MAX_ORDER][RSH_MAX_ORDER / 2] =\n"
                   "    %s;" % pair(sets))


def mix_row(f, s, polynomial, scale):
    """The factors of f_k, f_(k-2) .. in a polynomial of degree k times scale, lowest first."""
    rest, row = list(polynomial), [0.0] * (ORDER // 2)
    for j in range(len(rest) - 1, -1, -2):
        factor = rest[j]
        row[j // 2] = float(factor) * s[j] * scale
        for i, c in enumerate(f[j]):
            rest[i] -= factor * c
    return row


def quarter_tables(w, flat):
    """The rotation about x by 90 degrees, (x, y, z) -> (x, -z, y), by rows without its zeros: the
    exchange of y and z after which y is negated; and its transpose."""
    ends, columns, values, back = [], [], [], []
    for l, a in flat:
        for b in range(-l, l + 1):
            entry = swap(l, a, b)
            if abs(entry) > 1e-14:
                columns.append(b + l)
                values.append(-entry if a < 0 else entry)
                back.append(-entry if b < 0 else entry)
        ends.append(len(values))
    w.array("uint16_t", "rsh_quarter_end[RSH_MAX_COEFFICIENTS]", ends)
    w.array("uint8_t", "rsh_quarter_column[]", columns)
    w.array("float", "rsh_quarter[]", values)
    w.array("float", "rsh_quarter_back[]", back)


def ivanic_tables(w, flat):
    """u, v, w of Ivanic and Ruedenberg, without the factors that depend on the column alone."""
    rows, columns = [], []
    for l, m in flat:
        a, centre = abs(m), m == 0
        u = math.sqrt((l + m) * (l - m))
        sign = -1 if centre else 1
        v = sign * math.sqrt((2 if centre else 1) * max(l + a - 1, 0) * (l + a)) / 2
        third = 0.0 if centre else -math.sqrt(max((l - a - 1) * (l - a), 0)) / 2
        rows.append((u, v, third))
        d = (l + m) * (l - m) if a < l else 2 * l * (2 * l - 1)
        columns.append(1 / math.sqrt(d) if d else 1.0)
    w.lines.append("const float rsh_ivanic_row[RSH_MAX_COEFFICIENTS][3] = {")
    w.lines += ["    %s," % braces("%.9ef", row) for row in rows] + ["};"]
    w.array("float", "rsh_ivanic_column[RSH_MAX_COEFFICIENTS]", columns)


def lane_tables(w):
    """The tables of struct rsh_lane_set, and the steps of all sets."""
    rows, exchange = [], []
    for bands in BAND_SETS:
        outer, inner = layout(bands, False), layout(bands, True)
        first, last = bands[0] ** 2, (bands[-1] + 1) ** 2
        where = {None: 0}
        where.update({lm: i for i, lm in enumerate(outer) if lm})
        components = []
        for odd in (0, 1):
            own = [member(*lm, odd) if lm else None for lm in outer]
            components.append([index(lm[0], m) - first if m is not None else 31
                               for lm, m in zip(outer, own)])
        natural = []
        for k in range(first, first + 2 * LANES):
            l = math.isqrt(k)
            m = k - l * (l + 1)
            odd = k < last and member(l, abs(m), 0) != m
            natural.append(where[(l, abs(m))] + LANES * odd if k < last else 0)
        powers = [[lm[1] // 2 + 8 * (lm[1] % 2) if lm else 0 for lm in lanes]
                  for lanes in (outer, inner)]
        first_lane = slots(bands)
        sources = [[(first_lane[lm[0]] if lm else 0) + (i & 8) for i, lm in enumerate(target)]
                   for target in (inner, outer)]
        neighbours = [[where.get((lm[0], lm[1] + d), 0) if lm else 0 for lm in outer]
                      for d in (-1, 1)]
        texts = [braces("%d", r) for r in components] + [braces("%d", natural)]
        texts += [pair([braces("%d", r) for r in rs]) for rs in (powers, sources)]
        texts += [braces("%d", r) for r in neighbours]
        texts += [pair([braces("%.9ef", series_factors(outer, odd, kind)) for odd in (0, 1)])
                  for kind in ("down", "up", "d2_diagonal")]
        rows.append("    {%s,\n     %d, %d, %d}," % (",\n     ".join(texts), first, steps(bands),
                                                  len(exchange)))
        for t in range(steps(bands)):
            exchange.append([exchange_factors(bands, source, target, odd, t)
                             for source, target in ((outer, inner), (inner, outer))
                             for odd in (0, 1)])
    w.lines.append("const struct rsh_lane_set rsh_lane_sets[RSH_LANE_SETS] = {")
    w.lines += rows + ["};", "const struct rsh_lane_step rsh_lane_steps[] = {"]
    for factors in exchange:
        texts = [braces("%.9ef", r) for r in factors]
        w.lines.append("    {%s}," % pair([pair(texts[:2]), pair(texts[2:])]))
    w.lines.append("};")


def multiple(m, sine):
    """cos(m a), or sin(m a), without its odd powers of cos a and sin a: the factors of 1, t
    and t^2, t = cos 2 a; Chebyshev's polynomials of all four kinds."""
    odd = m % 2
    if sine:
        before, now = ([1, 0, 0], [1, 2, 0]) if odd else ([0, 0, 0], [2, 0, 0])
    else:
        before, now = [1, 0, 0], [-1 if odd else 0, 2 if odd else 1, 0]
    for _ in range(m // 2):
        before, now = now, [2 * a - b for a, b in zip([0] + now, before)]
    return before


def pair_vector(bands, first):
    """The rows of struct rsh_pair_lanes and its lanes, (l, m)."""
    lanes = [(l, s * m) for l in bands for m in range(1, l + 1) for s in (1, -1)]
    lanes += [(l, 0) for l in bands]
    where = {lm: i for i, lm in enumerate(lanes)}
    feeds = [[b for b in range(-l, l + 1) if abs(swap(l, a, b)) > 1e-14] for l, a in lanes]
    steps_of = [[(lm, f[t] if t < len(f) else None) for lm, f in zip(lanes, feeds)]
                for t in range(PAIR_STEPS)]
    texts = [braces("%d", [index(*lm) - first for lm in lanes])]
    texts.append(pair([braces("%d", [5 * j + abs(m) - 1 if m else 15 for _, m in lanes])
                       for j in range(3)]))
    texts.append(pair([braces("%d", [0 if b is None else where[l, b] for (l, _), b in step])
                       for step in steps_of]))
    texts.append(pair([braces("%.9ef", [0.0 if b is None else swap(l, m, b) for (l, m), b in step])
                       for step in steps_of]))
    texts += [braces("%d", [where.get((l, m + d), 0) for l, m in lanes]) for d in (-1, 1)]
    texts.append(braces("%.9ef", [slope(l, m) for l, m in lanes]))
    texts.append(braces("%.9ef", [-slope(l, m + 1) if m < l else 0.0 for l, m in lanes]))
    texts.append(braces("%.9ef", [d2_diagonal(l, m) for l, m in lanes]))
    return braces("%s", texts), lanes


def pair_tables(w):
    """The tables of orders up to 6."""
    rows = []
    for vectors, first in (([range(4)], 0), ([(2, 5), (3, 4)], 4)):
        natural, texts = [0] * (2 * LANES), []
        for v, bands in enumerate(vectors):
            text, lanes = pair_vector(bands, first)
            texts.append(text)
            for i, lm in enumerate(lanes):
                natural[index(*lm) - first] = i + LANES * v
        rows.append(braces("%s", [pair(texts), braces("%d", natural)]))
    w.lines.append("const struct rsh_pair_set rsh_pair_sets[2] = %s;" % pair(rows))
    ms = [1, 2, 3, 4, 5] * 3 + [0]
    texts = [pair([braces("%.1ff", [multiple(m, sine)[power] for m in ms]) for power in range(3)])
             for sine in (False, True)]
    w.lines.append("const struct rsh_pair_multiples rsh_pair_multiples = %s;" % pair(texts))


def series_factors(outer, odd, kind):
    """For one component: entries of D from the neighbours |m| - 1 and |m| + 1, and the diagonal of
    D^2."""
    factors = []
    for lm in outer:
        m = member(*lm, odd) if lm else None
        if m is None:
            factors.append(0.0)
            continue
        l = lm[0]
        below = slope(l, m)                                    # of m - 1
        above = -slope(l, m + 1) if m < l else 0.0             # of m + 1
        if kind == "d2_diagonal":
            factors.append(-(below**2 + above**2))
        else:
            factors.append(below if (kind == "down") == (m >= 0) else above)
    return factors


def exchange_factors(bands, source, target, odd, t):
    """Factors of step t of one exchange of one component. Step t takes the t-th lane of the band in
    the half that feeds it: its own half for the even component, the other for the odd one."""
    factors, first = [], slots(bands)
    for i, lm in enumerate(target):
        lane = ((i & 8) ^ (8 * odd)) + (first[lm[0]] + t if lm else 0)
        feed = source[lane] if lm and t <= lm[0] // 2 else None
        a = member(*lm, odd) if lm else None
        b = member(*feed, odd) if feed else None
        factors.append(swap(lm[0], a, b) if a is not None and b is not None else 0.0)
    return factors


def braces(form, row):
    return "{" + ", ".join(form % v for v in row) + "}"


def gauss(count):
    """Nodes and weights of Gauss and Legendre on 0 .. 1."""
    result = []
    for i in range(count):
        x = math.cos(math.pi * (i + 0.75) / (count + 0.5))
        for _ in range(30):
            p, p1 = 1.0, 0.0
            for l in range(1, count + 1):
                p, p1 = ((2 * l - 1) * x * p - (l - 1) * p1) / l, p
            slope_here = count * (x * p - p1) / (x * x - 1)
            x -= p / slope_here
        result.append((0.5 * (x + 1), 1 / ((1 - x * x) * slope_here**2)))
    return result


def meridian(m, z, sine):
    """Norm times Legendre function times sine^m for l = m .. ORDER - 1: Y without its azimuth."""
    values, p, p1 = [], 1.0, 0.0
    for l in range(m, ORDER):
        if l > m:
            p, p1 = z * p - recurrence(l, m) * p1, p
        values.append(norm(l, m) * p * sine**m)
    return values


def overlaps(m, nodes):
    """Integrals over the upper hemisphere of Y Y and of H Y, each [l - m][l' - m]. With z = t^2 the
    integrands are smooth."""
    size = ORDER - m
    yy = [[0.0] * size for _ in range(size)]
    hy = [[0.0] * size for _ in range(size)]
    for t, weight in nodes:
        z = t * t
        w = weight * 2 * t * math.pi * (1 if m else 2)
        y = meridian(m, z, math.sqrt(1 - z * z))
        h = [math.sqrt(2) * v for v in meridian(m, 2 * z - 1, 2 * math.sqrt(z * (1 - z)))]
        for a in range(size):
            for b in range(size):
                yy[a][b] += w * y[a] * y[b]
                hy[a][b] += w * h[a] * y[b]
    return yy, hy


def solve(matrix, right):
    """matrix^-1 right for a positive definite matrix."""
    rows = [list(a) + list(b) for a, b in zip(matrix, right)]
    size = len(rows)
    for i in range(size):
        rows[i] = [v / rows[i][i] for v in rows[i]]
        for k in range(size):
            if k != i:
                factor = rows[k][i]
                rows[k] = [u - factor * v for u, v in zip(rows[k], rows[i])]
    return [row[size:] for row in rows]


def extension(order, integrals):
    """Per m the matrix [l' - m][l - m] from H of `order` to Y of order + 2, see rsh_tables.h."""
    larger, result = min(order + 2, ORDER), []
    for m in range(order):
        yy, hy = integrals[m]
        below = lambda a, b: BELOW * (-1) ** (a + b)
        size = larger - m
        left = [[yy[a][b] * (1 + below(a, b)) for b in range(size)] for a in range(size)]
        right = [[hy[b][a] * (1 + BELOW * (-1) ** a) for b in range(order - m)]
                 for a in range(size)]
        result.append(solve(left, right))
    return result


def rows_of(blocks, outputs, inputs):
    """The layout of struct rsh_rows: low then high."""
    def entry(o, i, m):
        return blocks[m][o - m][i - m] if m <= min(o, i) else 0.0
    low = [entry(o, i, m) for o in range(outputs) for i in range(inputs) for m in range(8)]
    high = [entry(o, i, m) for o in range(8, outputs) for i in range(8, inputs)
            for m in range(8, 16)]
    return low, high


def hemisphere_tables(w):
    nodes = gauss(48)
    integrals = [overlaps(m, nodes) for m in range(ORDER)]
    names = []
    tables = [(extension(n, integrals), min(n + 2, ORDER), n) for n in range(1, ORDER + 1)]
    tables.append(([hy for _, hy in integrals], ORDER, ORDER))
    for k, (blocks, outputs, inputs) in enumerate(tables):
        low, high = rows_of(blocks, outputs, inputs)
        w.array("float", "low_%d[]" % k, low, "static ")
        if high:
            w.array("float", "high_%d[]" % k, high, "static ")
        names.append("{low_%d, %s, %d, %d}" % (k, "high_%d" % k if high else "0", outputs, inputs))
    w.lines.append("const struct rsh_rows rsh_extension[RSH_MAX_ORDER] = {\n    %s};"
                   % ",\n    ".join(names[:-1]))
    w.lines.append("const struct rsh_rows rsh_restriction = %s;" % names[-1])


def pair(rows):
    return "{" + ",\n     ".join(rows) + "}"


def main():
    w = Writer()
    plain_tables(w)
    lane_tables(w)
    pair_tables(w)
    hemisphere_tables(w)
    with open(sys.argv[1], "w") as f:
        f.write("\n".join(w.lines) + "\n")


main()
