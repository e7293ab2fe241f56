#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whether images by integrator sppm differ from those of path tracing by more than noise.

  tests/image/path_references.py --out DIR --spp N --parts P SCENE.xml
  bench/sppm_z.py DIR [SCENE.xml] [--parts 16] [--passes 64] [--photons 20000,50000] [--k 20]

The first command renders P independent images by path tracing, the second one as many as --parts by
sppm, and compares their means. tests/image/z_test takes the variance of a sample to be the same in
both images, which is not so here: a pass knows more than a path. So each mean has the variance of
its own parts, and the difference of the means has Student's distribution with the degrees of
freedom of Welch. The least of all probabilities is to be above that which one test in a hundred
would give, with as many tests as there are values; the fractions beyond 2 and 3 standard deviations
are to be near those of the normal distribution, .0455 and .0027. Blocks of pixels find differences
that are smaller than the noise of a pixel.
"""
import argparse
import math
import pathlib
import subprocess

import numpy as np
import runs
import unbiased

FIRST_SEED = 5001


def render(options, number):
    """One image by sppm."""
    name = f"{options.scene.stem}-sppm-{options.passes}-{options.k}-{number}.exr"
    out = pathlib.Path(options.dir) / name
    if not out.exists():
        photons, caustics = options.photons.split(",")
        size = options.size
        subprocess.run([options.satin, "render", options.scene, "-o", out, "--integrator", "sppm",
                        "--spp", str(options.passes), "--seed", str(FIRST_SEED + number),
                        "--set", f"photons={photons}", "--set", f"caustic-photons={caustics}",
                        "--set", f"photon-k={options.k}", "--set", f"caustic-k={options.k}",
                        "-D", "filter=box", "--width", str(size), "--height", str(size),
                        "--float", "--quiet"], check=True)
    return unbiased.layer(out, "RGB")


def blocks(images, side):
    """Means over blocks of pixels, of images of any number."""
    n, height, width, channels = images.shape
    return images.reshape(n, height // side, side, width // side, side,
                          channels).mean(axis=(2, 4))


def deviates(a, b):
    """The difference of the means of two sets of images, as normal deviates."""
    va, vb = a.var(axis=0, ddof=1) / len(a), b.var(axis=0, ddof=1) / len(b)
    v = va + vb
    freedom = v**2 / np.maximum(va**2 / (len(a) - 1) + vb**2 / (len(b) - 1), 1e-300)
    difference = a.mean(axis=0) - b.mean(axis=0)
    t = np.where(v > 0, difference / np.sqrt(np.where(v > 0, v, 1)), 0)
    # The normal deviate that is as improbable [Wallace 1959].
    return np.sign(t) * np.sqrt(freedom * np.log1p(t * t / freedom)) \
        * (8 * freedom + 1) / (8 * freedom + 3)


def report(name, z):
    least = math.erfc(np.abs(z).max() / math.sqrt(2))
    limit = -math.expm1(math.log1p(-0.01) / z.size)
    where = np.unravel_index(np.abs(z).argmax(), z.shape)
    print(f"{name}: least p {least:.2g} of {z.size} (limit {limit:.2g}) at {where[1]}, {where[0]}; "
          f"beyond 2 and 3 deviations {np.mean(np.abs(z) > 2):.4f} and "
          f"{np.mean(np.abs(z) > 3):.4f}; mean of z {z.mean():+.3f}, of its square "
          f"{np.mean(z * z):.3f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dir", help="that of path_references.py; images are left there")
    parser.add_argument("scene", nargs="?", type=pathlib.Path, default=runs.scene_file("caustic"))
    parser.add_argument("--satin", default=f"{runs.ROOT}/build/satin")
    parser.add_argument("--parts", type=int, default=16)
    parser.add_argument("--passes", type=int, default=64)
    parser.add_argument("--photons", default="20000,50000", help="of a pass: global, caustic")
    parser.add_argument("--k", type=int, default=20)
    options = parser.parse_args()
    options.scene = pathlib.Path(options.scene)
    parts = sorted((pathlib.Path(options.dir) / "parts").glob(f"{options.scene.stem}-*.exr"))
    path = np.array([unbiased.layer(part, "RGB") for part in parts])
    options.size = path.shape[1]
    sppm = np.array([render(options, i) for i in range(options.parts)])
    print(f"{len(path)} images by path tracing, {len(sppm)} by sppm of {options.passes} passes")
    for side in (1, 4, 16):
        report(f"{side}x{side} pixels", deviates(blocks(sppm, side), blocks(path, side)))
    means = [images.mean(axis=(1, 2, 3)) for images in (sppm, path)]
    of = means[1].mean()
    deviation = math.sqrt(sum(m.var(ddof=1) / len(m) for m in means))
    print(f"mean: {100 * (means[0].mean() / of - 1):+.3f} % +- {100 * deviation / of:.3f} %")


if __name__ == "__main__":
    main()
