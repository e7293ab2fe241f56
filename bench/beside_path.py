#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Two passes beside path tracing at equal time, over scenes that have no reference.

  bench/beside_path.py DIR [--limits 2 8] [--seeds 2] [--first-seed 0] [--size 200] [--cpu]
      [--reference-times 4] [--rooms FIRST:END] [--scenes SCENE ...] [--over RATIO]

DIR keeps what was rendered, and rows.tsv, a row per scene and limit as soon as it is known: a run
that was ended goes on from there, if it is begun again with the same arguments. Without --scenes
and --rooms, all of data/scenes; --rooms adds random rooms of tests/sweep. Limits are wall seconds
of all cores, and renders alternate, so that a busy machine is busy for both; with --cpu they are
processor seconds of one thread. With --over, only scenes of which some row in DIR has at least that
ratio are rendered at limits that have no row yet.

Errors are found by two path-traced images of other seeds and of --reference-times the limit
(unbiased.py), relative to the square of their median over 5x5 pixels plus .05 of the image's mean.
Pixels that see emitters are left out, and those in which the two differ by more than six times that
median, as one of them has a firefly there. That is in favour of path, and so is what path leaves
out of caustics. `ratio` is the error of two passes over that of path, `trimmed` the same without
the worst .5 % of the pixels of each, `mean` that of two passes over that of all path-traced images,
and its noise one standard error of the latter; `caustic` is the fraction of the mean that two
passes find by caustic photons.
"""
import math
import pathlib
import statistics
import subprocess
import sys

import numpy as np
from scipy.ndimage import median_filter

import runs
import unbiased

sys.path.insert(0, str(pathlib.Path(runs.ROOT) / "tests" / "sweep"))
from rooms import write_rooms  # pylint: disable=wrong-import-position

FLOOR = 0.05
FIREFLY = 6.0  # times the median
TRIMMED = 0.005  # fraction of pixels
COLUMNS = ("two passes", "path", "ratio", "trimmed", "mean", "noise", "caustic")


def image_of(options, scene, limit, seed, number):
    """Path of the image of one of the four renders; path-traced ones of an earlier run are kept."""
    way = "path" if number else "two-pass"
    times = options.reference_times if number > 1 else 1.0
    number = str(4 * seed + number)
    name = f"{scene.stem}-{limit:g}-{way}-{number}"
    found = pathlib.Path(options.dir) / (name + ".exr")
    if way == "path" and found.exists():
        return found
    return runs.render(options, scene, name, "--integrator", way, "--width", str(options.size),
                       "--height", str(options.size), "--time", str(times * limit), "--seed",
                       number)[0]


def trimmed(values):
    return np.sort(values)[:math.ceil((1.0 - TRIMMED) * values.size)].mean()


def errors(options, scene, limit, seed):
    """Of two passes and of path, whole and trimmed, by two further path-traced images; the mean of
    two passes over that of path, its noise, and the fraction of caustics. None: no pixel counts."""
    paths = [image_of(options, scene, limit, seed, i) for i in range(4)]
    images = [unbiased.channels(path) for path in paths]
    two, path, b, c = (image for image, _ in images)
    emitters = np.any([m for _, m in images], axis=0)
    mean = 0.5 * (b + c)
    scale = median_filter(mean, size=(5, 5, 1)) + FLOOR * mean.mean()
    mask = emitters | (np.abs(b - c).sum(axis=-1) > FIREFLY * scale.sum(axis=-1))
    if mask.all() or not mean.any():
        return None
    found = [unbiased.relative(image, b, c, scale ** 2)[~mask] for image in (two, path)]
    # Of all path-traced images, by their samples.
    times = options.reference_times
    all_path = (path + times * (b + c)) / (1 + 2 * times)
    lit = ~emitters
    brightness = all_path[lit].mean()
    noise = 0.5 * np.sqrt(np.square((b - c)[lit].mean(axis=-1)).sum()) / lit.sum()
    return (found[0].mean(), found[1].mean(), trimmed(found[0]), trimmed(found[1]),
            two[lit].mean() / brightness - 1, noise / brightness,
            unbiased.layer(paths[0], "caustic")[lit].mean() / brightness)


def measure(options, scene, limit):
    """A row, or None if the scene shows emitters alone."""
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    found = [errors(options, scene, limit, seed) for seed in seeds]
    if None in found:
        return None
    two, path, two_trimmed, path_trimmed, mean, noise, caustic = np.mean(found, axis=0)
    return [two, path, two / path, two_trimmed / path_trimmed, mean,
            noise / math.sqrt(len(found)), caustic]


class Rows:
    """What is known of scenes and limits, in a file that grows row by row."""

    def __init__(self, options):
        self.path = pathlib.Path(options.dir) / "rows.tsv"
        self.of = {}
        lines = self.path.read_text(encoding="utf-8").splitlines() if self.path.exists() else []
        for line in lines:
            name, limit, *values = line.split("\t")
            self.of[name, float(limit)] = [float(v) for v in values] or None

    def add(self, name, limit, row):
        self.of[name, limit] = row
        with open(self.path, "a", encoding="utf-8") as file:
            values = [f"{v:.6g}" for v in row or ()]
            file.write("\t".join([name, f"{limit:g}", *values]) + "\n")

    def chosen(self, name, over):
        """Whether the scene is to be rendered at a further limit."""
        rows = [row for (scene, _), row in self.of.items() if scene == name and row]
        return over is None or any(row[2] >= over or row[3] >= over for row in rows)


def show(name, limit, row):
    if row is None:
        print(f"| {name} | {limit:g} | sees emitters alone |" + " |" * 6, flush=True)
        return
    two, path, ratio, cut, mean, noise, caustic = row
    print(f"| {name} | {limit:g} | {two:.2e} | {path:.2e} | {ratio:.2f} | {cut:.2f} | "
          f"{100 * mean:+.1f} % | {100 * noise:.1f} % | {100 * caustic:.1f} % |", flush=True)


def summarize(rows, limit):
    known = [(name, row) for (name, at), row in rows.of.items() if at == limit and row]
    if not known:
        return
    worse = [sum(row[i] > 1.0 for _, row in known) for i in (2, 3)]
    medians = [statistics.median(row[i] for _, row in known) for i in (2, 3)]
    print(f"\n{limit:g} s: {len(known)} scenes, worse than path in {worse[0]}, trimmed {worse[1]}; "
          f"median ratio {medians[0]:.3f}, trimmed {medians[1]:.3f}\n\nThe worst ten:\n")
    heading()
    for name, row in sorted(known, key=lambda x: -max(x[1][2], x[1][3]))[:10]:
        show(name, limit, row)


def heading():
    print("| scene | seconds | " + " | ".join(COLUMNS) + " |\n|" + "---|" * (2 + len(COLUMNS)))


def scenes(options):
    found = [pathlib.Path(s) for s in options.scenes]
    if not found and not options.rooms:
        found = sorted((pathlib.Path(runs.ROOT) / "data/scenes").rglob("*.xml"))
    if options.rooms:
        first, end = (int(x) for x in options.rooms.split(":"))
        found += write_rooms(first, end, pathlib.Path(options.dir) / "rooms")
    return found


def main():
    p = runs.parser(__doc__)
    p.add_argument("--scenes", nargs="+", default=[], metavar="SCENE")
    p.add_argument("--limits", type=float, nargs="+", default=[2, 8])
    p.add_argument("--seeds", type=int, default=2)
    p.add_argument("--first-seed", type=int, default=0)
    p.add_argument("--size", type=int, default=200, help="width and height")
    p.add_argument("--reference-times", type=float, default=4)
    p.add_argument("--rooms", help="FIRST:END")
    p.add_argument("--over", type=float, metavar="RATIO")
    options = p.parse_args()
    pathlib.Path(options.dir).mkdir(parents=True, exist_ok=True)
    rows = Rows(options)
    heading()
    for scene in scenes(options):
        for limit in options.limits:
            if (scene.stem, limit) not in rows.of and rows.chosen(scene.stem, options.over):
                rows.add(scene.stem, limit, measure(options, scene, limit))
            if (scene.stem, limit) in rows.of:
                show(scene.stem, limit, rows.of[scene.stem, limit])
    for limit in options.limits:
        summarize(rows, limit)


if __name__ == "__main__":
    try:
        main()
    except subprocess.SubprocessError as error:
        sys.exit(str(error))
