#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What several processes gain, and how the time of a render would fall with their number.

  bench/ranks.py DIR [SCENE ...]   data scenes by name, others by the path of their file

Every scene is rendered by one, two and four ranks of one thread each, alternating; the wall times
are the least of all repeats. With --slow, two ranks are bound to a core each, and one of these
cores has another process to do, too: a rank half as fast as the other.

The model takes CPU times of the first rank, which other processes hardly change: loops that are
divided take half of their CPU time with two ranks, all others take as much as with one. On R ranks
a render takes

    serial + undivided + divided / R + loops * hops * LATENCY + bytes / BANDWIDTH

seconds, where the divided loops are joined by log2 R hops each, and each rank gets the results of
all others. Not in the model: that ranks wait for the last one, which takes one chunk at most.
"""
import contextlib
import math
import os
import subprocess
import sys

import runs

RANKS = (1, 2, 4)
MODEL = (1, 2, 8, 64, 256, 1000)
LATENCY = 10e-6   # seconds of a hop, of a network of 10 Gbit/s; a fast one has 2e-6
BANDWIDTH = 1e9   # bytes per second of a rank
SCENES = ["cornell-glossy", "cornell-metal", "caustic", "indirect-room"]


def render_by(options, n, scene, args, bound=""):
    """The statistics of a render by n ranks; `bound` is what binds a rank to a core."""
    program = options.satin
    options.satin = os.path.join(options.dir, "satin-by-ranks") if n > 1 else program
    if n > 1:
        with open(options.satin, "w", encoding="utf-8") as file:
            file.write("#!/bin/sh\nexec mpirun --oversubscribe --bind-to none "
                       f'-n {n} {bound} {program} "$@"\n')
        os.chmod(options.satin, 0o755)
    stats = runs.render(options, scene, "ranks", *args, "--threads", "1")[1]
    options.satin = program
    return stats


def measure(options, scene, args):
    """Statistics of the runs by number of ranks."""
    found = {n: [] for n in RANKS}
    for _ in range(options.repeats):
        for n, of in found.items():
            of.append(render_by(options, n, scene, args))
    return found


@contextlib.contextmanager
def busy(core):
    """Another process on a core."""
    with subprocess.Popen(["taskset", "-c", str(core), sys.executable, "-c", "while True: pass"]) \
            as process:
        yield
        process.kill()


def print_slow(options, scene, args):
    """Wall times of two ranks, alternating: both alone on their cores, and one of them not."""
    first, second = sorted(os.sched_getaffinity(0))[:2]
    bound = (f"sh -c 'exec taskset -c $(($OMPI_COMM_WORLD_RANK ? {second} : {first})) \"$@\"' "
             "satin")
    alone, beside = [], []
    for _ in range(options.repeats):
        alone.append(render_by(options, 2, scene, args, bound))
        with busy(second):
            beside.append(render_by(options, 2, scene, args, bound))
    walls = [least(found, lambda s: s["time.total_s"]) for found in (alone, beside)]
    print(f"Two ranks: {walls[0]:.2f} s; {walls[1]:.2f} s, {walls[1] / walls[0]:.2f} times as "
          "long, with one half as fast.\n", flush=True)


def cpu(stats, quantity):
    return {key.split(".")[1]: value for key, value in stats.items()
            if key.startswith("parts.") and key.endswith("." + quantity)}


def least(found, value):
    return min(value(stats) for stats in found)


def print_table(found):
    names = list(cpu(found[1][0], "parallel_s"))
    one, two = ({name: least(found[n], lambda s, name=name: cpu(s, "parallel_s").get(name, 0.0))
                 for name in names} for n in (1, 2))
    serial = sum(least(found[1], lambda s, name=name: cpu(s, "serial_s").get(name, 0.0))
                 for name in names)
    divided = {name: min(max(2 * (one[name] - two[name]), 0.0), one[name]) for name in names}
    print("| part | CPU in loops, s | with 2 ranks | divided |\n|---|---|---|---|")
    for name in sorted(names, key=lambda name: -one[name]):
        if one[name] >= 0.01 * sum(one.values()):
            print(f"| {name} | {one[name]:.3f} | {two[name]:.3f} | "
                  f"{100 * divided[name] / one[name]:.0f} % |")
    loops = max(s.get("ranks.loops", 0.0) for s in found[2])
    size = max(s.get("ranks.results_bytes", 0.0) for s in found[2])
    walls = {n: least(found[n], lambda s: s["time.total_s"]) for n in RANKS}
    print(f"\nSerial {serial:.3f} s; {loops:.0f} divided loops, {size / 1e6:.1f} MB of results. "
          "Wall time " + ", ".join(f"{walls[n]:.2f} s by {n}" for n in RANKS) + ".")
    rest = serial + sum(one.values()) - sum(divided.values())
    model = {}
    for n in MODEL:
        exchange = loops * math.log2(n) * LATENCY + size / BANDWIDTH if n > 1 else 0.0
        model[n] = rest + sum(divided.values()) / n + exchange
    print("Model: " + ", ".join(f"{model[1] / model[n]:.1f} times as fast by {n} ranks"
                                for n in MODEL[1:]) + ".\n", flush=True)


def main():
    # In a container all are root; Open MPI wants that said.
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    runs.measure_all(__doc__, SCENES, "production", 2,
                     lambda *render: print_table(measure(*render)), slow=print_slow)


if __name__ == "__main__":
    main()
