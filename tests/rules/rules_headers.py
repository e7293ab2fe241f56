#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compiles every header alone: private ones as C, public ones as strict C17 and as C++17. Checks
that every call of a public header has a comment that says from which threads it may be called, and
that those of the harmonics say which units they have.

Usage: rules_headers.py TREE CC CXX [ARGUMENT ...]; the arguments go to both compilers.
"""
import pathlib
import re
import subprocess
import sys

# The comment before a call of the public interface, and the call's name.
CALL = re.compile(r"((?:^//[^\n]*\n)*)^(?:SATIN|RSH)_API [^;()]*?(\w+)\(", re.MULTILINE)


def compiles(command, header):
    run = subprocess.run([*command, "-fsyntax-only", "-Wall", "-Wextra", "-Werror", str(header)],
                         stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
    if run.returncode != 0:
        print(f"{header} does not compile alone:\n{run.stderr}")
    return run.returncode == 0


def says_threads_and_units(header):
    calls = CALL.findall(header.read_text(encoding="utf-8"))
    silent = [name for comment, name in calls if not re.search("thread", comment, re.IGNORECASE)]
    for name in silent:
        print(f"{header}: the comment of {name} does not say from which threads it may be called")
    bare = [name for comment, name in calls if header.name == "rsh.h"
            and not re.search(r"\bunits?\b|\[(?:rad|sr)", comment)]
    for name in bare:
        print(f"{header}: the comment of {name} does not say what unit its results have")
    return not silent and not bare, len(calls)


def main():
    tree, cc, cxx, arguments = pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3], sys.argv[4:]
    public = [*arguments, f"-I{tree / 'include'}"]
    private = [*public, f"-I{tree / 'src'}", "-D_GNU_SOURCE"]
    c_public = [cc, "-x", "c", "-std=c17", "-pedantic", *public]
    cxx_public = [cxx, "-x", "c++", "-std=c++17", "-pedantic", *public]
    # Unused static functions are what a header of inline functions is made of; those that return
    # wide vectors are only ever inlined, so their calling convention does not matter.
    c_private = [cc, "-x", "c", "-std=gnu17", "-Wno-unused-function", "-Wno-psabi", *private]
    good, calls = True, 0
    for header in sorted((tree / "include").rglob("*.h")):
        fine, count = says_threads_and_units(header)
        good &= fine
        calls += count
        good &= compiles(c_public, header)
        good &= compiles(cxx_public, header)
    for header in sorted((tree / "src").rglob("*.h")):
        good &= compiles(c_private, header)
    if calls < 40:
        print("the calls of the public headers are not found")
    return 0 if good and calls >= 40 else 1


if __name__ == "__main__":
    sys.exit(main())
