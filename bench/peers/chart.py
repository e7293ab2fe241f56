#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws what peers.py found.

  bench/peers/chart.py chart TABLE OUT.png            error against time, a plot per scene
  bench/peers/chart.py images DIR OUT.png LIMIT SCENE ...
                                                      images of one limit, a row per scene

TABLE is what peers.py has printed, in one file or more; DIR is its folder. Needs `pip install
matplotlib pillow numpy OpenEXR`.
"""
import pathlib
import sys

import matplotlib
import numpy as np
import PIL.Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import unbiased  # pylint: disable=wrong-import-position

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # pylint: disable=wrong-import-position

COLORS = {"satin": "#0072b2", "mitsuba": "#d55e00", "cycles": "#009e73"}
COLUMNS = 4
PALETTE = 128
EXPOSURE = 0.18 * 1.7  # over the geometric mean


def rows(path):
    """Scene, limit, renderer and the errors of each row of the tables in a file."""
    for line in pathlib.Path(path).read_text(encoding="utf-8").splitlines():
        cells = [c.strip() for c in line.strip("|").split("|")]
        if len(cells) == 8 and cells[2] in COLORS:
            errors = [float(c.split()[0]) if c != "-" else None for c in cells[3:5]]
            yield cells[0], float(cells[1]), cells[2], errors


def save(figure, out, dpi):
    """In few colors, so that the file is small."""
    figure.savefig(out, dpi=dpi)
    PIL.Image.open(out).convert("RGB").quantize(PALETTE, dither=0).save(out, optimize=True)


def curves_of(table):
    """Limits and errors by scene, then by renderer and whether it denoises."""
    found = {}
    for scene, limit, renderer, errors in rows(table):
        for denoised, error in enumerate(errors):
            if error is not None:
                curves = found.setdefault(scene, {})
                curves.setdefault((renderer, denoised), []).append((limit, error))
    return found


def chart(table, out):
    found = curves_of(table)
    lines = -(-len(found) // COLUMNS)
    figure, axes = plt.subplots(lines, COLUMNS, figsize=(10, 2.4 * lines), squeeze=False)
    for axis in axes.flat[len(found):]:
        axis.axis("off")
    for axis, (scene, curves) in zip(axes.flat, found.items()):
        for (renderer, denoised), points in curves.items():
            axis.loglog(*zip(*points), "--" if denoised else "-", color=COLORS[renderer],
                        marker=".", label=renderer + (", denoised" if denoised else ""))
        axis.set_title(scene, fontsize=9)
        limits = sorted({limit for points in curves.values() for limit, _ in points})
        axis.set_xticks(limits, [f"{limit:g}" for limit in limits])
        axis.set_xticks([], minor=True)
        axis.tick_params(labelsize=7)
        axis.grid(alpha=0.3)
    handles = {h.get_label(): h for a in axes.flat for h in a.get_lines()}
    figure.legend(handles.values(), handles.keys(), loc="lower right", fontsize=8)
    figure.supxlabel("limit, seconds", fontsize=8)
    figure.supylabel("relMSE x 10\u2074", fontsize=8)
    figure.tight_layout()
    save(figure, out, 80)


def images(folder, out, limit, *scenes):
    figure, axes = plt.subplots(len(scenes), 4, figsize=(4 * 1.6, 1.65 * len(scenes)),
                                squeeze=False)
    for line, scene in zip(axes, scenes):
        at = pathlib.Path(folder) / scene
        shown = {"satin": unbiased.layer(at / f"satin-{limit}.exr", "RGB"),
                 "satin --denoise": unbiased.layer(at / f"satin-denoise-{limit}.exr", "RGB")}
        with np.load(at / f"mitsuba-{limit}.npz") as found:
            shown["Mitsuba 3"], shown["Mitsuba 3, denoised"] = found["color"], found["denoised"]
        scale = EXPOSURE / np.exp(np.log(shown["Mitsuba 3, denoised"].mean(-1) + 1e-3).mean())
        for axis, (name, image) in zip(line, shown.items()):
            axis.imshow(np.clip(scale * image, 0, 1) ** (1 / 2.2), interpolation="nearest")
            axis.set_title(name if scene == scenes[0] else "", fontsize=8)
            axis.axis("off")
    figure.subplots_adjust(0, 0, 1, 0.95, 0.02, 0.02)
    save(figure, out, 75)


if __name__ == "__main__":
    if len(sys.argv) < 4 or sys.argv[1] not in ("chart", "images"):
        sys.exit(__doc__)
    {"chart": chart, "images": images}[sys.argv[1]](*sys.argv[2:])
