#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Keeps retired words out of names, comments, messages and docs, so that one thing has one name,
the field's; keeps six words to the one meaning that docs/glossary.md gives them; and keeps that
page true.

Usage: rules_words.py TREE

A word counts wherever it stands alone or between underscores, whatever its case.
"""
import pathlib
import re
import sys

FOLDERS = ["include", "docs", "src", "tests", "bench", "data"]
# Beside these, files without a suffix are scripts.
CODE = {".c", ".h", ".cpp"}
TEXT = CODE | {".md", ".py", ".1", ".txt", ".build", ""}
# What others wrote, what programs wrote, and the two files that name the retired words themselves.
SKIPPED = {"seeds", "references", "results", "spectra", "meshes", "__pycache__", "glossary.md",
           "rules_words.py"}
# Retired words as patterns, and the terms in their place.
RETIRED = {
    "deal|deals|dealt|dealer": "allocate, distribute",
    "mend|mends|mended": "fix",
    "part(?:ed|ing)|halve|halved|halvings?": "separate, split; median split",
    "share|shares": "fraction or probability; have in common",
    "in (?:the )?place of": "instead of",
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
    r"judge\w*": "evaluate",
    "keeper|keepers": "consumer",
    "substance|substances": "IOR preset",
    "without a word": "silently",
    "even rays|evenly spread rays": "stratified rays",
    "bright place|bright places": "photon clusters",
    "trust|trusts|trusted": "maximum lookup radius; reliable",
    "put_wall|wall_change|wall_[uv]|walls? of (?:the )?strat(?:a|um)|walls? between (?:two )?cells"
    "|fixed walls": "stratum boundary",
    "max_depth edges|path edges|struct edge|next_edge|edge_count": "path segments",
    "places_(?:load|held|next|opposite)|eight_places|place_lanes": "indices",
    "place_(?:even|among|key|rungs|shape)|(?:by|check|find|same|instance|shape|module)_places?"
    "|cache_site \\*place": "position, index or transform; a place is a line of a file",
    "room for|room_for|denoise_room": "memory or space for",
    "(?:rng|uniform|near|cells|tally|side|photons)(?:_|->)seen|is_seen_from"
    "|seen_(?:s|least|fraction)|struct seen"
    "|seen of (?:the lights|(?:each|a|its|their) light)":
        "visible, visibility",
    "(?:deeper than|beyond|more than) (?:%d|64) levels|levels? of nesting|nesting levels?":
        "nested",
    "(?:double|float) \\*?level|level of light|find_levels": "brightness, mean",
    "light[-_]guide|gather[-_]guide": "guide-visibility, guide-clusters",
    "gather[-_]shadow|gather[-_]bounce": "gather-direct, gather-near",
    "radiance[-_]neighbours|cache_clamp": "neighbour clamp",
    "cache_converge|render_converge|cache_convergence|render_adapt":
        "cache_adapt, render_adaptive_cache, render_adaptive_sampling",
    "photon_smooth": "photon_caustic_smooth",
    "photons_worth|worth_starved": "photons_again, again_factor",
    "clamp_guides": "auxiliary images",
    "first look|render_look|paths_will_do|given_up": "coarse image; can_trace_paths, too_slow",
    "satin_log_level": "satin_log_severity",
    "gather[-_]room|room_fn|(?:irradiance|radiance)_room": "radius ratio",
    "rng_stage": "rng_stream",
    "rays are shared": "allocated",
    "(?:vec3|int|struct \\w+) ways?": "direction, method",
    "(?:diffuse|glossy|specular)[_ ]parts?|scene_part|part of (?:a|the) blend":
        "component, lobe",
    "(?:double|float|int|const char) \\*?way|one_way|find_way": "direction, fraction, lobe",
    "(?:bright|sky|lit)_windows?|window_bins|struct window|->window": "visibility, histogram",
    "old_(?:scene|file|format|version|mitsuba)|mitsuba_old|char old\\[\\]": "mitsuba06, previous",
}
# All of them as one pattern, for text in lower case.
RETIRED_WORD = re.compile(f"(?<![a-z])(?:{'|'.join(RETIRED)})(?![a-z])")
# Where a retired word is the right one; the last are names that options had, where they are quoted.
ALLOWED = re.compile(r"""\b(in|by)\ turns?\b | ["'`](ir)?radiance[-_](turn|neighbours)["'`]
                     | ["'`](light-guide|gather-(bounce|guide|room|shadow))["'`] | `photons\.seen_s`
                     """, re.VERBOSE)
# Words that mean one thing in src and include, as docs/glossary.md defines it: a pattern, the files
# that use the word in this meaning, and what may stand in other files.
ONE_MEANING = {
    "Place": ("places?", r"src/load/|src/base/(?:fileio|log|status)\.|src/render/options\.c"
              r"|include/satin/types\.h", r"log_place(?: \*?place)?|\bin place\b(?! of)"),
    "Room": (r"\w+_rooms?|rooms?_\w+|(?:no|enough|more|leaves?|makes?) room|room (?:for|to|left)",
             "", "gather-room"),
    "Seen": ("seen", r"src/(?:guide|photon|gather|shade|render)/|src/(?:film/film|cache/cache)\.h"
             r"|src/scene/scene_camera|src/load/load_plugins_(?:integrator|sensor|shape)\.c"
             r"|include/satin/options\.h", ""),
    "Level": ("levels?", r"src/cache/cache_(?:tree|fill)|src/load/load_(?:image_levels|build)"
              r"|src/load/load_plugins_texture\.c|src/scene/scene(?:_texture\.c|\.h)"
              r"|src/render/render_(?:budget|records)|src/film/film_exr_read\.c"
              r"|src/apps/app_info_scene\.c", r"zip_level\b|recursive-levels"),
    "Guide": ("guid(?:es?|ed|ing)", r"src/(?:guide|gather|photon|render)/",
              r"guide/guide\.h|\bguide_(?:clusters|visibility)\b|RNG_GUIDE"),
    # Never a fraction.
    "Shared": (r"shar(?:es?|ing)", "", ""),
}
# What stands between two words of a term at the end of a line, in a comment or a text.
LINE_END = re.compile(r"[ \t]*\n[ \t]*(?:// ?|# )?|\"\s*\n\s*\"")
# Ways to begin a comment that cannot be read alone; the second line is about its first line only.
CUT = re.compile(r"^\s*// (The same|Of what)\b"
                 r"|^(?![ \t]*//)[^\n]*\n[ \t]*// (Of|Nor|Those|Such|Who|As many|Its)\b",
                 re.MULTILINE)
# A comment line in lower case after a full stop: what is left of an older sentence.
LEFT_OVER = re.compile(r"//[^\n]*[^.\s]{2}\.\n[ \t]*// ([a-z]+)(?: [^<>=]|,)")


def files(tree):
    """The files that the rule is about."""
    yield from sorted(tree.glob("*.md"))
    yield tree / "bootstrap"
    for folder in FOLDERS:
        for path in sorted((tree / folder).rglob("*")):
            inside = path.relative_to(tree).parts
            if path.suffix in TEXT and path.is_file() and not SKIPPED & set(inside):
                yield path


def wrong_words(path, name):
    """Retired words and comments that are cut, in one file."""
    text = path.read_text(encoding="utf-8")
    joined = ALLOWED.sub("", LINE_END.sub(" ", text)).lower()
    found = RETIRED_WORD.findall(joined)
    for word in sorted(set(found)):
        instead = next(i for words, i in RETIRED.items() if re.fullmatch(words, word))
        yield f"{name}: '{word}' stands {found.count(word)} times: {instead}"
    cut = CUT.search(text) if path.suffix in CODE else None
    if cut:
        yield f"{name}: '{cut.group(1) or cut.group(2)}' begins a comment"
    left = LEFT_OVER.search(text) if path.suffix in CODE else None
    if left:
        yield f"{name}: '{left.group(1)}' begins a sentence"


def wrong_meanings(path, name, terms):
    """Words of one meaning in a file that has another subject."""
    if not name.startswith(("src/", "include/")) or path.suffix not in CODE:
        return
    text = LINE_END.sub(" ", path.read_text(encoding="utf-8"))
    for term, (words, subject, elsewhere) in ONE_MEANING.items():
        if term not in terms:
            yield f"docs/glossary.md: it does not define '{term}'"
        if subject and re.match(subject, name):
            continue
        rest = re.sub(elsewhere, "", text, flags=re.IGNORECASE) if elsewhere else text
        found = re.findall(rf"(?<![A-Za-z])(?:{words})(?![A-Za-z])", rest, re.IGNORECASE)
        if found:
            yield f"{name}: '{found[0]}' is not what docs/glossary.md calls {term}"


def glossary_terms(text):
    """The terms that the glossary defines: bold at the beginning of a line."""
    return re.findall(r"^\*\*([^*]+)\*\*", text, re.MULTILINE)


def wrong_glossary(tree):
    """Terms of the glossary that nothing uses, files that are not there, and a wrong order."""
    page = (tree / "docs/glossary.md").read_text(encoding="utf-8")
    terms = glossary_terms(page)
    code = " ".join(p.read_text(encoding="utf-8").lower() for folder in ("src", "include")
                    for p in (tree / folder).rglob("*") if p.suffix in TEXT and p.is_file())
    code = re.sub(r"[\s/]+|_", " ", code)
    for term in terms:
        if not re.search(rf"\b{re.escape(term.lower())}", code):
            yield f"docs/glossary.md: nothing in src or include is called '{term}'"
    for name in re.findall(r"`([\w/]+\.(?:c|cpp|h|py))`", page):
        if not any((tree / top / name).is_file() for top in ("src", ".")):
            yield f"docs/glossary.md: there is no {name}"
    if terms != sorted(terms, key=str.lower) or len(terms) < 10:
        yield "docs/glossary.md: its terms are not in alphabetical order"


def main():
    tree = pathlib.Path(sys.argv[1]).resolve()
    wrong = [w for path in files(tree) for w in wrong_words(path, path.relative_to(tree))]
    terms = glossary_terms((tree / "docs/glossary.md").read_text(encoding="utf-8"))
    wrong += [w for path in files(tree)
              for w in wrong_meanings(path, path.relative_to(tree).as_posix(), terms)]
    wrong += wrong_glossary(tree)
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
