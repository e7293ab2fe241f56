# SPDX-License-Identifier: Apache-2.0
"""What the workers of this folder have in common: their arguments, clock, denoiser and results.

A worker is a process that renders one scene with one renderer for so many seconds:

  NAME_worker.py SCENE OUT --seconds S [--setup] [--cpu] [--seed N]

It leaves OUT.npz, with the image as `color` and, if Open Image Denoise is installed, `denoised`,
and OUT.json: `setup`, the seconds of loading, compiling and building; `seconds`, all that counts;
`spp`, the samples per pixel. With --setup the former are part of the limit. Imports never are.
"""
import argparse
import json
import time

import numpy as np

try:
    import pyoidn
except ImportError:
    pyoidn = None

BATCH = 2  # samples per pixel, so that a batch is short beside the shortest limit
PILOT, PILOT_FRACTION = 8, 0.25  # samples of the first pilot, and time of the second one
TOLERANCE = 0.1  # of the time of a renderer that is given a number of samples


def arguments(doc):
    p = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawTextHelpFormatter)
    p.add_argument("scene")
    p.add_argument("out")
    p.add_argument("--seconds", type=float, required=True)
    p.add_argument("--setup", action="store_true", help="loading and compiling count")
    p.add_argument("--cpu", action="store_true", help="one thread, and its processor seconds")
    p.add_argument("--seed", type=int, default=0)
    options = p.parse_args()
    options.now = time.process_time if options.cpu else time.perf_counter
    return options


def denoise(image):
    """The color by Open Image Denoise with albedo and normal; the color itself without it."""
    if not pyoidn:
        return image["color"]
    albedo, normal = np.clip(image["albedo"], 0, 1), np.clip(image["normal"], -1, 1)
    return pyoidn.denoise(image["color"], albedo, normal, hdr=True)


def denoise_seconds(options, image):
    """With what only the first time takes, which loads the library's weights: for satin it counts
    too."""
    start = options.now()
    denoise(image)
    return options.now() - start


def save(options, image, setup, seconds, spp):
    denoised = {"denoised": denoise(image)} if pyoidn else {}
    np.savez(options.out + ".npz", color=image["color"], **denoised)
    with open(options.out + ".json", "w", encoding="utf-8") as file:
        json.dump({"setup": setup, "seconds": seconds, "spp": spp}, file)


def calibrate(options, render):
    """For renderers that are given a number of samples: `render(spp, seed)` returns an image. Short
    renders show what setup and a sample take, and the last one has as many as fit."""
    def timed(spp):
        start = options.now()
        image = render(spp, options.seed)
        return image, options.now() - start

    timed(1)  # what only the first render of a process does
    image, setup = timed(1)
    reserve = denoise_seconds(options, image)
    free = 0.0 if options.setup else setup
    left = options.seconds - reserve
    spp = PILOT
    for fraction in (PILOT_FRACTION, 1.0, 1.0, None):
        image, seconds = timed(spp)
        if fraction is None or abs((seconds - free) / left - 1) < TOLERANCE:
            break
        sample = max(seconds - setup, 1e-6) / (spp - 1)
        spp = max(2, round((fraction * left + free - setup) / sample))
    save(options, image, setup, seconds - free + reserve, spp)
