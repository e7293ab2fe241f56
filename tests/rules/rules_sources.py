#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The tree's own laws, checked on its text: which folder of src may include what, how files are
named, how long files and functions are, licence lines, and no paths of one machine.

Usage: rules_sources.py TREE. Prints `path:line: what is wrong` and exits 1 if anything is.
"""
import collections
import pathlib
import re
import subprocess
import sys

# The order of the light: a folder of src includes only those before it.
ORDER = ["base", "rsh", "brdf", "scene", "light", "load", "guide", "photon", "cache", "gather",
          "fill", "shade", "film", "render", "toml", "animation",
         "study", "apps"]
# The only folder that may include headers of a library.
LIBRARIES = {"embree": "scene", "flann": "photon", "toml": "toml"}
# How names of files may begin; base is free, the others have their folder's noun.
NOUNS = {"render": ("render", "options"), "apps": ("app", "main")}
# What the top folder may hold beside hidden files.
TOP = {"CHANGELOG.md", "LICENSE", "README.md", "bench", "bootstrap", "data", "docs", "include",
       "meson.build", "meson_options.txt", "src", "tests"}
MAX_LINES = 500
# Longer on purpose, each with its reason.
LONG_FILES = {"light_sky_tables.c": 700,  # generated
              "rsh_tables.py": 600}  # the whole generator, from the recurrences to the C tables
AIM_FUNCTION, MAX_FUNCTION = 60, 80
MAX_ARGUMENTS = 7
FOLDERS = ["src", "include", "data", "tests", "bench", "docs"]
CODE = {".c", ".h", ".cpp"}
DECLARED = re.compile(r"^(?!static|typedef|#|return)\w[\w \*\n]*?\b(\w+)\([^;{}]*\);", re.MULTILINE)
DEFINED = re.compile(r"^(?!static|typedef)\w[\w \*\n]*?\b(\w+)\([^;{}]*\)\s*\{", re.MULTILINE)
WITH_ARGUMENTS = re.compile(r"^(?!typedef|#)\w[\w \*\n]*?\b(\w+)"
                            r"\(((?:[^;{}()]|\([^;{}()]*\))*)\)\s*\{", re.MULTILINE)
MACHINE_PATH = re.compile(r"(?<![\w.$}])/(?:home|root|work|Users|mnt)/[\w.]")


def source_files(tree):
    """Every file of the project, generated and foreign ones aside."""
    top = [p for p in tree.iterdir() if p.is_file() and p.name not in ("LICENSE", ".git")]
    below = [p for folder in [*FOLDERS, ".ci"] for p in (tree / folder).rglob("*")
             if p.is_file() and "__pycache__" not in p.parts]
    return sorted(top + below)


def kept_at_top(tree):
    """What git keeps in the top folder; images that a user leaves there are the user's."""
    listed = subprocess.run(["git", "-C", tree, "ls-files"], stdout=subprocess.PIPE, text=True,
                            check=False)  # of a tree without history: nothing
    return {line.split("/")[0] for line in listed.stdout.splitlines()}


def check_includes(path, folder, lines):
    """`folder` may include base, the public headers, its own files and the named header of a folder
    before it."""
    for at, line in enumerate(lines, 1):
        library = re.match(r"\s*#\s*include\s+<([a-z]+)", line)
        if library and LIBRARIES.get(library.group(1).rstrip("0123456789"), folder) != folder:
            yield at, f"only {LIBRARIES[library.group(1)]} knows {library.group(1)}"
        found = re.match(r'\s*#\s*include\s+"([^"]+)"', line)
        if not found:
            continue
        other, _, header = found.group(1).rpartition("/")
        if other in ("satin", "base", folder):
            continue
        if other not in ORDER:
            yield at, f'"{found.group(1)}" is not written as FOLDER/header.h'
        elif ORDER.index(other) > ORDER.index(folder):
            yield at, f"{folder} comes before {other} and cannot include it"
        elif header != other + ".h":
            yield at, f"{header} is private to {other}; only {other}/{other}.h is for others"


def function_lengths(lines):
    """Line and length of functions as clang-format writes them: the body opens on a line of its own
    or its signature's last, and closes in column 1, that of a class's member in column 5."""
    start = close = None
    for at, line in enumerate(lines, 1):
        before = lines[at - 2].strip() if at > 1 else ""
        if start is None and re.match(r"[A-Za-z].*\)\s*\{$|\s{4,}.*\)\s*(const\s*)?\{$", line) \
                and not re.match(r"\s*(if|for|while|switch|else|\}|do)\b", line):
            member = line.startswith("    ") and (not before or before[-1] in ";}:{>")
            start, close = at, "    }" if member else "}"
        elif start is not None and line == close:
            yield start, at - start - 1
            start = None


def check_functions(lines):
    for start, length in function_lengths(lines):
        if length > AIM_FUNCTION:
            yield start, length


