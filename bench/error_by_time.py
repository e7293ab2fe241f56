#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Error against time: time limits that double, and the presets, which should lie on their line.

  bench/error_by_time.py DIR [SCENE ...] [--seeds N] [--limits S S ...] [--picture FILE.png]

DIR has references that `bench/quality.py references DIR SCENE ...` made, of the size that --extra
asks for here too. Prints a table in Markdown: for each scene and run the mean relMSE over the
seeds, its standard error, wall and processor seconds, and for a preset its error over that of the
limits, interpolated, at as many wall seconds. The exit status is 1 if an error rises from one limit
to the next by more than three standard errors. Needs a machine that does nothing else, or --cpu; a
picture needs matplotlib.
"""
import math
import resource
import statistics
import sys
import time

import runs

SCENES = ["indirect-room", "cornell-glossy", "cornell-metal", "caustic", "sphere-on-floor", "vase"]
QUALITIES = ["draft", "preview", "production"]


def render_once(options, scene, args, seed):
    """The relMSE of a render, its wall and its processor seconds."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    image, _ = runs.render(options, runs.scene_file(scene), "limit-" + scene, *args, "--seed",
                           str(seed))
    wall = time.monotonic() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return runs.error(options, image, scene)[0], wall, cpu


def mean_row(options, args, renders):
    errors, walls, cpus = zip(*renders)
    spread = statistics.stdev(errors) / math.sqrt(len(errors)) if len(errors) > 1 else 0.0
    return {"run": " ".join(args), "error": statistics.mean(errors), "spread": spread,
            "wall": statistics.mean(cpus if options.cpu else walls), "cpu": statistics.mean(cpus)}


def error_at(rows, wall):
    """The error at so many seconds, linear between logarithms, and extrapolated beyond the ends."""
    points = [(math.log(r["wall"]), math.log(r["error"])) for r in rows]
    i = max([k for k in range(len(points) - 1) if points[k][0] <= math.log(wall)], default=0)
    (x0, y0), (x1, y1) = points[i], points[i + 1]
    return math.exp(y0 + (math.log(wall) - x0) * (y1 - y0) / (x1 - x0))


def show(scene, row, beside=""):
    print("| %s | %s | %.2f ± %.2f | %.2f | %.2f | %s |" % (
        scene, row["run"], 1e4 * row["error"], 1e4 * row["spread"], row["wall"], row["cpu"],
        beside), flush=True)


def measure_scene(options, scene):
    arguments = [["--time", "%g" % seconds] for seconds in options.limits] + \
                [["--quality", quality] for quality in QUALITIES]
    renders = [[] for _ in arguments]
    # All runs by one seed, then those by the next, so that a busy machine slows all of them down.
    for seed in range(options.seeds):
        for args, done in zip(arguments, renders):
            done.append(render_once(options, scene, args, seed))
    rows = [mean_row(options, args, done) for args, done in zip(arguments, renders)]
    limits, presets = rows[:len(options.limits)], rows[len(options.limits):]
    for row in limits:
        show(scene, row)
    for row in presets:
        show(scene, row, "%.2f" % (row["error"] / error_at(limits, row["wall"])))
    rises = [b["run"] for a, b in zip(limits, limits[1:])
             if b["error"] > a["error"] + 3.0 * math.hypot(a["spread"], b["spread"])]
    for run in rises:
        print("%s: the error at %s is larger than before" % (scene, run), file=sys.stderr)
    return limits, presets, rises


def draw(found, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axis = plt.subplots(figsize=(7, 4.5))
    for scene, (limits, presets, _) in found.items():
        line, = axis.loglog([r["wall"] for r in limits], [r["error"] for r in limits], label=scene)
        axis.loglog([r["wall"] for r in presets], [r["error"] for r in presets], "o",
                    color=line.get_color())
    axis.set_xlabel("seconds")
    axis.set_ylabel("relMSE")
    axis.set_title("lines: --time; points: draft, preview, production")
    axis.grid(alpha=0.3, which="both")
    axis.legend()
    figure.savefig(path, dpi=100, bbox_inches="tight", metadata={"Software": None})


def main():
    parser = runs.parser(__doc__)
    parser.add_argument("scene", nargs="*", default=SCENES)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--limits", type=float, nargs="+", default=[2, 4, 8, 16, 32, 60])
    parser.add_argument("--picture", help="draw the lines to this PNG")
    options = parser.parse_intermixed_args()
    print("| scene | run | relMSE x 10^4 | s | CPU s | over limits |\n|---|---|---|---|---|---|")
    found = {scene: measure_scene(options, scene) for scene in options.scene}
    if options.picture:
        draw(found, options.picture)
    sys.exit(1 if any(rises for _, _, rises in found.values()) else 0)


if __name__ == "__main__":
    main()
