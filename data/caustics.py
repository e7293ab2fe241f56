# SPDX-License-Identifier: Apache-2.0
"""Scenes whose light is mostly caustics: generate.py writes them to scenes/caustics.

The ground is at y = 0, and the water of the pool at y = 0 too.
"""
import math

from parts import (area_light, diffuse, element, lathe, number, ply, plugin, real, rectangle, ref,
                   rgb, scene, sensor, sphere, strips, to_world, translate, value)

# Waves of the pool: amplitude [m], wavelength [m], direction [degrees], phase [degrees].
WAVES = [(0.022, 1.3, 20, 0), (0.014, 0.8, 75, 130), (0.01, 0.55, -40, 50), (0.005, 0.34, 130, 200)]
POOL = (2.4, 1.2, 1.6)  # half width, depth, half length


def mesh(name, *children):
    return plugin("shape", "ply", value("string", "filename", f"meshes/{name}.ply"), *children)


def water_surface(columns=96, rows=64):
    vertices = []
    for j in range(rows + 1):
        for i in range(columns + 1):
            x, z = POOL[0] * (2 * i / columns - 1), POOL[2] * (2 * j / rows - 1)
            y = slope_x = slope_z = 0.0
            for amplitude, wavelength, direction, phase in WAVES:
                k = 2 * math.pi / wavelength
                a, b = (k * f(math.radians(direction)) for f in (math.cos, math.sin))
                angle = a * x + b * z + math.radians(phase)
                y += amplitude * math.sin(angle)
                slope_x += amplitude * a * math.cos(angle)
                slope_z += amplitude * b * math.cos(angle)
            length = math.hypot(slope_x, 1, slope_z)
            vertices.append((x, y, z, -slope_x / length, 1 / length, -slope_z / length))
    return ply(vertices, strips(rows + 1, columns + 1, False))


def pool():
    half_x, depth, half_z = POOL
    tiles = plugin("bsdf", "diffuse",
                   plugin("texture", "checkerboard", rgb("color0", 0.42, 0.66, 0.7),
                          rgb("color1", 0.33, 0.58, 0.65),
                          element("transform", {"name": "to_uv"},
                                  element("scale", {"x": "24", "y": "16"})), name="reflectance"),
                   id="tiles")
    sides = [("+x", (-half_x, -depth / 2, 0), (half_z, depth / 2)),
             ("-x", (half_x, -depth / 2, 0), (half_z, depth / 2)),
             ("+z", (0, -depth / 2, -half_z), (half_x, depth / 2)),
             ("-z", (0, -depth / 2, half_z), (half_x, depth / 2))]
    edge = 0.06  # from the water to the ground
    ground = [("+y", (side * (half_x + 1.5), edge, 0), (1.5, half_z + 3)) for side in (-1, 1)]
    ground += [("+y", (0, edge, side * (half_z + 1.5)), (half_x, 1.5)) for side in (-1, 1)]
    rim = [("+x", (-half_x, edge / 2, 0), (half_z, edge / 2)),
           ("-x", (half_x, edge / 2, 0), (half_z, edge / 2)),
           ("+z", (0, edge / 2, -half_z), (half_x, edge / 2)),
           ("-z", (0, edge / 2, half_z), (half_x, edge / 2))]
    return scene(
        "A pool in the sun: waves of its water focus the light on its floor and walls. Beneath\n"
        "     the water all light of the sun is caustic.",
        sensor((0.6, 2.6, 4.2), (-0.1, -0.55, 0), 46),
        plugin("bsdf", "dielectric", real("int_ior", 1.333), real("ext_ior", 1), id="water"), tiles,
        diffuse("paving", 0.6, 0.55, 0.47), diffuse("ball", 0.7, 0.25, 0.1),
        rectangle("+y", (0, -depth, 0), (half_x, half_z), ref("tiles")),
        *[rectangle(*s, ref("tiles")) for s in sides],
        *[rectangle(*s, ref("paving")) for s in ground + rim],
        sphere((0.9, -depth + 0.3, -0.5), 0.3, ref("ball")),
        mesh("water", ref("water")),
        plugin("emitter", "directional", rgb("irradiance", 3.2, 3, 2.6),
               element("vector", {"name": "direction", "x": "-0.5", "y": "-1", "z": "-0.35"})),
        plugin("emitter", "constant", rgb("radiance", 0.16, 0.22, 0.3)))


# The glass: heights of its foot, of the water in it and of its rim.
GLASS_FOOT, GLASS_WATER, GLASS_RIM = 0.012, 0.085, 0.13
GLASS_SIDES = 96


def inner_radius(y):
    return 0.029 + 0.09 * (y - GLASS_FOOT)


def water_in_glass():
    """Where water touches glass, from the axis up to the water's surface; normals point out of the
    water."""
    heights = [GLASS_FOOT + 0.003 + (GLASS_WATER - GLASS_FOOT - 0.003) * k / 4 for k in range(5)]
    return lathe([(0.0001, GLASS_FOOT), (0.02, GLASS_FOOT),
                  *((inner_radius(y), y) for y in heights)], GLASS_SIDES, 3)


