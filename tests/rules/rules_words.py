#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Keeps retired words out of names, comments, messages and docs, so that one thing has one name,
the field's; and keeps docs/glossary.md true.

Usage: rules_words.py TREE

A word counts wherever it stands alone or between underscores, whatever its case. TO_DO names the
folders in which a word is not yet replaced; it may only shrink, so a folder that no longer has the
word is an error too.
"""
import collections
import pathlib
import re
import sys

FOLDERS = [".", "include", "docs", *(f"src/{s}" for s in (
    "base", "rsh", "brdf", "scene", "light", "load", "guide", "photon", "gather", "cache", "shade",
    "film", "render", "apps"))]
TEXT = {".c", ".h", ".cpp", ".md", ".py", ".1"}
# Retired words as patterns, and the terms in their place.
RETIRED = {
    "deal|deals|dealt|dealer": "allocate, distribute",
    "mend|mends|mended": "fix",
    "parted|halve|halved|halving": "separate, split; median split",
    "share|shares": "fraction or probability; have in common",
    "tell|tells|told": "report, indicate, describe",
    "bend|bends|bent": "curvature, Hessian",
    "turn|turns|turned|turning": "rotate, rotation",
    "reach": "influence radius",
    "surfel|surfels": "surface interaction",
    "relief|reliefs": "bump or normal map",
    "rough solution": "first-pass radiance estimate",
    "behind the image": "indirect bounce n",
    "grain|grains": "epsilon, noise, or chunk size",
    "memo|memos": "per-pixel cache",
    "judge|judges|judged": "evaluate",
    "keeper|keepers": "consumer",
    "substance|substances": "IOR preset",
    "without a word": "silently",
    "even rays|evenly spread rays": "stratified rays",
    "bright place|bright places": "photon clusters",
    "trust|trusts|trusted": "maximum lookup radius; reliable",
    "put_wall|wall_change|wall_[uv]|walls? of (?:the )?strat(?:a|um)|walls? between (?:two )?cells"
    "|fixed walls": "stratum boundary",
    "max_depth edges|path edges": "path segments",
}
# Where a retired word is the right one.
ALLOWED = re.compile(r"\b(in|by) turns?\b|\bradiance[-_]turn\b")
# What stands between two words of a term at the end of a line, in a comment or a text.
LINE_END = re.compile(r"[ \t]*\n[ \t]*(?:// ?|# )?|\"\s*\n\s*\"")
# Ways to begin a comment that cannot be read alone.
CUT = re.compile(r"^\s*// (The same|Of what)\b", re.MULTILINE)
# Of each word, the folders in which it is not yet replaced.
TO_DO = {}


def count_words(text):
    """How often each retired word stands in a text."""
    text = ALLOWED.sub("", LINE_END.sub(" ", text))
    return {words: len(re.findall(rf"(?<![A-Za-z])(?:{words})(?![A-Za-z])", text, re.IGNORECASE))
            for words in RETIRED}


def counts_of(tree):
    """(word, folder) to how often; the cut comments are a word of their own."""
    counts = collections.Counter()
    for folder in FOLDERS:
        # The top level has its own pages alone.
        for path in sorted((tree / folder).rglob("*") if folder != "." else tree.glob("*.md")):
            if path.suffix not in TEXT or path.name == "glossary.md":
                continue
            text = path.read_text(encoding="utf-8")
            for words, number in count_words(text).items():
                counts[words.split("|")[0], folder] += number
            if path.suffix in {".c", ".h", ".cpp"}:
                counts["// The same", folder] += len(CUT.findall(text))
    return counts


def glossary_terms(text):
    """The terms that the glossary defines: bold at the beginning of a line."""
    return re.findall(r"^\*\*([^*]+)\*\*", text, re.MULTILINE)


def wrong_glossary(tree):
    """Terms of the glossary that nothing uses, or that are not in their order."""
    terms = glossary_terms((tree / "docs/glossary.md").read_text(encoding="utf-8"))
    code = " ".join(p.read_text(encoding="utf-8").lower() for folder in ("src", "include")
                    for p in (tree / folder).rglob("*") if p.suffix in TEXT)
    code = re.sub(r"[\s/]+|_", " ", code)
    for term in terms:
        if not re.search(rf"\b{re.escape(term.lower())}", code):
            yield f"docs/glossary.md: nothing in src or include is called '{term}'"
    if terms != sorted(terms, key=str.lower) or len(terms) < 10:
        yield "docs/glossary.md: its terms are not in alphabetical order"


def wrong_words(counts):
    """Where a retired word stands, or is said to stand still and does not."""
    replacements = {words.split("|")[0]: what for words, what in RETIRED.items()}
    replacements["// The same"] = "a comment that can be read alone"
    known = {(word, folder) for word, folders in TO_DO.items() for folder in folders.split()}
    for word, folder in sorted({key for key in counts if counts[key]} - known):
        yield f"{folder}: '{word}' stands {counts[word, folder]} times: {replacements[word]}"
    for word, folder in sorted(known):
        if not counts[word, folder]:
            yield f"{folder}: '{word}' is replaced: take the folder off TO_DO"


def main():
    tree = pathlib.Path(sys.argv[1]).resolve()
    wrong = [*wrong_words(counts_of(tree)), *wrong_glossary(tree)]
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
