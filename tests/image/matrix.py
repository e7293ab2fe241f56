#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""One small scene per feature, rendered by satin's path tracer and by Mitsuba 3's: a table.

    tests/image/matrix.py BUILD [--only REGEX] [--spp N] [--work DIR]

Each module matrix_*.py beside this file has rows(folder): it may write files into the folder and
returns a dict of scenes, name -> XML between <scene> tags; the sensor is added unless the text has
one. For every row Mitsuba's image is made as make_references.py makes it, with mean and variance
per pixel, and BUILD/tests/image/z_test compares with half as many samples of ours: a z-test per
pixel and channel with Sidak's correction, and the image's mean. The outcome goes to matrix.csv
beside this file: Mitsuba's samples per pixel, the least p of all pixels, the limit for it, the
ratio of the means with its standard deviation; then the mean of the two-pass image, at its
defaults, over that of Mitsuba's. Rows of an earlier run that are not chosen by --only stay in the
table. Needs `pip install mitsuba numpy`.
"""
import argparse
import csv
import importlib
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
TABLE = HERE / "matrix.csv"
HEAD = ["row", "samples", "least_p", "limit", "mean_ratio", "deviation", "two_pass", "verdict"]
TWO_PASS = 0.02  # by how much the two-pass image's mean may differ
LINE = re.compile(r"least p (\S+) of \d+ \(limit ([^)]+)\).*mean ratio (\S+) \+- (\S+)")

SENSOR = """<sensor type="perspective">
  <float name="fov" value="40"/>
  <transform name="to_world"><lookat origin="0, 3, 7" target="0, 0.8, 0" up="0, 1, 0"/></transform>
  <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="64"/>
    <rfilter type="box"/></film>
</sensor>
"""


INTEGRATOR = '<integrator type="path"><integer name="max_depth" value="6"/></integrator>\n'


def scene_text(body):
    integrator = "" if "<integrator" in body else INTEGRATOR
    sensor = "" if "<sensor" in body else SENSOR
    return f'<scene version="3.0.0">\n{integrator}{sensor}{body}\n</scene>\n'


def read_table():
    if not TABLE.exists():
        return {}
    with TABLE.open(encoding="utf-8", newline="") as file:
        return {row["row"]: row for row in csv.DictReader(file)}


def write_table(table):
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        out = csv.DictWriter(file, HEAD, lineterminator="\n")
        out.writeheader()
        out.writerows(table[name] for name in sorted(table))


def reference(path, options):
    """Mitsuba's image of a scene, made once per text of the scene."""
    import make_references as make
    out, about = path.with_suffix(".exr"), path.with_suffix(".made")
    key = f"{make.file_hash(path)} {options.spp}"
    if out.exists() and about.exists() and about.read_text() == key:
        return out
    make.mitsuba_plugins.register()
    make.mi.file_resolver().prepend(str(path.parent))
    mean, variance = make.render(make.mi.load_file(str(path)), options.spp, 32)
    make.write(out, mean, variance, {"spp": str(options.spp), "parts": "32",
                                     "scene_hash": make.file_hash(path)})
    about.write_text(key)
    return out


def two_pass_ratio(path, image, options):
    import numpy as np
    from make_references import mi
    out = path.with_name("two_pass.exr")
    command = [options.build / "src/apps/satin", "render", path, "-o", out, "--quiet"]
    # No path finds the caustics of a point light, which photons do.
    command += ["--set", "caustic-photons=0"] if path.stem.endswith("_point") else []
    subprocess.run(command, check=True)
    ours, theirs = (np.array(mi.Bitmap(str(p)))[:, :, :3].mean() for p in (out, image))
    return ours / theirs


def run_row(name, path, options):
    result = dict.fromkeys(HEAD, "") | {"row": name, "samples": str(options.spp)}
    image = reference(path, options)
    done = subprocess.run([options.build / "tests/image/z_test", options.build / "src/apps/satin",
                           path, image, "8", str(max(options.spp // 16, 1))], cwd=options.work,
                          capture_output=True, text=True, check=False)
    found = LINE.search(done.stdout)
    if found:
        result |= dict(zip(HEAD[2:6], found.groups()))
    result["verdict"] = ["same", "differs"][done.returncode] if found else "failed"
    if found:
        ratio = two_pass_ratio(path, image, options)
        result["two_pass"] = f"{ratio:.4f}"
        if abs(ratio - 1) > TWO_PASS:
            result["verdict"] += ", two-pass differs"
    if not found:
        print(done.stdout + done.stderr)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--only", default="", help="rows whose names match")
    parser.add_argument("--spp", type=int, default=2048)
    parser.add_argument("--work", type=pathlib.Path, default=pathlib.Path("/tmp/satin-matrix"))
    options = parser.parse_args()
    options.build = options.build.resolve()
    options.work = options.work.resolve()
    options.work.mkdir(exist_ok=True)
    sys.path.insert(0, str(HERE))
    rows = {}
    for module in sorted(HERE.glob("matrix_*.py")):
        rows |= importlib.import_module(module.stem).rows(options.work)
    table, wrong = {n: r for n, r in read_table().items() if n in rows}, 0
    for name, body in rows.items():
        if not re.search(options.only, name):
            continue
        path = options.work / f"{name}.xml"
        text = scene_text(body)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
        table[name] = run_row(name, path, options)
        wrong += table[name]["verdict"] != "same"
        print(", ".join(table[name].values()), flush=True)
        write_table(table)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
