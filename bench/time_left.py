#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The time that is left, as the bar on a terminal shows it, beside the time until the render ended.

  bench/time_left.py DIR [SCENE.xml ...] [--quality NAME] [--size 400x400]

For each scene: the seconds of the render and of its forecast; the times of records and image over
those that were forecast; when the first figure was shown and in which stage, the true time over
that figure, and the least and greatest of such ratios as long as one of both was 3 seconds or more.
Images and statistics are left in DIR.
"""
import fcntl
import json
import os
import pty
import re
import struct
import subprocess
import termios
import time

import runs

SCENES = ["cornell-glossy", "cornell-metal", "indirect-room", "vase", "caustic", "two-rooms",
          "caustics/pool", "caustics/glass", "caustics/ring", "figures/hall", "figures/teapot",
          "cases/metal-room", "cases/panes", "cases/storeys"]
BAR = re.compile(r"\r([\w ]+?) +\[[#-]*\] +\d+ %[^\r\x1b]*  ([\d:]+) left")
COUNTS = 3.0  # seconds from which a ratio counts


def seconds(clock):
    total = 0
    for part in clock.split(":"):
        total = 60 * total + int(part)
    return total


def watch(arguments):
    """The seconds of the command, and (second, stage, time left) of all figures on its terminal."""
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 120, 0, 0))
    begin = time.monotonic()
    process = subprocess.Popen(arguments, stderr=slave, env={**os.environ, "TERM": "xterm"})
    os.close(slave)
    shown = []
    while True:
        try:
            text = os.read(master, 65536)
        except OSError:
            break
        now = time.monotonic() - begin
        shown += [(now, stage, seconds(left)) for stage, left in BAR.findall(text.decode())]
    os.close(master)
    if process.wait() != 0:
        raise SystemExit(f"failed: {' '.join(arguments)}")
    return time.monotonic() - begin, shown


def measure_once(options, scene, arguments):
    statistics = os.path.join(options.dir, "time-left.json")
    image = os.path.join(options.dir, "time-left.exr")
    whole, shown = watch([options.satin, "render", scene, "-o", image, "--stats", statistics,
                          *arguments, *options.extra.split()])
    with open(statistics, encoding="utf-8") as file:
        found = json.load(file)
    ratios = [(whole - now) / max(left, 0.5) for now, _, left in shown
              if max(whole - now, left) >= COUNTS]
    print(f"{whole:.1f} s", end="")
    if "time.forecast_s" in found:
        records, image = (found[f"time.{x}_s"] / found[f"forecast.{x}_s"]
                          for x in ("records", "image"))
        print(f", forecast {found['time.forecast_s']:.2f} s, records {records:.2f}, "
              f"image {image:.2f}", end="")
    if ratios:
        print(f"; first at {shown[0][0]:.1f} s in {shown[0][1]}: {ratios[0]:.2f}, "
              f"all: {min(ratios):.2f} to {max(ratios):.2f}", flush=True)
    else:
        print("; too short", flush=True)


def measure(options, scene, arguments):
    for _ in range(options.repeats):
        measure_once(options, scene, arguments)
    print()


if __name__ == "__main__":
    runs.measure_all(__doc__, SCENES, "preview", 1, measure)
