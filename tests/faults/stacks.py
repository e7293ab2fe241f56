# SPDX-License-Identifier: Apache-2.0
"""Reads the sites that fault_alloc.c lists, with the names of functions."""
import bisect
import collections
import functools
import re
import subprocess

# Count of allocations, frames in words from the innermost, and whether the command itself asked for
# the memory, or a small library for it.
Site = collections.namedtuple("Site", "count stack own")

# Modules that pass on what others ask for.
PASSING = re.compile(
    r"libstdc\+\+|libc\.so|libm\.so|libz\.so|libexpat\.so|libpng|libjpeg|libOpenEXRCore")


@functools.lru_cache(maxsize=None)
def demangled(symbol):
    return subprocess.run(["c++filt", symbol], capture_output=True, text=True).stdout.strip()


class Stacks:
    def __init__(self, satin):
        """Addresses and names of the command's functions."""
        table = subprocess.run(["nm", "-C", "--defined-only", satin], capture_output=True,
                               text=True, check=True).stdout
        rows = [line.split(" ", 2) for line in table.splitlines()]
        rows = sorted((int(a, 16), name) for a, kind, name in rows if kind in "tTwWiu")
        self.address = [row[0] for row in rows]
        self.name = [row[1] for row in rows]

    def word(self, frame):
        address, _, symbol = frame.partition(":")
        module, _, offset = address.rpartition("+")
        if module == "satin":
            at = bisect.bisect_right(self.address, int(offset, 16) - 1) - 1
            symbol = self.name[at]
        elif symbol.startswith("_Z"):
            symbol = demangled(symbol)
        return module, symbol or "?"

    def read(self, path):
        sites = {}
        for line in open(path, encoding="utf-8"):
            name, count, *frames = line.rstrip("\n").split("\t")
            words = [self.word(frame) for frame in frames]
            asking = [m for m, _ in words if not PASSING.match(m)]
            sites[name] = Site(int(count), [f"{m}: {s}" for m, s in words],
                               asking[:1] == ["satin"])
        return sites
