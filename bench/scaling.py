#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How the time of a render would fall with the number of cores, by part of the work.

  bench/scaling.py DIR [SCENE ...]   data scenes by name, others by the path of their file

Every scene is rendered with one and with two threads, alternating. The model takes nothing from
wall times, which other processes change, but CPU times that satin measures (`parts.*` of --stats,
docs/formats.md): what the main thread does outside of loops is serial, what all threads do in
loops is parallel, and from the times of the loops' chunks satin finds how much longer than their
64th part 64 threads would take. On n cores a part takes

    serial + parallel / n + imbalance (1 - 1/n) / (1 - 1/64)

seconds. Not in the model: that cores use the same memory and caches (the column `2/1`, CPU time
with two threads over that with one, shows what there is of it with two), and that sleeping threads
wake for each loop (the last line says what each microsecond of that costs).
"""
import statistics

import runs

CORES = (8, 16, 32, 64)
MODEL = 64  # PARALLEL_MODEL of src/base/parallel.h
SCENES = ["cornell-glossy", "cornell-metal", "caustic", "indirect-room"]


class Part:
    """Medians over runs of one part; the wall time is the least."""

    def __init__(self, name, found):
        def of(quantity):
            return [f.get(f"parts.{name}.{quantity}", 0.0) for f in found]
        self.serial, self.parallel, self.imbalance, self.loops = (
            statistics.median(of(q)) for q in ("serial_s", "parallel_s", "imbalance_s", "loops"))
        self.wall = min(of("wall_s"))

    def seconds(self, cores):
        return (self.serial + self.parallel / cores
                + self.imbalance * (1 - 1 / cores) / (1 - 1 / MODEL))


def measure(options, scene, args):
    """Statistics of runs with one thread, and with two."""
    found = {1: [], 2: []}
    for _ in range(options.repeats):
        for threads, of in found.items():
            of.append(runs.render(options, scene, "scaling", *args, "--threads", str(threads))[1])
    return found


def percent(x):
    return f"{100 * x:.2f} %"


def print_model(found):
    names = [key.split(".")[1] for key in found[1][0]
             if key.startswith("parts.") and key.endswith(".serial_s")]
    one = {name: Part(name, found[1]) for name in names}
    two = {name: Part(name, found[2]) for name in names}
    whole = {n: sum(part.seconds(n) for part in one.values()) for n in (1,) + CORES}
    cores = " | ".join(f"of {n}" for n in CORES)
    print("| part | CPU, s | wall with 1, s | with 2, s | 2/1 | serial, s | imbalance, s "
          f"| of 1 core | {cores} |\n|" + "---|" * (8 + len(CORES)))
    for name, part in sorted(one.items(), key=lambda of: -of[1].seconds(MODEL)):
        both = two[name].seconds(1) / part.seconds(1) if part.seconds(1) > 0 else 1
        print(f"| {name} | {part.seconds(1):.3f} | {part.wall:.3f} | {two[name].wall:.3f} | "
              f"{both:.2f} | {part.serial:.4f} | {part.imbalance:.4f} | "
              + " | ".join(percent(part.seconds(n) / whole[n]) for n in (1,) + CORES) + " |")
    serial = sum(part.serial for part in one.values())
    loops = sum(part.loops for part in one.values())
    print(f"\nThe whole takes {whole[1]:.2f} s of CPU; serial are {percent(serial / whole[1])}, "
          + ", ".join(f"{percent(serial / whole[n])} of {n}" for n in CORES)
          + "; speed-up " + ", ".join(f"{whole[1] / whole[n]:.1f} on {n}" for n in CORES)
          + f".\n{loops:.0f} loops: each us of waking threads costs "
          f"{percent(1e-6 * loops / whole[MODEL])} of {MODEL} cores' time.\n", flush=True)


def main():
    runs.measure_all(__doc__, SCENES, "preview,production", 3,
                     lambda *render: print_model(measure(*render)))


if __name__ == "__main__":
    main()
