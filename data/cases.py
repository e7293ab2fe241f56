# SPDX-License-Identifier: Apache-2.0
"""Scenes of what caches of indirect light get wrong, each with one trap: generate.py writes them to
scenes/cases, tests/image/cases.c evaluates pictures of them.

Rooms are built around the origin, the floor at y = 0. Walls face inside and are black outside.
"""
import math
import struct

from parts import (area_light, box, diffuse, element, number, plugin, real, rectangle, ref, rgb,
                   scene, sensor, sphere, to_world, value)

PAINT = [diffuse("white", 0.7, 0.7, 0.7), diffuse("warm", 0.6, 0.4, 0.28),
         diffuse("cool", 0.25, 0.4, 0.55), diffuse("floor", 0.5, 0.48, 0.44)]


def room(half_x, height, half_z, floor="floor", open_front=False):
    """A closed room; open to +z if open_front."""
    walls = [
        rectangle("+y", (0, 0, 0), (half_x, half_z), ref(floor)),
        rectangle("-y", (0, height, 0), (half_x, half_z), ref("white")),
        rectangle("+x", (-half_x, height / 2, 0), (half_z, height / 2), ref("warm")),
        rectangle("-x", (half_x, height / 2, 0), (half_z, height / 2), ref("cool")),
        rectangle("+z", (0, height / 2, -half_z), (half_x, height / 2), ref("white"))]
    front = rectangle("-z", (0, height / 2, half_z), (half_x, height / 2), ref("white"))
    return walls if open_front else walls + [front]


def lamp(facing, centre, half, *radiance):
    return rectangle(facing, centre, half, ref("white"), area_light(*radiance))


def sheet(facing, centre, half, name="sheet"):
    """A two-sided diffuse plane without thickness; its BRDF is SHEET."""
    return rectangle(facing, centre, half, ref(name))


SHEET = plugin("bsdf", "twosided", plugin("bsdf", "diffuse", rgb("reflectance", 0.6, 0.58, 0.5)),
               id="sheet")

SPOT_HEIGHT, SPOT_DEGREES, SPOT_INTENSITY = 2.9, 1, 4000


def spot(light):
    return [sensor((0, 1.6, 2.4), (0, 0.7, -1), 75), *PAINT, *room(2.5, 3, 2.5),
            box((-0.9, 0.4, -0.8), (0.4, 0.4, 0.4), 20, ref("white")), *light]


def spot_beam():
    beam = plugin("emitter", "spot",
                  to_world(element("lookat", {"origin": "0.3, 0.1, 0.2", "target": "0.3, 3, 0.2",
                                              "up": "0, 0, 1"})),
                  rgb("intensity", *[SPOT_INTENSITY] * 3), real("cutoff_angle", SPOT_DEGREES),
                  real("beam_width", 0.999 * SPOT_DEGREES))
    return scene(
        "All light of the room comes from a spot of 10 cm on its ceiling, which a beam two\n"
        "     degrees wide makes.", *spot([beam]))


def spot_disk():
    """The ceiling's radiance is reflectance / pi * intensity / height^2 where the beam reaches."""
    radius = SPOT_HEIGHT * math.tan(math.radians(SPOT_DEGREES))
    radiance = 0.7 / math.pi * SPOT_INTENSITY / SPOT_HEIGHT**2
    disk = plugin("shape", "disk",
                  to_world(element("scale", {"value": number(radius)}),
                           element("rotate", {"x": "1", "angle": "90"}),
                           element("translate", {"x": "0.3", "y": "2.9999", "z": "0.2"})),
                  ref("white"), area_light(*[radiance] * 3))
    return scene(
        "The room of spot.xml where a lamp takes the place of the spot on the ceiling: a path\n"
        "     tracer finds its light at once.", *spot([disk]))


def corner():
    return scene("A corner where three walls meet, in a room whose lamp faces the ceiling.",
                 sensor((0.9, 1.5, 0.9), (-2, 0.15, -2), 50), *PAINT, *room(2, 2.6, 2),
                 lamp("+y", (0.6, 2.1, 0.6), (0.4, 0.4), 14, 13, 11))


