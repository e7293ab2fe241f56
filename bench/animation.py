#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What photons and records in common gain for the frames of an animation, and how much the frames
flicker: a walk through two rooms, against the same frames rendered alone.

  bench/animation.py DIR [--size 120x90] [--frames 60] [--references 3]
                     [--extra "--quality draft"]

Times are CPU seconds, which other processes hardly change. Flicker is the mean square of the
difference of neighbouring frames after reprojection, over the mean square of the light. A pixel of
a frame is projected to the frame before it, by its distance from the camera, and compared with the
light there, interpolated between four pixels; it is left out if one of these shows something else,
by position or normal, or a light. What remains of the flicker without any noise is due to this
interpolation. For some frames the error is found against two path-traced references.
"""
import json
import os

import numpy as np
import OpenEXR
import runs

PATH_SPP = 256
SAME_DISTANCE = 0.02  # largest distance of two points that are one surface, over that to the camera
SAME_NORMAL = 0.95    # least cosine between their normals


class Frame:
    """An image, its camera, and the position of what each pixel shows."""

    def __init__(self, path):
        with OpenEXR.File(path, separate_channels=True) as image:
            self.of = {name: c.pixels.astype(np.float64) for name, c in image.channels().items()}
            header = image.header()
            # For row vectors: p_camera = (p, 1) M, with x to the left, y up and z forward.
            self.to_camera = np.array(header["worldToCamera"], np.float64).reshape(4, 4)
            self.to_film = np.array(header["worldToNDC"], np.float64).reshape(4, 4)
        self.height, self.width = self.of["R"].shape
        self.origin, self.axes = self.frame()
        y, x = np.mgrid[0.5:self.height, 0.5:self.width]
        self.p = self.positions(x / self.width, y / self.height, self.of["depth.Z"])
        self.n = np.stack([self.of["normal." + c] for c in "XYZ"], axis=-1)

    def frame(self):
        to_world = np.linalg.inv(self.to_camera)
        return to_world[3, :3], to_world[:3, :3]

    def positions(self, s, t, distance):
        """The points at these distances behind film positions (s, t) in [0, 1]."""
        film = np.linalg.inv(self.to_camera) @ self.to_film
        # film is that of the camera: s = (x film[0,0] + z film[2,0]) / z.
        x, y = (s - film[2, 0]) / film[0, 0], (t - film[2, 1]) / film[1, 1]
        d = np.stack([x, y, np.ones_like(x)], axis=-1)
        d /= np.linalg.norm(d, axis=-1, keepdims=True)
        return self.origin + distance[..., None] * (d @ self.axes)

    def light(self, layer):
        return np.stack([self.of[layer + c] for c in "RGB"], axis=-1)

    def view(self):
        """As a camera path has it."""
        origin, forward, up = self.origin, self.axes[2], self.axes[1]
        fov = 2 * np.degrees(np.arctan(0.5 / abs((np.linalg.inv(self.to_camera)
                                                  @ self.to_film)[0, 0])))
        vectors = (("origin", origin), ("target", origin + forward), ("up", up))
        return "".join(f"{name} = [{', '.join(f'{x:.9g}' for x in v)}]\n"
                       for name, v in vectors) + f"fov = {fov:.9g}\n"


def flicker(before, after, layer):
    """The mean square of the difference, that of the light, and the fraction of pixels compared."""
    p = after.p.reshape(-1, 3)
    film = np.concatenate([p, np.ones((len(p), 1))], axis=1) @ before.to_film
    ahead = film[:, 3] > 1e-6
    x = np.where(ahead, film[:, 0] / film[:, 3], -1) * before.width - 0.5
    y = np.where(ahead, film[:, 1] / film[:, 3], -1) * before.height - 0.5
    good = (x >= 0) & (y >= 0) & (x < before.width - 1) & (y < before.height - 1)
    good &= (after.of["emission.R"].ravel() == 0) & (after.of["depth.Z"].ravel() > 0)
    column, row = np.where(good, x, 0).astype(int), np.where(good, y, 0).astype(int)
    fx, fy = (x - column)[:, None], (y - row)[:, None]
    value = np.zeros_like(p)
    n = after.n.reshape(-1, 3)
    distance = np.linalg.norm(p - before.origin, axis=1)
    light = before.light(layer)
    for i in (0, 1):
        for k in (0, 1):
            at = (row + i, column + k)
            # Distance to the plane of what is there, as grazing surfaces lie far apart in a pixel.
            off = np.abs(np.sum((before.p[at] - p) * n, axis=1))
            good &= off < SAME_DISTANCE * distance
            good &= np.sum(before.n[at] * n, axis=1) > SAME_NORMAL
            good &= before.of["emission.R"][at] == 0
            value += (fx if k else 1 - fx) * (fy if i else 1 - fy) * light[at]
    own = after.light(layer).reshape(-1, 3)[good]
    return np.mean((value[good] - own)**2), np.mean(own**2), good.mean()


def mean_flicker(frames, layer):
    found = np.array([flicker(a, b, layer) for a, b in zip(frames, frames[1:])])
    return found[:, 0].sum() / found[:, 1].sum(), found[:, 2].mean()


def error(frame, references):
    """relMSE, by two references of independent noise, which their product leaves out."""
    one, two = references
    lit = frame.of["emission.R"] + one.of["emission.R"] + two.of["emission.R"] > 0
    found = [(frame.of[c] - one.of[c]) * (frame.of[c] - two.of[c])
             / ((one.of[c] + two.of[c])**2 / 4 + 0.01) for c in "RGB"]
    return float(np.mean([e[~lit].mean() for e in found]))


def load_stats(options, name):
    with open(os.path.join(options.dir, name + ".json"), encoding="utf-8") as file:
        return json.load(file)


def render(options, path, name, size, *args):
    """Renders the frames of a camera path to NAME-####.exr, with their statistics."""
    image, stats = (os.path.join(options.dir, f"{name}-####.{e}") for e in ("exr", "json"))
    runs.run([options.satin, "render", runs.scene_file("two-rooms"), "-o", image, "--stats", stats,
              "--quiet", "--animation", path, *size, *options.extra.split(), *args])