def glass_in_air():
    """Where glass touches air, from the water's surface over the rim and outside down to the middle
    of the foot; normals point out of the glass."""
    inside = [GLASS_WATER + (GLASS_RIM - GLASS_WATER) * k / 3 for k in range(4)]
    profile = [(inner_radius(y), y) for y in inside]
    rim = inner_radius(GLASS_RIM)
    profile += [(rim + 0.0015, GLASS_RIM + 0.0012), (rim + 0.003, GLASS_RIM)]
    outside = [GLASS_RIM - (GLASS_RIM - 0.004) * k / 4 for k in range(1, 5)]
    profile += [(inner_radius(y) + 0.003, y) for y in outside]
    profile += [(0.028, 0.0005), (0.02, 0.0003), (0.0001, 0.0003)]
    return lathe(profile[::-1], GLASS_SIDES, 3)


WOOD = (256, 64)  # size of its image


def wood_image():
    """Boards along x, with stripes: a PPM."""
    width, height = WOOD
    pixels = bytearray()
    for j in range(height):
        board = j * 4 // height
        for i in range(width):
            x, y = i / width, (j * 4 / height) % 1
            warp = 0.35 * math.sin(2 * math.pi * x + 1.7 * board)
            rings = math.sin(9 * (y + warp * 0.3) * (1 + 0.2 * board) + 2 * board)
            stripes = math.sin(40 * y + 5 * math.sin(2 * math.pi * (x + 0.13 * board)))
            tone = 0.8 + 0.1 * rings + 0.06 * stripes - (0.35 if y < 0.06 else 0)
            pixels += bytes(round(255 * tone * c) for c in (0.82, 0.6, 0.38))
    return f"P6\n{width} {height}\n255\n".encode() + bytes(pixels)


def glass():
    surface = inner_radius(GLASS_WATER)
    wood = plugin("bsdf", "roughplastic", real("alpha", 0.15),
                  plugin("texture", "bitmap", value("string", "filename", "wood.ppm"),
                         name="diffuse_reflectance"), id="wood")
    return scene(
        "A glass of water on a table of varnished wood, in the light of a small lamp. Glass\n"
        "     touches air, water touches glass, and water touches air.",
        sensor((0.02, 0.2, 0.42), (0.015, 0.045, -0.01), 32),
        plugin("bsdf", "dielectric", real("int_ior", 1.5), real("ext_ior", 1), id="glass"),
        plugin("bsdf", "dielectric", real("int_ior", 1.333), real("ext_ior", 1.5), id="inside"),
        plugin("bsdf", "dielectric", real("int_ior", 1.333), real("ext_ior", 1), id="water"),
        wood, diffuse("wall", 0.5, 0.52, 0.55), diffuse("lamp", 0.5, 0.5, 0.5),
        rectangle("+y", (0, 0, 0), (0.5, 0.5), ref("wood")),
        rectangle("+z", (0, 0.25, -0.5), (0.5, 0.25), ref("wall")),
        mesh("glass", ref("glass")), mesh("water-in-glass", ref("inside")),
        plugin("shape", "disk",
               to_world(element("scale", {"value": number(surface)}),
                        element("rotate", {"x": "1", "angle": "-90"}),
                        translate(0, GLASS_WATER, 0)), ref("water")),
        sphere((-0.35, 0.4, -0.2), 0.025, ref("lamp"), area_light(260, 235, 190)),
        plugin("emitter", "constant", rgb("radiance", 0.09, 0.1, 0.12)))


def ring_mesh(radius=0.01, half_width=0.0008, half_height=0.003):
    """A band whose cross section is an ellipse."""
    sides = 16
    profile = [(radius + half_width * math.cos(2 * math.pi * k / sides),
                half_height * (1 + math.sin(2 * math.pi * k / sides))) for k in range(sides + 1)]
    return lathe(profile, 128, 2)


def ring():
    gold = plugin("bsdf", "conductor", rgb("eta", 0.14, 0.37, 1.44), rgb("k", 3.98, 2.39, 1.6),
                  id="gold")
    return scene(
        "A gold ring on paper, in the light of a small lamp: the caustic inside it is a cardioid.",
        sensor((0.004, 0.042, 0.05), (0, 0.002, 0.001), 33, real("near_clip", 0.001),
               real("far_clip", 10)),
        gold, diffuse("paper", 0.75, 0.73, 0.68), diffuse("lamp", 0.5, 0.5, 0.5),
        rectangle("+y", (0, 0, 0), (0.2, 0.2), ref("paper")),
        mesh("ring", ref("gold")),
        sphere((0.09, 0.06, -0.03), 0.004, ref("lamp"), area_light(480, 430, 350)),
        plugin("emitter", "constant", rgb("radiance", 0.12, 0.13, 0.15)))


def files():
    """Every file of scenes/caustics."""
    scenes = {"pool": pool(), "glass": glass(), "ring": ring()}
    out = {f"caustics/{name}.xml": text.encode() for name, text in scenes.items()}
    out["caustics/wood.ppm"] = wood_image()
    meshes = {"water": water_surface(), "glass": glass_in_air(),
              "water-in-glass": water_in_glass(), "ring": ring_mesh()}
    out.update({f"caustics/meshes/{name}.ply": data for name, data in meshes.items()})
    return out
