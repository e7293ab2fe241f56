# SPDX-License-Identifier: Apache-2.0
"""Two placements of records in one scene, at equal number, and how many records the plain one needs
to be as good.

One layer of the image counts, against images without the cache that have the same first pass
but other random numbers. The thesis found by eye whether an image is free of artefacts; here
`visible error` is the fraction of pixels around which the mean of 5x5 deviates by more than 4 % of
all light there, twice what Weber's law hides. The systematic error is estimated by products of two
errors of different seeds.
"""
import dataclasses
import itertools
import os

import numpy
import OpenEXR
import scipy.ndimage

import runs

SEEDS = (1, 2, 3, 4)
STEPS = 5  # of the search for a number of records, and for visible errors
VISIBLE = 0.04
HEAD = ("| scene | placement | a | records | passes | fill, s | overhead | systematic | random "
        "| visible error |\n|---|---|---|---|---|---|---|---|---|---|")


def channels(path, prefix=""):
    found = OpenEXR.File(path, separate_channels=True).channels()
    return numpy.stack([found[prefix + c].pixels for c in "RGB"], -1).astype(float)


def luminance(image):
    """Around each pixel."""
    return scipy.ndimage.uniform_filter(image @ (0.2126, 0.7152, 0.0722), 5)


def sets(*options):
    """Arguments of satin render."""
    return [part for option in options for part in ("--set", option)]


@dataclasses.dataclass
class Found:
    a: float
    records: int
    stats: dict
    systematic: float
    random: float
    visible: float


@dataclasses.dataclass
class Placement:
    options: object
    name: str       # of a scene of data/scenes/figures
    kind: str       # of the records: irradiance or radiance
    layer: str      # of the image
    brute: tuple    # options of images without the cache
    both: tuple     # options of both placements
    part: tuple = (slice(None), slice(None))  # rows and columns that count

    def __post_init__(self):
        self.size = ["--width", str(self.options.size), "--height", str(self.options.size)]
        paths = [self.reference(seed) for seed in (11, 12)]
        self.truth = [channels(path, self.layer + ".") for path in paths]
        image = sum(channels(path) for path in paths) / 2
        self.weight = 1 / (image ** 2 + 0.01)
        self.light = luminance(image) + 0.01

    def render(self, out, seed, *args):
        return runs.render(self.options, runs.scene_file("figures", self.name),
                           f"{self.name}-{out}", *self.size, "--seed", str(seed), *args,
                           *sets("adaptive-sampling=off"))

    def reference(self, seed):
        path = os.path.join(self.options.dir, f"{self.name}-brute{seed}.exr")
        if not os.path.exists(path):
            self.render(f"brute{seed}", seed, "--spp", "16", *sets(*self.brute))
        return path

    def measure(self, a, *placement):
        images = []
        for seed in SEEDS:
            path, stats = self.render(seed, seed, "--spp", "4", *sets(
                *self.both, *placement, f"{self.kind}-a={a:.4f}"))
            images.append(channels(path, self.layer + "."))
        systematic = [((x - self.truth[0]) * (y - self.truth[1]) * self.weight)[self.part].mean()
                      for x, y in itertools.permutations(images, 2)]
        random = [((x - y) ** 2 / 2 * self.weight)[self.part].mean()
                  for x, y in itertools.combinations(images, 2)]
        mean = sum(self.truth) / 2
        visible = [(abs(luminance(x - mean)) > VISIBLE * self.light)[self.part].mean()
                   for x in images]
        return Found(a, stats["records." + self.kind], stats, numpy.mean(systematic),
                     numpy.mean(random), numpy.mean(visible))

    def search(self, plain, enough, low, high):
        """The largest accuracy a of the plain placement that gives `enough`, or the last tried."""
        best = None
        for _ in range(STEPS):
            a = (low * high) ** 0.5
            found = self.measure(a, plain)
            if enough(found):
                low, best = a, found
            else:
                high = a
        return best or found

    def row(self, placement, found, extra=""):
        passes = found.stats.get("cache.passes", 0)
        fill, overhead = found.stats["time.records_s"], found.stats.get("cache.overhead_s", 0.0)
        print(f"| {self.name} | {placement} | {found.a:.3f} | {found.records:.0f}{extra} | "
              f"{passes:.0f} | {fill:.1f} | {overhead / fill:.1%} | {found.systematic:.1e} | "
              f"{found.random:.1e} | {found.visible:.2%} |", flush=True)

    def compare(self, a, better, plain, low):
        """Prints rows of a table under HEAD; `low` bounds the accuracy of the plain placement."""
        best = self.measure(a, better)
        self.row(better, best)
        self.row(plain, self.search(plain, lambda f: f.records > best.records, low, 2 * a))
        same = self.search(plain, lambda f: f.visible <= best.visible, low, a)
        self.row(plain + ", as good", same, f", {same.records / best.records:.1f} times")
