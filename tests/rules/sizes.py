#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How large the folders of src are, in the order of the light: files and lines of each, how long
files and functions are, and how many includes lead from each folder to which.

Usage: sizes.py TREE [--write]
Prints the tables of docs/experiments/structure.md between SIZES and SIZES_END. With --write it puts
them into the page. rules_sizes.py compares them with the page.
"""
import collections
import pathlib
import re
import statistics
import sys

sys.dont_write_bytecode = True
from rules_sources import CODE, ORDER, function_lengths  # pylint: disable=wrong-import-position

PAGE = "docs/experiments/structure.md"
SIZES, SIZES_END = "<!-- sizes.py -->\n", "<!-- end of sizes.py -->\n"
# Generated tables, which are not in the longest file.
GENERATED = {"rsh_tables.h", "light_sky_tables.c"}
INCLUDE = re.compile(r'^\s*#\s*include\s+"(\w+)/', re.MULTILINE)


def summary(what, lengths):
    """A row with the number, median, 99th percentile and longest of (length, where)."""
    ordered = sorted(lengths)
    longest, where = ordered[-1]
    values = [length for length, _ in ordered]
    return (f"| {what} | {len(values)} | {statistics.median(values):g} "
            f"| {values[int(0.99 * (len(values) - 1))]} | {longest} (`{where}`) |")


def sources(tree):
    """Of each folder in order, its files with their text."""
    for folder in ORDER:
        yield folder, [(path, path.read_text(encoding="utf-8"))
                       for path in sorted((tree / "src" / folder).iterdir())
                       if path.suffix in CODE]


def size_tables(tree):
    files, functions = [], []
    lines = ["| folder | files | lines |", "|---|---|---|"]
    for folder, found in sources(tree):
        total = 0
        for path, text in found:
            content = text.splitlines()
            name = str(path.relative_to(tree))
            if path.name not in GENERATED:
                files.append((len(content), name))
            functions += [(length, name) for _, length in function_lengths(content)]
            total += len(content)
        lines.append(f"| {folder} | {len(found)} | {total:,} |")
    return lines + ["", "| | number | median | 99th percentile | longest |",
                    "|---|---|---|---|---|",
                    summary("files, generated tables aside", files),
                    summary("functions", functions)]


def include_table(tree):
    arrows = collections.Counter()
    for folder, found in sources(tree):
        for _, text in found:
            arrows.update((folder, other) for other in INCLUDE.findall(text) if other in ORDER)
    lines = ["| | " + " | ".join(ORDER) + " |", "|---" * (len(ORDER) + 1) + "|"]
    lines += [f"| {folder} | " + " | ".join(str(arrows[folder, other] or "") for other in ORDER)
              + " |" for folder in ORDER]
    upward = sum(count for (folder, other), count in arrows.items()
                 if ORDER.index(other) > ORDER.index(folder))
    return lines + ["", f"Includes of a folder that comes later: {upward}."]


def tables(tree):
    """The text between SIZES and SIZES_END."""
    return "\n" + "\n".join([*size_tables(tree), "", *include_table(tree)]) + "\n\n"


def split_page(tree):
    """The page before, between and after the marks."""
    before, rest = (tree / PAGE).read_text(encoding="utf-8").split(SIZES)
    between, after = rest.split(SIZES_END)
    return before + SIZES, between, SIZES_END + after


def main():
    tree = pathlib.Path(sys.argv[1]).resolve()
    if "--write" in sys.argv:
        before, _, after = split_page(tree)
        (tree / PAGE).write_text(before + tables(tree) + after, encoding="utf-8")
    else:
        print(tables(tree))


if __name__ == "__main__":
    main()
