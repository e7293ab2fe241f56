#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the measured tables of the documentation, and says which are older than their code.

  bench/tables.py list                 tables, their commands, and what is wrong with them
  bench/tables.py make NAME ...        runs the command, writes bench/results, stamps the table
  bench/tables.py accept NAME ... WHY  stamps tables that a change of code cannot have changed;
                                       the name `stale` is all whose hash differs

A stamp, a line of bench/results/stamps.tsv, holds a hash of the code that decides the figures.
Comments, white space, names of files and included headers do not count, so that moving a file
needs no more than the new name in TABLES below, and renaming what is in it an `accept`. Tables in
Markdown stand line by line in their page of docs as well; `make` prints them. Everything is run
in the root of the tree after `ninja -C build`.
"""
import datetime
import hashlib
import os
import pathlib
import platform
import re
import shlex
import subprocess
import sys

TREE = pathlib.Path(__file__).resolve().parent.parent
RESULTS = "bench/results/"
STAMPS = RESULTS + "stamps.tsv"
HARMONICS = ["src/rsh/*.[ch]", "src/rsh/rsh_tables.py"]
# The file of each table, the command that prints it, and the code that decides it.
TABLES = {
    "fig_5_5": ("fig_5_5.tsv", "build/bench/fig_5_5", [*HARMONICS, "bench/fig_5_5.c"]),
    "fig_5_6": ("fig_5_6.md", "build/bench/fig_5_6 data/scenes/vase.xml build 256 10",
                [*HARMONICS, "src/cache/cache_rotate.c", "bench/fig_5_6.c",
                 "data/scenes/vase.xml"]),
    "fig_5_7": ("fig_5_7.tsv", "build/bench/fig_5_7 51", [*HARMONICS, "bench/fig_5_7.c"]),
    "bench_rsh": ("bench_rsh.txt", "build/bench/bench_rsh 31", [*HARMONICS, "bench/bench_rsh.c"]),
    "harmonics_errors": ("harmonics_errors.md",
                         "python3 tests/stat/check_harmonics.py build/src/rsh/librsh.so 1000",
                         [*HARMONICS, "tests/stat/check_harmonics.py"]),
    "fig_6_15": ("fig_6_15.md", "bench/fig_6_15.py build/figures --spp 512 "
                 "--extra '--width 200 --height 200'",
                 ["src/cache/*.[ch]", "src/fill/*.[ch]",
                  "src/render/render_adaptive_sampling.[ch]",
                  "bench/fig_6_15.py", "data/scenes/figures/ward-floor.xml"]),
}
# What a comment is, by the file's suffix; strings come first, as they may hold what looks like one.
C_COMMENT = r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])*\'|//[^\n]*|/\*.*?\*/|^\s*#\s*include\s*"[^\n]*'
COMMENTS = {".c": C_COMMENT, ".h": C_COMMENT, ".xml": r"<!--.*?-->",
            ".py": r'"""(?:\\.|[^\\])*?"""|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|#[^\n]*'}


def bare(text, suffix):
    """The text without comments, included headers and white space."""
    def kept(found):
        return found.group() if found.group()[0] in "\"'" else ""
    text = re.sub(COMMENTS[suffix], kept, text, flags=re.DOTALL | re.MULTILINE)
    return re.sub(r"\s+", "", text)


def digest(tree, patterns):
    """Of all files' bare texts in any order, and the patterns that no file has."""
    parts, missing = [], []
    for pattern in patterns:
        files = list(tree.glob(pattern))
        missing += [] if files else [pattern]
        parts += [hashlib.sha256(bare(f.read_text(encoding="utf-8"), f.suffix).encode()).hexdigest()
                  for f in files]
    return hashlib.sha256("".join(sorted(parts)).encode()).hexdigest()[:16], missing


def read_stamps(tree):
    """Name to hash and how the stamp came about."""
    path = tree / STAMPS
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return {line.split("\t")[0]: line.split("\t")[1:] for line in lines if line[0] != "#"}


def write_stamp(name, how):
    stamps = read_stamps(TREE)
    stamps[name] = [digest(TREE, TABLES[name][2])[0], how]
    lines = ["# table, hash of the code that decides it, how it came about: see bench/tables.py"]
    lines += ["\t".join([key, *stamps[key]]) for key in sorted(stamps)]
    (TREE / STAMPS).write_text("\n".join(lines) + "\n", encoding="utf-8")


def wrong_with(tree, name):
    """What is wrong with a table, in sentences."""
    file, _, patterns = TABLES[name]
    now, missing = digest(tree, patterns)
    for pattern in missing:
        yield f"nothing is named {pattern}: correct TABLES in bench/tables.py"
    table = tree / RESULTS / file
    if name not in read_stamps(tree) or not table.is_file():
        yield f"there is no table: run bench/tables.py make {name}"
        return
    if not missing and read_stamps(tree)[name][0] != now:
        yield (f"{RESULTS}{file} is older than the code that decides it: run bench/tables.py make "
               f"{name}, or bench/tables.py accept {name} WHY if it cannot have changed")
    if file.endswith(".md"):
        pages = "\n".join(p.read_text(encoding="utf-8") for p in (tree / "docs").rglob("*.md"))
        for line in table.read_text(encoding="utf-8").splitlines():
            if line.startswith("|") and line not in pages.splitlines():
                yield f"no page of docs has the line {line} of {RESULTS}{file}"


def machine():
    """Where and of which commit a table was made."""
    commit = subprocess.run(["git", "-C", TREE, "rev-parse", "--short", "HEAD"], text=True,
                            stdout=subprocess.PIPE, check=False).stdout.strip()
    cpu = platform.processor() or platform.machine()
    if os.path.exists("/proc/cpuinfo"):
        text = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8")
        cpu = re.search(r"^model name\s*: (.*)", text, re.MULTILINE).group(1)
        sets = [s for s in ("avx512f", "avx2") if s in text]
        cpu += f" ({sets[0]})" if sets else ""
    return f"{datetime.date.today()}, after commit {commit}, {cpu}"


def make(name):
    file, command, _ = TABLES[name]
    print(f"{name}: {command}", file=sys.stderr)
    text = subprocess.run(shlex.split(command), cwd=TREE, stdout=subprocess.PIPE, text=True,
                          check=True).stdout
    if file.endswith(".md"):
        text = "".join(line + "\n" for line in text.splitlines() if line.startswith("|"))
        print(text)
    head = f"<!-- {machine()} -->\n\n" if file.endswith(".md") else f"# {machine()}\n"
    (TREE / RESULTS / file).write_text(head + text, encoding="utf-8")
    write_stamp(name, f"made {datetime.date.today()}")


def main():
    command, names = (sys.argv[1:2] or ["list"])[0], sys.argv[2:]
    why = names.pop() if command == "accept" and names else ""
    if command == "accept" and names == ["stale"]:
        names = [n for n, t in TABLES.items()
                 if read_stamps(TREE).get(n, ["", ""])[0] != digest(TREE, t[2])[0]]
        if not names:
            return
    unknown = [n for n in names if n not in TABLES]
    if unknown or command not in ("list", "make", "accept") or (command != "list" and not names):
        sys.exit(f"no table {', '.join(unknown)}" if unknown else __doc__)
    for name in names if command != "list" else TABLES:
        if command == "make":
            make(name)
        elif command == "accept":
            write_stamp(name, f"accepted {datetime.date.today()}: {why}")
        else:
            print("\n  ".join([f"{name}: {TABLES[name][1]}", *wrong_with(TREE, name)]))


if __name__ == "__main__":
    main()