def thin_wall():
    return scene("A wall without thickness between a bright room and one that is 100 times darker.",
                 sensor((0, 1.25, 5.2), (0, 1.25, 0), 36), *PAINT, SHEET,
                 *room(2, 2.5, 1.5, open_front=True),
                 sheet("+x", (0, 1.25, 0), (1.5, 1.25)),
                 lamp("-y", (-1, 2.45, 0), (0.4, 0.4), 20, 20, 20),
                 lamp("-y", (1, 2.45, 0), (0.4, 0.4), 0.2, 0.2, 0.2))


def backlit():
    return scene("A screen without thickness that a lamp behind it lights: its front sees what "
                 "the\n     room sends back.",
                 sensor((0.5, 1.3, 3.2), (0, 1.1, 0), 44), *PAINT, SHEET, *room(2, 2.6, 3.4),
                 sheet("+z", (0, 1.1, 0), (0.8, 0.8)),
                 lamp("+z", (0, 1.1, -1.6), (0.35, 0.35), 20, 19, 17))


def caustic_gloss():
    gloss = plugin("bsdf", "phong", rgb("diffuse_reflectance", 0.25, 0.25, 0.25),
                   rgb("specular_reflectance", 0.4, 0.4, 0.4), real("exponent", 20), id="gloss")
    glass = plugin("bsdf", "dielectric", real("int_ior", 1.5), real("ext_ior", 1), id="glass")
    return scene("The focus of a glass sphere on a glossy floor.",
                 sensor((0, 1.5, 3.2), (0, 0.35, 0), 34), *PAINT, gloss, glass,
                 *room(2, 2.6, 3.4, floor="gloss"), sphere((0.1, 0.6, 0), 0.4, ref("glass")),
                 lamp("-y", (-0.6, 2.5, -0.4), (0.4, 0.4), 20, 19, 17))


def caustic_bump():
    paint = plugin("bsdf", "diffuse", rgb("reflectance", 0.6, 0.6, 0.6))
    height, floor = waves("waves", paint, 0.3)
    polished = plugin("bsdf", "conductor", value("string", "material", "none"), id="mirror")
    return scene("A mirror sends light to a floor with steep waves in its normals, to all facets "
                 "from one\n     side.", height,
                 sensor((0, 2.2, 3.2), (0, 0.2, 0), 45), *PAINT, floor, polished,
                 *room(2, 2.6, 3.4, floor="waves"),
                 rectangle("+x", (-1.7, 0.8, 0), (1.2, 0.8), ref("mirror")),
                 sphere((1, 1.2, 0.4), 0.3,
                        plugin("bsdf", "diffuse", rgb("reflectance", 0, 0, 0)),
                        area_light(16, 15, 13)))


def mirror():
    polished = plugin("bsdf", "conductor", rgb("eta", 0.2, 0.2, 0.2), rgb("k", 4, 4, 4),
                      id="mirror")
    return scene("A large mirror that shows a floor, on which boxes stand, from afar.",
                 sensor((0, 1.5, 0.9), (0, 1.05, -2), 50), *PAINT, polished, *room(2, 2.6, 2),
                 rectangle("+z", (0, 1.2, -1.99), (1.4, 1), ref("mirror")),
                 box((-0.7, 0.3, 1.2), (0.25, 0.3, 0.2), 15, ref("white")),
                 box((0.6, 0.15, 1.4), (0.3, 0.15, 0.2), -25, ref("warm")),
                 lamp("+y", (0, 2.2, 1), (0.5, 0.3), 14, 13, 11))


def contact():
    legs = [box((x, 0.36, z), (0.025, 0.36, 0.025), 0, ref("warm"))
            for x in (-0.55, 0.55) for z in (-0.3, 0.3)]
    return scene("Furniture that stands on a floor and a chest that hovers a centimetre above it: "
                 "lines\n     of shadow where they meet.",
                 sensor((0.3, 1.2, 2.2), (0.05, 0.2, 0), 40), *PAINT, *room(2, 2.6, 2.4),
                 box((0, 0.74, 0), (0.6, 0.02, 0.35), 0, ref("warm")), *legs,
                 box((0.05, 0.16, 0.55), (0.3, 0.15, 0.15), 10, ref("white")),
                 lamp("+y", (-0.8, 2, 0.8), (0.4, 0.4), 16, 15, 13))


