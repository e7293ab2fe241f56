#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the walks of docs/tour.md: at most 15 numbered steps, each a function that is defined in
the file that the step names, so that a reader can follow one photon and one pixel through the code.

Usage: rules_walk.py TREE
"""
import pathlib
import re
import sys

STEPS_MAX = 15
WALKS = {"One photon", "One pixel"}
STEP = re.compile(r"^(\d+)\. `(\w+)` \(`([\w/.]+)`\)", re.MULTILINE)


def walks(text):
    """Title to steps (number, function, file) of each section of the third level that has any."""
    sections = re.split(r"^### ", text, flags=re.MULTILINE)[1:]
    found = {}
    for section in sections:
        title, body = section.split("\n", 1)
        body = re.split(r"^## ", body, flags=re.MULTILINE)[0]
        steps = STEP.findall(body)
        if steps:
            found[title] = steps
            numbered = re.findall(r"^\d+\. ", body, re.MULTILINE)
            if len(numbered) != len(steps):
                found[title] = [("0", "a step", "that names no function")]
    return found


def wrong_steps(tree, title, steps):
    if [int(number) for number, _, _ in steps] != list(range(1, len(steps) + 1)):
        yield f"{title}: the steps are not numbered from 1, or one names no function and file"
    if len(steps) > STEPS_MAX:
        yield f"{title}: {len(steps)} steps are more than {STEPS_MAX}"
    for _, function, file in steps:
        path = tree / "src" / file
        if not path.is_file():
            yield f"{title}: there is no src/{file}"
        # As clang-format writes a definition: it begins in column 1, and ends with its body.
        elif not re.search(rf"^\w[^;{{}}]*\b{function}\([^;{{}}]*\) \{{",
                           path.read_text(encoding="utf-8"), re.MULTILINE):
            yield f"{title}: src/{file} does not define {function}"


def main():
    tree = pathlib.Path(sys.argv[1]).resolve()
    found = walks((tree / "docs/tour.md").read_text(encoding="utf-8"))
    wrong = [f"docs/tour.md has no walk '{title}'" for title in sorted(WALKS - found.keys())]
    for title, steps in found.items():
        wrong += [f"docs/tour.md: {w}" for w in wrong_steps(tree, title, steps)]
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
