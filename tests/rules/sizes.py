#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How large the parts of src are: files and lines of each folder in the order of the light, and how
long files and functions are.

Usage: sizes.py TREE
"""
import pathlib
import statistics
import sys

sys.dont_write_bytecode = True
from rules_sources import CODE, ORDER, function_lengths  # pylint: disable=wrong-import-position


def summary(lengths):
    """Median, 99th percentile and longest of (length, where)."""
    ordered = sorted(lengths)
    longest, where = ordered[-1]
    values = [length for length, _ in ordered]
    return (f"{len(values)}, median {statistics.median(values):g}, 99th percentile "
            f"{values[int(0.99 * (len(values) - 1))]}, longest {longest} ({where})")


def main():
    tree = pathlib.Path(sys.argv[1]).resolve()
    files, functions = [], []
    print("| folder | files | lines |\n|---|---|---|")
    for folder in ORDER:
        count = total = 0
        for path in sorted((tree / "src" / folder).iterdir()):
            if path.suffix not in CODE:
                continue
            lines = path.read_text(encoding="utf-8").splitlines()
            name = str(path.relative_to(tree))
            files.append((len(lines), name))
            functions += [(length, f"{name}:{at}") for at, length in function_lengths(lines)]
            count, total = count + 1, total + len(lines)
        print(f"| {folder} | {count} | {total:,} |")
    print(f"\nfiles: {summary(files)}\nfunctions: {summary(functions)}")


if __name__ == "__main__":
    main()
