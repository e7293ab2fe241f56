#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders small reference images with satin's own path tracer: mean and variance per pixel.

    tests/image/path_references.py [--size PX] [--spp N] [--parts P] --out DIR SCENE.xml ...

The files are those of make_references.py, which has Mitsuba render and is to be preferred where it
runs; the z_* tests compare the two path tracers. Each image is rendered in P independent parts of
N / P samples per pixel with a box filter, kept in DIR/parts. Needs `pip install OpenEXR numpy`.
"""
import argparse
import pathlib
import subprocess

import numpy as np
import OpenEXR

TREE = pathlib.Path(__file__).resolve().parents[2]
FIRST_SEED = 2001


def file_hash(path):
    """FNV-1a, 64 bits, of a file's bytes: cases.c sees by it that a reference is out of date."""
    h = 0xcbf29ce484222325
    for byte in path.read_bytes():
        h = (h ^ byte) * 0x100000001b3 % 2**64
    return f"{h:016x}"


def render(satin, scene, size, spp, seed, out):
    if not out.exists():
        subprocess.run([satin, "render", scene, "-o", out, "--integrator", "path", "--spp",
                        str(spp), "--seed", str(seed), "-D", "filter=box", "--width", str(size),
                        "--height", str(size), "--float", "--quiet"], check=True)
    with OpenEXR.File(str(out), separate_channels=True) as image:
        return np.stack([image.channels()[c].pixels.astype(np.float64) for c in "RGB"], axis=2)


def write(path, mean, variance, about):
    # 8 bits are enough for a variance, and compress better.
    bits = variance.astype(np.float32).view(np.uint32)
    rounded = ((bits + 0x8000) & np.uint32(0xFFFF0000)).view(np.float32)
    channels = {}
    for i, color in enumerate("RGB"):
        channels[color] = np.ascontiguousarray(mean[:, :, i].astype(np.float32))
        channels["variance." + color] = np.ascontiguousarray(rounded[:, :, i])
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **about}
    OpenEXR.File(header, channels).write(str(path))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="+", type=pathlib.Path)
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--spp", type=int, default=4096)
    parser.add_argument("--parts", type=int, default=8)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--satin", default=TREE / "build" / "satin")
    options = parser.parse_args()

    kept = options.out / "parts"
    kept.mkdir(parents=True, exist_ok=True)
    for scene in options.scenes:
        images = np.array([render(options.satin, scene, options.size, options.spp // options.parts,
                                  FIRST_SEED + i, kept / f"{scene.stem}-{i + 1}.exr")
                           for i in range(options.parts)])
        mean, variance = images.mean(axis=0), images.var(axis=0, ddof=1) / options.parts
        write(options.out / f"{scene.stem}.exr", mean, variance,
              {"renderer": "satin, path", "spp": str(options.spp), "parts": str(options.parts),
               "scene_hash": file_hash(scene)})
        noise = np.sqrt(np.mean(variance / np.maximum(mean * mean, 1e-12)))
        print(f"{scene.stem}: mean {np.mean(mean):.5f}, relative noise per pixel {noise:.2e}",
              flush=True)


if __name__ == "__main__":
    main()