def render_alone(options, number, view, size, *args):
    """Renders one frame: the image and the statistics."""
    path = os.path.join(options.dir, "alone.toml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"first = {number}\n[[frame]]\n{view}")
    render(options, path, "alone", size, *args)
    name = f"alone-{number:04}"
    return Frame(os.path.join(options.dir, name + ".exr")), load_stats(options, name)


def all_records(stats):
    return stats["records.irradiance"] + stats["records.radiance"]


def report_records(common, alone):
    added = [s["frame.records"] for s in common]
    own = [all_records(s) for s in alone]
    print(f"records: {all_records(common[-1]):.0f} for all frames, {sum(own):.0f} alone")
    print("frame    added    alone")
    for i in [i for i in (0, 1, 2, 4, 9, *range(19, len(own), 10)) if i < len(own)]:
        print(f"{i + 1:5} {added[i]:8.0f} {own[i]:8.0f}")
    print(f" mean {np.mean(added):8.1f} {np.mean(own):8.1f}")


def report_times(common, alone):
    cpu = [s["time.cpu_s"] for s in common]
    whole, apart = cpu[-1], [s["time.cpu_s"] for s in alone]
    images = np.diff(cpu)
    print(f"CPU seconds: {whole:.1f} for all frames, {sum(apart):.1f} alone, "
          f"{sum(apart) / whole:.2f} times as many; per frame {whole / len(cpu):.2f} and "
          f"{np.mean(apart):.2f}, of which its image takes {np.mean(images):.2f}")


def main():
    parser = runs.parser(__doc__)
    parser.add_argument("--size", default="120x90")
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--references", type=int, default=3)
    options = parser.parse_args()
    os.makedirs(options.dir, exist_ok=True)
    width, height = options.size.split("x")
    size = ["--width", width, "--height", height, "--float"]
    walk = os.path.join(runs.ROOT, "data", "scenes", "two-rooms.toml")
    render(options, walk, "common", size, "--frames", f"1-{options.frames}")
    common, alone, common_stats, alone_stats = [], [], [], []
    for i in range(1, options.frames + 1):
        common.append(Frame(os.path.join(options.dir, f"common-{i:04}.exr")))
        common_stats.append(load_stats(options, f"common-{i:04}"))
        image, stats = render_alone(options, i, common[-1].view(), size)
        alone.append(image)
        alone_stats.append(stats)
    report_records(common_stats, alone_stats)
    report_times(common_stats, alone_stats)
    for layer in ("indirect_diffuse.", ""):
        (a, compared), (b, _) = mean_flicker(common, layer), mean_flicker(alone, layer)
        print(f"flicker of {layer or 'all light'} {1e4 * a:.3f} with records in common, "
              f"{1e4 * b:.3f} alone (x 10^-4), {100 * compared:.0f} % of the pixels")
    for i in np.linspace(0, options.frames - 1, options.references).astype(int):
        references = [render_alone(options, i + 1, common[i].view(), size, "--integrator", "path",
                                   "--spp", str(PATH_SPP), "--seed", str(seed))[0]
                      for seed in (1, 2)]
        print(f"frame {i + 1}: relMSE {1e4 * error(common[i], references):.2f} with records in "
              f"common, {1e4 * error(alone[i], references):.2f} alone (x 10^-4)", flush=True)


if __name__ == "__main__":
    main()
