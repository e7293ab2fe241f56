#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that `meson install` installs the man page, the documentation and the example scenes, in
folders as they are in the tree, so that links and commands of the documentation are valid there.

Usage: rules_install.py TREE BUILD
"""
import json
import pathlib
import re
import sys


def main():
    tree, build = (pathlib.Path(p).resolve() for p in sys.argv[1:])
    plan = json.loads((build / "meson-info/intro-installed.json").read_text(encoding="utf-8"))
    targets = {pathlib.Path(source): pathlib.Path(to) for source, to in plan.items()}

    def installed(path):
        """Where a file of the tree is installed, alone or with a folder around it."""
        for around in (path, *path.parents):
            if around in targets:
                return targets[around] / path.relative_to(around)
        return None

    wanted = [tree / "README.md", tree / "CHANGELOG.md", tree / "LICENSE", tree / "data/README.md"]
    wanted += sorted((tree / "docs").rglob("*.md")) + sorted((tree / "docs").glob("*.png"))
    wanted += sorted((tree / "docs").glob("*.c"))
    wanted += [p for p in sorted((tree / "data/scenes").rglob("*")) if p.is_file()]
    wanted += sorted((tree / "bench/studies").glob("*.toml"))
    readme, wrong = installed(tree / "README.md"), []
    for path in wanted:
        target = installed(path)
        if target is None:
            wrong.append(f"{path.relative_to(tree)} is not installed")
        elif readme and target != readme.parent / path.relative_to(tree):
            wrong.append(f"{path.relative_to(tree)} is not where the tree has it: {target}")
    if not any(re.search(r"man1/satin\.1$", str(to)) for to in targets.values()):
        wrong.append("the man page is not installed")
    print("\n".join(wrong[:20]))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
