#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Two passes beside path tracing at equal wall time, over scenes that have no reference.

  bench/beside_path.py DIR [--limits 2 8] [--seeds 2] [--size 200] [--rooms FIRST:END]
      [--scenes SCENE ...]

DIR keeps what was rendered; without --scenes, all of data/scenes; --rooms adds random rooms of
tests/sweep. Renders alternate, so that a busy machine is busy for both. Errors are found by two
path-traced images of other seeds and of four times the limit (unbiased.py), relative to the square
of their mean plus that of .05 of the image's mean. Pixels are left out in which these two differ by
more than their sum, as one of them has a firefly there, and those that see emitters; that is in
favour of path, and so is what path leaves out of caustics.
"""
import pathlib
import subprocess
import sys

import numpy as np

import runs
import unbiased

sys.path.insert(0, str(pathlib.Path(runs.ROOT) / "tests" / "sweep"))
from rooms import write_rooms  # pylint: disable=wrong-import-position

FLOOR = 0.05
REFERENCE_TIMES = 4


def unsure(b, c):
    """Pixels in which two images of one scene differ too much."""
    difference = np.abs(b - c).sum(axis=-1)
    return difference > (b + c).sum(axis=-1)


def errors(options, scene, limit, seed):
    """Of two passes and of path, each by two further path-traced images."""
    images = []
    for way, times in (("two-pass", 1), ("path", 1), ("path", REFERENCE_TIMES),
                       ("path", REFERENCE_TIMES)):
        number = str(4 * seed + len(images))
        image, _ = runs.render(options, scene, f"{scene.stem}-{way}-{number}", "--integrator", way,
                               "--width", str(options.size), "--height", str(options.size),
                               "--time", str(times * limit), "--seed", number)
        images.append(unbiased.channels(image))
    two, path, b, c = (image for image, _ in images)
    mask = np.any([m for _, m in images], axis=0) | unsure(b, c)
    if mask.all():
        return None
    mean = 0.5 * (b + c)
    over = mean ** 2 + (FLOOR * mean.mean()) ** 2
    return [unbiased.relative(image, b, c, over)[~mask].mean() for image in (two, path)]


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
    p.add_argument("--limits", type=float, nargs="+", default=[2, 8], help="wall seconds")
    p.add_argument("--seeds", type=int, default=2)
    p.add_argument("--size", type=int, default=200, help="width and height")
    p.add_argument("--rooms", help="FIRST:END")
    options = p.parse_args()
    pathlib.Path(options.dir).mkdir(parents=True, exist_ok=True)
    worse = total = 0
    print("| scene | seconds | two passes | path | ratio |\n|---|---|---|---|---|")
    for scene in scenes(options):
        for limit in options.limits:
            found = [errors(options, scene, limit, s) for s in range(options.seeds)]
            if None in found:
                print(f"| {scene.stem} | {limit:g} | sees emitters alone | | |")
                continue
            two, path = (float(np.mean(x)) for x in zip(*found))
            ratio = two / path if path > 0 else float("nan")
            total += 1
            worse += ratio > 1
            print(f"| {scene.stem} | {limit:g} | {two:.2e} | {path:.2e} | {ratio:.2f} |",
                  flush=True)
    print(f"\nworse than path in {worse} of {total}")


if __name__ == "__main__":
    try:
        main()
    except subprocess.SubprocessError as error:
        sys.exit(str(error))
