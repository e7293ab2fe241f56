#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The same scenes by satin and by other renderers, side by side in one run: error against time.

  bench/peers/peers.py DIR [--scenes SCENE ...] [--rooms ROOMS] [--peers mitsuba cycles]
      [--limits 3 10 60] [--pixels N] [--cpu] [--no-setup] [--reference-seconds S]

Scenes are files, or names of those in data/scenes. ROOMS is a folder of folders, each with a
scene.xml by others; without it there are no rooms. Peers that are not installed are left out,
saying so. Renderers alternate, and what is in DIR is not rendered again.

Limits are seconds on two cores for 400x300 pixels. An image of fewer pixels (--pixels) has that
much less time. With --cpu renderers have one thread and twice the limit, in its processor seconds.
With --no-setup every renderer has the seconds that it needs for loading and compiling in addition,
as these do not shrink with the image.

The error is relMSE, as `satin compare` has it, by two long renders of the peer itself
(bench/unbiased.py): satin's is by those of Mitsuba 3. Pixels that see emitters are left out. A row
has the error x 10^4 and its standard error, without and with denoising; the mean relative to the
reference's; samples per pixel, and the time that was taken, as a fraction of the limit; and satin's
errors over those of the renderer, without and with denoising.
"""
import argparse
import importlib.util
import json
import math
import os
import pathlib
import re
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import runs  # pylint: disable=wrong-import-position
import unbiased  # pylint: disable=wrong-import-position
import worker  # pylint: disable=wrong-import-position

FULL_PIXELS, FULL_CORES = 400 * 300, 2  # of the limits
MODULES = {"mitsuba": "mitsuba", "cycles": "bpy"}
SCENES = ["indirect-room", "cornell-glossy", "cornell-metal", "caustic"]
ATTEMPTS = 4  # to meet a time limit
MEAN_TOLERANCE = 0.03  # between the images of two renderers, if they are to be of one scene
HERE = pathlib.Path(__file__).resolve().parent


def parse():
    p = runs.parser(__doc__)
    p.add_argument("--scenes", nargs="*", default=SCENES)
    p.add_argument("--rooms", help="folder of rooms")
    p.add_argument("--peers", nargs="*", default=list(MODULES), choices=list(MODULES))
    p.add_argument("--limits", type=float, nargs="+", default=[3, 10, 60])
    p.add_argument("--pixels", type=int, default=FULL_PIXELS)
    p.add_argument("--no-setup", dest="setup", action="store_false",
                   help="loading and compiling do not count")
    p.add_argument("--reference-seconds", type=float, default=60, help="of each of the two")
    p.add_argument("--python", default=sys.executable, help="the interpreter of the workers")
    return p.parse_args()


def installed(options):
    """The peers that can be imported."""
    for peer in options.peers:
        code = f"import importlib.util as u, sys; sys.exit(not u.find_spec({MODULES[peer]!r}))"
        if os.spawnl(os.P_WAIT, options.python, options.python, "-c", code) == 0:
            yield peer
        else:
            print(f"{peer}: left out, there is no Python module {MODULES[peer]}", file=sys.stderr)


def scene_files(options):
    """Names and files of the scenes and rooms."""
    for name in options.scenes:
        path = pathlib.Path(name if name.endswith(".xml") else runs.scene_file(name))
        yield path.stem, path
    if not options.rooms:
        print("rooms: left out, as --rooms names no folder", file=sys.stderr)
        return
    for path in sorted(pathlib.Path(options.rooms).glob("*/scene.xml")):
        yield path.parent.name, path


def prepare(options, name, path):
    """A copy of the scene with the number of pixels and a box filter, which leaves the noise of
    pixels independent, as denoisers want it; beside it links to what it reads."""
    folder = pathlib.Path(options.dir).resolve() / name
    folder.mkdir(parents=True, exist_ok=True)
    for entry in path.resolve().parent.iterdir():
        if not (folder / entry.name).exists() and entry.is_dir():
            (folder / entry.name).symlink_to(entry)
    text = path.read_text(encoding="utf-8")
    sizes = [re.compile(rf'(<default name="{names}" value=")(\d+)') for names in
             ("(?:resx|width)", "(?:resy|height)")]
    width, height = (int(size.search(text).group(2)) for size in sizes)
    scale = math.sqrt(options.pixels / (width * height))
    for size, pixels in zip(sizes, (width, height)):
        text = size.sub(rf"\g<1>{round(scale * pixels)}", text)
    text = re.sub(r'<rfilter type="[^"]*"', '<rfilter type="box"', text)
    scene = folder / "scene.xml"
    scene.write_text(text, encoding="utf-8")
    return folder, scene


class Images:
    """What the renderers make of one scene, in its folder."""

    def __init__(self, options, folder, scene):
        self.options, self.folder, self.scene = options, folder, scene
        self.out = argparse.Namespace(**{**vars(options), "dir": str(folder)})

    def satin(self, name, *args):
        """The image's path, and its statistics."""
        image = self.folder / (name + ".exr")
        if not image.exists():
            runs.render(self.out, str(self.scene), name, *args)
        # Of names that recur, the first: "parts.other" is before the stages and after them.
        return image, json.loads(image.with_suffix(".json").read_text(encoding="utf-8"),
                                 object_pairs_hook=lambda pairs: dict(reversed(pairs)))

    def setup(self, stats):
        """Seconds of a render that do not count: of loading the scene, and of what is before the
        first stage, which is loading the denoiser's library."""
        return 0.0 if self.options.setup else stats["time.load_s"] + stats["parts.other.wall_s"]

    def emitters(self):
        """Which pixels see emitters, and the render's statistics."""
        image, stats = self.satin("emitters", "--integrator", "direct", "--spp", "64")
        return unbiased.channels(image)[1], stats

    def timed(self, name, seconds, *args):
        """By satin, as a worker has it. Loading takes more or less time in every run: if it left
        more or less than the limit for rendering, the image is rendered again."""
        setup = self.setup(self.emitters()[1])
        attempts = 1 if (self.folder / (name + ".exr")).exists() else ATTEMPTS
        for attempt in range(attempts):
            given = seconds + setup
            image, stats = self.satin(name, "--time", f"{given:.3f}", "--seed", "1", *args)
            setup = self.setup(stats)
            if abs((given - setup) / seconds - 1) < worker.TOLERANCE or attempt == attempts - 1:
                break
            image.unlink()
        used = (stats["time.whole_s"] - setup) / seconds
        return unbiased.channels(image)[0], f"{stats['image.spp']:.3g} in {used:.2f}"

    def worker(self, program, *args):
        """Runs one of the scripts of this folder, and returns whether it failed."""
        # Dr.Jit keeps its kernels in the home folder: this one has none of earlier runs.
        env = {**os.environ, "HOME": str(self.folder)}
        with open(self.folder / "log", "a", encoding="utf-8") as log:
            return subprocess.run(
                [self.options.python, HERE / (program + ".py"), self.scene, *args],
                env=env, check=False, stdout=log, stderr=log).returncode

    def peer(self, peer, name, seconds, seed):
        """The images by one of the peers, without and with denoising; None if it cannot."""
        out = self.folder / f"{peer}-{name}"
        about = self.folder / f"{peer}-{name}.json"
        if not about.exists():
            if peer != "mitsuba" and not (self.folder / "scene.npz").exists():
                self.worker("export_scene", self.folder / "scene.npz")
            flags = ["--cpu"] * self.options.cpu + ["--setup"] * self.options.setup
            failed = self.worker(f"{peer}_worker", out, "--seconds", str(seconds), "--seed",
                                 str(seed), *flags)
            if failed:
                return None, {"reason": f"its worker failed: {self.folder / 'log'}"}
        stats = json.loads(about.read_text(encoding="utf-8"))
        if "reason" in stats:
            return None, stats
        with np.load(str(out) + ".npz") as found:
            return {k: found[k].astype(np.float64) for k in found.files}, stats


