# SPDX-License-Identifier: Apache-2.0
"""The timing tables of the thesis' chapter 3: what radiance caching costs beside sampling each
glossy reflection by the BRDF, in still images and in the frames of a camera path.

Times are CPU seconds of all threads, which other processes hardly change. Each view is rendered
three times with one sample per pixel: with radiance records, with glossy rays instead, and with
direct light alone. The radiance records then take

    filling        records of the first render - records of the second, which are irradiance alone
    interpolation  image of the first render - image of the third

where the last includes the interpolation of irradiance, and that of glossy rays is the image of the
second render less that of the third, so that the same is in both.
"""
import dataclasses
import json
import os
import tomllib

import runs

# As in chapter 3: harmonics of order 10, a = .15 without a later second accuracy, no adaptation, no
# clamping by gradients, and records at least .3 pixel wide (R- = 2 pixels, times a).
THESIS = ["adaptive-sampling=off", "light-samples=8", "radiance-order=10", "radiance-a=.15",
          "irradiance-a=.15", "radiance-widen=1", "irradiance-widen=1", "adaptive-cache=off",
          "radiance-gradient-clamp=off", "radiance-min-pixels=.3", "radiance-max-pixels=100000",
          "guide-clusters=off"]
# The parts of a render (`parts.NAME.serial_s` and `parallel_s` in its statistics) that are these.
RECORDS = ("records", "sites", "choose", "gather", "insert", "adapt")
IMAGE = ("image", "plan", "rims")


def sets(*options):
    """Arguments of satin render."""
    return [part for option in options for part in ("--set", option)]


def parser(doc, size, frames, every, rays):
    p = runs.parser(doc)
    p.add_argument("--size", default=size, help="WIDTHxHEIGHT")
    p.add_argument("--frames", type=int, default=frames, help="of the animation")
    p.add_argument("--every", type=int, default=every,
                   help="render the image of each such frame; the others are taken to cost as much")
    p.add_argument("--rays", type=int, default=rays, help="gather rays of a radiance record")
    return p


@dataclasses.dataclass
class Cost:
    """CPU seconds of a render, and its records."""
    records: float
    image: float
    total: float
    made: int  # radiance records
    file: str

    @classmethod
    def of(cls, image, stats):
        def seconds(parts):
            return sum(stats.get(f"parts.{part}.{kind}_s", 0.0) for part in parts
                       for kind in ("serial", "parallel"))
        return cls(seconds(RECORDS), seconds(IMAGE), stats["time.cpu_s"],
                   round(stats.get("records.radiance", 0)), image)


class Views:
    """Renders of one scene with options that all of them have."""

    def __init__(self, options, scene, *settings):
        self.options, self.scene = options, runs.scene_file("figures", scene)
        width, height = options.size.split("x")
        self.known = {}  # radiance records in the files that were written, by name
        self.args = ["--width", width, "--height", height, "--spp", "1", "-D", "filter=box",
                     *sets(*THESIS, f"radiance-rays={options.rays}", *settings)]

    def render(self, name, *args, frame=None):
        image, stats = runs.render(self.options, self.scene, name, *self.args, *args, frame=frame)
        cost = Cost.of(image, stats)
        loaded = args[args.index("--load-cache") + 1] if "--load-cache" in args else None
        cost.made -= self.known.get(loaded, 0)
        if "--save-cache" in args:
            saved = args[args.index("--save-cache") + 1]
            self.known[saved] = round(stats.get("records.radiance", 0))
        return cost

    def error(self, cost, reference):
        """relMSE of indirect gloss against that of another render."""
        return json.loads(runs.run([self.options.satin, "compare", cost.file, reference.file,
                                    "--layer", "indirect_glossy", "--json"]))["relmse"]


def keyframes(path):
    """The keyframes of a camera path."""
    with open(path, "rb") as file:
        return tomllib.load(file)["keyframe"]


def write_view(options, key):
    """A path of one frame, with a keyframe's view: its name."""
    name = os.path.join(options.dir, f"view-{key['frame']}.toml")
    os.makedirs(options.dir, exist_ok=True)
    with open(name, "w", encoding="utf-8") as file:
        file.write(f"[[frame]]\norigin = {key['origin']}\ntarget = {key['target']}\n")
    return name


def write_walk(options, scene):
    """The path of a scene with as many frames as the options ask for: its name."""
    name = os.path.join(options.dir, scene + ".toml")
    keys = keyframes(runs.scene_file("figures", scene).replace(".xml", ".toml"))
    scale = (options.frames - 1) / (keys[-1]["frame"] - 1)
    with open(name, "w", encoding="utf-8") as file:
        for key in keys:
            file.write(f"[[keyframe]]\nframe = {1 + round((key['frame'] - 1) * scale)}\n"
                       f"origin = {key['origin']}\ntarget = {key['target']}\n")
    return name


