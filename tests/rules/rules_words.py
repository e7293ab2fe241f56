#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Keeps retired words out of names, comments, messages and docs, so that one thing has one name,
the field's; keeps the words of IDENTIFIERS to the one meaning that docs/glossary.md gives them, in
tests, bench and pages too; and keeps that page true.

Usage: rules_words.py TREE

A word counts wherever it stands alone or between underscores, whatever its case.
"""
import pathlib
import re
import sys

FOLDERS = ["include", "docs", "src", "tests", "bench", "data"]
# Beside these, files without a suffix are scripts.
CODE = {".c", ".h", ".cpp"}
TEXT = CODE | {".md", ".py", ".1", ".txt", ".build", ".toml", ".html", ".js", ".css", ""}
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
    "bounces? beyond the first|records? of the first (?:indirect )?bounce":
        "indirect bounce n, of which 1 is at y; records of the image are at x",
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
    "|fill_site \\*place": "position, index or transform; a place is a line of a file",
    "room for|room_for|denoise_room": "memory or space for",
    "(?:uniform|near|cells|tally|side|photons)(?:_|->)seen|is_seen_from"
    "|seen_(?:s|least|fraction)|struct seen(?!_path)"
    "|seen of (?:the lights|(?:each|a|its|their) light)":
        "visible, visibility",
    "(?:deeper than|beyond|more than) (?:%d|64) levels|levels? of nesting|nesting levels?":
        "nested",
    "(?:double|float) \\*?level|level of light|find_levels": "brightness, mean",
    "light[-_]guide|gather[-_]guide": "guide-visibility, guide-clusters",
    "gather[-_]shadow|gather[-_]bounce": "gather-direct, gather-near",
    "radiance[-_]neighbours|cache_clamp": "neighbour clamp",
    "cache_converge|render_converge|cache_convergence|render_adapt":
        "fill_adaptive_cache, render_adaptive_cache, render_adaptive_sampling",
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
    "gather_direct_table|pixel_entry|cache_origin|stage_part|denoiser_pace|even_samples":
        "gather_direct, pixel_value, provenance, stage_range, pixel_seconds, equal_samples",
    "rims? of (?:the )?(?:disc|disk|sun)s?": "boundary, edge; a rim is a lamp's",
    "photon_curve|morton curve|curve from effort|one curve|points of (?:this|the|its) curve":
        "morton order; functions of effort",
    "render_widths|given_widths|finest_width|times the width a": "factors of the accuracy a",
    "render_mattes|matte_pixel|film_is_matte": "render_cryptomatte, of option cryptomatte",
    "in (?:the|its) first pass[,;] (?:all records|after which)|radius in the first pass":
        "initial; the first pass is before the caches",
    "old_(?:scene|file|format|version|mitsuba)|mitsuba_old|char old\\[\\]": "mitsuba06, previous",
}
# All of them as one pattern, for text in lower case.
RETIRED_WORD = re.compile(f"(?<![a-z])(?:{'|'.join(RETIRED)})(?![a-z])")
# Where a retired word is the right one; the last are names that options had, where they are quoted.
ALLOWED = re.compile(r"""\bto\ deal\ in\ the\ Software\b |
                     \b(in|by)\ turns?\b | ["'`](ir)?radiance[-_](turn|neighbours)["'`]
                     | ["'`](light-guide|gather-(bounce|guide|room|shadow))["'`] | `photons\.seen_s`
                     | /usr/share/
                     """, re.VERBOSE)
# Words that mean one thing in src and include, as docs/glossary.md defines it. In identifiers: a
# pattern of the word, and all identifiers that have it, each with the files that may use it.
IDENTIFIERS = {
    "Place": ("places?|placed|placing", {
        "log_place": r"src/(?:apps/app_info_cache|base/(?:fileio|log)|film/film_exr_read|load/"
                     r"|render/(?:options|render_cache)|scene/scene_hints|study/|toml/"
                     r"|animation/)",
        "place": r"src/(?:animation/|base/(?:fileio|log)|load/|render/options|scene/scene_hints)",
        "MPI_IN_PLACE": "src/apps/app_ranks_mpi",
        "current_place": "src/load/load_xml"}),
    "Part": ("parts?", {
        "parallel_(?:begin_)?parts?|stats_set_parts|PARALLEL_PARTS_MAX|set_part|part_count":
            "src/",
        "parts?": "src/(?:base/(?:parallel|stats)|fill/|photon/|render/|film/film_exr_write)",
        "exr_add_part": "src/film/film_exr_write"}),
    "Branch": ("branch(?:es)?", {
        "branch|path_branch|follow_branch": "src/gather/gather_bounces"}),
    "Room": ("rooms?", {}),
    "Seen": ("seen", {
        "seen": r"src/(?:guide/|photon/photon|render/render_(?:budget|film)"
                r"|scene/scene_camera_check|shade/shade\.c)",
        r"guide_seen(?:_\w+)?|GUIDE_SEEN_\w+|RNG_SEEN|SEEN_PATHS|seen_paths?|trace_seen": "src/"}),
    "Level": ("levels?", {
        "levels?": r"src/(?:apps/app_info_scene|load/load_(?:build|image_l(?:evels|imit)"
                   r"|plugins_texture)"
                   r"|render/render_(?:budget|records)|scene/scene(?:_image|_texture)?\.)",
        "RENDER_LEVELS|cover_levels|record_level|level_pays":
            "src/render/render_(?:budget|records)",
        "load_image_levels": "src/load/load_(?:build|image_levels|plugins_texture)",
        "texture_level": "src/scene/scene_texture", "zip_level": "src/film/film_exr_write"}),
    "Guide": ("guid(?:es?|ed|ing)", {
        r"(?:guide|GUIDE)_\w+": "src/(?:guide|gather|photon)/",
        r"guide_(?:clusters|emission|visibility)"
        "(?:_(?:aim|build|bytes|free|most|samples|small|unused))?|GUIDE_SEEN_PATHS_MAX"
        : "include/satin/options|src/render/",
        "guided|GUIDED|gather_rays_guided": "src/gather/"}),
    "Curve": ("curves?", {
        r"\w+": r"src/(?:load/load_(?:curve|hair|build|shape|plugins_shape)|scene/)"
                r"|src/apps/app_info_scene"}),
    "Group": ("groups?", {r"\w+": r"src/(?:load/|scene/|guide/guide_aim)"}),
    "Job": ("jobs?", {
        "job|find_job": r"src/(?:render/render_(?:animation|metadata|state)"
                        r"|apps/app_(?:animation|render))|include/satin/animation"}),
    "Preview": ("previews?", {
        "OPTIONS_QUALITY_PREVIEW|SATIN_PREVIEW":
            r"src/(?:render/options|apps/app_help)|include/satin/options",
        "APP_PREVIEW_H|FLAG_PREVIEW|(?:app_)?preview(?:_write|_finish)?|film_write_preview":
            r"src/(?:apps/app_(?:preview|render)|film/film)"}),
    "Probe": ("prob(?:es?|ed|ing)", {
        "GUIDE_PROBES|NEAR_PROBED|choose_probes|gather_(?:near_)?probe|probes?":
            "src/(?:guide|gather)/"}),
    "View": ("views?", {
        r"satin_view|views?|view_(?:count|vector)|(?:make|set|adapt)_views?|RENDER_VIEW_PIXELS"
        r"|render_budget_view_pays|render_views\w*":
            r"src/(?:animation/|render/|apps/app_animation|scene/scene\.)|include/satin/animation",
        "(?:load|read|set)_field_of_view": "src/load/", "string_view": "src/toml/",
        "first_pass_view": "src/study/"}),
    # Never a fraction.
    "Shared": ("shar(?:es?|ed|ing)", {
        "load_xml_is_shared": "src/load/load_xml", "rtcSetSharedGeometryBuffer": "src/scene/",
        "SetSharedFilterImage": "src/film/",
        "MPI_(?:COMM_TYPE_SHARED|Win_allocate_shared|Win_shared_query)":
            "src/apps/app_ranks_mpi"}),
}
# Words that are retired from identifiers alone: a pattern of the word, the files from which it is
# retired, and the terms in its place.
RETIRED_IDENTIFIERS = [
    ("keep|keeps|kept|keeping|keeper", "src/photon/", "consumer, stored, preserved"),
    ("weigh|weighs|weighed|weighing", "src/", "weight, weights, probability"),
]
# Outside, where the identifiers of src may stand in any C file, also these. A room is a scene
# there.
TEST_IDENTIFIERS = {
    "Place": r"after_place", "Part": r"\w*(?i:part)s?\w*",
    "Branch": r"\w*(?i:branch)\w*", "Room": r"\w*(?i:room)\w*",
    "Seen": "seen_directly|seen_(?:one|many)",
    "Level": "levels?_\\w+|EXR_TILE_ONE_LEVEL|LogLevel|set_log_level",
    "Curve": r"\w+", "Group": r"\w+", "Job": r"\w+", "Preview": r"\w+", "Probe": r"\w+",
    "View": r"\w+",
    "Guide": r"test_guide_\w+", "Shared": "MAP_SHARED|oidnSetSharedFilterImage|shared"}
# Folders of code outside of src and include.
OUTSIDE = ("tests/", "bench/", "data/", "docs/")
# The type of what has one of these names.
TYPES = {"place": "log_place"}
# In comments and messages: a pattern of the word, the files that use it in this meaning, and what
# may stand in other files.
IN_TEXT = {
    "Place": ("places?", r"src/load/|src/base/(?:fileio|log|status)\.|src/render/options\.c"
              r"|include/satin/types\.h", r"\bin place\b(?! of)"),
    "Room": (r"(?:no|enough|more|leaves?|makes?) room|room (?:for|to|left)", "", ""),
    "Seen": ("seen", r"src/(?:guide|photon|gather|shade|render)/|src/(?:film/film|fill/fill)\.h"
             r"|src/scene/scene_camera|src/load/load_(?:plugins_(?:integrator|sensor)|shape)\.c"
             r"|include/satin/options\.h", ""),
    "Level": ("levels?", r"src/cache/cache_tree|src/fill/fill_batch"
              r"|src/load/load_(?:image_l(?:evels|imit)|build|plugins_texture\.c)"
              r"|src/scene/scene(?:_texture\.c|(?:_image)?\.h)"
              r"|src/render/render_(?:budget|records)|src/film/film_exr_read\.c",
              "recursive-levels"),
    "Guide": ("guid(?:es?|ed|ing)", r"src/(?:guide|gather|photon|render)/", ""),
    "Shared": (r"shar(?:es?|ing)", "", ""),
    "Branch": ("branch(?:es)?", "src/gather/gather_bounces|src/shade/shade_eye", ""),
    "Curve": ("curves?", r"src/load/load_(?:curve|hair|build|shape|plugins_shape)|src/scene/"
              r"|src/apps/app_info_scene", "may curve|curves away|(?:splines|meshes) and[^.]*curves"
              "|about curves"),
    "Group": ("groups?", r"src/load/|src/scene/|src/guide/guide_aim",
              r"process and[^.]* its group|to the group and|of a group|task group|Three instances"
              r"|(?:teardown|processes) of a group|one to it or to its group"),
    "Job": ("jobs?", r"src/apps/app_animation|src/render/render_(?:animation|metadata|state)"
            "|include/satin/animation", "job of|in one job"),
    "Preview": ("previews?", "src/apps/app_preview",
                r"(?:quality|at|draft and|draft,) `?preview|draft ?\|\s*preview|else preview"),
    "Probe": ("prob(?:es?|ed|ing)", "src/(?:guide|gather)/", "probe of a photon cluster"),
    "View": ("views?", r"src/(?:animation|render|scene)/|src/load/load_(?:transform|plugins_sensor)"
             r"|include/satin/(?:animation|scene)",
             "(?:angle|field) of view|along the view|view of this sensor|first view|one view"
             "|(?:a|each|this|keyframe's|two|three|of|the) views?"),
}
# Phrases in which such a word means something else, in any file.
OTHER_MEANING = re.compile(r"""\bplaces?\ (?:where|at\ which|in\ (?:space|a\ room)|on\ (?:a|the)\b)
    | \b(?:bright|dark|lit|near|every|each|many|some|other|same|few)\ places?\b
    | \blevels?\ of\ (?:light|noise|error|detail|bright|accuracy) | \b(?:light|noise)\ levels?\b
    | \bas\ seen\ (?:above|below|before)\b | \b(?:has|have)\ (?:been\ )?seen\b
    | \bguidelines?\b | \b(?:user's|this)\ guide\b""", re.VERBOSE | re.IGNORECASE)
# The words of one meaning on pages, which may have any subject: what may stand there in this
# meaning. A part is a word of plain English outside of names.
PAGE_TERMS = {
    "Place": r"(?:has|with|begins with) (?:its|the) place\b|the place of the error"
             r"|\bplaced by a transform|records are placed",
    "Room": "", "Shared": "", "Probe": "", "Branch": "meaning for part, branch",
    "Level": r"\b(?:each|every|finer|coarsest|next|last|second|two|its|the|largest|level by)"
             r" levels?\b|\blevels whose|\blevels of (?:the|stride)|\blevel by level",
    "Guide": r"\bguide-\w+|\bguid(?:ed|e) (?:rays|the rays)|\brays (?:are|were) guided"
             r"|(?:not|is) guided|\bguiding by|\ba guide distributes|\| *guide *\||spectra guide",
    "Curve": r"file of curves|\bcurves do not emit|(?:around|separate|and) curves|\(curves\)"
             r"|meaning for curve",
    "Group": r"of (?:a|the) group\b|the group's space",
    "Preview": r"(?<!a )(?<!the )(?<!each )(?<!its )\bpreview\b",
    "View": r"(?:angle|field|direction) of view|(?:in|into|its|the|one|all|each|of|two|several"
            r"|list of"
            r"|another|same|first|second|where|or|this|many|three) views?\b|\bview I+\b"
            r"|along the view",
    "Seen": r"\bseen (?!(?:by|from|of) (?:the |a |each )?(?:light|lamp|record|point|cell|photon))"
            r"|\bseen[.,;:|)]|\bseen$",
    "Job": r"\bjobs?\b",
}
QUOTED = re.compile(r"```.*?```|`[^`]*`", re.DOTALL)
WRONG_PAGES = ["The light at many places of a wall.", "There is no room for it.", "It shares rays.",
               "The level of noise rises.", "The processor's branch.", "A curve of errors.",
               "Some groups of rays.", "The preview is written.", "A probe of a record.",
               "The direct view.", "What is seen from a point.", "It guides the eye.",
               "A level is noise."]
# Lines that must be found wrong, and lines that must not.
WRONG = [("src/photon/photon.h", "int KEEP_ALL;"), ("src/light/light.h", "weigh_leaf(x);"),
         ("src/load/load.c", "vec3 place;"), ("src/guide/guide.h", "float seen_fraction;"),
         ("src/cache/cache.c", "int level;"), ("src/render/render.c", "int guide;"),
         ("src/load/load.c", "// A place where light is."), ("src/light/light.c", "// a level"),
         ("src/base/array.c", "float share;"), ("src/gather/gather.h", "bool has_room;"),
         ("src/scene/scene.h", "struct guide_cone cone;"), ("src/scene/scene.h", "bool seen;"),
         ("tests/unit/light.c", "struct mat4 place;"), ("tests/unit/light.c", "// a place"),
         ("data/cases.py", "# the level of water"), ("docs/example.c", "// It was seen."),
         ("bench/runs.py", "level = 1"),
         ("src/render/render_records.c", "// the level of noise"), ("src/base/vec.h", '"seen"')]
RIGHT = [("src/load/load.c", "struct log_place place;"), ("src/guide/guide.h", "bool seen;"),
         ("src/photon/photon.h", "struct guide_seen seen;"), ("src/load/load.c", "// at the place"),
         ("tests/unit/load.c", "// its place"), ("bench/runs.py", "x = 'level'"),
         ("src/cache/cache.c", "// sorts in place"), ("src/render/render_budget.c", "int levels;")]
# What stands between two words of a term at the end of a line, in a comment or a text.
LINE_END = re.compile(r"[ \t]*\n[ \t]*(?:// ?|# )?|\"\s*\n\s*\"")
# Comments, texts and included files.
SAYS = re.compile(r'//[^\n]*|/\*.*?\*/|#include[^\n]*|"(?:\\.|[^"\\\n])*"', re.DOTALL)
PYTHON_SAYS = re.compile(r'"""(?:\\.|[^\\])*?"""|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\''
                         r"|#[^\n]*", re.DOTALL)
JS_SAYS = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])* (?:\\.|[^"\\\n])*"', re.DOTALL)
# The suffixes of pages, of which code is left out.
PAGES = {".md", ".1", ".toml", ".html", ".js"}
# Ways to begin a comment that cannot be read alone; the second line is about its first line only.
CUT = re.compile(r"^\s*// (The same|Of what)\b"
                 r"|^(?![ \t]*//)[^\n]*\n[ \t]*// (Of|Nor|Those|Such|Who|As many|Its)\b",
                 re.MULTILINE)
# Comments that are divided by a declaration: after code, the second one continues the first, or the
# first one ends in the middle of a sentence.
DIVIDED = re.compile(r"^[ \t]*[^/\s\n][^\n]*[^/\s\n][ \t]+// [^\n]*\n"
                     r"[ \t]*[^/\s\n][^\n]*[^/\s\n][ \t]+// (and|or|but) "
                     r"|^[ \t]*[^/\s\n][^\n]*[^/\s\n][ \t]+// [^\n]*(,)\n(?![ \t]*//)"
                     r"|^[ \t]*// [^\n]*(, or| and|,)\n(?![ \t]*//)", re.MULTILINE)
CUTS = ["int a;  // the site,\nint b;  // and its width", "int a;  // one of the two,\nint b;",
        "// By a limit, or\nint a;"]
WHOLE = ["int a;  // the site\nint b;  // its width", "int a;  // one,\n        // of two\nint b;"]
# Two sentences of a comment without a full stop between them, also across two lines if the first is
# not after code or a banner.
BEGINS = ("(Whether|Returns|Sets|The|An|If|It|Its|This|These|Makes|Finds|Adds|Each|False|True|Where"
          "|When|After|Before|Of|At|By|To|With|Without)")
RUN_TOGETHER = re.compile(rf'//[^\n"]*[a-z,] {BEGINS}\b'
                          rf'|^[ \t]*// (?!----)[^\n"]*[a-z,]\n[ \t]*// {BEGINS}\b', re.MULTILINE)
RUNS_TOGETHER = ["// and of its inverse Whether photon\n// i is", "// a limit\n// The other"]
RUNS_APART = ["// a limit. The other", "int a;  // a limit\n// The other", "// ---- a.c\n// If it"]
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
    divided = DIVIDED.search(text) if path.suffix in CODE else None
    if divided:
        yield f"{name}: a declaration divides the comment {divided.group(0)!r}"
    left = LEFT_OVER.search(text) if path.suffix in CODE else None
    if left:
        yield f"{name}: '{left.group(1)}' begins a sentence"
    together = RUN_TOGETHER.search(text) if path.suffix in CODE else None
    if together:
        yield f"{name}: no full stop before '{together.group(1) or together.group(2)}'"


def wrong_identifiers(text, name):
    """Identifiers with a word of one meaning that are not in the table for this file."""
    identifiers = set(re.findall(r"[A-Za-z_]\w*", text))
    tests = name.startswith(OUTSIDE)
    for term, (words, allowed) in IDENTIFIERS.items():
        if tests:
            known = [] if name.endswith(".py") else allowed
            allowed = dict.fromkeys([*known, TEST_IDENTIFIERS[term]], "")
        part = re.compile(rf"(?:^|_|(?<=[a-z])(?=[A-Z]))(?i:{words})(?:$|_|(?<=[a-z])(?=[A-Z]))")
        for identifier in sorted(filter(part.search, identifiers)):
            if not any(re.fullmatch(known, identifier) and re.match(where, name)
                       for known, where in allowed.items()):
                yield f"'{identifier}' is not what docs/glossary.md calls {term}"
    for words, where, instead in RETIRED_IDENTIFIERS:
        retired = re.compile(rf"(?:^|_)(?i:{words})(?:$|_)")
        if re.match(where, name):
            yield from (f"'{x}' is retired here: {instead}"
                        for x in sorted(filter(retired.search, identifiers)))
    for variable, kind in TYPES.items():
        for found in re.findall(rf"(\w+)[\s*]+{variable}\b(?=[;,)\[ =])", text):
            if found not in (kind, "return"):
                yield f"'{found} {variable}' should be a {kind}"


def wrong_text(text, name):
    """Words of one meaning in a comment or a message that has another subject."""
    for term, (words, subject, elsewhere) in IN_TEXT.items():
        if subject and re.match(subject, name):
            continue
        rest = re.sub(elsewhere, "", text, flags=re.IGNORECASE) if elsewhere else text
        found = re.search(rf"(?<![\w/-])(?:{words})(?![\w/]|-(?:clusters|visibility))", rest,
                          re.IGNORECASE)
        if found:
            yield f"'{found.group()}' is not what docs/glossary.md calls {term}"
    found = OTHER_MEANING.search(text)
    if found:
        yield f"'{found.group()}' has another meaning than in docs/glossary.md"


def wrong_page(text, name):
    """Words of one meaning on a page outside of the phrases where they have it. Code on the page is
    not read."""
    text = LINE_END.sub(" ", QUOTED.sub(" ", text))
    for term, right in PAGE_TERMS.items():
        words, _, elsewhere = IN_TEXT[term]
        allowed = "|".join(filter(None, [elsewhere if term in ("Place", "Room", "Shared") else "",
                                         right]))
        rest = re.sub(allowed, " ", text, flags=re.IGNORECASE) if allowed else text
        found = re.search(rf"(?<![\w/-])(?:{words})(?![\w/-])", rest, re.IGNORECASE)
        if found:
            yield f"{name}: '{found.group()}' is not what docs/glossary.md calls {term}"
    found = OTHER_MEANING.search(text)
    if found:
        yield f"{name}: '{found.group()}' has another meaning than in docs/glossary.md"


def said_on(path):
    """What a page says: of a program's file its comments and texts."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".toml":
        return "\n".join(re.findall(r"#[^\n]*", text))
    if path.suffix == ".js":
        return "\n".join(JS_SAYS.findall(text))
    if path.suffix == ".html":
        return re.sub(r"<!--|-->|<[^>]*>", " ", re.sub(r"<style.*?</style>", " ", text, flags=re.S))
    return text.replace("\\-", "-")


def wrong_meanings(text, name):
    """Words of one meaning that are used in another one, in code and in what it says."""
    pattern = PYTHON_SAYS if name.endswith(".py") else SAYS
    says = pattern.findall(text)
    code = pattern.sub(" ", text)
    subject = name
    if name.startswith(OUTSIDE):  # its strings quote messages of the program, or are a scene's
        says = [x for x in says if x.startswith(("//", "/*", "#", '"""')) and "#include" not in x]
        # A unit test's comments are about the source of its name.
        subject = re.sub(r"^tests/unit/(([a-z]+)\w*\.c)$", r"src/\2/\1", name)
    said = LINE_END.sub(" ", "\n".join(says))
    for what in [*wrong_identifiers(code, name), *wrong_text(said, subject)]:
        yield f"{name}: {what}"


def wrong_examples():
    """What shows that wrong_meanings finds something."""
    for name, text in WRONG:
        if not list(wrong_meanings(text, name)):
            yield f"rules_words.py does not see what is wrong with {text!r} in {name}"
    for name, text in RIGHT:
        yield from wrong_meanings(text, name)
    for text in WRONG_PAGES:
        if not list(wrong_page(text, "README.md")):
            yield f"rules_words.py does not see what is wrong with {text!r}"
    for text in RUNS_TOGETHER:
        if not RUN_TOGETHER.search(text):
            yield f"rules_words.py does not see what is wrong with {text!r}"
    for text in CUTS:
        if not DIVIDED.search(text):
            yield f"rules_words.py does not see what divides the comment {text!r}"
    for text in filter(DIVIDED.search, WHOLE):
        yield f"rules_words.py finds {text!r} divided"
    for text in filter(RUN_TOGETHER.search, RUNS_APART):
        yield f"rules_words.py finds {text!r} wrong"


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
    wrong += [f"docs/glossary.md: it does not define '{t}'" for t in IDENTIFIERS if t not in terms]
    wrong += wrong_examples()
    for path in files(tree):
        name = path.relative_to(tree).as_posix()
        if name.startswith(("src/", "include/")) and path.suffix in CODE \
                or name.startswith(OUTSIDE) and path.suffix in CODE | {".py"}:
            wrong += wrong_meanings(path.read_text(encoding="utf-8"), name)
        if path.suffix in PAGES:
            wrong += wrong_page(said_on(path), name)
    wrong += wrong_glossary(tree)
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
