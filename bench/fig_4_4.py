#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Interpolation with each kind of gradient: scenes like those of [K05 figures 4.4, 4.6 to 4.8], the
same records for every kind.

  bench/fig_4_4.py DIR [4.4] [4.6] [4.7] [4.8]

DIR gets the scenes, the renders and an image per figure: the reference, then each kind, and below
each its difference times ten. Prints a table in Markdown: the rms difference of the indirect layer
relative to its mean, over the image and over the part where occlusion changes. Indirect light is
of the first bounce (first pass `none`). The reference gathers at every sample for 4.4; for the
others it has a radiance record at every pixel, so that what harmonics cannot hold of the BRDF does
not count.
"""
import os
import pathlib
import re
import sys

import runs

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(runs.ROOT, "data"))
import figures  # noqa: E402  needs the path
from generate import cornell  # noqa: E402
from parts import (area_light, box, diffuse, plugin, real, rectangle, ref, rgb, scene,  # noqa: E402
                   sensor, sphere, value)


def ward(name):
    return plugin("bsdf", "ward", value("string", "variant", "ward-duer"), real("alpha_u", 0.15),
                  real("alpha_v", 0.15), rgb("diffuse_reflectance", 0, 0, 0),
                  rgb("specular_reflectance", 0.9, 0.9, 0.9), id=name)


def cornell_diffuse():
    parts = cornell(diffuse("back", 0.72, 0.70, 0.66),
                    box((-0.36, 0.6, -0.28), (0.28, 0.6, 0.28), 18, ref("white")),
                    box((0.36, 0.3, 0.3), (0.28, 0.3, 0.28), -17, ref("white")))
    # The light in the ceiling, not under it, where a slit would be all that errs.
    return scene("A diffuse Cornell box.", *(part.replace("1.99", "1.9999") for part in parts))


def sphere_alone():
    return scene(
        "A diffuse sphere on a Ward floor: all that the floor reflects indirectly.",
        sensor((0, 1.5, 3.4), (0, 0.05, 0.55), 26), ward("floor"),
        diffuse("ball", 0.72, 0.45, 0.16), rectangle("+y", (0, 0, 0), (3, 3), ref("floor")),
        sphere((0, 0.62, -0.1), 0.62, ref("ball")),
        rectangle("-y", (0.8, 3.5, 2), (0.7, 0.5), ref("ball"), area_light(60, 55, 50)))


def teapot():
    return re.sub(r'<bsdf type="phong".*?</bsdf>', ward("glaze"), figures.teapot(), flags=re.DOTALL)


# Records are few and at the same positions for every kind, so that the gradients decide.
ALIKE = ["adaptive-cache=off", "{}-gradient-clamp=off", "{}-neighbour-clamp=off", "{}-rays=4096"]
DIFFUSE = ["irradiance-a=0.15", "irradiance-widen=1", "irradiance-min-pixels=0"]
GLOSSY = ["radiance-a=0.3", "radiance-widen=1.4", "radiance-max-pixels=15"]
DIFFUSE_REFERENCE = ["irradiance-cache=off", "irradiance-rays=10000"]
GLOSSY_REFERENCE = ["radiance-a=0.1", "radiance-widen=1", "radiance-min-pixels=1",
                    "radiance-max-pixels=1", "radiance-rays=8192"]
KINDS = ["none", "stratified", "solid-angle", "differences"]
# Of each figure: scene, kind of record, its cached material, exposure, part of the picture.
FIGURES = {
    "4.4": (cornell_diffuse, "irradiance", None, 1.5, "0.2,0.4,0.8,0.9"),
    "4.6": (sphere_alone, "radiance", "floor", 4, "0.2,0.3,0.8,0.8"),
    "4.7": (teapot, "radiance", "both", 1, "0.3,0.15,0.7,0.5"),
    "4.8": (figures.box_pyramid, "radiance", "metal", 1, "0.2,0.5,0.8,0.9"),
}


def render(options, path, out, settings):
    settings = ["spp=16", "adaptive-sampling=off", "photons=1000", "caustic-photons=0",
                "light-samples=1", "first-pass=none", *settings]
    flags = [word for setting in settings for word in ("--set", setting)]
    return runs.render(options, path, out, "--width", str(options.size), "--height",
                       str(options.size), "-D", "filter=box", *flags)


def figure(options, name):
    make, record, material, exposure, part = FIGURES[name]
    path = os.path.join(options.dir, f"fig_{name}.xml")
    pathlib.Path(path).write_text(make(), encoding="utf-8")
    always = [f"material.{material}.cache=on"] if material else []
    reference = GLOSSY_REFERENCE if material else DIFFUSE_REFERENCE
    images = [render(options, path, f"fig_{name}-reference",
                     [s.format(record) for s in ALIKE] + reference + always)[0]]
    kinds = KINDS if material else [*KINDS, "ward-heckbert"]
    settings = [s.format(record) for s in ALIKE] + (GLOSSY if material else DIFFUSE) + always
    counts = []
    for kind in kinds:
        image, stats = render(options, path, f"fig_{name}-{kind}",
                              [*settings, f"{record}-gradients={kind}"])
        images.append(image)
        counts.append(stats["records." + record])
    printed = runs.run([options.compose, os.path.join(options.dir, f"fig_{name}.png"),
                        "indirect_glossy" if material else "indirect_diffuse", str(exposure), part,
                        *images])
    for kind, count, line in zip(kinds, counts, printed.split("\n")):
        print(f"| {name} | {kind} | {count:.0f} | {' | '.join(line.split())} |", flush=True)


def main():
    parser = runs.parser(__doc__)
    parser.add_argument("figure", nargs="*", default=list(FIGURES))
    parser.add_argument("--size", type=int, default=200)
    parser.add_argument("--compose", default=os.path.join(runs.ROOT, "build", "bench",
                                                          "side_by_side"))
    options = parser.parse_args()
    os.makedirs(options.dir, exist_ok=True)
    for name, data in figures.files().items():
        if name.endswith(".ply"):
            pathlib.Path(options.dir, os.path.basename(name)).write_bytes(data)
    print("| figure | gradients | records | rms | rms of the part |\n|---|---|---|---|---|")
    for name in options.figure:
        figure(options, name)


if __name__ == "__main__":
    main()
