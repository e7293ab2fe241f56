#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes random rooms as scenes: boxes, balls, panes and lamps of all sizes, every reflection
model, in units from a thousandth to a thousand. A room is a function of its number alone.

    tests/sweep/rooms.py FIRST:END FOLDER

writes FOLDER/room-FIRST.xml and so on. shell.py has the walls, materials.py the reflection models.
"""
import math
import pathlib
import sys

from materials import write_files
from parts import area_light, element, plugin, real, ref, rgb, rotate, to_world, triple, value
from shell import Shell


class Room(Shell):
    """A whole room; `text` is its scene."""

    # ---- Lamps -----------------------------------------------------------------------------------

    def lamp(self):
        self.lights += 1
        self.dice.pick((self.ceiling_lamp, self.ceiling_lamp, self.ceiling_lamp, self.ball_lamp,
                        self.ball_lamp, self.spot, self.spot, self.bulb, self.beam))()

    def position_of_lamp(self):
        x, y, z = (self.dice.range(-0.8, 0.8) * h for h in self.half)
        return x, self.half[1] * self.dice.range(0.4, 0.9) if self.dice.chance(0.7) else y, z

    def ceiling_lamp(self):
        """A rectangle or disk under the ceiling that faces the floor, sometimes the ceiling."""
        a, b = self.dice.log(0.02, 0.8), self.dice.log(0.02, 0.8)
        x, _, z = self.position_of_lamp()
        kind, steps = ("rectangle", self.grow(a, b, 1))
        if self.dice.chance(0.3):
            kind, b = "disk", a
            steps = self.grow(a, a, 1)
        up = self.dice.chance(0.15)
        y = self.half[1] - (self.dice.log(0.05, 0.5) if up else self.dice.log(1e-3, 0.1))
        self.parts.append(plugin(
            "shape", kind, to_world(steps, rotate("x", -90 if up else 90), self.move(x, y, z)),
            self.materials.diffuse(), area_light(*self.light(6 / max(a * b, 0.003)))))

    def ball_lamp(self):
        """Alone, or inside of a ball of glass."""
        radius = self.dice.log(0.02, 0.3)
        position = self.position_of_lamp()
        self.ball(position, radius, area_light(*self.light(0.8 / radius ** 2)))
        if self.dice.chance(0.2):
            self.ball(position, radius * self.dice.range(1.1, 2), self.materials.dielectric())

    def spot(self):
        origin = self.position_of_lamp()
        target = (origin[0] * 0.3, -self.half[1], origin[2] * 0.3 + 0.1)
        self.parts.append(plugin(
            "emitter", "spot", rgb("intensity", *self.light(20 * self.k ** 2)),
            real("cutoff_angle", self.dice.range(5, 60)),
            to_world(self.look(origin, target))))

    def bulb(self):
        position = element("point", {"name": "position",
                                  "value": triple([self.k * v for v in self.position_of_lamp()])})
        self.parts.append(plugin("emitter", "point", position,
                                 rgb("intensity", *self.light(3 * self.k ** 2))))

    def beam(self):
        size = self.dice.log(0.02, 0.5)
        x, y, z = self.position_of_lamp()
        self.parts.append(plugin(
            "shape", self.dice.pick(("rectangle", "disk")),
            to_world(self.grow(size, size, 1), rotate("x", self.dice.range(50, 130)),
                     self.move(x, y, z)),
            plugin("emitter", "directionalarea", rgb("radiance", *self.light(4 / size ** 2)))))

    # ---- Objects ---------------------------------------------------------------------------------

    def thing(self, floor, limit):
        """Stands on height `floor`, no wider than `limit`; returns its x, z, top and width."""
        half = [self.dice.log(0.03, 0.6) for _ in range(3)]
        half[0], half[2] = min(half[0], limit), min(half[2], limit)
        if self.dice.chance(0.4):
            half = [min(half)] * 3
        x, z = self.spot_on_floor(math.hypot(half[0], half[2]))
        return self.thing_at(x, z, floor + self.gap(), half)

    def thing_at(self, x, z, foot, half):
        self.targets.append((x, foot + half[1], z))
        kind = self.dice.pick(("box", "box", "ball", "ball", "tube", "sheet", "copies"))
        top = foot + 2 * half[1]
        if kind == "ball":
            radius = min(half)
            self.ball((x, foot + radius, z), radius, self.materials.body())
            top = foot + 2 * radius
        elif kind == "box":
            self.add("cube", half, x, foot + half[1], z, self.materials.body())
        elif kind == "tube":
            self.tube(x, z, foot, top, min(half[0], half[2]))
        elif kind == "sheet":
            self.add("rectangle", (half[0], half[1], 1), x, foot + half[1], z,
                     self.materials.sheet())
        else:
            self.copies(x, z, foot, min(half))
        return x, z, top, min(half[0], half[2])

    def add(self, kind, size, x, y, z, material):
        self.parts.append(plugin("shape", kind, to_world(self.grow(*size), *self.rotation(),
                                                         self.move(x, y, z)), material))

    def tube(self, x, z, foot, top, radius):
        """Open, or closed by a disk above."""
        ends = [element("point", {"name": name,
                                  "value": triple((self.k * x, self.k * y, self.k * z))})
                for name, y in (("p0", foot), ("p1", top))]
        material = plugin("bsdf", "twosided", self.materials.smooth())
        self.parts.append(plugin("shape", "cylinder", *ends, real("radius", self.k * radius),
                                 material))
        if self.dice.chance(0.5):
            self.parts.append(plugin("shape", "disk", to_world(
                self.grow(radius, radius, 1), rotate("x", -90), self.move(x, top, z)), material))

    def copies(self, x, z, foot, radius):
        """A ball of a group, at three positions."""
        name = f"group{len(self.parts)}"
        ball = plugin("shape", "sphere", real("radius", self.k * radius), self.materials.body())
        self.parts.append(plugin("shape", "shapegroup", ball, id=name))
        for i in range(3):
            self.parts.append(plugin("shape", "instance", ref(name), to_world(
                self.move(x, foot + radius, z - 2 * i * radius))))

    def things(self):
        for _ in range(self.dice.count(1, 5)):
            x, z, top, width = self.thing(-self.half[1], 0.8)
            if self.dice.chance(0.3):
                self.thing_at(x, z, top + self.gap(), [width * self.dice.range(0.3, 1)] * 3)

    # ---- The eye ---------------------------------------------------------------------------------

    def eye(self):
        origin = (self.dice.range(-0.8, 0.8) * self.half[0],
                  self.dice.range(-0.6, 0.8) * self.half[1], 0.93 * self.half[2])
        target = [self.dice.range(-0.6, 0.6) * h for h in self.half]
        if self.dice.chance(0.7):
            target = list(self.dice.pick(self.targets))
        target[2] = min(target[2], origin[2] - 0.5)
        kind, more = "perspective", []
        if self.dice.chance(0.1):
            kind = "thinlens"
            more = [real("aperture_radius", self.k * self.dice.log(0.001, 0.05)),
                    real("focus_distance", self.k * self.half[2])]
        film = plugin("film", "hdrfilm", value("integer", "width", "64"),
                      value("integer", "height", "64"), plugin("rfilter", "$filter"))
        return plugin("sensor", kind, real("fov", self.dice.range(30, 80)),
                      real("near_clip", 1e-3 * self.k), real("far_clip", 1e4 * self.k), *more,
                      to_world(self.look(origin, target)), film)

    def text(self):
        self.shell()
        self.things()
        for _ in range(self.dice.count(0 if self.lights else 1, 3)):
            self.lamp()
        head = element("default", {"name": "filter", "value": "box"})
        return element("scene", {"version": "3.0.0"}, head, self.eye(), *self.parts) + "\n"


def write_rooms(first, end, folder):
    """Returns the paths."""
    folder.mkdir(parents=True, exist_ok=True)
    write_files(folder)
    paths = [folder / f"room-{i}.xml" for i in range(first, end)]
    for i, path in zip(range(first, end), paths):
        path.write_text(Room(i).text(), encoding="utf-8")
    return paths


def main():
    if len(sys.argv) != 3 or sys.argv[1].count(":") != 1:
        sys.exit(__doc__)
    first, end = map(int, sys.argv[1].split(":"))
    write_rooms(first, end, pathlib.Path(sys.argv[2]))


if __name__ == "__main__":
    main()
