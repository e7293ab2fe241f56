#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that every C and C++ file is as clang-format leaves it. Versions of clang-format disagree
in detail, so only the one that the tree is formatted with counts; without it the check is skipped.

Usage: rules_format.py TREE
"""
import pathlib
import re
import shutil
import subprocess
import sys

VERSION = 14
SKIPPED = 77  # meson's exit status for a skipped test


def find_tool():
    for name in (f"clang-format-{VERSION}", "clang-format"):
        tool = shutil.which(name)
        if not tool:
            continue
        text = subprocess.run([tool, "--version"], capture_output=True, text=True,
                              check=False).stdout
        found = re.search(r"version (\d+)", text)
        if found and int(found.group(1)) == VERSION:
            return tool
    return None


def main():
    tree = pathlib.Path(sys.argv[1]).resolve()
    tool = find_tool()
    if not tool:
        print(f"skipped: clang-format {VERSION} is not installed")
        return SKIPPED
    files = sorted(p for folder in ("src", "include", "tests", "bench", "docs")
                   for p in (tree / folder).rglob("*") if p.suffix in (".c", ".h", ".cpp"))
    run = subprocess.run([tool, "--dry-run", "-Werror", *map(str, files)], check=False)
    return run.returncode


if __name__ == "__main__":
    sys.exit(main())
