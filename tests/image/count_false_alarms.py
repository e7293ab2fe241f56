#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts how often z_test.c fails a correct image, by Mitsuba's own images instead of satin's.

    tests/image/count_false_alarms.py [--spp N] [--parts P] [--pool K] [--draws D] SCENE.xml ...

Renders K parts of N samples per pixel, with other seeds than the reference's, draws P of them D
times, and evaluates each draw against tests/image/references/SCENE.exr as z_test.c does. Prints the
fractions of draws that fail by a pixel and by the image's mean, and the extreme z.
"""
import argparse
import pathlib
from math import erfc, expm1, log1p, sqrt

import mitsuba as mi
import numpy as np

import make_references  # sets Mitsuba's variant

SIGNIFICANCE, MEAN_TOLERANCE, MEAN_Z, ROUNDING = 0.01, 0.003, 3.3, 1e-5


def read(path):
    bitmap = mi.Bitmap(str(path))
    pixels = np.array(bitmap, dtype=np.float64)
    about = bitmap.metadata()
    return pixels[:, :, :3], pixels[:, :, 3:], float(about["spp"]), float(about["parts"])


def evaluate(parts, spp, reference):
    """Worst z of all pixels and channels; worst channel's mean ratio and its deviation."""
    b, variance_b, n_b, parts_b = reference
    n_a = spp * len(parts)
    a, variance_a = parts.mean(axis=0), parts.var(axis=0) / (len(parts) - 1)
    one = np.maximum(variance_a * n_a, variance_b * n_b)
    t = (a - b) / np.sqrt(one / n_a + one / n_b + (ROUNDING * b) ** 2)
    n = parts_b - 1
    z = np.sign(t) * np.sqrt(n * np.log1p(t * t / n)) * (8 * n + 1) / (8 * n + 3)
    ratio = a.sum(axis=(0, 1)) / b.sum(axis=(0, 1))
    deviation = np.sqrt((variance_a + variance_b).sum(axis=(0, 1))) / b.sum(axis=(0, 1))
    c = np.abs(ratio - 1).argmax()
    return z.flat[np.abs(z).argmax()], ratio[c], deviation[c]


def z_limit(count):
    """The |z| whose two-sided p is Sidak's fraction of the significance, by bisection."""
    p, low, high = -expm1(log1p(-SIGNIFICANCE) / count), 0.0, 20.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if erfc(middle / sqrt(2)) > p else (low, middle)
    return low


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="+", type=pathlib.Path)
    parser.add_argument("--spp", type=int, default=128)
    parser.add_argument("--parts", type=int, default=8)
    parser.add_argument("--pool", type=int, default=96)
    parser.add_argument("--draws", type=int, default=200)
    options = parser.parse_args()

    make_references.mitsuba_plugins.register()
    random = np.random.default_rng(1)
    for path in options.scenes:
        reference = read(make_references.TREE / f"tests/image/references/{path.stem}.exr")
        size = reference[0].shape[0]
        scene = make_references.load(path, size)
        pool = np.stack([np.array(mi.render(scene, spp=options.spp, seed=100000 + k),
                                  dtype=np.float64)[:, :, :3] for k in range(options.pool)])
        worst, ratio, deviation = np.array(
            [evaluate(pool[random.permutation(options.pool)[:options.parts]], options.spp,
                      reference)
             for _ in range(options.draws)]).T
        pixels = np.mean(np.abs(worst) > z_limit(reference[0].size))
        means = np.mean(np.abs(ratio - 1) > MEAN_TOLERANCE + MEAN_Z * deviation)
        print(f"{path.stem}: pixels {pixels:.3f}, mean {means:.3f}, "
              f"z {worst.min():.2f} to {worst.max():.2f}", flush=True)


if __name__ == "__main__":
    main()
