#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Error and time of two-pass renders of the data scenes against converged path-traced references.

  bench/quality.py references DIR [SCENE ...]   render references (slow: PARTS x SPP samples)
  bench/quality.py measure DIR [SCENE ...]      production, --time 4, --time 11; with --path also
                                                path for 11 s, and its time at equal error

DIR keeps the references (400x400) and what is rendered. relMSE is the mean of
(x - r)^2 / (r^2 + 0.01) with emitters masked and the reference's own noise subtracted.
"""
import os
import time

import runs

SCENES = ["indirect-room", "cornell-glossy", "cornell-metal", "caustic", "sphere-on-floor", "vase"]


def scene_file(name):
    return name if name.endswith(".xml") else runs.scene_file(name)


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
                runs.run([options.satin, "render", scene_file(name), "-o", part, "--integrator",
                          "path", "--spp", str(options.spp), "--seed", str(1000 + seed), "--float",
                          "--quiet"] + options.extra.split())
        runs.run([options.satin, "average", *parts, "-o",
                  os.path.join(options.dir, label(name) + ".exr")])


def measure_one(options, name, args):
    out = os.path.join(options.dir, label(name) + "-image.exr")
    start = time.time()
    runs.run(["/usr/bin/time", "-f", "%M", "-o", out + ".mem", options.satin, "render",
              scene_file(name), "-o", out, "--quiet"] + args + options.extra.split())
    seconds = time.time() - start
    relmse, bias = runs.error(options, out, label(name))
    with open(out + ".mem") as f:
        megabytes = int(f.read().split()[-1]) / 1024
    return relmse, bias, seconds, megabytes


def measure(options):
    kinds = [["--quality", "production"], ["--time", "4"], ["--time", "11"]]
    path = ["--integrator", "path", "--time", "11", "--spp", "65536"]
    if options.path:
        kinds.append(path)
    print("%-16s %-44s %9s %8s %7s %7s" % ("scene", "run", "relMSE", "bias", "s", "MB"))
    for name in options.scene:
        errors = []
        for args in kinds:
            relmse, bias, seconds, megabytes = measure_one(options, name, args)
            print("%-16s %-44s %9.6f %+7.2f%% %7.2f %7.0f"
                  % (label(name), " ".join(args), relmse, 100 * bias, seconds, megabytes),
                  flush=True)
            errors.append(relmse)
        # The error of path tracing is variance alone, which falls as 1 / time.
        for args, error in zip(kinds, errors if options.path else []):
            if args is not path and error > 0:
                print("%-16s %-44s %9.6f %8s %7.0f %7.0f"
                      % (label(name), "path, at the error of " + " ".join(args), error, "",
                         seconds * errors[-1] / error, megabytes), flush=True)


def main():
    parser = runs.parser(__doc__, what=["references", "measure"])
    parser.add_argument("scene", nargs="*", default=SCENES)
    parser.add_argument("--parts", type=int, default=16)
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--path", action="store_true", help="measure path tracing for 11 s too")
    options = parser.parse_args()
    os.makedirs(options.dir, exist_ok=True)
    if options.what == "references":
        references(options)
    else:
        measure(options)


if __name__ == "__main__":
    main()
