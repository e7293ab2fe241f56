#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that no measured table is older than the code that decides it, by the hashes of
bench/tables.py, and that these see changes of code and nothing else.

Usage: rules_tables.py TREE
"""
import pathlib
import shutil
import sys
import tempfile

sys.dont_write_bytecode = True

# Texts that count as the same, and as different ones.
SAME = [(".c", "int a; // one\n", "int  a;\n/* two */"),
        (".c", '#include "rsh/a.h"\nint a;', '#include "other/b.h"\n\nint a;'),
        (".py", 'a = "#"  # one', "a = \"#\"\n# two\n"),
        (".xml", "<a/><!-- one\n -->", "<a/>")]
DIFFERENT = [(".c", "a = 1.0f;", "a = 2.0f;"), (".c", 'p("// one");', 'p("// two");'),
             (".c", "#include <math.h>\n", "#include <tgmath.h>\n"),
             (".c", "'\"'; // a\nb", "'\"';"),
             (".py", 'a = "# one"', 'a = "# two"'), (".xml", '<a b="1"/>', '<a b="2"/>')]


def failures_of_hashes(tables):
    for suffix, a, b in SAME:
        if tables.bare(a, suffix) != tables.bare(b, suffix):
            yield f"{a!r} and {b!r} should have one hash"
    for suffix, a, b in DIFFERENT:
        if tables.bare(a, suffix) == tables.bare(b, suffix):
            yield f"{a!r} and {b!r} should have different hashes"
    with tempfile.TemporaryDirectory() as folder:
        tree = pathlib.Path(folder)
        (tree / "a.c").write_text("int a;", encoding="utf-8")
        (tree / "b.c").write_text("int b;", encoding="utf-8")
        before = tables.digest(tree, ["*.c"])
        shutil.move(tree / "a.c", tree / "z.c")
        if tables.digest(tree, ["*.c"]) != before:
            yield "a file's name should not count"
        (tree / "z.c").write_text("int c;", encoding="utf-8")
        if tables.digest(tree, ["*.c"]) == before:
            yield "a file's text should count"
        if tables.digest(tree, ["*.c", "*.h"])[1] != ["*.h"]:
            yield "a pattern without files should be reported"


def main():
    tree = pathlib.Path(sys.argv[1]).resolve()
    sys.path.insert(0, str(tree / "bench"))
    import tables  # needs the path

    wrong = list(failures_of_hashes(tables))
    wrong += [f"{name}: {what}" for name in tables.TABLES for what in tables.wrong_with(tree, name)]
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
