#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that names are defined once in include, src, bench, tests and docs: functions, static
objects (constants and tables), tags of structs, unions and enums, and what is in the anonymous
namespaces of C++ name one thing, so that a search or a back-trace leads to one definition. A
function of src that other files can call begins with the name of its folder, and nothing begins
with the name of another folder; folder base and the words of rsh, which knows no folder, aside.
Objects inside functions are exempt: they are local variables that happen to be constant, which no
back-trace names and a debugger shows after their function. Enumerators and macros are unique in src
and include; in tests and benches, which are programs of one file, they may recur, as N and ORDER.
Checks also that constants of one name have one value in all files of src; and that an option has
one name, that of its field in satin_options, in the table of options, in docs/options.md and in the
glossary.

Usage: rules_names.py TREE
"""
import collections
import pathlib
import re
import sys

sys.dont_write_bytecode = True
from rules_sources import ORDER  # pylint: disable=wrong-import-position

FOLDERS = ["include", "src", "bench", "tests", "docs"]
CODE = {".c", ".h", ".cpp"}
# How functions begin that other files can call, where that is not the name of their folder.
PREFIXES = {"apps": "app_", "render": "render_|options?_"}
# As clang-format writes definitions: they begin in column 1, and a body opens on their last line.
FUNCTION = re.compile(r"^static (?:inline )?(?:_Noreturn )?[\w \*]*?\b(\w+)\([^;{}]*?\)\s*\{",
                      re.MULTILINE)
OPEN_FUNCTION = re.compile(r"^(?!(?:_Noreturn )?static|typedef|extern|return)(?![A-Z_]+ )"
                           r"\w[\w \*\n]*?\b([a-z]\w+)\([^;{}]*?\)\s*\{", re.MULTILINE)
INLINE_FUNCTION = re.compile(r"^INLINE [\w \*]*?\b(\w+)\([^;{}]*?\)\s*\{", re.MULTILINE)
TAG = re.compile(r"^(?:typedef |static |const )*(?:struct|union|enum) (\w+) \{", re.MULTILINE)
# Without comments, only the bracket that ends a namespace has spaces after it.
NAMESPACE = re.compile(r"^namespace \{\n(.*?)^\} +$", re.MULTILINE | re.DOTALL)
IN_NAMESPACE = re.compile(r"^(?!static )\w[\w:<>\*& ]*?(?<!::)\b(\w+)\([^;{}]*?\)[\w ]*\{"
                          r"|^(?:struct|class|union|enum) (\w+)[\w:<> ]* \{", re.MULTILINE)
# What is in brackets is removed before, which leaves these empty.
OBJECTS = re.compile(r"^static (?!inline\b)([\w \*\[\]\n{}]+(?:[=,][^;]*)?);", re.MULTILINE)
OBJECT = re.compile(r"(\w+)(?:\[\])*\s*(?:=.*)?$", re.DOTALL)

CONSTANTS = re.compile(r"^(?:    )?(?:static )?const (?:float|double|int|size_t|u?int\d+_t) "
                       r"([^;]*);"
                       r"|^(?:    )?(?:static )?(?:const )?enum(?: \w+)? \{(.*?)\}",
                       re.MULTILINE | re.DOTALL)
CONSTANT = re.compile(r"\b([A-Z][A-Z0-9_]*[A-Z0-9])(?:\[\w*\])? ?=\s*([^,;{}]+|\{[^}]*\})")
MACRO = re.compile(r"^#define ([A-Z][A-Z0-9_]*) (?!\\)(\S[^\n]*)", re.MULTILINE)


# Every name of an enumeration, and every macro.
ENUMERATION = re.compile(r"\benum(?: \w+)? \{(.*?)\}", re.DOTALL)
ENUMERATOR = re.compile(r"(?:^|,)\s*([A-Za-z_]\w*)")
ANY_MACRO = re.compile(r"^#\s*define (\w+)", re.MULTILINE)


def wrong_enumerators(tree):
    """Enumerators and macros that two files of src or include define."""
    files = collections.defaultdict(set)
    for path in sorted(p for f in ("include", "src") for p in (tree / f).rglob("*")
                       if p.suffix in CODE):
        text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
        for body in ENUMERATION.findall(text):
            for name in ENUMERATOR.findall(body):
                files[name].add(path.name)
        for name in ANY_MACRO.findall(text):
            files[name].add(path.name)
    for name, where in sorted(files.items()):
        if len(where) > 1:
            yield f"{name} is defined in {' and '.join(sorted(where))}"
    if len(files) < 500:
        yield "enumerators and macros are not found"


def constants(path):
    """Names and values of a file's constants, enumerators and macros without arguments."""
    text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
    for found in CONSTANTS.finditer(text):
        yield from CONSTANT.findall(found.group(1) or found.group(2))
    yield from MACRO.findall(text)


def wrong_constants(tree):
    """Constants of one name whose values in two files have none in common."""
    values = collections.defaultdict(lambda: collections.defaultdict(set))
    for path in sorted(p for p in (tree / "src").rglob("*") if p.suffix in CODE):
        for name, value in constants(path):
            values[name][path.name].add(" ".join(value.split()))
    for name, files in sorted(values.items()):
        differing = [(a, b) for a in files for b in files if a < b and not files[a] & files[b]]
        if differing:
            a, b = differing[0]
            yield f"{name} is {min(files[a])} in {a} and {min(files[b])} in {b}"
    if len(values) < 300:
        yield "constants are not found"


