# SPDX-License-Identifier: Apache-2.0
"""libraries.txt: failed allocations inside libraries that end badly there."""
import fnmatch


class Known:
    def __init__(self, path):
        """Lines of OUTCOME PATTERN, a tab and the reason; # begins a comment."""
        self.lines = []
        for line in path.read_text(encoding="utf-8").splitlines():
            if not line or line.startswith("#"):
                continue
            rule, _, reason = line.partition("\t")
            outcome, _, pattern = rule.partition(" ")
            if not reason.strip() or not pattern:
                raise SystemExit(f"{path.name}: no reason: {line}")
            self.lines.append((outcome, pattern.strip(), line))
        self.used = set()

    def has(self, outcome, site):
        """Whether a line has this outcome and matches a frame inside the library."""
        inside = []
        for frame in site.stack:
            if frame.startswith("satin: "):
                break
            inside.append(frame)
        for wanted, pattern, line in self.lines:
            if wanted == outcome and any(fnmatch.fnmatchcase(f, pattern) for f in inside):
                self.used.add(line)
                return True
        return False

    def stale(self):
        return [line for _, _, line in self.lines if line not in self.used]
