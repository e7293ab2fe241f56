#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Error and time of two-pass renders of the data scenes against converged path-traced references.

  bench/quality.py references DIR [SCENE ...]   render references (slow: PARTS x SPP samples)
  bench/quality.py measure DIR [SCENE ...]      production, --time 4, --time 11; with --path also
                                                path for 11 s, and its time at equal error

DIR keeps the references (400x400) and what is rendered. relMSE is the mean of
(x - r)^2 / (r^2 + 0.01) with emitters masked and the reference's own noise subtracted.
"""
import argparse
import json
import os
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SCENES = ["indirect-room", "cornell-glossy", "cornell-metal", "caustic", "sphere-on-floor", "vase"]


def run(args):
    start = time.time()
    done = subprocess.run(args, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        sys.exit("failed: " + " ".join(args))
    return done.stdout, time.time() - start


def scene_file(name):
    return name if name.endswith(".xml") else os.path.join(ROOT, "data", "scenes", name + ".xml")


def label(name):
    folder, base = os.path.split(name)
    return os.path.basename(folder) if base == "scene.xml" else base.removesuffix(".xml")


def references(options):
    for name in options.scene:
        parts = []
        for seed in range(options.parts):
            part = os.path.join(options.dir, "%s-part%02d.exr" % (label(name), seed))
            parts.append(part)
            if not os.path.exists(part):
                run([options.satin, "render", scene_file(name), "-o", part, "--integrator", "path",
                     "--spp", str(options.spp), "--seed", str(1000 + seed), "--quiet"]
                    + options.extra.split())
        mask = os.path.join(options.dir, label(name) + "-mask.exr")
        run([options.satin, "render", scene_file(name), "-o", mask, "--integrator", "direct",
             "--spp", "64", "--set", "light_samples=1", "--quiet"] + options.extra.split())
        run([options.average, os.path.join(options.dir, label(name) + ".exr"), mask] + parts)


def measure_one(options, name, args):
    out = os.path.join(options.dir, label(name) + "-image.exr")
    _, seconds = run(["/usr/bin/time", "-f", "%M", "-o", out + ".mem", options.satin, "render",
                      scene_file(name), "-o", out, "--quiet"] + args + options.extra.split())
    text, _ = run([options.satin, "compare", out, os.path.join(options.dir, label(name) + ".exr"),
                   "--mask-emission", "--json"])
    result = json.loads(text)
    with open(out + ".mem") as f:
        megabytes = int(f.read().split()[-1]) / 1024
    return result, seconds, megabytes


def measure(options):
    runs = [["--quality", "production"], ["--time", "4"], ["--time", "11"]]
    path = ["--integrator", "path", "--time", "11", "--spp", "65536"]
    if options.path:
        runs.append(path)
    print("%-16s %-44s %9s %8s %7s %7s" % ("scene", "run", "relMSE", "bias", "s", "MB"))
    for name in options.scene:
        errors = []
        for args in runs:
            result, seconds, megabytes = measure_one(options, name, args)
            print("%-16s %-44s %9.6f %+7.2f%% %7.2f %7.0f"
                  % (label(name), " ".join(args), result["relmse"],
                     100 * (result["mean_ratio"] - 1), seconds, megabytes), flush=True)
            errors.append(result["relmse"])
        # The error of path tracing is variance alone, which falls as 1 / time.
        for args, error in zip(runs, errors if options.path else []):
            if args is not path and error > 0:
                print("%-16s %-44s %9.6f %8s %7.0f %7.0f"
                      % (label(name), "path, at the error of " + " ".join(args), error, "",
                         seconds * errors[-1] / error, megabytes), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["references", "measure"])
    parser.add_argument("dir")
    parser.add_argument("scene", nargs="*", default=SCENES)
    parser.add_argument("--satin", default=os.path.join(ROOT, "build", "satin"))
    parser.add_argument("--average", default=os.path.join(ROOT, "build", "bench", "average"))
    parser.add_argument("--parts", type=int, default=16)
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--path", action="store_true", help="measure path tracing for 11 s too")
    parser.add_argument("--extra", default="", help="more arguments for satin render")
    options = parser.parse_args()
    os.makedirs(options.dir, exist_ok=True)
    if options.what == "references":
        references(options)
    else:
        measure(options)


if __name__ == "__main__":
    main()
