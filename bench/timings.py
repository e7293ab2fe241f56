# SPDX-License-Identifier: Apache-2.0
"""The timing tables of the thesis' chapter 3: what radiance caching costs beside sampling each
glossy reflection by the BRDF, in still images and in the frames of a camera path.

Times are CPU seconds of all threads, which other processes hardly change. Each view is rendered
with one sample per pixel: with radiance records, with glossy rays instead, and with direct light
alone. Radiance records then take

    filling        the seconds of all records, times the fraction of gather rays that are theirs
    interpolation  the seconds of the image, less those of the image of direct light

where the last includes the interpolation of irradiance. What glossy rays take is the seconds of
their image, less those of the image of direct light, so the same is in both.
"""
import dataclasses
import json
import os
import tomllib

import runs

# As in chapter 3: harmonics of order 10, a = .15 without a later second accuracy, no adaptation, no
# clamping by gradients or curvature, and records at least .3 pixel wide (R- = 2 pixels, times a).
THESIS = ["adaptive-sampling=off", "light-samples=8", "radiance-order=10", "radiance-a=.15",
          "irradiance-a=.15", "radiance-widen=1", "irradiance-widen=1", "adaptive-cache=off",
          "radiance-gradient-clamp=off", "radiance-curvature-clamp=off", "radiance-min-pixels=.3",
          "radiance-max-pixels=100000", "guide-clusters=off"]
# The parts of a render (`parts.NAME.serial_s` and `parallel_s` in its statistics) that are these.
RECORDS = ("records", "sites", "choose", "gather", "insert", "adapt")
IMAGE = ("image", "plan", "rims")


def sets(*options):
    """Arguments of satin render."""
    return [part for option in options for part in ("--set", option)]


def parser(doc, size, frames, images, rays):
    p = runs.parser(doc)
    p.add_argument("--size", default=size, help="WIDTHxHEIGHT")
    p.add_argument("--frames", type=int, default=frames, help="of the animation")
    p.add_argument("--images", type=int, default=images,
                   help="of the animation; the other frames are taken to cost as much")
    p.add_argument("--rays", type=int, default=rays, help="gather rays of a radiance record")
    return p


@dataclasses.dataclass
class Cost:
    """CPU seconds of a render, and its records."""
    filling: float  # of radiance records
    image: float
    total: float
    made: int       # radiance records
    file: str


def seconds(stats, parts):
    return sum(stats.get(f"parts.{part}.{kind}_s", 0.0) for part in parts
               for kind in ("serial", "parallel"))


class Views:
    """Renders of one scene with options that all of them have."""

    def __init__(self, options, scene, *settings):
        self.options, self.scene = options, runs.scene_file("figures", scene)
        width, height = options.size.split("x")
        self.known = {}  # radiance records and rays of the files that were written, by name
        self.args = ["--width", width, "--height", height, "--spp", "1", "-D", "filter=box",
                     *sets(*THESIS, f"radiance-rays={options.rays}", *settings)]

    def render(self, name, *args, frame=None):
        image, stats = runs.render(self.options, self.scene, name, *self.args, *args, frame=frame)
        loaded = args[args.index("--load-cache") + 1] if "--load-cache" in args else None
        known = self.known.get(loaded, (0, 0))
        records, rays = round(stats.get("records.radiance", 0)), stats.get("records.rays", 0)
        made = records - known[0]
        theirs = made * self.options.rays / (rays - known[1]) if made else 0.0
        if "--save-cache" in args:
            self.known[args[args.index("--save-cache") + 1]] = (records, rays)
        return Cost(min(theirs, 1.0) * seconds(stats, RECORDS), seconds(stats, IMAGE),
                    stats["time.cpu_s"], made, image)

    def error(self, cost, reference):
        """relMSE of indirect gloss against that of another render."""
        return json.loads(runs.run([self.options.satin, "compare", cost.file, reference.file,
                                    "--layer", "indirect_glossy", "--json"]))["relmse"]


