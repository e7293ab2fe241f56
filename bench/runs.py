# SPDX-License-Identifier: Apache-2.0
"""What the scripts of this folder have in common: renders, their statistics, their errors.

References are those that `bench/quality.py references DIR SCENE.xml ...` makes.
"""
import argparse
import json
import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

# Makes processor seconds of the seconds that a program measures (cpu_clock.c).
CPU_CLOCK = os.path.join(ROOT, "build", "bench", "cpu_clock.so")


def parser(description, what=()):
    """Arguments that every script takes, after one word of `what` if there are any."""
    p = argparse.ArgumentParser(description=description,
                                formatter_class=argparse.RawDescriptionHelpFormatter)
    if what:
        p.add_argument("what", choices=what)
    p.add_argument("dir", help="folder of references; images are left there")
    p.add_argument("--satin", default=os.path.join(ROOT, "build", "satin"))
    p.add_argument("--extra", default="", help="more arguments for satin render")
    p.add_argument("--cpu", action="store_true",
                   help="one thread, and limits in its processor seconds: for busy machines")
    return p


def measure_all(doc, scenes, quality, repeats, measure, **others):
    """Calls measure(options, scene, arguments of the render) for each scene and quality, or that of
    the others whose name is given as a flag."""
    p = parser(doc)
    for flag, other in others.items():
        p.add_argument("--" + flag, dest="measure", action="store_const", const=other,
                       help="see above")
    p.add_argument("scene", nargs="*", default=scenes)
    p.add_argument("--quality", default=quality)
    p.add_argument("--size", default="400x400", help="WIDTHxHEIGHT")
    p.add_argument("--repeats", type=int, default=repeats)
    p.set_defaults(measure=measure)
    options = p.parse_args()
    os.makedirs(options.dir, exist_ok=True)
    width, height = options.size.split("x")
    for name in options.scene:
        scene = name if name.endswith(".xml") else scene_file(name)
        for each in options.quality.split(","):
            print(f"{name}, {each}, {options.size}\n", flush=True)
            options.measure(options, scene, ["--quality", each, "--width", width,
                                             "--height", height])


def run(args, env=None):
    done = subprocess.run(args, stdout=subprocess.PIPE, text=True, check=False, env=env)
    if done.returncode:
        sys.exit("failed: " + " ".join(map(str, args)))
    return done.stdout


def scene_file(*parts):
    return os.path.join(ROOT, "data", "scenes", *parts) + ".xml"


def render(options, scene, out, *args, satin=None, frame=None):
    """Renders to DIR/out.exr, or to DIR/out-N.exr frame number N of an animation: its path, and the
    statistics as a dictionary."""
    os.makedirs(options.dir, exist_ok=True)
    name = os.path.join(options.dir, out) + ("-#" if frame else "")
    image, stats = (name + suffix for suffix in (".exr", ".json"))
    frames = ["--frames", str(frame)] if frame else []
    threads, env = (["--threads", "1"], {**os.environ, "LD_PRELOAD": CPU_CLOCK}) \
        if options.cpu else ([], None)
    run([satin or options.satin, "render", scene, "-o", image, "--stats", stats, "--quiet",
         *frames, *args, *threads, *options.extra.split()], env)
    image, stats = (path.replace("#", str(frame)) for path in (image, stats))
    with open(stats, encoding="utf-8") as file:
        return image, json.load(file)


def error(options, image, reference):
    """relMSE, and the mean relative to the reference's; pixels of emitters are left out."""
    found = json.loads(run([options.satin, "compare", image,
                            os.path.join(options.dir, reference + ".exr"), "--mask-emission",
                            "--json"]))
    return found["relmse"], found["mean_ratio"] - 1
