# SPDX-License-Identifier: Apache-2.0
"""Random reflection models for rooms.py: every surface BRDF that a scene file may hold, apart from
MERL's files, which are large, and from roughdiffuse and the coats, which came later: a room stays a
function of its number."""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "data"))
from parts import element, number, plugin, real, rgb, value  # noqa: E402

METALS = ("Au", "Cu", "Al", "Ag", "Cr")
WAVES, BRDF = "waves.pgm", "measured.txt"  # files beside the scenes, see write_files


def write_files(folder):
    """What bump maps, normal maps and measured BRDFs read, in the folder of the scenes."""
    size = 32
    angle = [2 * math.pi * k / size for k in range(size)]
    heights = [round(127 + 60 * math.sin(x) + 60 * math.cos(2 * y)) for y in angle for x in angle]
    (folder / WAVES).write_text(f"P2 {size} {size} 255\n" + " ".join(map(str, heights)) + "\n",
                                encoding="ascii")
    angles, azimuths = (0, 20, 40, 60, 80), (0, 60, 120, 180)
    rows = []
    for eye in angles:  # a wide lobe around the mirror direction over a diffuse base
        for light in angles:
            for azimuth in azimuths:
                a, b, c = (math.radians(v) for v in (eye, light, azimuth))
                mirror = math.cos(a) * math.cos(b) - math.sin(a) * math.sin(b) * math.cos(c)
                rows.append(number(0.08 + 0.12 * max(mirror, 0) ** 4))
    axes = [f"theta_o {len(angles)} {' '.join(map(str, angles))}", "phi_o 1 0",
            f"theta_i {len(angles)} {' '.join(map(str, angles))}",
            f"phi {len(azimuths)} {' '.join(map(str, azimuths))}"]
    (folder / BRDF).write_text("\n".join(["brdf 1", *axes, "channels 1", "values", *rows]) + "\n",
                               encoding="ascii")


