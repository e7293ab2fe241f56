#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The worst means of 5x5 pixels of images of one scene, against path tracing.

  bench/blocks.py DIR SCENE IMAGE [IMAGE ...] [--bound 3] [--worst 10]

A coarse reference covers the whole film. Where an image may deviate by more than --bound percent,
but the noise of the reference does not decide it, tiles of 20x20 pixels are path-traced with more
samples, until the noise of each such mean is below NOISE percent. DIR keeps the references, which
further images use and refine. A scene may not refer to files by relative paths, as copies of it are
rendered from DIR. The deviations are of luminance, relative to the reference at that position.
Printed for each image: the number of positions beyond the bound that are certain (by two standard
deviations), the number that are possible, and the worst positions, with the noise of the reference
and the light of each layer in percent of the reference there.
"""
import os
import re
import sys

import numpy as np
import OpenEXR
import scipy.ndimage

import runs

WEIGHTS = (0.2126, 0.7152, 0.0722)
SIDE, MARGIN = 20, 5  # of a tile; pixels around it that its means need, and a filter's radius
PARTS = 8             # images of a reference, whose differences give its noise
COARSE = 128          # samples per pixel of each part over the whole film
FINEST = 16384        # samples per pixel and part of the finest tile
NOISE = 0.5           # percent


def luminance(path):
    found = OpenEXR.File(str(path)).channels()
    return np.asarray(found["RGB"].pixels, dtype=np.float64)[..., :3] @ WEIGHTS


def means(image):
    """Of 5x5 pixels, around each pixel that has so many."""
    return scipy.ndimage.uniform_filter(image, (0,) * (image.ndim - 2) + (5, 5))


class Reference:
    """The mean of each position and its standard deviation, by PARTS images of the whole film and
    of tiles."""

    def __init__(self, options, size):
        self.options = options
        self.height, self.width = size
        name = os.path.splitext(os.path.basename(options.scene))[0]
        self.folder = os.path.join(options.dir, f"{name}-{self.width}x{self.height}")
        os.makedirs(self.folder, exist_ok=True)
        scene = os.path.join(self.folder, "all.xml")
        self.write_crop(scene, 0, 0, self.width, self.height)
        parts = means(np.array([self.part(scene, f"all-{i}", COARSE, 1000 + i)
                                for i in range(PARTS)]))
        self.mean, self.noise = statistics(parts)
        # One estimate of noise from few parts is uncertain, so neighbours count too.
        self.noise = np.maximum(self.noise, smooth(self.noise))
        self.spp = np.full(size, PARTS * COARSE)
        for file in sorted(os.listdir(self.folder)):
            tile = re.fullmatch(rf"tile-(\d+)-(\d+)-(\d+)-{PARTS - 1}\.exr", file)
            if tile:
                x, y, spp = (int(v) for v in tile.groups())
                if PARTS * spp > self.spp[y, x]:
                    self.refine(x, y, spp)

    def part(self, scene, name, spp, seed):
        image = os.path.join(self.folder, name + ".exr")
        if not os.path.exists(image):
            runs.run([self.options.satin, "render", scene, "-o", image, "--integrator", "path",
                      "--spp", str(spp), "--seed", str(seed), "--quiet"])
        return luminance(image)

    def refine(self, x, y, spp):
        """Path-traces the tile whose first pixel is (x, y)."""
        left, top = max(x - MARGIN, 0), max(y - MARGIN, 0)
        right, bottom = (min(v + SIDE + MARGIN, most) for v, most in ((x, self.width),
                                                                      (y, self.height)))
        scene = os.path.join(self.folder, f"tile-{x:03d}-{y:03d}.xml")
        self.write_crop(scene, left, top, right - left, bottom - top)
        parts = means(np.array([self.part(scene, f"tile-{x:03d}-{y:03d}-{spp}-{i}", spp, 2000 + i)
                                for i in range(PARTS)]))
        mean, noise = statistics(parts)
        noise = np.maximum(noise, smooth(noise))
        inside = np.s_[y - top:y - top + SIDE, x - left:x - left + SIDE]
        for all_of, tile in ((self.mean, mean), (self.noise, noise)):
            all_of[y:y + SIDE, x:x + SIDE] = tile[inside]
        self.spp[y:y + SIDE, x:x + SIDE] = PARTS * spp

    def write_crop(self, path, x, y, width, height):
        with open(self.options.scene, encoding="utf-8") as file:
            text = file.read()
        film = "".join(f'<integer name="{name}" value="{value}"/>' for name, value in (
            ("width", self.width), ("height", self.height), ("crop_offset_x", x),
            ("crop_offset_y", y), ("crop_width", width), ("crop_height", height)))
        text = re.sub(r'\s*<integer name="(width|height)" value="[^"]*"/>', "", text)
        text = re.sub(r'(<film [^>]*[^/]>)', lambda found: found.group(1) + film, text, count=1)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)


def statistics(parts):
    return parts.mean(axis=0), parts.std(axis=0, ddof=1) / np.sqrt(len(parts))


def smooth(noise):
    return np.sqrt(scipy.ndimage.uniform_filter(noise ** 2, 5))


def deviations(image, reference):
    """Of the image, and the noise of the reference, in percent; 0 at the border of the film."""
    over = np.maximum(reference.mean, 1e-6 * reference.mean.max()) / 100
    error, noise = (means(image) - reference.mean) / over, reference.noise / over
    for found in (error, noise):
        inner = found[2:-2, 2:-2].copy()
        found[:] = 0
        found[2:-2, 2:-2] = inner
    return error, noise


def refine_where_uncertain(options, reference, images):
    """Refines tiles, coarse to fine, until their noise decides about the bound."""
    spp = COARSE
    while spp < FINEST:
        spp *= 4
        wanted = np.zeros((reference.height, reference.width), dtype=bool)
        for image in images:
            error, noise = deviations(image, reference)
            wanted |= (np.abs(error) + 2 * noise > options.bound) & (noise > NOISE)
        for y in range(0, reference.height, SIDE):
            for x in range(0, reference.width, SIDE):
                tile = np.s_[y:y + SIDE, x:x + SIDE]
                if wanted[tile].any() and reference.spp[tile].max() < PARTS * spp:
                    reference.refine(x, y, spp)


def layers(path):
    """The light of each layer of an image that has layers, around each pixel."""
    found = OpenEXR.File(str(path)).channels()
    return {name: means(np.asarray(found[name].pixels, dtype=np.float64)[..., :3] @ WEIGHTS)
            for name in ("direct", "indirect_diffuse", "indirect_glossy", "caustic")
            if name in found}


def report(options, path, image, reference):
    error, noise = deviations(image, reference)
    size = np.abs(error)
    print(f"{path}: {np.sum(size - 2 * noise > options.bound)} positions of 5x5 pixels certainly "
          f"over {options.bound:g} %, {np.sum(size + 2 * noise > options.bound)} possibly; "
          f"root mean square {np.sqrt(np.mean(error ** 2)):.2f} %")
    light = layers(path)
    left = size.copy()
    for _ in range(options.worst):
        y, x = np.unravel_index(np.argmax(left), left.shape)
        parts = ", ".join(f"{name} {100 * value[y, x] / reference.mean[y, x]:.1f}"
                          for name, value in light.items())
        print(f"  x {x:3d} y {y:3d}: {error[y, x]:+6.2f} +- {noise[y, x]:.2f} %, "
              f"{reference.spp[y, x]} samples per pixel; {parts}")
        left[max(y - 4, 0):y + 5, max(x - 4, 0):x + 5] = 0


def main():
    p = runs.parser(__doc__)
    p.add_argument("scene")
    p.add_argument("images", nargs="+", metavar="image")
    p.add_argument("--bound", type=float, default=3, help="percent")
    p.add_argument("--worst", type=int, default=10, help="number of positions to print")
    options = p.parse_args()
    images = [luminance(path) for path in options.images]
    if len({image.shape for image in images}) > 1:
        sys.exit("the images differ in size")
    reference = Reference(options, images[0].shape)
    refine_where_uncertain(options, reference, images)
    for path, image in zip(options.images, images):
        report(options, path, image, reference)


if __name__ == "__main__":
    main()