def waves(name, bsdf, height):
    """A BRDF with waves in its normals, and their height, which `-D waves=...` changes."""
    heights = plugin("texture", "bitmap", value("string", "filename", "waves.ppm"),
                     value("boolean", "raw", "true"),
                     element("transform", {"name": "to_uv"}, element("scale", {"value": "6"})))
    return [element("default", {"name": "waves", "value": number(height)}),
            plugin("bsdf", "bumpmap", heights, real("scale", 0).replace('"0"', '"$waves"'), bsdf,
                   id=name)]


def bump():
    gloss = plugin("bsdf", "phong", rgb("diffuse_reflectance", 0.35, 0.33, 0.3),
                   rgb("specular_reflectance", 0.3, 0.3, 0.3), real("exponent", 12))
    height, floor = waves("waves", gloss, 0.1)
    return scene("A glossy floor with waves in its normals, which are no reason for more records:\n"
                 "     `-D waves=0` is the same floor flat.", height,
                 sensor((0, 1.5, 1.8), (0, 0.4, -0.6), 60), *PAINT, floor,
                 *room(2, 2.6, 2, floor="waves"),
                 box((-0.5, 0.3, -0.7), (0.3, 0.3, 0.3), 25, ref("white")),
                 lamp("+y", (0.3, 2.1, 0), (0.5, 0.5), 14, 13, 11))


def bump_walls():
    paint = plugin("bsdf", "diffuse", rgb("reflectance", 0.65, 0.6, 0.5))
    height, walls = waves("white", paint, 0.3)
    return scene("A room with steep waves in the normals of all its surfaces: what these reflect\n"
                 "     follows from the waves, while photons hit flat surfaces.", height,
                 sensor((0, 1, 1.9), (0, 0.9, 0), 70), walls,
                 *(wall.replace('"warm"', '"white"').replace('"cool"', '"white"')
                   for wall in room(1.6, 2, 2, floor="white")),
                 sphere((0.4, 0.35, -0.4), 0.35, plugin("bsdf", "diffuse",
                                                        rgb("reflectance", 0.7, 0.7, 0.7))),
                 rectangle("-y", (0, 1.98, -0.3), (0.3, 0.3),
                           plugin("bsdf", "diffuse", rgb("reflectance", 0, 0, 0)),
                           area_light(18, 16, 13)))


def waves_image(size=32):
    """Crossed waves of one period as a grey image in plain bytes."""
    grey = [int(127.5 + 60 * (math.sin(2 * math.pi * (x + 0.5) / size) +
                               math.sin(2 * math.pi * (y + 0.5) / size)))
             for y in range(size) for x in range(size)]
    return b"P6\n%d %d\n255\n" % (size, size) + b"".join(struct.pack("3B", v, v, v) for v in grey)


def storeys():
    return scene("A ceiling without thickness between a bright storey above and one that is 100 "
                 "times\n     darker: the walls go through both.",
                 sensor((0, 1.25, 5.2), (0, 1.25, 0), 36), *PAINT, SHEET,
                 *room(2, 2.5, 1.5, open_front=True),
                 sheet("+y", (0, 1.25, 0), (2, 1.5)),
                 lamp("+x", (-1.95, 1.9, 0), (0.4, 0.3), 20, 20, 20),
                 lamp("+x", (-1.95, 0.6, 0), (0.4, 0.3), 0.2, 0.2, 0.2))


def gap():
    return scene("The foot of a wall that hangs 0.1 mm above a floor, which goes on under it to "
                 "the\n     outside. There it is much brighter.",
                 sensor((0, 0.14, -1.72), (0, 0.02, -2), 40), *PAINT, SHEET,
                 rectangle("+y", (0, 0, 0), (4, 4), ref("floor")),
                 rectangle("-y", (0, 2.6, 0), (2, 2), ref("white")),
                 rectangle("+x", (-2, 1.3, 0), (2, 1.3), ref("warm")),
                 rectangle("-x", (2, 1.3, 0), (2, 1.3), ref("cool")),
                 rectangle("-z", (0, 1.3, 2), (2, 1.3), ref("white")),
                 sheet("+z", (0, 1.3001, -2), (2, 1.3)),
                 lamp("+y", (0.5, 2, 0.2), (0.5, 0.5), 12, 11, 10),
                 plugin("emitter", "constant", rgb("radiance", 8, 9, 10)))


