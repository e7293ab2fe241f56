# SPDX-License-Identifier: Apache-2.0
"""Two ways to place records on one scene: at equal number, and how many records the plain way needs
for the error of the better one.

The accuracy of the plain way is bisected until it makes as many records as the better way did; from
there it falls by a sixth at a time until the error is the better way's.
"""
import dataclasses

import runs

IMAGE = ["--spp", "16", "--set", "adaptive=off"]     # the same noise in all
CLOSE = 0.02    # numbers of records are equal within this
STEP = 5 / 6    # of the accuracy, in search of the equal error
MOST = 12       # such steps
HEAD = ("| scene | records | radiance | irradiance | fill s | overhead | passes | relMSE | mean |\n"
        "|---|---|---|---|---|---|---|---|---|")


@dataclasses.dataclass
class Contest:
    options: object
    scene: str          # its file
    name: str           # of its reference
    better: str         # option=value
    plain: str
    accuracy: str       # the option that sets how many records the plain way makes
    counted: str        # the statistic that counts them
    both: tuple = ()    # options of both ways

    def fill_plain(self, out, a, more):
        return runs.render(self.options, self.scene, f"{self.name}-{out}", "--set", self.plain,
                           "--set", f"{self.accuracy}={a:.5f}", *self.both, *more)

    def equal_count(self, wanted):
        """The accuracy at which the plain way makes as many records, or the nearest in 10 tries."""
        low, high, best = 0.01, 2.0, None
        for _ in range(10):
            a = (low * high)**0.5
            _, stats = self.fill_plain("search", a, ["--spp", "1"])
            off = stats[self.counted] / wanted - 1
            if best is None or abs(off) < abs(best[1]):
                best = (a, off)
            if abs(off) <= CLOSE:
                break
            low, high = (a, high) if off > 0 else (low, a)
        return best[0]

    def equal_error(self, a, wanted):
        """The plain way's number of records with an error no larger; None if not in MOST steps."""
        for _ in range(MOST):
            a *= STEP
            image, stats = self.fill_plain("search", a, IMAGE)
            if runs.error(self.options, image, self.name)[0] <= wanted:
                return stats[self.counted]
        return None

    def row(self, what, image, stats):
        relmse, mean = runs.error(self.options, image, self.name)
        fill, overhead = stats["time.records_s"], stats.get("cache.overhead_s", 0.0)
        print(f"| {self.name} | {what} | {stats['records.radiance']:.0f} | "
              f"{stats['records.irradiance']:.0f} | {fill:.2f} | {overhead / fill:.1%} | "
              f"{stats.get('cache.passes', 1):.0f} | {relmse:.6f} | {mean:+.2%} |", flush=True)
        return relmse

    def run(self):
        """Prints the rows of a table under HEAD."""
        image, stats = runs.render(self.options, self.scene, self.name + "-better", "--set",
                                   self.better, *self.both, *IMAGE)
        wanted, count = self.row(self.better, image, stats), stats[self.counted]
        a = self.equal_count(count)
        image, stats = self.fill_plain("plain", a, IMAGE)
        if self.row(f"{self.plain} {self.accuracy}={a:.3f}", image, stats) <= wanted:
            print(f"| {self.name} | {self.plain} is no worse at equal number | | | | | | | |")
            return
        needed = self.equal_error(a, wanted)
        answer = f"takes {needed:.0f}, {needed / count:.1f}x" if needed else "takes too many"
        print(f"| {self.name} | {self.plain} at equal error {answer} | | | | | | | |", flush=True)
