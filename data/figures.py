# SPDX-License-Identifier: Apache-2.0
"""Scenes of the figures that compare ways to distribute records: generate.py writes them to
scenes/figures, bench/fig_*.py render them. They are like those of the thesis that the figures are
numbered after, with geometry of their own, and as many bounces: one indirect on the metal floor,
four of teapot and hall.
"""
import math

from parts import (area_light, box, camera_path, curtain, diffuse, element, lathe, plugin, ply,
                   real, rectangle, ref, rgb, scene, sensor, sphere, sweep, to_world, translate,
                   value)

WHITE = diffuse("white", 0.7, 0.68, 0.64)
# A brushed metal in three lobes: sharp, broad, almost diffuse.
LOBES = ("-1 -1 1 24 1.5 1.45 1.35  -0.98 -0.98 1 7 0.3 0.29 0.27  "
         "-0.95 -0.95 0.9 2 0.05 0.05 0.05")


def metal(name):
    return plugin("bsdf", "lafortune", rgb("diffuse_reflectance", 0, 0, 0),
                  value("string", "lobes", LOBES), id=name)


def mesh(filename, *children):
    return plugin("shape", "ply", value("string", "filename", filename), *children)


def open_box(floor, back="white"):
    """A room of 2 m that is open to the eye, lit from its ceiling."""
    return [diffuse("red", 0.6, 0.08, 0.06), diffuse("green", 0.13, 0.42, 0.12), WHITE,
            rectangle("+y", (0, 0, 0), (1, 1), ref(floor)),
            rectangle("-y", (0, 2, 0), (1, 1), ref("white")),
            rectangle("+x", (-1, 1, 0), (1, 1), ref("red")),
            rectangle("-x", (1, 1, 0), (1, 1), ref("green")),
            rectangle("+z", (0, 1, -1), (1, 1), ref(back)),
            rectangle("-y", (0, 1.99, 0), (0.35, 0.35), ref("white"), area_light(12, 11, 9))]


def cornell():
    back = plugin("bsdf", "phong", rgb("diffuse_reflectance", 0.2, 0.2, 0.22),
                  rgb("specular_reflectance", 0.5, 0.5, 0.5), real("exponent", 22), id="back")
    return scene("Two boxes in a room with a glossy back wall (Phong, exponent 22); cornell.toml "
                 "goes from one view to another.",
                 sensor((0, 1, 4.35), (0, 1, 0), 33), back, *open_box("white", "back"),
                 box((-0.36, 0.6, -0.28), (0.28, 0.6, 0.28), 18, ref("white")),
                 box((0.36, 0.3, 0.3), (0.28, 0.3, 0.28), -17, ref("white")), depth=3)


def cornell_path():
    return camera_path("180 frames between two views of cornell.xml.",
                       (1, (0, 1, 4.35), (0, 1, 0)), (180, (0.75, 1.1, 2.6), (-0.1, 0.9, -1)))


def box_pyramid():
    return scene("A box and a pyramid on a floor of metal (Lafortune, three lobes).",
                 sensor((0, 1.75, 3), (0, 0.4, -0.1), 36), metal("metal"), *open_box("metal"),
                 box((-0.4, 0.35, -0.3), (0.25, 0.35, 0.25), 22, ref("white")),
                 mesh("pyramid.ply", to_world(element("rotate", {"y": "1", "angle": "-15"}),
                                              translate(0.4, 0, 0.15)), ref("white")),
                 depth=3)


def pyramid_mesh(half=0.34, height=0.65):
    foot = [(-half, 0, half), (half, 0, half), (half, 0, -half), (-half, 0, -half)]
    length = math.hypot(half, height)
    vertices = []
    for k in range(4):
        (x0, _, z0), (x1, _, z1) = foot[k], foot[(k + 1) % 4]
        outward = ((x0 + x1) / 2 * height / half / length, half / length,
                   (z0 + z1) / 2 * height / half / length)
        vertices += [(*p, *outward) for p in (foot[k], foot[(k + 1) % 4], (0, height, 0))]
    return ply(vertices, [(i, i + 1, i + 2) for i in range(0, 12, 3)])


def teapot():
    glaze = plugin("bsdf", "phong", rgb("diffuse_reflectance", 0.2, 0.08, 0.05),
                   rgb("specular_reflectance", 0.55, 0.55, 0.52), real("exponent", 16), id="glaze")
    both = plugin("bsdf", "twosided", ref("glaze"), id="both")
    pose = to_world(element("rotate", {"y": "1", "angle": "-25"}))
    return scene("A glazed teapot (Phong, exponent 16) on a table, in a lit room.",
                 sensor((0.1, 1.15, 2.6), (0.08, 0.42, 0), 40), glaze, both, WHITE,
                 diffuse("table", 0.5, 0.42, 0.32), diffuse("blue", 0.15, 0.25, 0.5),
                 diffuse("rust", 0.55, 0.25, 0.12),
                 rectangle("+y", (0, 0, 0), (2, 2), ref("table")),
                 rectangle("+z", (0, 1.2, -1.6), (2, 1.2), ref("white")),
                 rectangle("+x", (-1.6, 1.2, 0), (2, 1.2), ref("rust")),
                 rectangle("-x", (1.6, 1.2, 0), (2, 1.2), ref("blue")),
                 rectangle("-z", (0, 1.2, 3), (2, 1.2), ref("white")),
                 rectangle("-y", (0, 2.4, 0), (2, 3.2), ref("white")),
                 *[mesh(f"teapot-{part}.ply", pose, ref("both"))
                   for part in ("body", "spout", "handle")],
                 rectangle("-y", (-0.5, 2.39, 0.6), (0.45, 0.45), ref("white"),
                           area_light(19, 17.5, 15)), depth=6)


