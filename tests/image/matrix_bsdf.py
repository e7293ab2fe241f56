# SPDX-License-Identifier: Apache-2.0
"""Rows of matrix.py: every BRDF that Mitsuba has, or that mitsuba_plugins.py gives it, under every
kind of light, with constant and with textured parameters. Their names start with bsdf_."""
from matrix_scene import FLOOR, LAMP, to_world, real, text, true, twosided

LIGHTS = {
    "constant": '<emitter type="constant"><rgb name="radiance" value="0.6, 0.7, 0.8"/></emitter>',
    "point": '<emitter type="point"><point name="position" x="2" y="5" z="3"/>'
             '<rgb name="intensity" value="60, 55, 50"/></emitter>',
    "area": LAMP,
    "envmap": '<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>',
}


def rgb(name, value):
    return f'<rgb name="{name}" value="{value}"/>'


def colours(name, first="0.9, 0.5, 0.2", second="0.2, 0.4, 0.7"):
    return (f'<texture type="checkerboard" name="{name}">{rgb("color0", first)}'
            f'{rgb("color1", second)}<transform name="to_uv"><scale x="8" y="6"/></transform>'
            '</texture>')


def numbers(name, first, second):
    return (f'<texture type="checkerboard" name="{name}">{real("color0", first)}'
            f'{real("color1", second)}<transform name="to_uv"><scale x="6" y="4"/></transform>'
            '</texture>')


def image(name, file):
    return (f'<texture type="bitmap" name="{name}">{true("raw")}{text("filename", file)}'
            '<transform name="to_uv"><scale x="2" y="2"/></transform></texture>')


def bsdf(kind, *parts):
    return f'<bsdf type="{kind}">{"".join(parts)}</bsdf>'


GOLD = text("material", "Au")
BASE = bsdf("roughplastic", rgb("diffuse_reflectance", "0.2, 0.3, 0.5"), real("alpha", 0.3))
FIRST = bsdf("diffuse", rgb("reflectance", "0.7, 0.3, 0.1"))
SECOND = bsdf("roughconductor", GOLD, real("alpha", 0.3))
LEAF = real("diff_trans", 1.2) + real("spec_trans", 0.3) + real("eta", 1.3)
LOBES = text("lobes", "-1 -1 1 8 0.4 0.4 0.3  -0.7 -0.9 1.02 3 0.1 0.1 0.2")

# Mitsuba's path tracer takes what lets light pass for opaque when it samples lights, and multiplies
# by the opacity of a mask twice then; its volumetric one does neither, and like satin it does not
# count surfaces that are passed as segments of the path.
THROUGH = '<integrator type="volpath"><integer name="max_depth" value="6"/></integrator>\n'

