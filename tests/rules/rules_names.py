#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that names are defined once in include, src and bench: static functions and tags of
structs, unions and enums name one thing, so that a search or a back-trace leads to one definition.

Usage: rules_names.py TREE
"""
import collections
import pathlib
import re
import sys

# The unit tests are separate programs, whose helpers may be called alike.
FOLDERS = ["include", "src", "bench"]
CODE = {".c", ".h", ".cpp"}
# Names that still recur. The list may only shrink: one that no longer recurs is an error too.
TO_DO = set("""

""".split())
# As clang-format writes definitions: they begin in column 1, and a body opens on their last line.
FUNCTION = re.compile(r"^static (?:inline )?(?:_Noreturn )?[\w \*]*?\b(\w+)\([^;{}]*?\)\s*\{",
                      re.MULTILINE)
INLINE_FUNCTION = re.compile(r"^INLINE [\w \*]*?\b(\w+)\([^;{}]*?\)\s*\{", re.MULTILINE)
TAG = re.compile(r"^(?:typedef )?(?:struct|union|enum) (\w+) \{", re.MULTILINE)


def definitions(path):
    """The names that a file defines for itself; comments aside."""
    text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
    yield from FUNCTION.findall(text)
    yield from INLINE_FUNCTION.findall(text)
    yield from TAG.findall(text)


def recurring(tree):
    """Of each name that is defined in more than one file, the files."""
    places = collections.defaultdict(list)
    for path in sorted(p for f in FOLDERS for p in (tree / f).rglob("*") if p.suffix in CODE):
        for name in sorted(set(definitions(path))):
            places[name].append(path)
    return {name: paths for name, paths in places.items() if len(paths) > 1}


def main():
    tree = pathlib.Path(sys.argv[1]).resolve()
    found = recurring(tree)
    wrong = [f"{name} is defined in {', '.join(str(p.relative_to(tree)) for p in paths)}"
             for name, paths in sorted(found.items()) if name not in TO_DO]
    wrong += [f"{name} no longer recurs: take it off TO_DO"
              for name in sorted(TO_DO - found.keys())]
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
