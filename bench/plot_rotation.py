#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws what fig_5_5 and fig_5_7 print. Needs matplotlib.

usage: plot_rotation.py TABLE.tsv PICTURE.png        (the table's columns show which figure it is)
"""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

COLOURS = {"1": "tab:red", "1.5": "tab:orange", "2": "tab:blue"}
ROWS = [("maximum", "largest error, unit vectors"), ("mean", "mean singular value"),
        ("lobe", r"error, $\cos^7\theta$")]


def read(path):
    with open(path, encoding="utf-8") as f:
        return list(csv.DictReader((line for line in f if not line.startswith("#")),
                                   delimiter="\t"))


def draw_errors(rows):
    figure, axes = plt.subplots(3, 2, figsize=(8, 8), sharex=True)
    for column, n in enumerate(("5", "8")):
        for axis, (name, title) in zip(axes[:, column], ROWS):
            for order, colour in COLOURS.items():
                chosen = [r for r in rows if r["n"] == n and r["order"] == order]
                axis.plot([float(r["degrees"]) for r in chosen], [float(r[name]) for r in chosen],
                          color=colour, label="order " + order)
            axis.set_ylabel(title)
            axis.grid(alpha=0.3)
            axis.set_xlim(0, 40)
            axis.set_ylim(bottom=0)
        axes[0, column].set_title("n = " + n)
        axes[2, column].set_xlabel("angle [degrees]")
    axes[0, 0].legend()
    return figure


def draw_times(rows):
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.5), sharey=True)
    for axis, channels in zip(axes, ("1", "3")):
        for form in dict.fromkeys(r["form"] for r in rows if not r["form"].endswith("-fma")):
            chosen = [r for r in rows if r["form"] == form and r["channels"] == channels]
            style = "--" if "scalar" in form or form in ("zxzxz", "zxzxz-whole", "ivanic") else "-"
            axis.plot([int(r["n"]) for r in chosen], [float(r["ns"]) for r in chosen], style,
                      marker=".", label=form)
        axis.set_yscale("log")
        axis.set_xlabel("order n")
        axis.set_title("one channel" if channels == "1" else "three channels")
        axis.grid(alpha=0.3, which="both")
    axes[0].set_ylabel("ns per record, one core")
    axes[1].legend(fontsize=8, loc="upper left", bbox_to_anchor=(1, 1))
    return figure


def main():
    rows = read(sys.argv[1])
    figure = draw_errors(rows) if "degrees" in rows[0] else draw_times(rows)
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=80)


main()
