#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders many scenes under many seeds and flags deviations; see docs/experiments/sweep.md.

    tests/sweep/sweep.py [--scenes] [--rooms FIRST:END] [--build DIR] [ARGUMENT ...] [SCENE.xml ...]

--scenes takes all scenes of data/scenes, --rooms random rooms, which are written to DIR/rooms (DIR
is `build` if not given); it may be repeated. All other arguments go to DIR/tests/sweep/sweep:

    --seeds FIRST:END          5 to 64 seeds (0:10)
    --presets NAME,...         draft, preview, production (draft)
    --first NAME,...           first passes (precomputed)
    --size N                   width and height in pixels, a multiple of 8 (64)
    --jobs N                   processes, of one thread each (1)
    --limit S                  seconds that a render may take, 0: any (300)
    --threshold T              sigmas beyond which a block is flagged (6)
    --worst                    prints the largest score of every cell, flagged or not
    --out DIR                  keeps flagged images there, as EXR and PNG
    -D NAME=VALUE, --set NAME=VALUE    as those of `satin render`

Exit status: 0 no flag, 1 flags, 2 wrong arguments.
"""
import argparse
import os
import pathlib
import subprocess
import sys

from rooms import write_rooms

TREE = pathlib.Path(__file__).resolve().parents[2]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, add_help=False, allow_abbrev=False,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", action="store_true")
    parser.add_argument("--rooms", action="append", default=[])
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"))
    parser.add_argument("-h", "--help", action="store_true")
    known, rest = parser.parse_known_args()
    if known.help:
        print(__doc__)
        sys.exit(0)
    return known, rest


def data_scenes():
    """Those of data/scenes by their paths from here."""
    folder = pathlib.Path(os.path.relpath(TREE / "data/scenes"))
    return sorted(folder.rglob("*.xml"))


def rooms(text, folder):
    first, colon, end = text.partition(":")
    if not (colon and first.isdigit() and end.isdigit() and int(first) < int(end)):
        sys.exit(f"sweep.py: --rooms wants FIRST:END, not '{text}'")
    return write_rooms(int(first), int(end), folder)


def main():
    known, rest = arguments()
    scenes = data_scenes() if known.scenes else []
    for text in known.rooms:
        scenes += rooms(text, known.build / "rooms")
    program = known.build / "tests/sweep/sweep"
    return subprocess.run([program, "-D", "filter=box", *rest, *scenes], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
