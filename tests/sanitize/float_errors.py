#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders small scenes with a build that reports floating-point divisions by zero and conversions
to integers out of range, and compares the lines with those that are allowed.

  tests/sanitize/float_errors.py SOURCE BUILD

SOURCE is the tree; BUILD a folder for the instrumented build, made if it is missing and kept, so
that the next run only compiles what changed. allowed.txt beside this file has a line for each
line that may divide by zero: `FILE: TEXT OF THE LINE  # why it is sound`. The exit status is 1 if
another line does, or if an allowed line is in its file no more.
"""
import pathlib
import re
import subprocess
import sys

FLAGS = "-fsanitize=float-divide-by-zero,float-cast-overflow"
# Every BRDF table, light, first pass and integrator that the data has, at the smallest sizes.
RENDERS = [
    ["caustic.xml"],
    ["cornell-glossy.xml"],
    ["cornell-metal.xml", "--time", "1"],
    ["cornell-metal.xml", "--set", "radiance-basis=sh", "--set", "adaptive-cache=off"],
    ["furnace-box-50.xml"],
    ["indirect-room.xml", "--set", "irradiance-radius=hessian"],
    ["indirect-room.xml", "--first-pass", "recursive"],
    ["sphere-on-floor.xml", "--first-pass", "photons"],
    ["vase.xml", "--set", "irradiance-noise=0.05"],
    ["vase.xml", "--integrator", "path", "--spp", "4"],
    ["caustic.xml", "--integrator", "photons"],
    ["caustic.xml", "--set", "photons=0"],
]
SIZE = ["--width", "24", "--height", "24", "--quality", "draft", "--set", "photons=20000", "--set",
        "caustic-photons=20000", "--quiet"]
REPORT = re.compile(r"^(?:\.\./)*(.+?):(\d+):\d+: runtime error: (.*)$", re.MULTILINE)


def build(source, folder):
    if not (folder / "build.ninja").exists():
        # Compiling takes longer than the renders, and reports have their lines without symbols.
        subprocess.run(["meson", "setup", folder, source, "-Ddebug=false", "-Doptimization=1",
                        "-Dc_args=" + FLAGS, "-Dc_link_args=" + FLAGS, "-Dcpp_link_args=" + FLAGS],
                       check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["ninja", "-C", folder, "--quiet", "src/apps/satin",
                    "src/load/satin_oiio.so"], check=True)
    return folder / "src/apps/satin"


def read_allowed(source):
    allowed, stale = set(), []
    for line in (source / "tests/sanitize/allowed.txt").read_text().splitlines():
        if not line.strip() or line.startswith("#"):
            continue
        name, text = line.split("  # ")[0].split(": ", 1)
        allowed.add((name, text))
        if text not in [x.strip() for x in (source / name).read_text().splitlines()]:
            stale.append(f"{name}: no line reads '{text}': take it out of allowed.txt")
    return allowed, stale


def errors(source, satin, scene, arguments, folder):
    done = subprocess.run([satin, "render", scene, "-o", folder / "image.exr", *SIZE, *arguments],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        sys.exit(f"{scene.name} {' '.join(arguments)}: status {done.returncode}\n{done.stdout}")
    for file, number, what in REPORT.findall(done.stdout):
        name = next(str(p.relative_to(source)) for p in [source / file, pathlib.Path("/") / file]
                    if p.exists())
        yield name, (source / name).read_text().splitlines()[int(number) - 1].strip(), number, what


def main():
    source, folder = (pathlib.Path(x).resolve() for x in sys.argv[1:3])
    satin = build(source, folder)
    allowed, wrong = read_allowed(source)
    known = set()
    cases = sorted((source / "data/scenes/cases").glob("*.xml"))
    for name, *arguments in RENDERS + [[str(case)] for case in cases]:
        for file, text, number, what in errors(source, satin, source / "data/scenes" / name,
                                               arguments, folder):
            if (file, text) not in allowed and (file, number) not in known:
                wrong.append(f"{file}:{number}: {what}: {text}  ({pathlib.Path(name).name})")
            known.add((file, number))
    print(f"{len(RENDERS) + len(cases)} renders, {len(known)} lines divide by zero or overflow")
    print("\n".join(wrong))
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
