#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What --denoise does to the error of an image.

  bench/denoise.py DIR [SCENE ...]

DIR has the references of bench/quality.py, rendered with --extra '--width W --height H'; the images
are made as large. Every render gives both figures, as it keeps its noisy image. relMSE as
docs/experiments.md has it, emitters masked. Needs `pip install OpenEXR numpy`.
"""
import os

import numpy as np
import OpenEXR
import runs

RUNS = [["--quality", "draft"], ["--quality", "draft", "--set", "radiance-cache=off"],
        ["--quality", "preview"], ["--quality", "production"],
        ["--integrator", "path", "--spp", "64"]]


def read(path):
    with OpenEXR.File(path, separate_channels=True) as image:
        return {name: c.pixels.astype(np.float64) for name, c in image.channels().items()}


def relmse(image, reference, layer=""):
    lit = sum(image["emission." + c] + reference.get("emission." + c, 0.0) for c in "RGB") > 0
    error = [((image[layer + c] - reference[c])**2 - reference["variance." + c])
             / (reference[c]**2 + 0.01) for c in "RGB"]
    return float(np.mean([e[~lit].mean() for e in error]))


def main():
    parser = runs.parser(__doc__)
    parser.add_argument("scene", nargs="*", default=["indirect-room", "cornell-glossy", "caustic"])
    parser.add_argument("--seeds", type=int, default=2)
    options = parser.parse_args()
    print(f"{'scene':16} {'run':36} {'noisy':>10} {'denoised':>10}   x 10^4")
    for scene in options.scene:
        reference = read(os.path.join(options.dir, scene + ".exr"))
        height, width = reference["R"].shape
        for run in RUNS:
            pair = []
            for seed in range(options.seeds):
                path, _ = runs.render(options, runs.scene_file(scene), "denoise-image",
                                      "--denoise", "--width", str(width), "--height",
                                      str(height), "--seed", str(seed), *run)
                image = read(path)
                pair.append((relmse(image, reference, "noisy."), relmse(image, reference)))
            noisy, denoised = 1e4 * np.mean(pair, axis=0)
            print(f"{scene:16} {' '.join(run):36} {noisy:10.2f} {denoised:10.2f}", flush=True)


if __name__ == "__main__":
    main()
