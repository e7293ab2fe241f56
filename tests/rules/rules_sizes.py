#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that the tables of sizes and includes in docs/experiments/structure.md are those that
sizes.py prints. Line counts change with every commit, so those of a folder may differ by a
twentieth, and those of the lengths of functions and files too; numbers of files, and which folder
includes which, may not.

Usage: rules_sizes.py TREE. `sizes.py TREE --write` updates the page.
"""
import pathlib
import re
import sys

sys.dont_write_bytecode = True
from sizes import PAGE, split_page, tables  # pylint: disable=wrong-import-position

TOLERANCE = 0.05


def cells(text):
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()]


def is_near(page, found):
    """Whether two cells are equal, or numbers that differ by little."""
    if page == found:
        return True
    numbers = [re.match(r"[\d,.]+", cell) for cell in (page, found)]
    if not all(numbers):
        return False
    a, b = (float(number.group().replace(",", "")) for number in numbers)
    return abs(a - b) <= max(TOLERANCE * b, 2)


def main():
    tree = pathlib.Path(sys.argv[1]).resolve()
    page, found = cells(split_page(tree)[1]), cells(tables(tree))
    wrong = [] if len(page) == len(found) else ["other rows"]
    for a, b in zip(page, found):
        files = len(a) == 3 and a[1] != b[1]
        if files or len(a) != len(b) or not all(map(is_near, a, b)):
            wrong.append(f"{' | '.join(a)} is now {' | '.join(b)}")
    wrong += [f"{line} (upward)" for line in map(" ".join, found)
              if line.startswith("Includes") and not line.endswith(" 0.")]
    if wrong:
        print("\n".join(f"{PAGE}: {w}" for w in wrong))
        print("update it by tests/rules/sizes.py . --write")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