def without(brackets, text):
    """The text with nothing inside brackets, which are of one kind."""
    inner = re.compile(rf"\{brackets[0]}[^\{brackets[0]}\{brackets[1]}]*\{brackets[1]}")
    count = 1
    while count:
        text, count = inner.subn(lambda _: "\0\0", text)
    return text.replace("\0\0", brackets)


def objects(text):
    """The names of the static objects of a file; those inside functions aside."""
    text = re.sub(r"//[^\n]*", "", text)
    text = re.sub(r"\"(?:[^\"\\\n]|\\.)*\"|'(?:[^'\\\n]|\\.)+'", "0", text)
    for brackets in ("[]", "()", "{}"):
        text = without(brackets, text)
    for statement in OBJECTS.findall(text):
        for declared in statement.split(","):
            yield OBJECT.search(declared).group(1)


def definitions(path):
    """The names that a file defines for itself; comments aside."""
    text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
    yield from (name for name in FUNCTION.findall(text) if name != "__attribute__")
    yield from INLINE_FUNCTION.findall(text)
    yield from TAG.findall(text)
    yield from objects(text)
    for namespace in NAMESPACE.findall(text) if path.suffix == ".cpp" else []:
        yield from ("".join(names) for names in IN_NAMESPACE.findall(namespace))


def open_functions(path):
    """The names of the functions of a C file that other files can call."""
    if path.suffix != ".c":
        return []
    text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
    return [name for name in OPEN_FUNCTION.findall(text) if name != "main"]


def recurring(tree):
    """Of each name that is defined in more than one file, or for a function and a tag, the files.
    Programs of one file, and of the folders that make one, may have functions of one name."""
    definitions_of = collections.defaultdict(list)
    for path in sorted(p for f in FOLDERS for p in (tree / f).rglob("*") if p.suffix in CODE):
        names = set(definitions(path))
        # Both in one file, of which each counts.
        functions = set(open_functions(path)) if path.is_relative_to(tree / "src") else set()
        text = path.read_text(encoding="utf-8")
        statics = {*FUNCTION.findall(text), *objects(text)}
        for name in [*sorted(names), *sorted(functions), *sorted(statics & {*TAG.findall(text)})]:
            definitions_of[name].append(path)
    return {name: paths for name, paths in definitions_of.items() if len(paths) > 1}


def wrong_prefixes(tree):
    """Functions of src that do not begin with the name of their folder though other files can call
    them, and functions and tags that begin with that of another folder."""
    count = 0
    for path in sorted(p for p in (tree / "src").rglob("*") if p.suffix in CODE):
        folder = path.parent.name
        if folder in ("base", "rsh"):
            continue
        text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
        statics = FUNCTION.findall(text)
        callable_ = open_functions(path) + (statics if path.suffix == ".h" else [])
        count += len(callable_)
        for name in callable_:
            if not re.match(PREFIXES.get(folder, rf"{folder}(_|$)") + "|satin_", name):
                yield f"{path.relative_to(tree)}: {name} does not begin with its folder's name"
        others = [other for other in ORDER if other not in (folder, "base")]
        for name in {*statics, *open_functions(path), *TAG.findall(text)}:
            for other in others:
                if name.startswith(other + "_"):
                    yield f"{path.relative_to(tree)}: {name} begins with the name of {other}"
    if count < 500:
        yield "functions of src are not found"


def wrong_options(tree):
    """Options whose name is not their field's, and where options and pages disagree."""
    text = (tree / "src/render/options_table.c").read_text(encoding="utf-8")
    rows = re.findall(r'^    \{"([\w-]+)", OPTION_\w+, AT\((\w+)\)', text, re.MULTILINE)
    options = {name for name, _ in rows}
    header = (tree / "include/satin/options.h").read_text(encoding="utf-8")
    body = re.search(r"typedef struct satin_options \{(.*?)\n\} satin_options;", header,
                     re.DOTALL).group(1)
    fields = set(re.findall(r"(\w+)(?:\[\d+\])?[;,]", re.sub(r"//[^\n]*", "", body)))
    page = (tree / "docs/options.md").read_text(encoding="utf-8")
    documented = set(re.findall(r"^\| ([\w-]+) \| (?!range)", page, re.MULTILINE))
    glossary = (tree / "docs/glossary.md").read_text(encoding="utf-8")
    named = set(re.findall(r"\b[Oo]ptions?\s+`([\w-]+)`", glossary))
    for name, field in rows:
        if name.replace("-", "_") != field:
            yield f"option {name} sets the field {field}"
    for field in sorted(fields ^ {field for _, field in rows}):
        yield f"{field} is not both a field of satin_options and a row of options_table"
    for name in sorted(options ^ documented):
        yield f"{name} is not both a row of options_table and of docs/options.md"
    for name in sorted(named - options):
        yield f"docs/glossary.md: there is no option {name}"
    if len(rows) < 50:
        yield "options_table.c: its rows are not found"


def main():
    tree = pathlib.Path(sys.argv[1]).resolve()
    found = recurring(tree)
    known = [name for path in (tree / "src").rglob("*") if path.suffix in CODE
             for name in objects(path.read_text(encoding="utf-8"))]
    wrong = ["static objects are not found"] if len(known) < 300 else []
    wrong += [f"{name} is defined in {', '.join(str(p.relative_to(tree)) for p in paths)}"
             for name, paths in sorted(found.items())]
    wrong += wrong_prefixes(tree)
    wrong += wrong_options(tree)
    wrong += wrong_constants(tree)
    wrong += wrong_enumerators(tree)
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
