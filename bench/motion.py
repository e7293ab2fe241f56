#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What records of the scene at rest are worth where an object or a light moves, and the error that
they leave: four positions of an object in the first of two rooms, against frames whose records are
all made anew, and against path-traced references.

  bench/motion.py DIR [--size 160x120] [--quality draft] [--object ball]

A frame whose records are all its own is one of a scene file with the object there. Errors are
relMSE x 10^4 without the reference's own noise, by the product of the errors against two of them.
"""
import os

import numpy as np
import OpenEXR
import runs

VIEW = "[[frame]]\norigin = [-3.1, 1.5, 1.5]\ntarget = [-1, 0.9, -1]\n"
# Positions of the object: on its table, beside that, over the floor, and on the floor.
OFFSETS = [(0, 0, 0), (0.1, 0, 0.2), (0.3, -0.4, 1.2), (-0.8, -0.7, 1)]
LIGHTS = [1, 0.9, 0.5, 0]  # intensities of a lamp
PATH_SPP = 256


def write_motion(options, path):
    text = VIEW * len(OFFSETS) + f'[[object]]\nid = "{options.object}"\n'
    for i, (offset, light) in enumerate(zip(OFFSETS, LIGHTS)):
        value = f"translate = {list(offset)}"
        if options.object == "lamp":
            value = f"intensity = {light}"
        text += f"[[object.keyframe]]\nframe = {i + 1}\n{value}\n"
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def write_scene(options, frame):
    """The scene with the object where it is in a frame: the name of its file."""
    with open(runs.scene_file("two-rooms"), encoding="utf-8") as file:
        text = file.read()
    begin = text.index(f'id="{options.object}"')
    end = text.index("</shape>", begin)
    shape = text[begin:end]
    x, y, z = OFFSETS[frame - 1]
    if options.object == "lamp":
        value = ", ".join(str(LIGHTS[frame - 1] * v) for v in (9, 8, 7))
        shape = shape.replace('value="9, 8, 7"', f'value="{value}"')
    elif "<transform" in shape:
        at = shape.index("</transform>")
        shape = shape[:at] + f'<translate x="{x}" y="{y}" z="{z}"/>' + shape[at:]
    else:
        shape += f'<transform name="to_world"><translate x="{x}" y="{y}" z="{z}"/></transform>'
    name = os.path.join(options.dir, f"two-rooms-{options.object}-{frame}.xml")
    with open(name, "w", encoding="utf-8") as file:
        file.write(text[:begin] + shape + text[end:])
    return name


def colours(image, layer=""):
    with OpenEXR.File(image, separate_channels=True) as file:
        channels = file.channels()
        return np.stack([channels[layer + c].pixels.astype(np.float64) for c in "RGB"], axis=-1)


def error(image, truth, lit):
    one, two = truth
    found = (image - one) * (image - two) / ((one + two)**2 / 4 + 0.01)
    return 1e4 * found.mean(axis=-1)[~lit].mean()


def records_of(stats):
    return stats["records.irradiance"] + stats["records.radiance"]


def fill_seconds(stats):
    """CPU seconds of making the records of a frame, with the test rays: its render has a pool of
    its own, so the parts are of this frame alone."""
    return sum(stats.get(f"parts.{part}.{kind}_s", 0.0) for kind in ("serial", "parallel")
               for part in ("records", "sites", "choose", "gather", "insert", "adapt", "tests"))


def main():
    parser = runs.parser(__doc__)
    parser.add_argument("--size", default="160x120")
    parser.add_argument("--quality", default="draft")
    parser.add_argument("--object", default="ball", choices=("ball", "crate", "lamp"))
    options = parser.parse_args()
    os.makedirs(options.dir, exist_ok=True)
    width, height = options.size.split("x")
    args = ["--width", width, "--height", height, "--float", "--quality", options.quality]
    motion = os.path.join(options.dir, options.object + ".toml")
    write_motion(options, motion)
    view = os.path.join(options.dir, "view.toml")
    with open(view, "w", encoding="utf-8") as file:
        file.write(VIEW)
    print("| frame | kept of those at rest | made | CPU s | relMSE | all made anew | CPU s | "
          "relMSE |\n|---|---|---|---|---|---|---|---|")
    for frame in range(1, len(OFFSETS) + 1):
        kept, stats = runs.render(options, runs.scene_file("two-rooms"), options.object, *args,
                                  "--animation", motion, frame=frame)
        scene = write_scene(options, frame)
        own, own_stats = runs.render(options, scene, "own", *args, "--animation", view, frame=1)
        truth = [colours(runs.render(options, scene, f"truth-{seed}", *args, "--integrator", "path",
                                     "--spp", str(PATH_SPP), "--seed", str(seed), "--animation",
                                     view, frame=1)[0]) for seed in (1, 2)]
        lit = colours(own, "emission.").sum(axis=-1) > 0
        at_rest = stats["frame.records_kept"] + stats["frame.records_dropped"]
        print(f"| {frame} | {stats['frame.records_kept']:.0f} of {at_rest:.0f} | "
              f"{stats['frame.records']:.0f} | {fill_seconds(stats):.2f} | "
              f"{error(colours(kept), truth, lit):.2f} | {records_of(own_stats):.0f} | "
              f"{fill_seconds(own_stats):.2f} | {error(colours(own), truth, lit):.2f} |",
              flush=True)


if __name__ == "__main__":
    main()