def keyframes(scene):
    """The keyframes of a scene's camera path."""
    with open(runs.scene_file("figures", scene).replace(".xml", ".toml"), "rb") as file:
        return tomllib.load(file)["keyframe"]


def write_view(options, key):
    """A path of one frame, with a keyframe's view: its name."""
    name = os.path.join(options.dir, f"view-{key['frame']}.toml")
    os.makedirs(options.dir, exist_ok=True)
    with open(name, "w", encoding="utf-8") as file:
        file.write(f"[[frame]]\norigin = {key['origin']}\ntarget = {key['target']}\n")
    return name


def write_walk(options, scene, frames):
    """The path of a scene with so many frames: its name. If they are few, keyframes between the
    first and the last one are left out that come to the frame of another one."""
    name = os.path.join(options.dir, f"{scene}-{frames}.toml")
    keys = keyframes(scene)
    scale = (frames - 1) / (keys[-1]["frame"] - 1)
    at = {}
    for key in [*keys[1:], keys[0]] if frames > 1 else keys[:1]:
        at[1 + round((key["frame"] - 1) * scale)] = key
    with open(name, "w", encoding="utf-8") as file:
        for number, key in sorted(at.items()):
            file.write(f"[[keyframe]]\nframe = {number}\n"
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
        load = ["--load-cache", file] if file in views.known and common else []
        return views.render(f"{name}-{label}", "--animation", path, *load, "--save-cache", file,
                            *sets(*settings), frame=1)

    def by_rays(count, label="rays"):
        return render(label, "radiance-cache=off", f"glossy-samples={count}")

    records = render("records")
    direct = views.render(f"{name}-direct", "--animation", path, *sets("max-depth=2"), frame=1)
    rays = by_rays(guess)
    filling = records.filling
    interpolation = records.image - direct.image
    count = guess
    for _ in range(2):  # the seconds of rays are not in proportion to their number
        count *= (filling + interpolation) / (rays.image - direct.image)
        count = min(max(round(count), 1), reference)
        rays = by_rays(count, "same")
    truth = by_rays(reference, "reference")
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


def measure_frames(views, name, scene, count):
    """The frames of a scene's path, with `count` glossy rays per point in those without records.
    The records of all frames are made, but only some of the images."""
    options = views.options
    images, step = options.images, (options.frames - 1) / max(options.images - 1, 1)
    path = write_walk(options, scene, options.frames)
    file = os.path.join(options.dir, f"{name}-walk.cache")
    with_records = []
    for i in range(images):
        use = ["--load-cache", file] if i else ["--save-cache", file]
        with_records.append(views.render(f"{name}-walk", "--animation", path, *use,
                                         frame=1 + round(i * step)))
    # The others need no records of other frames, so their path has these frames alone.
    path = write_walk(options, scene, images)

    def mean_image(label, *settings):
        return sum(views.render(f"{name}-{label}", "--animation", path, *sets(*settings),
                                frame=1 + i).image for i in range(images)) / images

    base = mean_image("walk-direct", "max-depth=2")
    rays = mean_image("walk-rays", "radiance-cache=off", f"glossy-samples={count}") - base
    image = sum(cost.image for cost in with_records) / images - base
    return Frames(with_records[0].made, with_records[0].filling / options.frames, image, rays,
                  images)


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


def print_stills(names, thesis, found):
    """A table of views by their names, with the first rows of each as the thesis has them."""
    head = [""] + [cell for name in names for cell in (f"{name}, thesis", "satin")]
    rows = still_rows(found)
    print_rows(head, [[name] + [cell for printed, own in zip(thesis, cells)
                                for cell in ((printed + 2 * [""])[i], own)]
                      for i, (name, cells) in enumerate(rows)])


def print_rows(head, rows):
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(row) + " |")
    print(flush=True)