def error(image, reference, lit):
    """relMSE x 10^4 with its standard error, and the mean relative to the reference's."""
    b, c = reference
    mean = 0.5 * (b + c)
    by_pixel = unbiased.relative(image, b, c, mean ** 2 + 0.01)[lit]
    return (1e4 * by_pixel.mean(), 1e4 * by_pixel.std() / math.sqrt(lit.sum()),
            image[lit].mean() / mean[lit].mean() - 1)


def row(where, renderer, errors, note, ratios="-"):
    """Prints a row; `where` is scene and limit."""
    cells = [f"{e:.2f} ± {s:.2f}" for e, s, _ in errors] + ["-"] * (2 - len(errors))
    print("|", " | ".join([where[0], f"{where[1]:g}", renderer, *cells,
                           f"{100 * errors[0][2]:+.1f} %", note, ratios]), "|", flush=True)


def find_references(options, peers, name, images, lit):
    """Of each peer two long renders; those whose mean is not Mitsuba's are left out."""
    references, mean = {}, None
    for peer in peers:
        found = []
        for i in range(2):
            found.append(images.peer(peer, f"reference-{i}", options.reference_seconds, 100 + i))
            if not found[-1][0]:
                print(f"{name}: {peer} is left out, {found[-1][1]['reason']}", file=sys.stderr)
                break
        else:
            pair = [image["color"] for image, _ in found]
            own = np.mean([image[lit] for image in pair])
            mean = mean or own  # of Mitsuba, which is first
            print(f"{name}: {peer}, {100 * (own / mean - 1):+.2f} % of light, setup "
                  f"{found[0][1]['setup']:.2f} s", file=sys.stderr)
            if abs(own / mean - 1) < MEAN_TOLERANCE:
                references[peer] = pair
            else:
                print(f"{name}: {peer} is left out, its light differs", file=sys.stderr)
    return references


