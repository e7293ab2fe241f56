#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Adaptive and uniform placing of radiance records: the systematic error of what glossy surfaces
reflect, at equal number, and how many uniform records reach that of the adaptive ones [K05 figure
6.9, which found 3.3, 1.8 and 7 times as many].

  bench/fig_6_9.py DIR [SCENE ...] [--size N] [--a A]

Both interpolate at the accuracy at which they fill, as the thesis does. Only the channels
`indirect_glossy` count, against pictures without the radiance cache that share the first pass
but no random numbers: several of each, so that the product of two errors tells the systematic
part alone. Prints a table in Markdown; the images stay in DIR. Needs the Python packages numpy and
OpenEXR.
"""
import itertools
import os

import numpy
import OpenEXR

import runs

LAYER = "indirect_glossy."
SEEDS = (1, 2, 3, 4)
STEPS = 5  # of the search for a number of records, and for an error


def channels(path, prefix=""):
    found = OpenEXR.File(path, separate_channels=True).channels()
    return numpy.stack([found[prefix + c].pixels for c in "RGB"], -1).astype(float)


class Scene:
    def __init__(self, options, name):
        self.options, self.name = options, name
        self.size = ["--width", str(options.size), "--height", str(options.size)]
        self.reference = [self.brute(seed) for seed in (11, 12)]
        beauty = sum(channels(path) for path in self.reference) / 2
        self.weight = 1 / (beauty ** 2 + 0.01)

    def brute(self, seed):
        out = f"{self.name}-brute{seed}"
        path = os.path.join(self.options.dir, out + ".exr")
        if not os.path.exists(path):
            runs.render(self.options, runs.scene_file("figures", self.name), out, *self.size,
                        "--seed", str(seed), "--spp", "36", "--set", "adaptive=off", "--set",
                        "radiance-cache=off", "--set", "glossy-samples=32")
        return path

    def measure(self, adaptive, a):
        """Records, statistics, systematic and random error at accuracy a."""
        images = []
        for seed in SEEDS:
            path, stats = runs.render(
                self.options, runs.scene_file("figures", self.name), f"{self.name}-{seed}",
                *self.size, "--seed", str(seed), "--spp", "4", "--set", "adaptive=off", "--set",
                "radiance-max-pixels=100000", "--set", "radiance-widen=1", "--set",
                f"adaptive-cache={adaptive}", "--set",
                f"radiance-a={a:.4f}")
            images.append(channels(path, LAYER))
        brute = [channels(path, LAYER) for path in self.reference]
        pairs = list(itertools.permutations(images, 2))
        systematic = sum(((a - brute[0]) * (b - brute[1]) * self.weight).mean()
                         for a, b in pairs) / len(pairs)
        random = sum(((a - b) ** 2 / 2 * self.weight).mean() for a, b in pairs) / len(pairs)
        return stats["records.radiance"], stats, systematic, random

    def search(self, wanted, index, low, high):
        """The uniform accuracy whose result [index] is the wanted one, which falls with a for the
        number of records (0) and rises for the error (2)."""
        for _ in range(STEPS):
            a = (low * high) ** 0.5
            found = self.measure("off", a)
            if (found[index] > wanted) == (index == 0):
                low = a
            else:
                high = a
        return a, found


def row(name, placing, a, found, extra=""):
    records, stats, systematic, random = found
    passes, overhead = stats.get("cache.passes", 0), stats.get("cache.overhead_s", 0.0)
    part = overhead / stats["time.records_s"]
    print(f"| {name} | {placing} | {a:.3f} | {records:.0f}{extra} | {passes:.0f} | {part:.1%} | "
          f"{systematic:.2e} | {random:.2e} |", flush=True)


def main():
    parser = runs.parser(__doc__)
    parser.add_argument("scene", nargs="*", default=["box-pyramid", "teapot", "hall"])
    parser.add_argument("--size", type=int, default=160)
    parser.add_argument("--a", type=float, default=0.45, help="accuracy before adaptation")
    options = parser.parse_args()
    print("| scene | placing | a | radiance records | passes | overhead | systematic | random |")
    print("|---|---|---|---|---|---|---|---|")
    for name in options.scene:
        scene = Scene(options, name)
        adaptive = scene.measure("on", options.a)
        row(name, "adaptive", options.a, adaptive)
        row(name, "uniform", *scene.search(adaptive[0], 0, 0.05, 1.0))
        a, found = scene.search(adaptive[2], 2, 0.02, 1.0)
        row(name, "uniform, equal error", a, found, f", {found[0] / adaptive[0]:.1f} times")


if __name__ == "__main__":
    main()
