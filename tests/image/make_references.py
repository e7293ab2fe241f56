#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders small reference images with Mitsuba 3's path tracer: mean and variance per pixel.

    tests/image/make_references.py [--size PX] [--spp N] [--parts P] [--out DIR] [--scalar]
        [SCENE.xml ...]

Without scenes: all of data/scenes. Needs `pip install mitsuba numpy` and LLVM 19 or later, or is
slow with --scalar; tests only read what it wrote. Each image is rendered in P independent parts of
N / P samples per pixel. The file NAME.exr has the channels R, G, B (mean of all samples), and
variance.R, variance.G, variance.B (variance of that mean, estimated from the parts), and a hash of
the scene's file. The film gets a box filter, so that the pixels are independent of each other.
"""
import argparse
import pathlib
import re
import sys

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb" if "--scalar" in sys.argv else "llvm_ad_rgb")
import mitsuba_plugins  # noqa: E402  (needs the variant)

TREE = pathlib.Path(__file__).resolve().parents[2]


def file_hash(path):
    """FNV-1a, 64 bits, of a file's bytes: z_test.c sees by it that a reference is out of date."""
    h = 0xcbf29ce484222325
    for byte in path.read_bytes():
        h = (h ^ byte) * 0x100000001b3 % 2**64
    return f"{h:016x}"


def load(path, size):
    """The scene with a film of size x size pixels and a box filter, whatever its file says."""
    text = path.read_text(encoding="utf-8")
    for name in ("width", "height"):
        text = re.sub(rf'(<integer\s+name="{name}"\s+value=)"[^"]*"', rf'\1"{size}"', text)
    text = re.sub(r'<rfilter\s+type="[^"]*"', '<rfilter type="box"', text)
    mi.file_resolver().prepend(str(path.parent))
    return mi.load_string(text)


def render(scene, spp, parts):
    """Mean over all parts and the variance of that mean."""
    integrator = scene.integrator() or mi.load_dict({"type": "path"})
    total = squares = 0.0
    for part in range(parts):
        image = np.array(mi.render(scene, integrator=integrator, spp=spp // parts, seed=part + 1),
                         dtype=np.float64)[:, :, :3]
        total, squares = total + image, squares + image * image
    mean = total / parts
    variance = np.maximum(squares / parts - mean * mean, 0) / (parts - 1)
    return mean, variance


def write(path, mean, variance, about):
    pixels = np.concatenate([mean, variance], axis=2).astype(np.float32)
    # 8 bits are enough for a variance, and compress better.
    bits = pixels[:, :, 3:].copy().view(np.uint32)
    pixels[:, :, 3:] = ((bits + 0x8000) & np.uint32(0xFFFF0000)).view(np.float32)
    names = ["R", "G", "B", "variance.R", "variance.G", "variance.B"]
    bitmap = mi.Bitmap(pixels, pixel_format=mi.Bitmap.PixelFormat.MultiChannel, channel_names=names)
    for key, text in about.items():
        bitmap.metadata()[key] = text
    bitmap.write(str(path))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--spp", type=int, default=16384)
    parser.add_argument("--parts", type=int, default=64)
    parser.add_argument("--out", type=pathlib.Path, default=TREE / "tests/image/references")
    parser.add_argument("--scalar", action="store_true", help="without LLVM")
    options = parser.parse_args()

    mitsuba_plugins.register()
    options.out.mkdir(exist_ok=True)
    for path in options.scenes or sorted((TREE / "data/scenes").glob("*.xml")):
        mean, variance = render(load(path, options.size), options.spp, options.parts)
        write(options.out / f"{path.stem}.exr", mean, variance,
              {"renderer": f"Mitsuba {mi.__version__}, path", "spp": str(options.spp),
               "parts": str(options.parts), "scene_hash": file_hash(path)})
        noise = np.sqrt(np.mean(variance / np.maximum(mean * mean, 1e-12)))
        print(f"{path.stem}: mean {np.mean(mean):.5f}, relative noise per pixel {noise:.2e}",
              flush=True)


if __name__ == "__main__":
    main()