class Materials:
    """Draws from `dice`, see rooms.py."""

    def __init__(self, dice):
        self.dice = dice

    def color(self, low=0.05, high=0.85):
        grey = self.dice.range(low, high)
        return [min(high, grey * self.dice.range(0.6, 1.3)) for _ in range(3)]

    def to_uv(self):
        return element("transform", {"name": "to_uv"}, element(
            "scale", {"x": number(self.dice.log(1, 8)), "y": number(self.dice.log(1, 8))}))

    def reflectance(self, name, high=0.85):
        """A colour, now and then in checks."""
        if self.dice.chance(0.2):
            return plugin("texture", "checkerboard", rgb("color0", *self.color(high=high)),
                          rgb("color1", *self.color(high=high)), self.to_uv(), name=name)
        return rgb(name, *self.color(high=high))

    def amount(self, name, low, high):
        """A number, now and then in checks."""
        if self.dice.chance(0.1):
            return plugin("texture", "checkerboard", real("color0", self.dice.range(low, high)),
                          real("color1", self.dice.range(low, high)), self.to_uv(), name=name)
        return real(name, self.dice.range(low, high))

    def rough(self):
        kind = value("string", "distribution", self.dice.pick(("beckmann", "ggx")))
        if self.dice.chance(0.25):
            return [kind, real("alpha_u", self.dice.log(0.03, 0.6)),
                    real("alpha_v", self.dice.log(0.03, 0.6))]
        return [kind, real("alpha", self.dice.log(0.02, 0.7))]

    def ior(self):
        return real("int_ior", self.dice.range(1.1, 2.2))

    # Surfaces that let nothing through.

    def diffuse(self):
        return plugin("bsdf", "diffuse", self.reflectance("reflectance"))

    def conductor(self):
        return plugin("bsdf", "conductor", value("string", "material", self.dice.pick(METALS)))

    def roughconductor(self):
        return plugin("bsdf", "roughconductor", *self.rough(),
                      value("string", "material", self.dice.pick(METALS)))

    def plastic(self):
        return plugin("bsdf", "plastic", self.reflectance("diffuse_reflectance"), self.ior(),
                      value("boolean", "nonlinear", self.dice.pick(("true", "false"))))

    def roughplastic(self):
        kind = value("string", "distribution", self.dice.pick(("beckmann", "ggx")))
        return plugin("bsdf", "roughplastic", self.reflectance("diffuse_reflectance"), self.ior(),
                      kind, real("alpha", self.dice.log(0.02, 0.7)))

    def phong(self):
        return plugin("bsdf", "phong", self.reflectance("diffuse_reflectance", 0.45),
                      self.reflectance("specular_reflectance", 0.5),
                      real("exponent", self.dice.log(1, 2000)))

    def ward(self):
        kind = self.dice.pick(("ward", "ward-duer", "balanced"))
        return plugin("bsdf", "ward", self.reflectance("diffuse_reflectance", 0.45),
                      self.reflectance("specular_reflectance", 0.45),
                      value("string", "variant", kind), real("alpha_u", self.dice.log(0.04, 0.6)),
                      real("alpha_v", self.dice.log(0.04, 0.6)))

    def lafortune(self):
        side = -self.dice.range(0.5, 0.8)
        lobe = [side, side, self.dice.range(0.4, 0.8), self.dice.log(1, 60), 0.3, 0.3, 0.3]
        return plugin("bsdf", "lafortune", self.reflectance("diffuse_reflectance", 0.4),
                      value("string", "lobes", ", ".join(map(number, lobe))))

    def tabulated(self):
        return plugin("bsdf", "tabulated", value("string", "filename", BRDF))

    def principled(self):
        names = ("roughness", "anisotropic", "metallic", "spec_tint", "sheen", "sheen_tint",
                 "flatness", "clearcoat", "clearcoat_gloss")
        some = [self.amount(name, 0, 1) for name in names if self.dice.chance(0.4)]
        return plugin("bsdf", "principled", self.reflectance("base_color"), *some)

    def blend(self):
        return plugin("bsdf", "blendbsdf", self.amount("weight", 0, 1), self.smooth(),
                      self.smooth())

    def bump(self):
        heights = plugin("texture", "bitmap", value("string", "filename", WAVES),
                         value("boolean", "raw", "true"), self.to_uv())
        return plugin("bsdf", "bumpmap", heights, real("scale", self.dice.log(0.001, 0.05)),
                      self.smooth())

    def normals(self):
        """Constant normals that lean, or such in checks."""
        lean = [[self.dice.range(0.35, 0.65), self.dice.range(0.35, 0.65), 1] for _ in range(2)]
        checks = plugin("texture", "checkerboard", rgb("color0", *lean[0]), rgb("color1", *lean[1]),
                        self.to_uv(), name="normalmap")
        return plugin("bsdf", "normalmap", checks, self.smooth())

    def smooth(self):
        """One of the models that others are made of."""
        return self.dice.pick((self.diffuse, self.roughconductor, self.roughplastic, self.phong,
                               self.ward, self.plastic))()

    # Bodies of glass, and sheets.

    def dielectric(self):
        return plugin("bsdf", "dielectric", self.ior())

    def roughdielectric(self):
        return plugin("bsdf", "roughdielectric", *self.rough(), self.ior())

    def glassy(self):
        return plugin("bsdf", "principled", rgb("base_color", *self.color(0.5, 1)),
                      real("spec_trans", self.dice.range(0.2, 1)),
                      real("roughness", self.dice.range(0.05, 0.8)),
                      real("eta", self.dice.range(1.2, 1.8)))

    def thindielectric(self):
        return plugin("bsdf", "thindielectric", self.ior())

    def principledthin(self):
        names = ("roughness", "spec_trans", "sheen", "flatness", "diff_trans")
        some = [self.amount(name, 0, 1) for name in names if self.dice.chance(0.5)]
        return plugin("bsdf", "principledthin", self.reflectance("base_color"), *some)

    def mask(self):
        return plugin("bsdf", "mask", self.amount("opacity", 0, 1),
                      plugin("bsdf", "twosided", self.smooth()))

    def null(self):
        return plugin("bsdf", "null")

    # The names that rooms.py uses.

    def wall(self):
        if self.dice.chance(0.75):
            return self.diffuse()
        return self.dice.pick((self.phong, self.ward, self.roughplastic, self.plastic, self.bump,
                               self.normals, self.lafortune, self.roughconductor, self.tabulated,
                               self.principled))()

    def opaque(self):
        return self.dice.pick((self.diffuse, self.diffuse, self.conductor, self.roughconductor,
                               self.plastic, self.roughplastic, self.phong, self.ward,
                               self.lafortune, self.tabulated, self.principled, self.blend,
                               self.bump, self.normals, self.mask))()

    def body(self):
        """For a closed body."""
        if self.dice.chance(0.25):
            return self.dice.pick((self.dielectric, self.roughdielectric, self.glassy))()
        return self.opaque()

    def sheet(self):
        if self.dice.chance(0.5):
            return self.dice.pick((self.thindielectric, self.principledthin, self.null))()
        return plugin("bsdf", "twosided", self.smooth())
