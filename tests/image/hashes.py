#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Hashes of the pixels of all data scenes and cases, small and quick, and of a few larger images. A
change of the code that must not change images is shown by equal hashes of the programs before and
after it.

Usage: hashes.py SATIN [OTHER]
With one program, prints a line `hash scene options` for each image. With two, prints those that
differ and exits 1 if there are any. A render that fails is an error, also if both programs fail
alike: it is printed, and the exit status is 2.

Every scene is rendered by three integrators at 48x48, by two passes at quality draft. The larger
images are for what these do not show: the other two qualities, batches of more records than the
least (from 16384 sites at a time on) and the records of further bounces. One program takes 40
seconds on two free cores.
"""
import argparse
import concurrent.futures
import hashlib
import pathlib
import struct
import subprocess
import sys
import tempfile

SCENES = pathlib.Path(__file__).resolve().parents[2] / "data/scenes"
COMMON = ["--spp", "4", "--threads", "1", "--quiet"]
# The sides of the image and the options with which every scene is rendered.
SMALL = [(48, "--integrator two-pass --quality draft"), (48, "--integrator path"),
         (48, "--integrator photons --quality draft")]
# Scenes, sides and options. The slowest come first, so that all cores are used until the end.
LARGER = [("cases/metal-room.xml", 96, "--quality production"),
          ("cases/window.xml", 96, "--quality preview"), ("vase.xml", 96, "--quality preview"),
          ("cornell-glossy.xml", 96, "--quality preview"),
          ("indirect-room.xml", 192, "--quality draft"),
          ("cornell-glossy.xml", 48, "--quality draft --first-pass recursive")]


class RenderFailed(Exception):
    """A render that ended without an image."""


def pixels(data):
    """The content of an EXR file without its metadata: channels, their order, and chunks."""
    at, attributes = 8, {}
    while data[at]:
        name, kind, rest = data[at:at + 600].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        size, = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    first, = struct.unpack_from("<Q", data, at + 1)
    return attributes[b"channels"] + attributes[b"dataWindow"] + data[first:]


def as_before(satin, options):
    """The arguments with which a program writes the channels of programs before --float."""
    helped = subprocess.run([satin, "help", "render"], capture_output=True, text=True, check=True)
    if "--float " not in helped.stdout:
        return []
    # Since then path has channels of variance, which are left out here.
    path = "--integrator path" in options
    return ["--float"] + (["--layers", "emission,albedo,normal,depth,samples"] if path else [])


def hash_of(satin, scene, side, options):
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out.exr"
        done = subprocess.run(
            [satin, "render", SCENES / scene, "-o", out, "--width", str(side),
             "--height", str(side), *options.split(), *COMMON, *as_before(satin, options)],
            capture_output=True, text=True)
        if done.returncode:
            raise RenderFailed(f"{satin} {scene} {side}x{side} {options}: exit {done.returncode}: "
                               f"{done.stderr.strip()}")
        return hashlib.sha256(pixels(out.read_bytes())).hexdigest()[:16]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("satin", nargs="+", help="one program or two")
    programs = [pathlib.Path(p).resolve() for p in parser.parse_args().satin]
    scenes = [s.relative_to(SCENES) for s in sorted(SCENES.glob("**/*.xml"))]
    cases = LARGER + [(scene, *small) for scene in scenes for small in SMALL]
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        hashes = [list(pool.map(lambda case: hash_of(program, *case), cases))
                  for program in programs]
    names = [f"{scene} {side}x{side} {options}" for scene, side, options in cases]
    if len(programs) == 1:
        for value, name in zip(hashes[0], names):
            print(value, name)
        return 0
    different = [row for row in zip(*hashes, names) if row[0] != row[1]]
    for row in different:
        print(*row)
    print(f"{len(different)} of {len(cases)} images differ")
    return 1 if different else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except RenderFailed as failed:
        print(failed, file=sys.stderr)
        sys.exit(2)