def teapot_meshes():
    body = [(0.28, 0), (0.36, 0.05), (0.47, 0.22), (0.5, 0.4), (0.42, 0.58), (0.3, 0.68),
            (0.29, 0.7), (0.2, 0.76), (0.08, 0.8), (0.05, 0.84), (0.07, 0.89), (0.001, 0.92)]
    spout = [(0.36, 0.22, 0.13), (0.56, 0.26, 0.1), (0.68, 0.4, 0.07), (0.76, 0.58, 0.05),
             (0.86, 0.68, 0.045)]
    handle = [(-0.42, 0.56, 0.035), (-0.62, 0.6, 0.035), (-0.74, 0.5, 0.035),
              (-0.68, 0.3, 0.035), (-0.45, 0.18, 0.035)]
    return {"teapot-body.ply": lathe(body, 48, 3), "teapot-spout.ply": sweep(spout, 24, 5),
            "teapot-handle.ply": sweep(handle, 16, 5)}


def flamingo():
    metal = plugin("bsdf", "phong", rgb("diffuse_reflectance", 0.05, 0.03, 0.03),
                   rgb("specular_reflectance", 0.8, 0.62, 0.55), real("exponent", 7), id="metal")
    return scene("A flamingo of metal (Phong, exponent 7) in a room of coloured walls; "
                 "flamingo.toml walks around it.",
                 sensor((1.2, 1.3, 3), (0, 0.95, 0), 45), metal,
                 plugin("bsdf", "twosided", ref("metal"), id="both"), WHITE,
                 diffuse("floor", 0.5, 0.42, 0.32), diffuse("blue", 0.15, 0.25, 0.5),
                 diffuse("rust", 0.55, 0.25, 0.12), diffuse("leaf", 0.2, 0.42, 0.16),
                 rectangle("+y", (0, 0, 0), (3, 3), ref("floor")),
                 rectangle("-y", (0, 3, 0), (3, 3), ref("white")),
                 rectangle("+z", (0, 1.5, -3), (3, 1.5), ref("leaf")),
                 rectangle("-z", (0, 1.5, 3.5), (3, 1.5), ref("white")),
                 rectangle("+x", (-3, 1.5, 0), (3.5, 1.5), ref("rust")),
                 rectangle("-x", (3, 1.5, 0), (3.5, 1.5), ref("blue")),
                 box((-1.1, 0.25, -1.2), (0.4, 0.25, 0.4), 25, ref("white")),
                 mesh("flamingo-body.ply", ref("both")),
                 *[mesh("flamingo-leg.ply", to_world(translate(-0.02, 0, z)), ref("both"))
                   for z in (-0.08, 0.08)],
                 rectangle("-y", (-0.6, 2.99, 0.8), (0.6, 0.6), ref("white"),
                           area_light(16, 15, 13)), depth=6)


def flamingo_meshes():
    body = [(-0.62, 0.62, 0.004), (-0.52, 0.7, 0.05), (-0.35, 0.79, 0.14), (-0.12, 0.84, 0.2),
            (0.1, 0.86, 0.19), (0.26, 0.92, 0.12), (0.36, 1.05, 0.065), (0.38, 1.2, 0.048),
            (0.31, 1.34, 0.042), (0.21, 1.47, 0.04), (0.19, 1.6, 0.042), (0.27, 1.71, 0.05),
            (0.38, 1.72, 0.06), (0.47, 1.66, 0.045), (0.52, 1.58, 0.026), (0.53, 1.51, 0.004)]
    leg = [(0, 0.7, 0.045), (0.03, 0.5, 0.022), (-0.01, 0.36, 0.026), (0.02, 0.2, 0.018),
           (0.02, 0.02, 0.02), (0.06, 0.012, 0.012)]
    return {"flamingo-body.ply": sweep(body, 48, 6), "flamingo-leg.ply": sweep(leg, 16, 4)}


def flamingo_path():
    return camera_path("280 frames around flamingo.xml.", (1, (2.3, 1.6, 2.9), (0, 0.9, 0)),
                       (140, (0.5, 1.3, 1.7), (0.05, 1, 0)), (280, (-1.5, 1.1, 1.4), (0, 1.1, 0)))


