#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders a scene with Mitsuba 3's path tracer for a limited time (worker.py has the arguments).

Batches of a few samples per pixel follow each other for the time that is nearest to
the limit. The BRDFs that
Mitsuba lacks are those of tests/image/mitsuba_plugins.py. Needs `pip install mitsuba`, LLVM 19 or
later, and for denoised images `pip install pyoidn`.
"""
import pathlib
import sys

import drjit as dr
import mitsuba as mi
import numpy as np

import worker

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests" / "image"))
mi.set_variant("llvm_ad_rgb")
import mitsuba_plugins  # pylint: disable=wrong-import-position

LAYERS = {"color": slice(0, 3), "albedo": slice(3, 6), "normal": slice(6, 9)}


def load(path):
    # With one thread, which is the main one, loading of meshes waits forever.
    dr.set_thread_count(2)
    scene = mi.load_file(path)
    integrator = mi.load_dict({"type": "aov", "aovs": "albedo:albedo,normal:sh_normal",
                               "image": scene.integrator() or {"type": "path"}})
    return scene, integrator


def main():
    options = worker.arguments(__doc__)
    mitsuba_plugins.register()
    start = options.now()
    scene, integrator = load(options.scene)
    if options.cpu:
        dr.set_thread_count(1)

    def batch(number):
        seed = 1_000_000 * options.seed + number
        return np.array(mi.render(scene, integrator=integrator, spp=worker.BATCH, seed=seed))

    total = batch(0)
    compiled = options.now()
    total += batch(1)
    setup = 2 * compiled - options.now() - start  # the second batch compiles nothing
    reserve = worker.denoise_seconds(options, {k: total[..., at] / 2 for k, at in LAYERS.items()})
    if options.setup:
        begin, count = start, 2
    else:
        total, begin, count = 0, options.now(), 0
    used, half = 0.0, 0.0
    while count == 0 or used + reserve + half <= options.seconds:
        total = total + batch(2 + count)
        count += 1
        used = options.now() - begin
        half = 0.5 * used / count
    image = {k: np.ascontiguousarray(total[..., at] / count) for k, at in LAYERS.items()}
    worker.save(options, image, setup, used + reserve, worker.BATCH * count)


if __name__ == "__main__":
    main()
