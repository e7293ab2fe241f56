#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the walks of docs/tour.md: at most 15 numbered steps, each a function that is defined in
the file that the step names, so that a reader can follow one photon and one pixel through the code.
The steps are in the order of the calls: satin_render or a step before calls each one, through at
most CALLS_MAX calls; no step calls one before it; and of two that one function calls, the one that
it names first comes first. Calls are read from the text: a function calls what its body names, and
what is in the tables of functions that it names.

The first rays of a record are given to folder scene, which traces them, at most RAY_CALLS_MAX calls
below satin_render, and the tour names each call. From there to the library that intersects there
are a few more, in headers too, which are not read here. The rays are the first stratified ray, the
first probe of a photon cluster, and the visibility ray of the irradiance that the record expects.

Usage: rules_walk.py TREE
"""
import pathlib
import re
import sys

STEPS_MAX, CALLS_MAX = 15, 6
RAY_CALLS_MAX = 8
# For each first ray the function that traces it, and the one that calls this.
RAYS = [("scene_intersect", "gather_segment_trace"), ("scene_occluded", "guide_cones_from"),
        ("scene_occluded", "photon_irradiance_many")]
NUMBERS = ["no", "one", "two", "three", "four", "five", "six", "seven", "eight"]
MAIN = "satin_render"
TABLE = "[]"  # ends the name of a table of functions
WALKS = {"One photon", "One pixel"}
STEP = re.compile(r"^(\d+)\. `(\w+)` \(`([\w/.]+)`\)", re.MULTILINE)
# Functions and tables as clang-format writes them: from column 1 to a bracket in column 1.
BODY = re.compile(r"^\w[^;{}()#]*?\b(\w+)(?:\([^;{}]*\)|\[\w*\] =) "
                  r"\{([^\n]*\};?$|.*?^\})", re.M | re.S)
NO_CODE = re.compile(r'//[^\n]*|"(?:\\.|[^"\\\n])*"')


def call_graph(tree):
    """Of each function and table of src, those that it names, in the order of the text."""
    bodies, tables = [], set()
    for path in sorted((tree / "src").rglob("*.c")):
        text = NO_CODE.sub("", path.read_text(encoding="utf-8"))
        for found in BODY.finditer(text):
            bodies.append(found.groups())
            if found.group(0).split("{")[0].endswith("= "):
                tables.add(found.group(1))
    known = {name: name + TABLE * (name in tables) for name, _ in bodies}
    graph = {}
    for name, body in bodies:
        named = graph.setdefault(known[name], [])
        named += [known[x] for x in dict.fromkeys(re.findall(r"\w+", body))
                  if x in known and x != name]
    # What is in a table is called at some point after it is named.
    for named in graph.values():
        named.sort(key=lambda x: x.endswith(TABLE))
    return graph


def chain(graph, caller, called):
    """The shortest chain of calls from one function to another, both included; None if there is
    none of at most CALLS_MAX."""
    before = {caller: None}
    front = [caller]
    for _ in range(CALLS_MAX + 1):
        if called in before:
            break
        following = []
        for name in front:
            for x in graph.get(name, []):
                if x not in before:
                    before[x] = name
                    following.append(x)
        front = following
    if called not in before:
        return None
    names = [called]
    while before[names[-1]]:
        names.append(before[names[-1]])
    return names[::-1]


def count_calls(names):
    return sum(not name.endswith(TABLE) for name in names) - 1


def wrong_siblings(graph, callers, first, second):
    """Whether the nearest caller of both names all that leads to the second before anything that
    leads to the first."""
    both = [(chain(graph, c, first), chain(graph, c, second)) for c in callers]
    both = [pair for pair in both if all(pair)]
    if not both:
        return False
    one, other = min(both, key=lambda pair: len(pair[0]) + len(pair[1]))
    for caller, x, y in zip(one, one[1:], other[1:]):
        order = graph[caller]
        begin = min(at for at, name in enumerate(order) if chain(graph, name, first))
        if max(at for at, name in enumerate(order) if chain(graph, name, second)) < begin:
            return True
        if x != y:
            break
    return False


def wrong_order(graph, title, names, others):
    """`others`: the functions of the other walks."""
    for at, name in enumerate(names):
        before = [MAIN, *names[:at]]
        if name != MAIN and not any(chain(graph, caller, name) for caller in before + others):
            yield f"{title}: no step before {name} calls it"
        for caller in names[at + 1:]:
            calls = chain(graph, caller, name)
            nearer = [chain(graph, x, name) for x in names[:at]]
            if calls and not any(x and count_calls(x) <= count_calls(calls) for x in nearer):
                yield f"{title}: {caller} calls {name}, which stands before it"
        if at > 0 and not chain(graph, names[at - 1], name) and \
                wrong_siblings(graph, before[:-1], names[at - 1], name):
            yield f"{title}: {name} is called before {names[at - 1]}"


def wrong_ray(graph, text, end, last):
    """What is wrong with the tour's list of the calls from MAIN to `end`, which `last` calls."""
    lists = re.findall(rf"From `{MAIN}` to `{end}`,[^:]* (\w+) calls: ([^.]*) itself\.",
                       re.sub(r"\s+", " ", text))
    found = [(count, names) for count, names in
             ((count, re.findall(r"`(\w+)`", names)) for count, names in lists)
             if names[-2:] == [last, end]]
    if len(found) != 1:
        yield f"the calls from {MAIN} through {last} to {end} are not listed"
        return
    count, names = found[0]
    for caller, called in zip([MAIN, *names], names):
        calls = chain(graph, caller, called)
        if not calls or count_calls(calls) != 1:
            yield f"{caller} does not call {called}"
    if len(names) > RAY_CALLS_MAX or NUMBERS[len(names)] != count:
        yield f"{len(names)} calls through {last} to {end} are not {count}, or are too many"


def walks(text):
    """Title to steps (number, function, file) of each section of third order that has any."""
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
    graph = call_graph(tree)
    text = (tree / "docs/tour.md").read_text(encoding="utf-8")
    found = walks(text)
    wrong = [f"docs/tour.md: {w}" for ray in RAYS for w in wrong_ray(graph, text, *ray)]
    wrong += [f"docs/tour.md has no walk '{title}'" for title in sorted(WALKS - found.keys())]
    for title, steps in found.items():
        wrong += [f"docs/tour.md: {w}" for w in wrong_steps(tree, title, steps)]
        others = [name for other in found if other != title for _, name, _ in found[other]]
        wrong += [f"docs/tour.md: {w}" for w in
                  wrong_order(graph, title, [name for _, name, _ in steps], others)]
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