def hall():
    sheets = plugin("bsdf", "twosided", metal("metal"), id="sheets")
    steps = [box((0.6, 0.15 * (i + 0.5), 1.2 - 0.5 * i), (2.6, 0.15 * (i + 0.5), 0.25), 0,
                 ref("stone")) for i in range(5)]
    return scene("A hall of curved metal sheets under sun and sky, with steps to its entrance.",
                 sensor((-2.5, 2.2, 14), (0.8, 3.9, -2), 46), sheets,
                 diffuse("stone", 0.5, 0.46, 0.4),
                 diffuse("town", 0.3, 0.22, 0.16), diffuse("plaster", 0.6, 0.58, 0.54),
                 rectangle("+y", (0, 0, 0), (40, 40), ref("stone")),
                 rectangle("+x", (-25, 4, 0), (40, 4), ref("town")),
                 rectangle("-x", (25, 4, 0), (40, 4), ref("town")),
                 rectangle("-z", (0, 4, 30), (40, 4), ref("town")),
                 box((1, 2.5, -8), (5, 2.5, 2), 0, ref("plaster")), *steps,
                 *[mesh(f"hall-{part}.ply", ref("sheets")) for part in ("left", "right", "prow")],
                 plugin("emitter", "directional",
                        element("vector", {"name": "direction", "x": "-0.5", "y": "-0.75",
                                           "z": "-0.45"}), rgb("irradiance", 2.6, 2.4, 2)),
                 plugin("emitter", "constant", rgb("radiance", 0.25, 0.36, 0.55)), depth=6)


def hall_meshes():
    def flat(height):
        return lambda _: height

    left = curtain([(-7, -7), (-6.5, -3), (-4.5, -0.5), (-3, 1.5), (-3.4, 3.2)], flat(0),
                   lambda t: 8 - 2.5 * t + 0.9 * math.sin(3 * t), 6, 8)
    right = curtain([(3.5, 2.5), (3.6, 0.5), (5, -1.5), (7.5, -2.6), (9, -5)], flat(0),
                    lambda t: 5 + 3.2 * t, 6, 8)
    prow = curtain([(-2.6, -3.6), (-1, -2), (1, -1.6), (2.8, -2.6), (4, -4.6)], flat(2.6),
                   lambda t: 8.4 - 5 * (t - 0.4)**2, 6, 8)
    return {"hall-left.ply": left, "hall-right.ply": right, "hall-prow.ply": prow}


def steps():
    flight = [box((0, 0.03 * (i + 1), -0.6 - 0.3 * i), (1.2, 0.03 * (i + 1), 0.15), 0, ref("ochre"))
              for i in range(6)]
    return scene("A flight of low steps in a hall, lit from in front along the floor.",
                 sensor((0.9, 1.7, 3.6), (0.1, 0.5, -1.4), 52), WHITE,
                 diffuse("ochre", 0.75, 0.5, 0.2), diffuse("slate", 0.22, 0.24, 0.28), *flight,
                 rectangle("+y", (0, 0, 0), (4, 4), ref("slate")),
                 rectangle("-y", (0, 3, 0), (4, 4), ref("white")),
                 rectangle("+x", (-3, 1.5, 0), (4, 1.5), ref("white")),
                 rectangle("-x", (3, 1.5, 0), (4, 1.5), ref("white")),
                 rectangle("+z", (0, 1.5, -3), (3, 1.5), ref("white")),
                 rectangle("-z", (0, 1.5, 4), (3, 1.5), ref("white")),
                 rectangle("-z", (0, 0.4, 3.98), (1.2, 0.3), ref("white"), area_light(12, 11, 9)))


def ward_floor():
    floor = plugin("bsdf", "ward", value("string", "variant", "ward-duer"),
                   value("float", "alpha_u", "$alpha"), value("float", "alpha_v", "$alpha"),
                   rgb("diffuse_reflectance", 0, 0, 0), rgb("specular_reflectance", 0.9, 0.9, 0.9),
                   id="floor")
    return scene("A few objects on a Ward floor (Ward-Duer, rho_s 0.9): `-D alpha=0.3` sets how "
                 "rough.",
                 element("default", {"name": "alpha", "value": "0.3"}),
                 sensor((0, 1.75, 3), (0, 0.4, -0.1), 36), floor, *open_box("floor"),
                 diffuse("ochre", 0.65, 0.42, 0.12),
                 box((-0.45, 0.4, -0.35), (0.25, 0.4, 0.25), 18, ref("white")),
                 sphere((0.4, 0.32, -0.25), 0.32, ref("ochre")),
                 box((0.05, 0.12, 0.4), (0.2, 0.12, 0.12), -30, ref("white")))


def files():
    """Every file of scenes/figures as {path: bytes}."""
    scenes = {"cornell": cornell(), "box-pyramid": box_pyramid(), "teapot": teapot(),
              "flamingo": flamingo(), "hall": hall(), "ward-floor": ward_floor(), "steps": steps()}
    out = {f"{name}.xml": text.encode() for name, text in scenes.items()}
    out["cornell.toml"] = cornell_path().encode()
    out["flamingo.toml"] = flamingo_path().encode()
    out.update(flamingo_meshes())
    out["pyramid.ply"] = pyramid_mesh()
    out.update(teapot_meshes())
    out.update(hall_meshes())
    return {f"figures/{name}": data for name, data in out.items()}
