# SPDX-License-Identifier: Apache-2.0
"""What is run while allocations fail, and what of its outputs must not change."""
import collections
import json
import pathlib
import shutil
import struct
import subprocess

HERE = pathlib.Path(__file__).parent
SEEDS = HERE.parent / "fuzz" / "seeds"
TIME_LIMIT = 300  # s; the slowest scenario takes .5 on an idle machine

# `before` are commands that make inputs; of every `stride` sites the short run tries one.
Scenario = collections.namedtuple("Scenario", "arguments before stride")

RENDER = ["render", "room.xml", "-o", "out.exr", "--threads", "1", "-q"]
# The fast ones come first, because a site is tried in the first scenario that has it.
SCENARIOS = {
    "path": Scenario(["render", "shelf.xml", "-o", "out.exr", "--threads", "1", "-q",
                      "--integrator", "path", "-D", "spp=2"], [], 1),
    "denoise": Scenario(["render", "shelf.xml", "-o", "out.exr", "--threads", "1", "-q",
                         "--integrator", "path", "-D", "spp=2", "--denoise"], [], 1),
    "coats": Scenario(["render", "shelf.xml", "-o", "out.exr", "--threads", "1", "-q",
                       "--integrator", "path", "-D", "spp=2", "-D", "coats=coats.xml"], [], 1),
    "maps": Scenario(["maps", "in.exr", "-o", "."], [[*RENDER, "--set", "record-maps=on"]], 1),
    "study": Scenario(["study", "study.toml", "--list"], [], 1),
    "animation": Scenario(["render", "shelf.xml", "-o", "out.#.exr", "--threads", "1", "-q",
                           "--integrator", "path", "-D", "spp=2", "--animation", "walk.toml",
                           "--resume"], [], 1),
    "room": Scenario([*RENDER, "--png", "--stats", "out.json", "--save-cache", "out.cache"], [], 4),
    "reload": Scenario([*RENDER, "--load-cache", "in.cache", "--save-cache", "out.cache"],
                       [[*RENDER, "--save-cache", "in.cache"]], 4),
    "recursive": Scenario([*RENDER, "-D", "pass=recursive", "--set", "recursive-bounces=2"], [], 8),
    "images": Scenario([*RENDER, "-D", "floor=paper.xml", "--set", "guide-visibility=off"], [], 8),
}

FILES = {"small.png": "bitmap", "small.hdr": "bitmap", "text.ply": "ply", "smooth.obj": "obj",
         "four.serialized": "serialized", "linear.txt": "linear", "strands.hair": "hair",
         "isotropic": "tabulated"}
RENAMED = {"colours.ply": "attribute/bytes.ply", "list.spd": "spd/list"}


def prepare(scenario, satin, folder):
    """Fills a new folder with the inputs of all scenarios and what commands make."""
    shutil.copytree(HERE / "scenes", folder)
    (folder / "more").mkdir()
    (folder / "sensor.xml").rename(folder / "more" / "sensor.xml")
    for name, kind in FILES.items():
        shutil.copy(SEEDS / kind / name, folder)
    for name, source in RENAMED.items():
        shutil.copy(SEEDS / source, folder / name)
    for command in scenario.before:
        subprocess.run([satin, *command], cwd=folder, check=True)
    if (folder / "out.exr").exists():
        (folder / "out.exr").rename(folder / "in.exr")


def read_exr(data):
    """Attributes but the statistics, and everything after the table of offsets."""
    at, attributes = 8, {}
    while data[at]:
        name, _, rest = data[at:at + 600].partition(b"\0")
        kind = rest.partition(b"\0")[0]
        at += len(name) + len(kind) + 2
        size, = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    attributes.pop(b"satin:stats", None)
    first, = struct.unpack_from("<Q", data, at + 1)
    return attributes, data[first:]


def read_statistics(data):
    """Counts but not times."""
    return {name: value for name, value in json.loads(data).items()
            if not name.endswith(("_s", "per_second"))
            and not name.startswith(("time.", "memory."))}


def normalised(path, data=None):
    """The content of an output without what differs from run to run."""
    path = pathlib.Path(path)
    if data is None:
        data = path.read_bytes()
    try:
        if path.suffix == ".exr":
            return read_exr(data)
        if path.suffix == ".json":
            return read_statistics(data)
    except (ValueError, IndexError, struct.error):
        pass  # a broken file that is like no other
    return data