def stairs():
    steps = [box((-0.3, 0.025 * (i + 1), -0.4 - 0.12 * i), (1.2, 0.025 * (i + 1), 0.06), 0,
                 ref("white")) for i in range(8)]
    return scene("Low steps, which few gather rays from the floor meet. All light is indirect.",
                 sensor((0.8, 0.9, 0.9), (-0.15, 0.12, -0.6), 48), *PAINT, *room(2, 2.6, 2),
                 *steps, lamp("+y", (0.4, 2.1, 0.7), (0.4, 0.4), 14, 13, 11))


def daylight_room():
    """Floor, ceiling and walls with a hole for a window, and the sun and sky outside."""
    closed = [box((0, -0.1, 0), (2.6, 0.1, 2.6), 0, ref("floor")),
              box((0, 2.9, 0), (2.6, 0.1, 2.6), 0, ref("white")),
              box((0, 1.4, -2.6), (2.6, 1.4, 0.1), 0, ref("white")),
              box((0, 1.4, 2.6), (2.6, 1.4, 0.1), 0, ref("white")),
              box((2.6, 1.4, 0), (0.1, 1.4, 2.6), 0, ref("cool"))]
    # The wall with the hole: below, above and beside it.
    holed = [box((-2.6, y, z), (0.1, half_y, half_z), 0, ref("warm"))
             for y, z, half_y, half_z in [(0.45, 0, 0.45, 2.6), (2.5, 0, 0.3, 2.6),
                                          (1.55, -1.75, 0.65, 0.85), (1.55, 1.75, 0.65, 0.85)]]
    light = [plugin("emitter", "directional",
                    element("vector", {"name": "direction", "x": "0.8", "y": "-0.6", "z": "0.2"}),
                    rgb("irradiance", 11, 10, 8)),
             plugin("emitter", "constant", rgb("radiance", 0.6, 0.8, 1.2))]
    return closed + holed, light


def window():
    walls, light = daylight_room()
    return scene("A room that sun and sky shine into through an open window.",
                 sensor((1.9, 1.5, 2.2), (-0.7, 0.9, -1.4), 68), *PAINT, *walls,
                 box((-0.6, 0.4, -1.3), (0.4, 0.4, 0.4), 20, ref("white")), *light)


def panes():
    walls, light = daylight_room()
    paint = plugin("bsdf", "roughplastic", rgb("diffuse_reflectance", 0.7, 0.68, 0.6),
                   real("alpha", 0.2), id="paint")
    glazing = [box((x, 1.55, 0), (0.003, 0.65, 0.9), 0, ref("glass")) for x in (-2.6, -2.578)]
    frame = [box((-2.55, y, 0), (0.03, 0.03, 0.9), 0, ref("paint")) for y in (0.93, 2.17)]
    frame += [box((-2.53, 1.55, z), (0.03, 0.65, 0.03), 0, ref("paint")) for z in (-0.87, 0, 0.87)]
    table = [box((-0.5, 0.75, -0.6), (0.7, 0.03, 0.45), 0, ref("wood"))]
    table += [box((x, 0.36, z), (0.03, 0.36, 0.03), 0, ref("wood"))
              for x in (-1.1, 0.1) for z in (-0.95, -0.25)]
    others = [box((-0.7, 0.9, -0.6), (0.15, 0.12, 0.1), 20, ref("paint")),
              box((0.2, 0.2, -2.1), (0.6, 0.2, 0.25), 0, ref("cloth")),
              box((0.2, 0.6, -2.4), (0.6, 0.25, 0.06), 0, ref("cloth")),
              box((2.15, 0.7, -1.5), (0.3, 0.7, 0.5), 0, ref("paint"))]
    return scene("A furnished room that sun and sky shine into through two panes in a frame.",
                 sensor((1.9, 1.5, 2.2), (-0.7, 0.9, -1.4), 68), *PAINT,
                 plugin("bsdf", "dielectric", id="glass"), paint, diffuse("wood", 0.45, 0.28, 0.15),
                 diffuse("cloth", 0.2, 0.35, 0.25), *walls, *glazing, *frame, *table, *others,
                 *light)


