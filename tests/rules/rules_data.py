#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that data/scenes is exactly what data/generate.py writes.

Usage: rules_data.py TREE
"""
import pathlib
import sys

sys.dont_write_bytecode = True


def main():
    data = pathlib.Path(sys.argv[1]) / "data"
    sys.path.insert(0, str(data))
    from generate import files  # needs the path

    expected = files()
    present = {str(p.relative_to(data / "scenes")): p.read_bytes()
               for p in (data / "scenes").rglob("*") if p.is_file()}
    wrong = [f"{name}: not made by generate.py" for name in sorted(present.keys() - expected)]
    wrong += [f"{name}: missing" for name in sorted(expected.keys() - present)]
    wrong += [f"{name}: differs from what generate.py writes"
              for name in sorted(expected.keys() & present) if expected[name] != present[name]]
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