@dataclasses.dataclass
class Still:
    """What a view costs with radiance records, and with glossy rays."""
    made: int             # radiance records that were made for this view
    filling: float        # CPU seconds of making them
    interpolation: float
    total: float          # of the whole render with them
    rays: int             # glossy rays per point that take about as long
    rays_seconds: float   # that these take
    error: float          # relMSE of the gloss by records
    rays_error: float     # and by rays

    @property
    def seconds(self):
        return self.filling + self.interpolation


def measure_still(views, name, path, guess, reference, common=""):
    """The one view of a path. `guess`: glossy rays that may take as long as the
    records; `reference`: those of the reference. With a name `common`, records of views measured
    before with that name are there already."""
    def render(label, *settings):
        file = os.path.join(views.options.dir, f"{common or name}-{label}.cache")
        load = ["--load-cache", file] if file in views.known else []
        return views.render(f"{name}-{label}", "--animation", path, *load, "--save-cache", file,
                            *sets(*settings), frame=1)

    def by_rays(count, label="rays"):
        return render(label, "radiance-cache=off", f"glossy-samples={count}")

    records = render("records")
    direct = views.render(f"{name}-direct", "--animation", path, *sets("max-depth=2"), frame=1)
    rays = by_rays(guess)
    filling = max(records.records - rays.records, 0.0)
    interpolation = records.image - direct.image
    count = (filling + interpolation) / (rays.image - direct.image) * guess
    count = min(max(round(count), 1), reference)
    rays, truth = by_rays(count, "same"), by_rays(reference, "reference")
    return Still(records.made, filling, interpolation, records.total, count,
                 rays.image - direct.image, views.error(records, truth), views.error(rays, truth))


@dataclasses.dataclass
class Frames:
    """What a frame of an animation costs."""
    made: int             # radiance records of all frames
    filling: float        # CPU seconds of the radiance records per frame
    interpolation: float  # per frame that was rendered
    rays: float           # per frame, by glossy rays
    rendered: int         # frames whose images were rendered

    @property
    def seconds(self):
        return self.filling + self.interpolation


def measure_frames(views, name, path, count):
    """The frames of a path, with `count` glossy rays per point in those without records."""
    options = views.options
    numbers = range(1, options.frames + 1, options.every)

    def render(label, *settings):
        """The records of all frames, and the mean seconds of the images that are rendered."""
        file = os.path.join(options.dir, f"{name}-{label}.cache")
        costs = []
        for number in numbers:
            load = ["--load-cache", file] if costs else ["--save-cache", file]
            costs.append(views.render(f"{name}-{label}", "--animation", path, *load,
                                      *sets(*settings), frame=number))
        return costs[0], sum(cost.image for cost in costs) / len(costs)

    records, image = render("walk")
    irradiance, rays = render("walk-rays", "radiance-cache=off", f"glossy-samples={count}")
    direct = [views.render(f"{name}-walk-direct", "--animation", path, *sets("max-depth=2"),
                           frame=number).image for number in numbers]
    base = sum(direct) / len(direct)
    filling = (records.records - irradiance.records) / options.frames
    return Frames(records.made, filling, image - base, rays - base, len(numbers))


def still_rows(found):
    """The rows of a table of views: each a name and its cells."""
    return [("radiance records made", [f"{s.made}" for s in found]),
            ("filling, s", [f"{s.filling:.1f}" for s in found]),
            ("interpolation, s", [f"{s.interpolation:.1f}" for s in found]),
            ("whole render, s", [f"{s.total:.1f}" for s in found]),
            ("glossy rays per point in that time", [f"{s.rays}" for s in found]),
            ("their seconds", [f"{s.rays_seconds:.1f}" for s in found]),
            ("relMSE x 10^4 by records", [f"{1e4 * s.error:.2f}" for s in found]),
            ("relMSE x 10^4 by rays", [f"{1e4 * s.rays_error:.2f}" for s in found])]


def frame_rows(found, count, thesis):
    """The rows of a table of an animation, with what the thesis found."""
    cells = [("radiance records of all frames", f"{found.made}"),
             ("filling, s per frame", f"{found.filling:.2f}"),
             ("interpolation, s per frame", f"{found.interpolation:.2f}"),
             ("both, s per frame", f"{found.seconds:.2f}"),
             (f"{count} glossy rays per point, s per frame", f"{found.rays:.2f}"),
             ("times as long as the records", f"{found.rays / found.seconds:.1f}"),
             ("frames whose image was rendered", f"{found.rendered}")]
    return [[name, printed, cell] for (name, cell), printed in zip(cells, [*thesis, ""])]


def print_rows(head, rows):
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(row) + " |")
    print(flush=True)
