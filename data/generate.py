#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the scenes of data/scenes and their meshes: `data/generate.py` writes them in place,
`data/generate.py DIR` into another folder. The same bytes come out on every machine; a test
compares them with the committed files.

Lengths are metres, y is up, the eye looks along -z unless a scene says otherwise. Reflectances stay
at or below 0.8 where nature allows a choice, so that long light paths die out.
"""
import pathlib
import sys

import cases
import caustics
import figures
from parts import (area_light, box, camera_path, diffuse, element, lathe, number, plugin, real,
                   rectangle, ref, rgb, scene, sensor, sphere, to_world, translate, triple, tube,
                   value)

WHITE, RED, GREEN = (0.72, 0.70, 0.66), (0.60, 0.08, 0.06), (0.13, 0.42, 0.12)


def cornell(back_wall, *contents):
    """A box of 2 m, open to the eye, with coloured side walls and a light in the ceiling."""
    return [
        sensor((0, 1, 4.35), (0, 1, 0), 33),
        diffuse("white", *WHITE), diffuse("red", *RED), diffuse("green", *GREEN), back_wall,
        rectangle("+y", (0, 0, 0), (1, 1), ref("white")),
        rectangle("-y", (0, 2, 0), (1, 1), ref("white")),
        rectangle("+x", (-1, 1, 0), (1, 1), ref("red")),
        rectangle("-x", (1, 1, 0), (1, 1), ref("green")),
        rectangle("+z", (0, 1, -1), (1, 1), ref("back")),
        rectangle("-y", (0, 1.99, 0), (0.3, 0.3), ref("white"), area_light(14, 12.5, 10)),
        *contents,
    ]


def cornell_glossy():
    back = plugin("bsdf", "phong", rgb("diffuse_reflectance", 0.2, 0.2, 0.22),
                  rgb("specular_reflectance", 0.5, 0.5, 0.5), real("exponent", 22), id="back")
    return scene("Cornell box with a glossy back wall: Phong, exponent 22.", *cornell(
        back,
        box((-0.36, 0.6, -0.28), (0.28, 0.6, 0.28), 18, ref("white")),
        box((0.36, 0.3, 0.3), (0.28, 0.3, 0.28), -17, ref("white"))))


def metal(name, eta, k, tint):
    return plugin("bsdf", "roughconductor", value("string", "distribution", "ggx"),
                  real("alpha", 0.15), rgb("eta", *eta), rgb("k", *k),
                  rgb("specular_reflectance", *tint), id=name)


def cornell_metal():
    back = metal("back", (1.66, 0.88, 0.52), (9.22, 6.27, 4.84), (0.8, 0.8, 0.8))
    gold = metal("gold", (0.14, 0.37, 1.44), (3.98, 2.39, 1.60), (0.85, 0.85, 0.85))
    return scene("Cornell box with a back wall of rough aluminium and a sphere of rough gold\n"
                 "     (GGX, alpha 0.15).", *cornell(
                     back, gold,
                     box((-0.4, 0.45, -0.35), (0.28, 0.45, 0.28), 20, ref("white")),
                     sphere((0.38, 0.42, 0.2), 0.42, ref("gold"))))


def caustic():
    glass = plugin("bsdf", "dielectric", real("int_ior", 1.5), real("ext_ior", 1), id="glass")
    mirror = plugin("bsdf", "conductor", rgb("eta", 0.2, 0.92, 1.1), rgb("k", 3.91, 2.45, 2.14),
                    rgb("specular_reflectance", 0.95, 0.95, 0.95))
    return scene(
        "Caustics on a diffuse floor: the focus of a glass sphere and the cardioid inside an open\n"
        "     ring of polished copper. The ring has no thickness: no light may leak under it.",
        sensor((0, 3.1, 4), (-0.03, 0.2, -0.05), 30),
        diffuse("floor", 0.7, 0.68, 0.64), diffuse("wall", 0.42, 0.5, 0.6), glass,
        plugin("bsdf", "twosided", mirror, id="ring"),
        rectangle("+y", (0, 0, 0), (3, 3), ref("floor")),
        rectangle("+z", (0, 1.5, -3), (3, 1.5), ref("wall")),
        rectangle("+x", (-3, 1.5, 0), (3, 1.5), ref("wall")),
        rectangle("-x", (3, 1.5, 0), (3, 1.5), ref("wall")),
        sphere((-0.4, 0.5, -0.3), 0.5, ref("glass")),
        tube((0.6, 0, 0.25), 0.3, 0.55, ref("ring")),
        plugin("shape", "rectangle",
               to_world(element("scale", {"value": "0.45"}),
                        element("lookat", {"origin": "2.5, 2.2, 0.9", "target": "0, 0, 0",
                                           "up": "0, 1, 0"})),
               ref("wall"), area_light(33, 29.8, 24.7)))


def table(x, z, top, half):
    legs = [box((x + i * (half[0] - 0.05), (top - 0.04) / 2, z + k * (half[1] - 0.05)),
                (0.03, (top - 0.04) / 2, 0.03), 0, ref("wood")) for i in (-1, 1) for k in (-1, 1)]
    return [box((x, top - 0.02, z), (half[0], 0.02, half[1]), 0, ref("wood")), *legs]


def indirect_room():
    return scene(
        "A closed diffuse room. Its only light hangs in the middle and faces the ceiling:\n"
        "     everything that the eye sees is lit indirectly.",
        sensor((0.9, 1.45, 2.3), (-0.18, 1.02, -1.2), 62),
        diffuse("wall", 0.78, 0.74, 0.68), diffuse("ceiling", 0.8, 0.8, 0.8),
        diffuse("floor", 0.5, 0.38, 0.27), diffuse("accent", 0.25, 0.42, 0.5),
        diffuse("wood", 0.45, 0.28, 0.16), diffuse("cloth", 0.62, 0.22, 0.16),
        diffuse("pale", 0.75, 0.73, 0.7),
        rectangle("+y", (0, 0, 0), (2, 2.5), ref("floor")),
        rectangle("-y", (0, 2.7, 0), (2, 2.5), ref("ceiling")),
        rectangle("+x", (-2, 1.35, 0), (2.5, 1.35), ref("wall")),
        rectangle("-x", (2, 1.35, 0), (2.5, 1.35), ref("wall")),
        rectangle("+z", (0, 1.35, -2.5), (2, 1.35), ref("accent")),
        rectangle("-z", (0, 1.35, 2.5), (2, 1.35), ref("wall")),
        # A panel that hangs from the ceiling and lights it; its underside is dark.
        box((-0.1, 2.1, -0.5), (0.75, 0.015, 0.5), 0, ref("pale")),
        rectangle("+y", (-0.1, 2.117, -0.5), (0.72, 0.47), ref("pale"), area_light(7, 6.3, 5.4)),
        # A sofa, a low table with a lamp foot's sphere on it, a shelf, a rug.
        box((-1.45, 0.22, -0.9), (0.4, 0.22, 0.95), 0, ref("cloth")),
        box((-1.78, 0.55, -0.9), (0.12, 0.45, 0.95), 0, ref("cloth")),
        box((-1.4, 0.32, -1.9), (0.45, 0.32, 0.1), 0, ref("cloth")),
        box((-1.4, 0.32, 0.1), (0.45, 0.32, 0.1), 0, ref("cloth")),
        *table(0.0, -0.75, 0.45, (0.5, 0.35)),
        sphere((-0.12, 0.61, -0.82), 0.16, ref("pale")),
        box((0.22, 0.5, -0.68), (0.14, 0.05, 0.1), 25, ref("accent")),
        box((1.75, 0.5, -1.7), (0.25, 0.5, 0.7), 0, ref("wood")),
        sphere((1.72, 1.22, -1.9), 0.22, ref("cloth")),
        box((1.74, 1.2, -1.35), (0.12, 0.2, 0.12), 30, ref("pale")),
        box((-0.15, 0.01, -0.75), (0.9, 0.01, 0.9), 0, ref("pale")))


def two_rooms():
    """Rooms of x < 0 and of x > 0, with a doorway between them."""
    half = 0.06  # of the wall between them
    walls = []
    for side, name in ((-1, "wall"), (1, "accent")):
        walls += [
            rectangle("+y", (1.8 * side, 0, 0), (1.8, 2), ref("floor")),
            rectangle("-y", (1.8 * side, 2.6, 0), (1.8, 2), ref("ceiling")),
            rectangle("+x" if side < 0 else "-x", (3.6 * side, 1.3, 0), (2, 1.3), ref(name)),
            rectangle("+z", (1.8 * side, 1.3, -2), (1.8, 1.3), ref("wall")),
            rectangle("-z", (1.8 * side, 1.3, 2), (1.8, 1.3), ref("wall"))]
    walls += [box((0, 1.3, -1.275), (half, 1.3, 0.725), 0, ref("wall")),
              box((0, 1.3, 1.175), (half, 1.3, 0.825), 0, ref("wall")),
              box((0, 2.35, -0.1), (half, 0.25, 0.45), 0, ref("wall"))]
    gold = plugin("bsdf", "roughconductor", value("string", "material", "Au"),
                  real("alpha", 0.25), id="gold")
    return scene(
        "Two rooms and a doorway. The lamp of the first faces the ceiling, that of the second\n"
        "     faces a wall: all else is lit indirectly. two-rooms.toml walks through both.",
        sensor((-3.1, 1.5, 1.5), (-1.2, 1, -1), 70),
        diffuse("wall", 0.76, 0.73, 0.68), diffuse("ceiling", 0.8, 0.8, 0.8),
        diffuse("floor", 0.48, 0.38, 0.29), diffuse("accent", 0.3, 0.42, 0.5),
        diffuse("wood", 0.45, 0.28, 0.16), diffuse("cloth", 0.62, 0.22, 0.16), gold, *walls,
        box((-1.9, 2.0, 0.2), (0.5, 0.015, 0.4), 0, ref("wood")),
        rectangle("+y", (-1.9, 2.017, 0.2), (0.47, 0.37), ref("wood"), area_light(9, 8, 7),
                  id="lamp"),
        *table(-1.5, -1.3, 0.7, (0.6, 0.4)),
        sphere((-1.4, 0.92, -1.3), 0.22, ref("gold"), id="ball"),
        box((-3.1, 0.35, -0.4), (0.35, 0.35, 0.9), 0, ref("cloth")),
        box((3.2, 1.9, -1.2), (0.02, 0.25, 0.4), 0, ref("wood")),
        rectangle("+x", (3.222, 1.9, -1.2), (0.38, 0.23), ref("wood"), area_light(20, 21, 24)),
        *table(2.3, 0.9, 0.45, (0.5, 0.5)),
        box((2.3, 0.6, 0.9), (0.15, 0.15, 0.15), 30, ref("cloth"), id="crate"),
        box((1.2, 0.4, -1.7), (0.5, 0.4, 0.25), 0, ref("wood")),
        sphere((1.2, 1.0, -1.7), 0.2, ref("accent")))


def walk():
    return camera_path("60 frames through two-rooms.xml.",
                       (1, (-3.1, 1.5, 1.5), (-1.2, 1, -1)), (25, (-1.1, 1.5, 0), (1.5, 1.2, -0.6)),
                       (40, (0.3, 1.5, -0.1), (2.5, 0.9, -0.2)),
                       (60, (2.3, 1.5, -0.9), (2, 0.7, 1)))


def sphere_on_floor():
    floor = plugin("bsdf", "ward", value("string", "variant", "ward-duer"), real("alpha_u", 0.15),
                   real("alpha_v", 0.15), rgb("diffuse_reflectance", 0, 0, 0),
                   rgb("specular_reflectance", 0.9, 0.9, 0.9), id="floor")
    return scene(
        "A diffuse sphere on a Ward floor (rho_s 0.9, alpha 0.15, no diffuse lobe) between\n"
        "     coloured walls.",
        sensor((0, 1.35, 4.6), (0, 0.72, -0.2), 32),
        floor, diffuse("ball", 0.72, 0.45, 0.16), diffuse("wall", 0.62, 0.6, 0.56),
        diffuse("blue", 0.12, 0.24, 0.55), diffuse("plum", 0.5, 0.14, 0.3),
        rectangle("+y", (0, 0, 0), (1.6, 2), ref("floor")),
        rectangle("+z", (0, 1.25, -2), (1.6, 1.25), ref("wall")),
        rectangle("+x", (-1.6, 1.25, 0), (2, 1.25), ref("blue")),
        rectangle("-x", (1.6, 1.25, 0), (2, 1.25), ref("plum")),
        rectangle("-y", (0, 2.5, 0), (1.6, 2), ref("wall")),
        sphere((0, 0.62, -0.1), 0.62, ref("ball")),
        rectangle("-y", (0, 2.49, 0.3), (0.7, 0.5), ref("wall"), area_light(19, 17.5, 15)))


def vase():
    glaze = plugin("bsdf", "phong", rgb("diffuse_reflectance", 0.05, 0.2, 0.24),
                   rgb("specular_reflectance", 0.5, 0.52, 0.5), real("exponent", 7), id="glaze")
    tiles = plugin("bsdf", "diffuse",
                   plugin("texture", "checkerboard", rgb("color0", 0.66, 0.6, 0.5),
                          rgb("color1", 0.3, 0.2, 0.15),
                          element("transform", {"name": "to_uv"},
                                  element("scale", {"value": "10"})),
                          name="reflectance"), id="tiles")
    body = plugin("shape", "ply", value("string", "filename", "meshes/vase.ply"),
                  to_world(translate(0, 0, -0.2)), ref("glaze"))
    return scene(
        "A glazed vase, a body of revolution with Phong reflection (exponent 7), in a lit room.",
        sensor((0, 1.5, 4.3), (0, 0.86, -0.2), 33),
        glaze, tiles, diffuse("wall", 0.66, 0.62, 0.56), diffuse("warm", 0.66, 0.3, 0.14),
        diffuse("cool", 0.2, 0.36, 0.5),
        rectangle("+y", (0, 0, 0), (2, 2), ref("tiles")),
        rectangle("+z", (0, 1.3, -2), (2, 1.3), ref("wall")),
        rectangle("+x", (-2, 1.3, 0), (2, 1.3), ref("warm")),
        rectangle("-x", (2, 1.3, 0), (2, 1.3), ref("cool")),
        rectangle("-y", (0, 2.6, 0), (2, 2), ref("wall")),
        rectangle("-y", (-0.7, 2.59, 0.4), (0.5, 0.5), ref("wall"), area_light(24, 21.5, 18)),
        body)


def vase_mesh():
    outside = [(0.26, 0), (0.31, 0.04), (0.29, 0.1), (0.4, 0.35), (0.5, 0.65), (0.47, 0.95),
               (0.31, 1.25), (0.19, 1.47), (0.2, 1.62), (0.31, 1.76)]
    rim_and_inside = [(0.3, 1.78), (0.285, 1.76), (0.17, 1.62), (0.16, 1.47), (0.28, 1.22),
                      (0.44, 0.93), (0.46, 0.65), (0.36, 0.35), (0.1, 0.12), (0.001, 0.11)]
    return lathe(outside + rim_and_inside, 48, 3)


def furnace_box(rho):
    """Walls that emit 1 - rho and reflect rho: the radiance is 1 everywhere."""
    return scene(
        f"Closed box: every wall reflects {number(rho)} diffusely and emits {number(1 - rho)}. "
        "Exact: radiance 1 everywhere.",
        sensor((0.3, 0.2, 0.6), (-1, -0.4, -1), 70),
        diffuse("wall", rho, rho, rho),
        plugin("shape", "cube", value("boolean", "flip_normals", "true"), ref("wall"),
               area_light(1 - rho, 1 - rho, 1 - rho)))


def furnace_sphere(where, x):
    """A point light of 1 W/sr in a sphere of radius 1 and albedo 1/2."""
    exact = ("direct radiance 1/(2 pi), indirect 1/(2 pi), together 1/pi = 0.318310." if x == 0 else
             "indirect radiance 1/(2 pi) = 0.159155 everywhere; direct\n"
             "     radiance cos(theta) / (2 pi d^2), d and theta from the light to the wall.")
    light = plugin("emitter", "point", element("point", {"name": "position", "x": number(x),
                                                         "y": "0", "z": "0"}),
                   rgb("intensity", 1, 1, 1))
    return scene(
        f"Inside of a diffuse sphere of radius 1, albedo 0.5, point light of 1 W/sr {where} the\n"
        f"     centre. Exact: {exact}",
        sensor((0.2, 0.1, 0.7), (-0.1, 0, -1), 70),
        diffuse("wall", 0.5, 0.5, 0.5),
        sphere((0, 0, 0), 1, value("boolean", "flip_normals", "true"), ref("wall")), light)


def files():
    """Every file of data/scenes as {path: bytes}."""
    scenes = {"cornell-glossy": cornell_glossy(), "cornell-metal": cornell_metal(),
              "caustic": caustic(), "indirect-room": indirect_room(),
              "two-rooms": two_rooms(),
              "sphere-on-floor": sphere_on_floor(), "vase": vase(),
              "furnace-sphere-center": furnace_sphere("at", 0),
              "furnace-sphere-off": furnace_sphere("off", 0.5)}
    for percent in (20, 50, 80):
        scenes[f"furnace-box-{percent}"] = furnace_box(percent / 100)
    out = {f"{name}.xml": text.encode() for name, text in scenes.items()}
    out["two-rooms.toml"] = walk().encode()
    out["meshes/vase.ply"] = vase_mesh()
    out.update(cases.files())
    out.update(caustics.files())
    out.update(figures.files())
    return out


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else (
        pathlib.Path(__file__).resolve().parent / "scenes")
    for path, data in files().items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(data)


if __name__ == "__main__":
    main()
