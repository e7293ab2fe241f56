#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Rooms that others made, against time: two passes beside path tracing, at equal wall seconds.

  bench/rooms.py ROOMS DIR [--limits 10 30] [--seeds 2] [--denoise]
  bench/rooms.py ROOMS DIR --size 640x360 [--reference SECONDS] ...

ROOMS is a folder of folders, each with a scene.xml and reference-WxH.exr of the same film, as
another renderer made it; those without are left out, saying so. With --size, two path-traced images
of that size and so many seconds each are the references of all rooms instead; they are made once
and stay in DIR. Renders alternate, so that a busy machine is busy for all. Images and statistics
are left in DIR. relMSE over all pixels, FLIP as by `satin compare --flip`, means relative to the
reference's. The references are path-traced and so have noise of their own, which relMSE and FLIP
count; `error` does not (unbiased.py): it is found by both references, or by the reference and a
further path-traced image, of the longest limit. With --size it is relative to the squared radiance
of a third image, by two passes: single bright pixels of a reference would hide errors.
"""
import glob
import json
import os
import re
import statistics
import sys

import runs
import unbiased

METHODS = [("two passes", []), ("path", ["--integrator", "path"])]


def rooms(folder):
    """Name and scene of each room."""
    for scene in sorted(glob.glob(os.path.join(folder, "*", "scene.xml"))):
        yield os.path.basename(os.path.dirname(scene)), scene


def with_references(folder):
    """Name, scene, reference and its size of each room."""
    for name, scene in rooms(folder):
        found = glob.glob(os.path.join(os.path.dirname(scene), "reference-*.exr"))
        size = re.search(r"reference-(\d+)x(\d+)\.exr$", found[0]) if found else None
        if size:
            yield name, scene, found[0], size.groups()
        else:
            print(f"{name}: skipped, it has no reference-WxH.exr", file=sys.stderr)


def made_references(options, name, scene, size):
    """Two path-traced images of a room, their mean, and one by two passes, as paths; made unless
    they are there."""
    width, height = size
    found = []
    for (_, arguments), seed in zip([METHODS[1], METHODS[1], METHODS[0]], ("1000", "1001", "1002")):
        out = f"{name}-{width}x{height}-reference-{seed}"
        image = os.path.join(options.dir, out + ".exr")
        if not os.path.exists(image):
            runs.render(options, scene, out, "--width", width, "--height", height, "--seed", seed,
                        *arguments, "--time", str(options.reference))
        found.append(image)
    mean = os.path.join(options.dir, f"{name}-{width}x{height}-reference.exr")
    runs.run([options.satin, "average", *found[:2], "-o", mean])
    return [*found[:2], mean, found[2]]


def error(options, image, reference):
    found = json.loads(runs.run([options.satin, "compare", image, reference, "--json", "--flip"]))
    return found["relmse"], found["flip"], found["mean_ratio"] - 1


def exact_error(image, first, second, bright):
    """Without the noise of the first two references; relative to an image of little noise."""
    found, b, c, over = (unbiased.channels(x)[0] for x in (image, first, second, bright))
    return unbiased.relative(found, b, c, over ** 2 + 0.01).mean()


def compare(options, name, scene, size, references):
    """Renders a room with each limit and prints the rows. The errors are found by the first two
    references together, relMSE, FLIP and means by the third one. The fourth one shows where the
    room is bright."""
    first, second, shown, bright = references
    width, height = size
    for limit in options.limits:
        results = {}
        for seed in range(options.seeds):
            for denoise in [[], ["--denoise"]] if options.denoise else [[]]:
                for method, arguments in METHODS:
                    out = f"{name}-{method.replace(' ', '-')}-{limit:g}{'-denoised' * len(denoise)}"
                    image, stats = runs.render(
                        options, scene, out, "--width", width, "--height", height, "--time",
                        str(limit), "--seed", str(seed), *arguments, *denoise)
                    row = (exact_error(image, first, second, bright),
                           *error(options, image, shown), stats["image.spp"])
                    results.setdefault(" ".join([method, *denoise]), []).append(row)
        for method, rows in results.items():
            exact, relmse, flip, mean, spp = (statistics.mean(column) for column in zip(*rows))
            print(f"| {name} | {limit:g} | {method} | {exact:.5f} | {relmse:.5f} | "
                  f"{flip:.4f} | {100 * mean:+.2f} % | {spp:.1f} |", flush=True)


def main():
    p = runs.parser(__doc__)
    p.add_argument("--limits", type=float, nargs="+", default=[10, 30], help="wall seconds")
    p.add_argument("--seeds", type=int, default=2)
    p.add_argument("--denoise", action="store_true", help="both methods again with --denoise")
    p.add_argument("--size", help="WIDTHxHEIGHT, with references by path tracing")
    p.add_argument("--reference", type=float, default=300, help="wall seconds of each of them")
    # The folder of rooms comes first.
    if len(sys.argv) < 2 or not os.path.isdir(sys.argv[1]):
        sys.exit("skipped: give a folder of rooms, and one for images\n\n" + __doc__)
    folder = sys.argv.pop(1)
    options = p.parse_args()
    print("| room | seconds | method | error | relMSE | FLIP | mean | samples per pixel |\n"
          "|---|---|---|---|---|---|---|---|")
    if options.size:
        size = options.size.split("x")
        for name, scene in rooms(folder):
            compare(options, name, scene, size, made_references(options, name, scene, size))
    else:
        for name, scene, reference, size in with_references(folder):
            width, height = size
            traced, _ = runs.render(options, scene, f"{name}-traced", "--width", width, "--height",
                                    height, "--integrator", "path", "--time",
                                    str(max(options.limits)), "--seed", "1000")
            compare(options, name, scene, size, [reference, traced, reference, reference])


if __name__ == "__main__":
    main()
