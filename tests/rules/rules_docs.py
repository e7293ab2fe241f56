#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that the documentation is true where a program can check it: commands in ```sh blocks, and
those of tables before a link, use arguments, options and scripts that exist, ```xml scenes load,
links lead to files and to headings of pages, pages that comments name exist, and all statistics
that the source names have a row in docs/formats.md.

Usage: rules_docs.py TREE SATIN
"""
import collections
import functools
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

# Commands of others, which are not checked.
FOREIGN = {"meson", "ninja", "apt-get", "pip", "sed", "cc", "gdb", "git", "(cd"}
CODE = {".c", ".h", ".cpp", ".py", ".build"}


@functools.lru_cache(maxsize=None)
def anchors(path):
    """The anchors of a page's headings, as GitHub and GitLab name them: in lower case, hyphens for
    blanks, without punctuation, and numbered from the second heading of one name on."""
    text = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.M | re.S)
    found, times = set(), collections.Counter()
    for heading in re.findall(r"^#+ +(.*?)[ #]*$", text, re.MULTILINE):
        heading = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading)
        name = re.sub(r"[^\w -]", "", heading).lower().replace(" ", "-")
        found.add(f"{name}-{times[name]}" if times[name] else name)
        times[name] += 1
    return found


class Checker:
    def __init__(self, tree, satin):
        self.tree, self.satin, self.helps, self.wrong = tree, satin, {}, []

    def run(self, *arguments):
        done = subprocess.run([self.satin, *arguments], capture_output=True, text=True, check=False)
        return done.returncode, done.stdout, done.stderr

    def help(self, topic):
        """The words of `satin help TOPIC`, or None if there is no such topic."""
        if topic not in self.helps:
            status, text, _ = self.run("help", *([topic] if topic else []))
            self.helps[topic] = set(re.findall(r"[\w-]+", text)) if status == 0 else None
        return self.helps[topic]

    def satin_command(self, words):
        if not words or words[0].startswith("--"):
            words = ["", *words]
        command, rest = words[0], words[1:]
        if command == "help":
            for topic in (w for w in rest if not w.startswith("-")):
                if self.help(topic) is None:
                    yield f"no help on '{topic}'"
            return
        known = self.help(command)
        if known is None or command and command not in self.help(""):
            yield f"satin has no command '{command}'"
            return
        for at, word in enumerate(rest):
            if word.startswith("-") and word.split("=")[0].lstrip("-") not in \
                    {k.lstrip("-") for k in known}:
                yield f"satin {command} has no argument {word}"
            if word == "--set" and rest[at + 1].split("=")[0] not in self.help("options"):
                yield f"there is no option '{rest[at + 1]}'"

    def command(self, line):
        words = shlex.split(line, comments=True)
        while words and (words[0] in ("nice", "time", "-n", "10", "sudo") or "=" in words[0]):
            words = words[1:]
        if words and words[0] == "mpirun":
            words = words[next((i for i, word in enumerate(words) if "satin" in word), 0):]
        if ">" in words:
            words = words[:words.index(">")]
        if not words or words[0] in FOREIGN:
            return
        program = words[0]
        if program in ("satin", "build/satin"):
            yield from self.satin_command(words[1:])
        elif program == "./bootstrap":
            text = subprocess.run([self.tree / "bootstrap", "help"], capture_output=True, text=True,
                                  check=False).stdout
            if len(words) > 1 and not re.search(rf"^  {re.escape(words[1])} ", text, re.MULTILINE):
                yield f"bootstrap has no command '{words[1]}'"
        elif program == "python3":
            if not (self.tree / words[1]).is_file():
                yield f"there is no {words[1]}"
        elif program.startswith("build/"):
            # A program of the tree, or an example that a command beside it compiles.
            source = program.removeprefix("build/") + ".c"
            if not any((self.tree / path).is_file() for path in (source, "docs/" + source)):
                yield f"nothing builds {program}"
        elif not (self.tree / program).is_file():
            yield f"there is no {program}"

    def scene(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "scene.xml"
            path.write_text(text, encoding="utf-8")
            status, _, message = self.run("info", str(path))
            if status != 0:
                yield message.strip().replace(str(path), "scene.xml")

    def link(self, path, link, anchor):
        to = path.parent / link if link else path
        if not to.exists():
            yield f"the link to {link} leads nowhere"
        elif anchor and to.suffix == ".md" and anchor not in anchors(to):
            yield f"the link to {link}#{anchor} leads to no heading"

    def page(self, path):
        text = path.read_text(encoding="utf-8")
        for kind, block in re.findall(r"^```(\w+)\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
            if kind == "xml":
                self.note(path, self.scene(block))
            elif kind == "sh":
                for line in block.replace("\\\n", " ").splitlines():
                    self.note(path, self.command(line))
        for line in re.findall(r"\| `([^`|]+)` \| \[[^|]*\|$", text, re.MULTILINE):
            self.note(path, self.command(line))
        for link, anchor in re.findall(r"\]\(([^)#\s]*)(?:#([^)\s]*))?[^)]*\)", text):
            if "://" not in link:
                self.note(path, self.link(path, link, anchor))

    def statistics(self, path):
        rows = path.read_text(encoding="utf-8")
        called = re.compile(r'stats_(?:set|add)\([^"]*"(\w+\.[\w.]+)"')
        seconds = re.compile(r'"(time\.\w+)"')
        for source in sorted((self.tree / "src").rglob("*.c")):
            text = source.read_text(encoding="utf-8")
            for name in called.findall(text) + seconds.findall(text):
                if f"`{name}`" not in rows:
                    self.note(path, [f"says nothing of the statistic {name}"])

    def comments(self):
        for folder in ("include", "src", "tests", "bench"):
            for path in sorted((self.tree / folder).rglob("*")):
                if path.is_file() and path.suffix in CODE:
                    for page in re.findall(r"docs/[\w/-]+\.md", path.read_text(encoding="utf-8")):
                        if not (self.tree / page).is_file():
                            self.note(path, [f"there is no page {page}"])

    def note(self, path, what):
        self.wrong += [f"{path.relative_to(self.tree)}: {w}" for w in what]


def main():
    tree = pathlib.Path(sys.argv[1]).resolve()
    checker = Checker(tree, sys.argv[2])
    pages = [tree / "README.md", *sorted((tree / "docs").rglob("*.md")), tree / "data/README.md",
             tree / "tests/fuzz/README.md"]
    for path in pages:
        checker.page(path)
    checker.statistics(tree / "docs/formats.md")
    checker.comments()
    print("\n".join(checker.wrong))
    return 1 if checker.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