def check_text(path, lines):
    limit = LONG_FILES.get(path.name, MAX_LINES)
    if path.suffix in CODE | {".py"} and len(lines) > limit:
        yield len(lines), f"{len(lines)} lines; the limit is {limit}"
    if path.suffix in CODE and (not lines or lines[0] != "// SPDX-License-Identifier: Apache-2.0"):
        yield 1, "the first line must be: // SPDX-License-Identifier: Apache-2.0"
    if path.suffix in CODE and not (len(lines) > 1 and lines[1].startswith("//")):
        yield 2, "the file does not open with a comment that says what it does"
    for at, line in enumerate(lines, 1):
        if MACHINE_PATH.search(line):
            yield at, "a path of one machine"
        if path.suffix == ".py" and len(line) > 100:
            yield at, f"{len(line)} columns; the limit is 100"


def check_names(tree):
    """Names in src are unique and begin with their folder's noun; a unit test bears the name of the
    source that it tests."""
    sources = [p for p in (tree / "src").rglob("*") if p.suffix in CODE]
    for name, count in collections.Counter(p.name for p in sources).items():
        if count > 1:
            yield tree / "src", f"{count} files are named {name}"
    for path in sources:
        folder = path.parent.name
        if path.parent.parent.name != "src" or folder not in ORDER:
            yield path, "is not in a folder of the order"
        elif folder != "base" and not re.match(
                rf"({'|'.join(NOUNS.get(folder, (folder,)))})(_|$)", path.stem):
            yield path, f"its name does not begin with its folder's noun, {folder}"
    stems = {p.stem for p in sources}
    for path in (tree / "tests/unit").glob("*.c"):
        if path.stem not in stems:
            yield path, "no source has this test's name"


def declared(path):
    """The functions that a header declares, and its comments."""
    text = path.read_text(encoding="utf-8")
    comments = "\n".join(re.findall(r"//[^\n]*", text))
    return DECLARED.findall(re.sub(r"//[^\n]*", "", text)), comments


def check_headers(tree):
    """A private header has the name of the source that defines what it declares, or its comments
    name the sources that do. Only headers for functions of several sources, whose name no source
    has, need not."""
    defines = collections.defaultdict(set)
    sources = [p for p in (tree / "src").rglob("*") if p.suffix in CODE - {".h"}]
    for path in sources:
        text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
        for name in DEFINED.findall(text):
            defines[name].add(path.name)
    stems = {p.stem for p in sources}
    for path in sorted((tree / "src").rglob("*.h")):
        names, comments = declared(path)
        found = {name: defines[name] for name in names if name in defines}
        if path.stem == path.parent.name or not found:
            continue
        where = set.union(*found.values())
        if path.stem not in stems and len(where) == 1 and min(where) not in comments:
            yield path, f"what it declares is all defined in {min(where)}"
        for name, files in found.items() if path.stem in stems else []:
            if not any(pathlib.Path(x).stem == path.stem or x in comments for x in files):
                yield path, f"{name} is defined in {min(files)}, which no comment names"


def check_arguments(tree):
    """Functions of src with more than MAX_ARGUMENTS arguments."""
    for path in sorted((tree / "src").rglob("*.c")):
        text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
        for name, arguments in WITH_ARGUMENTS.findall(text):
            if without_brackets(arguments).count(",") >= MAX_ARGUMENTS:
                yield path, f"{name} has more than {MAX_ARGUMENTS} arguments"


def without_brackets(text):
    """The text without what is in round brackets, as in pointers to functions."""
    return re.sub(r"\([^()]*\)", "", text)


def main():
    tree = pathlib.Path(sys.argv[1]).resolve()
    wrong = [(p, 1, what) for p, what in [*check_names(tree), *check_headers(tree),
                                          *check_arguments(tree)]]
    wrong += [(tree / name, 1, "the top level has no place for it")
              for name in sorted(kept_at_top(tree) - TOP) if not name.startswith(".")]
    warnings = []
    for path in source_files(tree):
        try:
            lines = path.read_text(encoding="utf-8").split("\n")
        except UnicodeDecodeError:
            continue
        lines = lines[:-1] if lines and not lines[-1] else lines
        found = list(check_text(path, lines))
        if path.suffix in CODE:
            if path.is_relative_to(tree / "src"):
                found += check_includes(path, path.parent.name, lines)
            for at, length in check_functions(lines):
                if length > MAX_FUNCTION:
                    found.append((at, f"function of {length} lines; the limit is {MAX_FUNCTION}"))
                else:
                    warnings.append((path, at, f"function of {length} lines"))
        wrong += [(path, at, what) for at, what in found]
    for path, at, what in warnings:
        print(f"warning: {path.relative_to(tree)}:{at}: {what}; the aim is {AIM_FUNCTION}")
    for path, at, what in wrong:
        print(f"{path.relative_to(tree)}:{at}: {what}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