def scaled_room(unit, what):
    """Everything of lengths times `unit`; radiance is what it was."""
    def at(*xyz):
        return tuple(c * unit for c in xyz)

    walls = [("+y", (0, 0, 0), (2.5, 2.5), "floor"), ("-y", (0, 3, 0), (2.5, 2.5), "white"),
             ("+x", (-2.5, 1.5, 0), (2.5, 1.5), "warm"),
             ("-x", (2.5, 1.5, 0), (2.5, 1.5), "cool"),
             ("+z", (0, 1.5, -2.5), (2.5, 1.5), "shine"),
             ("-z", (0, 1.5, 2.5), (2.5, 1.5), "white")]
    shine = plugin("bsdf", "phong", rgb("diffuse_reflectance", 0.2, 0.2, 0.2),
                   rgb("specular_reflectance", 0.5, 0.5, 0.5), real("exponent", 16), id="shine")
    return scene(f"A room {what} wide: but for its unit of length the same as the others.",
                 sensor(at(0, 1.5, 2.4), at(0, 1.2, -1), 70, real("near_clip", 0.01 * unit),
                        real("far_clip", 100 * unit)), *PAINT, shine,
                 *[rectangle(facing, at(*p), at(*half), ref(name))
                   for facing, p, half, name in walls],
                 box(at(-0.8, 0.5, -1), at(0.4, 0.5, 0.4), 20, ref("white")),
                 sphere(at(0.8, 0.5, -0.8), 0.5 * unit, ref("warm")),
                 rectangle("+y", at(0, 2.4, -0.4), at(0.6, 0.6), ref("white"),
                           area_light(12, 11, 10)))


def glossy_room(what, *bsdf):
    """An open box whose back wall reflects a ball of the same material, 4 cm before it."""
    gloss = plugin("bsdf", *bsdf, id="gloss")
    back = rectangle("+z", (0, 1, -1), (1, 1), ref("gloss"))
    walls = [wall for wall in room(1, 2, 1, open_front=True) if 'z="-1"' not in wall]
    return scene(f"A wall and a ball close to it, both {what}: the ball's reflection changes over "
                 "a\n     few centimetres, a small part of the distance to all else.",
                 sensor((0, 1, 4.35), (0, 1, 0), 33), *PAINT, gloss, *walls, back,
                 sphere((0.3, 0.6, -0.58), 0.38, ref("gloss")),
                 lamp("-y", (0, 1.99, 0), (0.3, 0.3), 14, 12.5, 10))


def phong_room():
    return glossy_room("Phong of exponent 22", "phong",
                       rgb("diffuse_reflectance", 0.2, 0.2, 0.22),
                       rgb("specular_reflectance", 0.5, 0.5, 0.5), real("exponent", 22))


def metal_room():
    return glossy_room("of rough metal (GGX, alpha 0.15)", "roughconductor",
                       value("string", "distribution", "ggx"), real("alpha", 0.15),
                       rgb("eta", 1.66, 0.88, 0.52), rgb("k", 9.22, 6.27, 4.84),
                       rgb("specular_reflectance", 0.8, 0.8, 0.8))


def files():
    """Every file of scenes/cases as {path: bytes}."""
    scenes = {"spot": spot_beam(), "spot-lamp": spot_disk(), "corner": corner(),
              "thin-wall": thin_wall(), "backlit": backlit(), "caustic-gloss": caustic_gloss(),
              "caustic-bump": caustic_bump(),
              "mirror": mirror(), "contact": contact(), "bump": bump(),
              "bump-walls": bump_walls(), "storeys": storeys(),
              "gap": gap(), "stairs": stairs(), "window": window(), "panes": panes(),
              "glossy-room": phong_room(), "metal-room": metal_room(),
              "room-5m": scaled_room(1, "5 m"),
              "room-5mm": scaled_room(0.001, "5 mm"), "room-500km": scaled_room(1e5, "500 km")}
    out = {f"cases/{name}.xml": text.encode() for name, text in scenes.items()}
    out["cases/waves.ppm"] = waves_image()
    return out