def measure(options, peers, name, images):
    lit = ~images.emitters()[0]
    references = find_references(options, peers, name, images, lit)
    if "mitsuba" not in references:
        return
    for limit in options.limits:
        seconds = limit * options.pixels / FULL_PIXELS * (FULL_CORES if options.cpu else 1)
        found = [images.timed(f"satin-{limit:g}", seconds),
                 images.timed(f"satin-denoise-{limit:g}", seconds, "--denoise")]
        own = [error(image, references["mitsuba"], lit) for image, _ in found]
        row((name, limit), "satin", own, ", ".join(note for _, note in found))
        for peer, reference in references.items():
            found, stats = images.peer(peer, f"{limit:g}", seconds, 1)
            errors = [error(found[k], reference, lit) for k in ("color", "denoised") if k in found]
            row((name, limit), peer, errors, f"{stats['spp']} in {stats['seconds'] / seconds:.2f}",
                ", ".join(f"{a[0] / b[0]:.3g}" for a, b in zip(own, errors)))


def main():
    options = parse()
    found = importlib.util.find_spec("pyoidn")
    if found and "SATIN_OIDN" not in os.environ:  # the same library for all
        os.environ["SATIN_OIDN"] = str(next(pathlib.Path(found.origin).parent.glob(
            "oidn/lib/libOpenImageDenoise.so.2")))
    peers = list(installed(options))
    if "mitsuba" not in peers:
        sys.exit("skipped: the references of satin's images need Mitsuba 3")
    print("| scene | limit | renderer | error | denoised | mean | samples, time | satin over it |\n"
          "|---|---|---|---|---|---|---|---|")
    for name, path in scene_files(options):
        measure(options, peers, name, Images(options, *prepare(options, name, path)))


if __name__ == "__main__":
    main()