# Each name has a BSDF with constants, and one with textures or None.
MODELS = {
    "diffuse": (twosided(FIRST), twosided(bsdf("diffuse", colours("reflectance")))),
    "conductor": (twosided(bsdf("conductor", GOLD)),
                  twosided(bsdf("conductor", GOLD, colours("specular_reflectance")))),
    "roughconductor": (
        twosided(bsdf("roughconductor", GOLD, real("alpha_u", 0.1), real("alpha_v", 0.3),
                      text("distribution", "ggx"))),
        twosided(bsdf("roughconductor", GOLD, numbers("alpha", 0.15, 0.4)))),
    "roughconductor_eta": (
        twosided(bsdf("roughconductor", rgb("eta", "1.1, 0.8, 0.3"), rgb("k", "6, 4, 3"))),
        twosided(bsdf("roughconductor", colours("eta", "1, 0.8, 0.3", "0.2, 0.9, 1"),
                      colours("k", "1, 0.6, 0.3", "0.3, 0.4, 1"), real("alpha", 0.3)))),
    "plastic": (twosided(bsdf("plastic", rgb("diffuse_reflectance", "0.2, 0.5, 0.3"))),
                twosided(bsdf("plastic", colours("diffuse_reflectance"), true("nonlinear")))),
    "roughplastic": (twosided(BASE), twosided(
        bsdf("roughplastic", colours("diffuse_reflectance"), true("nonlinear"),
             real("alpha", 0.2), text("distribution", "ggx")))),
    "dielectric": (bsdf("dielectric"),
                   bsdf("dielectric", colours("specular_transmittance"))),
    "thindielectric": (bsdf("thindielectric"),
                       bsdf("thindielectric", colours("specular_transmittance"))),
    "roughdielectric": (bsdf("roughdielectric", real("alpha", 0.3)),
                        bsdf("roughdielectric", numbers("alpha", 0.2, 0.5),
                             text("distribution", "ggx"))),
    "principled": (twosided(bsdf("principled", rgb("base_color", "0.7, 0.3, 0.2"),
                                 real("roughness", 0.5), real("sheen", 0.5),
                                 real("clearcoat", 0.6), real("flatness", 0.4))),
                   twosided(bsdf("principled", colours("base_color"),
                                 numbers("roughness", 0.4, 0.8), numbers("metallic", 0, 1)))),
    "principled_glass": (bsdf("principled", real("spec_trans", 0.9), real("roughness", 0.4)),
                         bsdf("principled", colours("base_color"), real("roughness", 0.5),
                              numbers("spec_trans", 0.2, 0.8))),
    "principledthin": (bsdf("principledthin", rgb("base_color", "0.4, 0.7, 0.3"), LEAF),
                       bsdf("principledthin", colours("base_color"), LEAF)),
    "principledthin_eta": (None, bsdf(
        "principledthin", rgb("base_color", "0.4, 0.7, 0.3"), real("spec_trans", 0.7),
        real("diff_trans", 0.6), real("roughness", 0.4), numbers("eta", 1.2, 1.8))),
    "blendbsdf": (twosided(bsdf("blendbsdf", real("weight", 0.4), FIRST, SECOND)),
                  twosided(bsdf("blendbsdf", numbers("weight", 0.2, 0.9), FIRST, SECOND))),
    "mask": (bsdf("mask", real("opacity", 0.6), twosided(FIRST)),
             bsdf("mask", numbers("opacity", 0.1, 1), twosided(BASE))),
    "mask_mask": (bsdf("mask", real("opacity", 0.7), bsdf("mask", real("opacity", 0.8),
                                                          twosided(FIRST))), None),
    "mask_blend": (bsdf("blendbsdf", real("weight", 0.4), bsdf("mask", real("opacity", 0.3), FIRST),
                        twosided(SECOND)),
                   bsdf("mask", real("opacity", 0.9), bsdf(
                       "blendbsdf", numbers("weight", 0.2, 0.9),
                       bsdf("mask", numbers("opacity", 0.1, 1), twosided(FIRST)),
                       bsdf("mask", real("opacity", 0.8), twosided(SECOND))))),
    "bumpmap": (None, twosided(bsdf("bumpmap", real("scale", 0.2), image("map", "height.exr"),
                                    BASE))),
    "normalmap": (None, bsdf("normalmap", image("normalmap", "normal.exr"), twosided(BASE))),
    "bump_in_normal": (None, twosided(bsdf("normalmap", image("normalmap", "normal.exr"), bsdf(
        "bumpmap", real("scale", 0.15), image("map", "height.exr"), BASE)))),
    "normal_in_normal": (None, twosided(bsdf("normalmap", image("normalmap", "normal.exr"), bsdf(
        "normalmap", image("normalmap", "normal.exr"), BASE)))),
    "normal_in_bump": (None, twosided(bsdf("bumpmap", real("scale", 0.15), image(
        "map", "height.exr"), bsdf("normalmap", image("normalmap", "normal.exr"), BASE)))),
    "bump_in_bump": (None, twosided(bsdf("bumpmap", real("scale", 0.15), image(
        "map", "height.exr"), bsdf("bumpmap", real("scale", 0.1), image("map", "height.exr"),
                                   BASE)))),
    "null": (bsdf("null"), None),
    "twosided": (bsdf("twosided", FIRST, BASE), None),
    "phong": (twosided(bsdf("phong", rgb("diffuse_reflectance", "0.3, 0.2, 0.1"),
                            rgb("specular_reflectance", "0.5"), real("exponent", 12))),
              twosided(bsdf("phong", colours("diffuse_reflectance", "0.5, 0.3, 0.1", "0.1"),
                            rgb("specular_reflectance", "0.4"), real("exponent", 20)))),
    "ward": (twosided(bsdf("ward", rgb("diffuse_reflectance", "0.3, 0.2, 0.1"),
                           rgb("specular_reflectance", "0.5"), real("alpha_u", 0.15),
                           real("alpha_v", 0.4))), None),
    "lafortune": (twosided(bsdf("lafortune", rgb("diffuse_reflectance", "0.2, 0.3, 0.4"), LOBES)),
                  None),
}

# Mitsuba 3.9.1 rotates what is in a bumpmap about the normal, by an angle that is 0 only where the
# surface's own frame is the world's. Its later sources do not.
UPRIGHT = ("normal_in_bump", "bump_in_bump")

# The ball is above the floor: where a null one touched it, Mitsuba's rays, which set out farther
# from surfaces, lost the floor.
SHEET = '<shape type="rectangle">{1}{0}</shape>\n'
OBJECTS = ('<shape type="sphere"><point name="center" x="-1.1" y="1.1" z="0"/>{0}</shape>\n'
           + SHEET)


def write_maps(folder):
    import mitsuba as mi
    import numpy as np
    x, y = np.meshgrid(np.arange(64) / 64, np.arange(64) / 64)
    height = 0.5 + 0.2 * np.sin(6 * np.pi * x) + 0.2 * np.cos(8 * np.pi * y)
    slope = [-1.2 * np.pi * np.cos(6 * np.pi * x) * 0.1, 1.6 * np.pi * np.sin(8 * np.pi * y) * 0.1]
    normal = np.stack([*slope, np.ones_like(x)], axis=2)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    mi.Bitmap(height.astype(np.float32)[:, :, None]).write(str(folder / "height.exr"))
    mi.Bitmap((0.5 * normal + 0.5).astype(np.float32)).write(str(folder / "normal.exr"))


def rows(folder):
    write_maps(folder)
    tilted = to_world('<scale value="0.9"/><rotate x="1" angle="-20"/><rotate y="1" angle="25"/>'
                   '<translate x="1.2" y="1"/>')
    upright = to_world('<translate y="1.1"/>')
    out = {}
    for name, kinds in MODELS.items():
        things, where = (SHEET, upright) if name in UPRIGHT else (OBJECTS, tilted)
        for kind, what in zip(("constant", "textured"), kinds):
            for light, emitter in LIGHTS.items():
                if what:
                    out[f"bsdf_{name}_{kind}_{light}"] = (
                        THROUGH * (name.startswith(("mask", "null"))) + FLOOR + emitter
                        + things.format(what, where))
    return out
