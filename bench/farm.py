#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""An estimate of how long many frames take on many nodes, and of whether they are done in a day.

  bench/farm.py DIR [--frames 10000] [--nodes 100] [--cores 64] [--size 1920x1080]
                [--quality production] [--measured 240x135] [--hours 24]

Measured with one thread on this machine, at the smaller size: the walk through two rooms with 6 and
with 12 frames, the records of 12 frames by two ranks too, and two frames with these records loaded.
From the parts of these renders, in CPU seconds, the model of docs/cluster.md takes

    records, by all nodes in one job   serial + loops / cores + divided loops / (cores nodes)
    frames, each node its own range    reading + serial + loops / cores, for each frame

where the records of a frame more cost as much as the mean of the last 6, and all that is done per
pixel grows in proportion to the pixels. Not in the model: slower cores if all work, a file system
that all nodes read at once, and nodes that fail; a node that is lost costs its range of frames.
"""
import dataclasses
import os
import shlex

import runs

FRAMES = 6  # of the shorter walk
# Parts whose work is per pixel, or per site, of which there are some per pixel.
PER_PIXEL = ("sites", "choose", "adapt", "image", "plan", "rims", "film", "write")
IMAGE = ("image", "plan", "rims", "film", "write")
RECORDS = ("records", "sites", "choose", "gather", "insert", "adapt")


@dataclasses.dataclass
class Work:
    """CPU seconds on one thread: of serial code, and of loops."""
    serial: float = 0.0
    loops: float = 0.0

    @classmethod
    def of(cls, stats, scale, chosen):
        """The parts that `chosen` picks by name, those per pixel times `scale`."""
        work = cls()
        for key, value in stats.items():
            words = key.split(".")
            if words[0] != "parts" or not chosen(words[1]):
                continue
            value *= scale if words[1] in PER_PIXEL else 1
            work.serial += value if words[2] == "serial_s" else 0
            work.loops += value if words[2] == "parallel_s" else 0
        return work

    def __add__(self, other):
        return Work(self.serial + other.serial, self.loops + other.loops)

    def __sub__(self, other):
        return Work(self.serial - other.serial, self.loops - other.loops)

    def __mul__(self, by):
        return Work(self.serial * by, self.loops * by)

    def seconds(self, threads):
        return self.serial + self.loops / threads


def write_walk(options, frames):
    """A part of the walk of data/scenes/two-rooms.toml, of so many frames."""
    name = os.path.join(options.dir, f"walk-{frames}.toml")
    with open(name, "w", encoding="utf-8") as file:
        file.write("[[keyframe]]\nframe = 1\norigin = [-3.1, 1.5, 1.5]\ntarget = [-1.2, 1, -1]\n"
                   f"[[keyframe]]\nframe = {frames}\norigin = [{-3.1 + 0.08 * frames}, 1.5, 1.2]\n"
                   "target = [-0.5, 1, -1]\n")
    return name


class Measured:
    def __init__(self, options):
        self.options = options
        os.makedirs(options.dir, exist_ok=True)
        width, height = options.measured.split("x")
        self.args = ["--quality", options.quality, "--width", width, "--height", height,
                     "--threads", "1"]
        size = [[int(x) for x in text.split("x")] for text in (options.size, options.measured)]
        self.scale = size[0][0] * size[0][1] / (size[1][0] * size[1][1])

    def render(self, frames, frame, *args, ranks=1):
        program = self.options.satin
        if ranks > 1:
            self.options.satin = os.path.join(self.options.dir, "satin-by-ranks")
            with open(self.options.satin, "w", encoding="utf-8") as file:
                file.write(f"#!/bin/sh\nexec mpirun --oversubscribe -n {ranks} "
                           f'{shlex.quote(program)} "$@"\n')
            os.chmod(self.options.satin, 0o755)
        _, stats = runs.render(self.options, runs.scene_file("two-rooms"), "farm", *self.args,
                               "--animation", write_walk(self.options, frames), *args, frame=frame)
        self.options.satin = program
        return stats

    def work(self, stats, chosen):
        return Work.of(stats, self.scale, chosen)


def is_record(part):
    return part in RECORDS


def is_image(part):
    return part in IMAGE


def is_common(part):
    return part not in RECORDS and part not in IMAGE


def estimate(options):
    """The model's lines, as pairs of what is done and its seconds."""
    m = Measured(options)
    cache = os.path.join(options.dir, "farm.cache")
    few, many = m.render(FRAMES, 1), m.render(2 * FRAMES, 1, "--save-cache", cache)
    by_two = m.render(2 * FRAMES, 1, ranks=2) if options.nodes > 1 else many
    loaded = [m.render(2 * FRAMES, frame, "--load-cache", cache) for frame in (1, 2 * FRAMES)]
    each = (m.work(many, is_record) - m.work(few, is_record)) * (1 / FRAMES)
    records = m.work(many, is_record) + each * (options.frames - 2 * FRAMES)
    one, two = m.work(many, is_record).loops, m.work(by_two, is_record).loops
    divided = min(max(2 * (one - two), 0.0), one) / one
    common = m.work(many, is_common)
    image = (m.work(loaded[0], is_image) + m.work(loaded[1], is_image)) * 0.5
    reading = max(s["time.load_s"] for s in loaded)
    for stats in (few, many):
        print(f"measured: {stats['records.irradiance'] + stats['records.radiance']:.0f} records, "
              f"{m.work(stats, is_record).loops:.0f} CPU s of their loops at full size")
    print(f"measured: {100 * divided:.0f} % of these are divided between ranks; "
          f"{image.loops + image.serial:.1f} CPU s per image at full size\n")
    per_node = -(-options.frames // options.nodes)
    return [("photons and all else before records", common.seconds(options.cores)),
            (f"records of all frames, {options.nodes} nodes in one job",
             records.serial + records.loops * (1 - divided) / options.cores
             + records.loops * divided / (options.cores * options.nodes)),
            ("photons again, on each node", reading + common.seconds(options.cores)),
            (f"{per_node} frames on each node", per_node * image.seconds(options.cores))]


def main():
    parser = runs.parser(__doc__)
    parser.add_argument("--frames", type=int, default=10000)
    parser.add_argument("--nodes", type=int, default=100)
    parser.add_argument("--cores", type=int, default=64, help="of a node")
    parser.add_argument("--size", default="1920x1080", help="WIDTHxHEIGHT of the frames")
    parser.add_argument("--quality", default="production")
    parser.add_argument("--measured", default="240x135", help="the size that is measured")
    parser.add_argument("--hours", type=float, default=24.0, help="that there are")
    options = parser.parse_args()
    # In a container all are root; Open MPI wants that said.
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    lines = estimate(options)
    print("| what | hours |\n|---|---|")
    for what, seconds in lines:
        print(f"| {what} | {seconds / 3600:.3f} |")
    hours = sum(seconds for _, seconds in lines) / 3600
    print(f"| {options.frames} frames of {options.size} in all | {hours:.2f} |\n")
    verdict = "are done" if hours <= options.hours else "are not done"
    print(f"They {verdict} in {options.hours:g} hours, of which they take "
          f"{100 * hours / options.hours:.1f} %.")


if __name__ == "__main__":
    main()
