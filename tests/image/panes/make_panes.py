#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes beside this script: waves.ply, a pane whose upper face has waves; bulb.ply and
filament.ply, the glass of a bulb with a neck, and a ring that glows; and sky.exr, a sky with a sun
in it. Needs `pip install OpenEXR numpy`."""
import math
import pathlib

import numpy as np
import OpenEXR

HERE = pathlib.Path(__file__).resolve().parent
CELLS = 12  # along a side
HALF, BOTTOM, TOP, WAVE = 1.3, 1.0, 1.05, 0.02


def write_mesh(name, properties, vertex, face):
    """Each quadrilateral of `face` as two triangles."""
    head = ["ply", "format ascii 1.0", f"element vertex {len(vertex)}"]
    head += [f"property float {p}" for p in properties.split()]
    head += [f"element face {2 * len(face)}", "property list uchar int vertex_indices",
             "end_header"]
    triangles = [f"3 {q[0]} {q[k]} {q[k + 1]}" for q in face for k in (1, 2)]
    (HERE / name).write_text("\n".join(head + vertex + triangles) + "\n")


def revolved(profile, sides, closed):
    """The surface that a profile of points (radius, z), with normals, makes around the axis:
    vertices, and faces that look to the left of the profile."""
    vertex, face = [], []
    count = len(profile)
    for r, z, nr, nz in profile:
        for i in range(sides):
            c, s = math.cos(2 * math.pi * i / sides), math.sin(2 * math.pi * i / sides)
            vertex.append(f"{r * c:.6f} {r * s:.6f} {z:.6f} {nr * c:.6f} {nr * s:.6f} {nz:.6f}")
    for k in range(count if closed else count - 1):
        for i in range(sides):
            a, b = k * sides, (k + 1) % count * sides
            j = (i + 1) % sides
            face.append([a + i, b + i, b + j, a + j])
    return vertex, face


def bulb_profile(inset, sign):
    """From the top of the bulb to its closed foot: a ball, a neck, and half a ball below it."""
    points = []
    ball, neck, foot = 0.3, 0.13, -0.6
    ball_end = math.acos(-0.7)  # where the ball passes into the neck
    for k in range(17):
        t = 1e-3 + (ball_end - 1e-3) * k / 16
        points.append((ball * math.sin(t), ball * math.cos(t), math.sin(t), math.cos(t)))
    r, z, nr, nz = points[-1]
    for k in range(1, 8):
        t = k / 8
        f = t * t * (3 - 2 * t)
        df = 6 * t * (1 - t)
        x, y = r + (neck - r) * f, z + (foot - z) * t
        dx, dy = (neck - r) * df, foot - z
        # Blends the normal of the ball into that of the neck.
        mx, my = -dy / math.hypot(dx, dy), dx / math.hypot(dx, dy)
        w = min(4 * t, 1)
        mx, my = w * mx + (1 - w) * nr, w * my + (1 - w) * nz
        points.append((x, y, mx / math.hypot(mx, my), my / math.hypot(mx, my)))
    for k in range(17):
        t = math.pi / 2 * k / 16 * 0.999
        points.append((neck * math.cos(t), foot - neck * math.sin(t), math.cos(t), -math.sin(t)))
    return [(r - inset * nr, z - inset * nz, sign * nr, sign * nz) for r, z, nr, nz in points]


def bulb():
    """Glass between two surfaces, .01 thick. The holes at its poles are 1e-3 of the radius wide."""
    outer, face = revolved(bulb_profile(0, 1), 24, False)
    inner, inside = revolved(bulb_profile(0.01, -1), 24, False)
    face += [[len(outer) + i for i in q[::-1]] for q in inside]
    write_mesh("bulb.ply", "x y z nx ny nz", outer + inner, face)


def filament():
    ring = []
    for k in range(12):
        c, s = math.cos(2 * math.pi * k / 12), math.sin(2 * math.pi * k / 12)
        ring.append((0.12 + 0.04 * c, -0.04 * s, c, -s))
    write_mesh("filament.ply", "x y z nx ny nz", *revolved(ring, 24, True))


def waves():
    """A closed box: its two faces, then the rim between them."""
    side = CELLS + 1
    vertex, face = [], []
    for top in (0, 1):
        for i in range(side):
            for j in range(side):
                x, y = (2 * HALF * k / CELLS - HALF for k in (i, j))
                z = TOP + WAVE * math.sin(5 * x + 1) * math.cos(4 * y) if top else BOTTOM
                vertex.append(f"{x:.5f} {y:.5f} {z:.5f}")
    for top in (0, side * side):
        for i in range(CELLS):
            for j in range(CELLS):
                a = top + i * side + j
                quad = [a, a + side, a + side + 1, a + 1]
                face.append(quad if top else quad[::-1])
    rim = ([i * side for i in range(CELLS)] + [CELLS * side + j for j in range(CELLS)] +
           [i * side + CELLS for i in range(CELLS, 0, -1)] + list(range(CELLS, 0, -1)))
    for a, b in zip(rim, rim[1:] + rim[:1]):
        face.append([a, b, b + side * side, a + side * side])
    write_mesh("waves.ply", "x y z", vertex, face)


def sky():
    """Brighter towards the horizon; the sun is 2 x 2 texels of 11 degrees, bright enough to bring
    about half of the light."""
    texel = np.zeros((16, 32, 3), np.float32)
    up = np.cos(math.pi * (np.arange(16) + 0.5) / 16)[:, None, None]
    texel[:] = np.array([0.6, 0.8, 1.2]) * (1.5 - up)
    texel[3:5, 8:10] = (30, 26, 20)
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage},
                 {"RGB": texel}).write(str(HERE / "sky.exr"))


waves()
bulb()
filament()
sky()
