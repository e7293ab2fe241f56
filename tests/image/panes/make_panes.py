#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes waves.ply, a pane whose upper face has waves, and sky.exr, a sky with a sun in it, beside
this script. Needs `pip install OpenEXR numpy`."""
import math
import pathlib

import numpy as np
import OpenEXR

HERE = pathlib.Path(__file__).resolve().parent
CELLS = 12  # along a side
HALF, BOTTOM, TOP, WAVE = 1.3, 1.0, 1.05, 0.02


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
    head = ["ply", "format ascii 1.0", f"element vertex {len(vertex)}", "property float x",
            "property float y", "property float z", f"element face {2 * len(face)}",
            "property list uchar int vertex_indices", "end_header"]
    triangles = [f"3 {q[0]} {q[k]} {q[k + 1]}" for q in face for k in (1, 2)]
    (HERE / "waves.ply").write_text("\n".join(head + vertex + triangles) + "\n")


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
sky()
