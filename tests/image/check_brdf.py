#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares satin's BRDFs with Mitsuba 3's, and phong and ward with their formulas in double.

usage: check_brdf.py BUILD_DIR      (needs mitsuba and numpy; BUILD_DIR/tests/image/brdf_values)

For random parameters and directions, f_r must agree to 1e-4: relatively where f_r > 1, absolutely
below. Delta lobes: directions and weights of Mitsuba's samples. Prints the worst case per model;
exit status 1 if one is over.
"""
import subprocess
import sys

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
BOUND = 1e-4
DIRECTIONS = 150
rng = np.random.default_rng(7)

NO_COAT = (0.0, 0.0, 0.0)
# The principled models' numbers, in the order of enum brdf_slot.
NUMBERS = ("metallic", "anisotropic", "spec_trans", "spec_tint", "sheen", "sheen_tint", "flatness",
           "clearcoat", "clearcoat_gloss", "diff_trans")
BOTH_SIDES = ("roughdielectric", "principled", "principledthin")


class Params(dict):
    """Parameters in the order that brdf_values reads."""

    def __init__(self, model, **kw):
        super().__init__(model=model, distribution=0, variant=0, nonlinear=0, diffuse=[0.0] * 3,
                         specular=[1.0] * 3, transmittance=[1.0] * 3, eta=[0.0] * 3, k=[1.0] * 3,
                         ior=1.5, au=0.1, av=0.1, exponent=30.0)
        self.update(dict.fromkeys(NUMBERS, 0.0))
        self.update(kw)
        if "principled" in model:
            self["av"] = 0.0

    def line(self):
        p = self
        numbers = [p["ior"], *p["diffuse"], *p["specular"], *p["transmittance"], *NO_COAT,
                   *p["eta"], *p["k"], *NO_COAT, p["au"], p["av"], p["exponent"],
                   *[p[name] for name in NUMBERS], p["ior"]]
        return (f"b {p['model']} {p['distribution']} {p['variant']} {p['nonlinear']} "
                + " ".join(f"{x:.9g}" for x in numbers))


def directions(n):
    """Unit vectors above the surface; a fraction of them grazing."""
    z = rng.random(n)
    z[: n // 5] *= 0.05
    phi = 2 * np.pi * rng.random(n)
    s = np.sqrt(1 - z * z)
    return np.stack([s * np.cos(phi), s * np.sin(phi), z], 1).astype(np.float32)


def pairs(p):
    """Half random pairs, half near the mirror direction at the width of the lobe."""
    wo, wi = directions(DIRECTIONS), directions(DIRECTIONS)
    m = np.stack([rng.normal(0, p["au"], DIRECTIONS), rng.normal(0, p["av"] or p["au"], DIRECTIONS),
                  np.ones(DIRECTIONS)], 1)
    m /= np.linalg.norm(m, axis=1)[:, None]
    mirrored = 2 * (wo * m).sum(1)[:, None] * m - wo
    half = DIRECTIONS // 2
    wi[:half] = mirrored[:half]
    wi[wi[:, 2] < 1e-3] = [0.6, 0, 0.8]
    if p["model"] in BOTH_SIDES:  # a third each inside, and through in each direction
        refracted = wi / p["ior"] + (wo * m).sum(1)[:, None] * m * (1 - 1 / p["ior"])
        wi[1::3] = -refracted[1::3] / np.linalg.norm(refracted[1::3], axis=1)[:, None]
        wi[:, 2][np.abs(wi[:, 2]) < 1e-3] = -1e-3
        wo[2::3, 2] *= -1
        wi[2::6, 2] *= -1
    return wo, wi.astype(np.float32)


def mitsuba_bsdf(p):
    rgb = lambda v: {"type": "rgb", "value": [float(x) for x in v]}
    name = ["beckmann", "ggx"][p["distribution"]]
    d = {"type": p["model"]}
    if p["model"] == "diffuse":
        d["reflectance"] = rgb(p["diffuse"])
    if "conductor" in p["model"]:
        d.update(eta=rgb(p["eta"]), k=rgb(p["k"]), specular_reflectance=rgb(p["specular"]))
    if p["model"] in ("roughconductor", "roughdielectric"):
        d.update(alpha_u=float(p["au"]), alpha_v=float(p["av"]), distribution=name)
    if "dielectric" in p["model"]:
        d.update(int_ior=float(p["ior"]), ext_ior=1.0, specular_reflectance=rgb(p["specular"]),
                 specular_transmittance=rgb(p["transmittance"]))
    if "plastic" in p["model"]:
        d.update(int_ior=float(p["ior"]), ext_ior=1.0, specular_reflectance=rgb(p["specular"]),
                 diffuse_reflectance=rgb(p["diffuse"]), nonlinear=bool(p["nonlinear"]))
    if p["model"] == "roughplastic":
        d.update(alpha=float(p["au"]), distribution=name)
    if "principled" in p["model"]:
        names = set(NUMBERS) - ({"diff_trans"} if p["model"] == "principled" else
                                {"metallic", "clearcoat", "clearcoat_gloss"})
        d.update(base_color=rgb(p["diffuse"]), roughness=float(p["au"]), eta=float(p["ior"]),
                 **{name: float(p[name]) for name in names})
    return mi.load_dict(d)


def interaction(wo):
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(*[float(x) for x in wo])
    si.sh_frame = mi.Frame3f(mi.Normal3f(0, 0, 1))
    return si


def mitsuba_values(p, wo, wi):
    bsdf, ctx = mitsuba_bsdf(p), mi.BSDFContext()
    return np.array([np.array(bsdf.eval(ctx, interaction(o), mi.Vector3f(*[float(x) for x in i])))
                     / abs(float(i[2])) for o, i in zip(wo, wi)])


def mitsuba_delta(p, wo):
    """Per wo, the delta samples {sign of z: (direction, weight * probability)}."""
    bsdf, ctx, out = mitsuba_bsdf(p), mi.BSDFContext(), []
    for o in wo:
        lobes = {}
        for u in np.linspace(0.0005, 0.9995, 60):
            s, w = bsdf.sample(ctx, interaction(o), float(u), mi.Point2f(0.3, 0.6))
            if s.pdf > 0 and mi.has_flag(s.sampled_type, mi.BSDFFlags.Delta) or \
               s.pdf > 0 and mi.has_flag(s.sampled_type, mi.BSDFFlags.Null):
                lobes[np.sign(s.wo.z) == np.sign(o[2])] = np.concatenate(
                    [np.array(s.wo), np.array(w) * s.pdf])
        out.append(lobes)
    return out


def formula_values(p, wo, wi):
    """phong and ward as Mitsuba 0.6 defines them."""
    wo, wi = wo.astype(float), wi.astype(float)
    if p["model"] == "phong":
        mirror = wo * [-1, -1, 1]
        n, c = p["exponent"], np.clip((mirror * wi).sum(1), 0, None)
        lobe = (n + 2) / (2 * np.pi) * np.where(c > 0, c, 1) ** n * (c > 0)
    else:
        h, au, av = wo + wi, p["au"], p["av"]
        e = np.exp(-((h[:, 0] / au) ** 2 + (h[:, 1] / av) ** 2) / h[:, 2] ** 2)
        ci, co = wi[:, 2], wo[:, 2]
        scale = [1 / (4 * np.pi * au * av * np.sqrt(ci * co)), 1 / (4 * np.pi * au * av * ci * co),
                 (h * h).sum(1) / (np.pi * au * av * h[:, 2] ** 4)][p["variant"]]
        lobe = scale * e
    return np.array(p["diffuse"])[None] / np.pi + lobe[:, None] * np.array(p["specular"])[None]


def cases():
    color = lambda lo=0.0, hi=1.0: rng.uniform(lo, hi, 3).round(4).tolist()
    yield Params("diffuse", diffuse=color())
    for distribution in (0, 1):
        for au, av in ((0.05, 0.05), (0.1, 0.4), (0.5, 0.02), (0.3, 0.3), (1, 1), (0.7, 0.2)):
            yield Params("roughconductor", distribution=distribution, au=au, av=av,
                         specular=color(), eta=color(0.1, 3), k=color(0.5, 6))
        for au, av, ior in ((0.05, 0.05, 1.5), (0.3, 0.3, 2.4), (0.1, 0.6, 1.33), (0.8, 0.8, 0.7)):
            yield Params("roughdielectric", distribution=distribution, au=au, av=av, ior=ior,
                         specular=color(), transmittance=color())
        for alpha, ior, nonlinear in ((0.02, 1.5, 1), (0.1, 1.49, 0), (0.3, 1.9, 1), (0.7, 1.3, 0),
                                      (1, 1.5, 1)):
            yield Params("roughplastic", distribution=distribution, au=alpha, av=alpha, ior=ior,
                         nonlinear=nonlinear, diffuse=color(), specular=color())
    for roughness in (0.05, 0.2, 0.5, 1):
        for ior in (1.5, 1.1, 2.0):
            some = {name: float(rng.random()) * (rng.random() < 0.6) for name in NUMBERS}
            yield Params("principled", au=roughness, ior=ior, diffuse=color(), **some)
            some["diff_trans"] *= 2
            yield Params("principledthin", au=roughness, ior=ior, diffuse=color(), **some)
    for ior, nonlinear in ((1.49, 0), (1.9, 1), (1.2, 1), (2.4, 0)):
        yield Params("plastic", ior=ior, nonlinear=nonlinear, diffuse=color(), specular=color())
    yield Params("conductor", specular=color(), eta=color(0.1, 3), k=color(0.5, 6))
    yield Params("conductor")
    for model in ("dielectric", "thindielectric"):
        for ior in (1.5, 1.33, 2.4, 1.0001):
            yield Params(model, ior=ior, specular=color(), transmittance=color())
    for n in (0, 1, 7.5, 22, 300):
        yield Params("phong", exponent=n, diffuse=color(), specular=color(), au=0.3, av=0.3)
    for variant in (0, 1, 2):
        for au, av in ((0.15, 0.15), (0.6, 0.25), (0.15, 0.5)):
            yield Params("ward", variant=variant, au=au, av=av, diffuse=color(), specular=color())


def delta_error(p, wo, lines):
    worst = 0.0
    for o, theirs, line in zip(wo, mitsuba_delta(p, wo), lines):
        v = [float(x) for x in line.split()]
        for i in range(int(v[0])):
            ours = v[1 + 7 * i: 8 + 7 * i]
            same = theirs.get(np.sign(ours[2]) == np.sign(o[2]))
            if same is None:  # a probability too small for Mitsuba to have drawn it
                worst = max(worst, 0.0 if ours[6] < 0.02 else 1.0)
                continue
            worst = max(worst, np.abs(np.array(ours[:6]) - same).max())
    return worst


def main():
    helper = sys.argv[1] + "/tests/image/brdf_values"
    todo, text = [], []
    for p in cases():
        if p["model"] != "dielectric" and p["model"] != "thindielectric" and \
           p["model"] != "conductor":
            wo, wi = pairs(p)
            todo.append((p, wo, wi))
            text.append(p.line())
            text += ["e " + " ".join(f"{x:.9g}" for x in (*o, *i)) for o, i in zip(wo, wi)]
        if p["model"] in ("conductor", "dielectric", "thindielectric", "plastic"):
            wo = directions(20)
            if p["model"].endswith("dielectric"):
                wo[::2, 2] *= -1
            todo.append((p, wo, None))
            text.append(p.line())
            text += ["d " + " ".join(f"{x:.9g}" for x in o) for o in wo]
    run = subprocess.run([helper], input="\n".join(text) + "\n", capture_output=True, text=True)
    if run.returncode:
        sys.exit(run.stderr)
    lines, at, worst = run.stdout.splitlines(), 0, {}
    for p, wo, wi in todo:
        block, at = lines[at: at + len(wo)], at + len(wo)
        if wi is None:
            key, error = p["model"] + " (delta)", delta_error(p, wo, block)
        else:
            ours = np.array([[float(x) for x in line.split()] for line in block])
            exact = p["model"] in ("phong", "ward")
            theirs = (formula_values if exact else mitsuba_values)(p, wo, wi)
            error = (np.abs(ours - theirs) / np.maximum(1, np.abs(theirs))).max()
            key = p["model"]
        if "-v" in sys.argv:
            print(f"{key:24} {error:.1e}  {p.line()}")
        worst[key] = max(worst.get(key, 0), error)
    for key, error in worst.items():
        print(f"{key:24} {error:.1e}  {'ok' if error <= BOUND else 'OVER'}")
    sys.exit(any(e > BOUND for e in worst.values()))


if __name__ == "__main__":
    main()
