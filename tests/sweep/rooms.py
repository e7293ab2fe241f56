#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes random rooms as scenes: boxes, balls, panes and lamps of all sizes, every reflection
model, in units from a thousandth to a thousand. A room is a function of its number alone.

    tests/sweep/rooms.py FIRST:END FOLDER

writes FOLDER/room-FIRST.xml and so on. Lengths below are metres before the room's unit `k`; a light
that has intensity, not radiance, grows with k^2, so the picture does not depend on it.
"""
import math
import pathlib
import random
import sys

from materials import Materials, write_files
from parts import (area_light, element, number, plugin, real, ref, rgb, rotate, to_world, triple,
                   value)


class Dice:
    """Random numbers that are the same in every version of Python."""

    def __init__(self, room):
        self.random = random.Random(room).random

    def range(self, low, high):
        return low + (high - low) * self.random()

    def log(self, low, high):
        return low * (high / low) ** self.random()

    def chance(self, p):
        return self.random() < p

    def count(self, low, high):
        return low + int(self.random() * (high - low + 1))

    def pick(self, items):
        return items[int(self.random() * len(items))]


class Room:
    def __init__(self, index):
        self.dice = Dice(index)
        self.k = self.dice.log(1e-3, 1e3) if self.dice.chance(0.5) else 1.0
        self.half = [self.dice.range(1, 3.5), self.dice.range(1, 1.8), self.dice.range(1.2, 4)]
        self.power = self.dice.log(0.01, 100) if self.dice.chance(0.3) else 1.0
        self.materials = Materials(self.dice)
        self.parts, self.lights = [], 0
        self.seen = []  # centres of things, one of which the eye may look at

    # ---- Placing ---------------------------------------------------------------------------------

    def move(self, x, y, z):
        return element("translate", {"value": triple((self.k * x, self.k * y, self.k * z))})

    def grow(self, x, y, z):
        return element("scale", {"value": triple((self.k * x, self.k * y, self.k * z))})

    def turn(self):
        """None, about the vertical, or any."""
        if self.dice.chance(0.3):
            return []
        upright = rotate("y", self.dice.range(0, 360))
        if self.dice.chance(0.7):
            return [upright]
        return [rotate("x", self.dice.range(0, 90)), upright]

    def gap(self):
        """Between a thing and what it stands on: none, small, or a hair inside."""
        return self.dice.pick((0, 0, self.dice.log(1e-4, 0.1), -self.dice.log(1e-4, 0.02)))

    def spot_on_floor(self, radius):
        """x and z off the walls and off the eye, which has the end of large z; or at a wall."""
        if self.dice.chance(0.2):
            side = self.dice.pick((-1, 1))
            x = side * (self.half[0] - radius - self.gap())
        else:
            x = self.dice.range(-1, 1) * max(self.half[0] - radius, 0)
        return x, self.dice.range(-1, 0.2) * max(self.half[2] - radius, 0)

    # ---- The shell -------------------------------------------------------------------------------

    def panel(self, axis, sign, low, high, material):
        """A rectangle of the wall at sign * half[axis] that faces inwards, between two corners in
        the other two axes, in their order."""
        u, v = [a for a in range(3) if a != axis]
        turn = {(0, -1): [rotate("y", 90)], (0, 1): [rotate("y", -90)],
                (1, -1): [rotate("x", -90)], (1, 1): [rotate("x", 90)],
                (2, -1): [], (2, 1): [rotate("y", 180)]}[axis, sign]
        size, centre = [0, 0, 0], [0, 0, 0]
        for a, lo, hi in ((u, low[0], high[0]), (v, low[1], high[1])):
            size[a], centre[a] = (hi - lo) / 2, (hi + lo) / 2
        centre[axis] = sign * self.half[axis]
        flat = {0: (size[2], size[1]), 1: (size[0], size[2]), 2: (size[0], size[1])}[axis]
        steps = [self.grow(flat[0], flat[1], 1), *turn, self.move(*centre)]
        return plugin("shape", "rectangle", to_world(*steps), *material)

    def wall(self, axis, sign, material, hole):
        """A whole wall, or four panels around a hole given by two corners."""
        u, v = [a for a in range(3) if a != axis]
        low, high = (-self.half[u], -self.half[v]), (self.half[u], self.half[v])
        if not hole:
            return [self.panel(axis, sign, low, high, material)]
        (a, b), (c, d) = hole
        return [self.panel(axis, sign, *corners, material)
                for corners in ((low, (a, high[1])), ((c, low[1]), high),
                                ((a, low[1]), (c, b)), ((a, d), (c, high[1])))]

    def pane(self, axis, sign, hole):
        """What may close a window: a sheet, or a slab of glass."""
        if self.dice.chance(0.5):
            return []
        if self.dice.chance(0.5):
            return [self.panel(axis, sign, *hole, [self.materials.thindielectric()])]
        u, v = [a for a in range(3) if a != axis]
        (a, b), (c, d) = hole
        size, centre = [0, 0, 0], [0, 0, 0]
        size[u], size[v], size[axis] = (c - a) / 2, (d - b) / 2, self.dice.log(0.002, 0.05)
        centre[u], centre[v] = (a + c) / 2, (b + d) / 2
        centre[axis] = sign * (self.half[axis] + size[axis])
        return [plugin("shape", "cube", to_world(self.grow(*size), self.move(*centre)),
                       self.materials.dielectric())]

    def shell(self):
        """Six walls, one of them perhaps with a window to the sky."""
        shared = self.materials.wall()
        window = self.dice.pick(((0, -1), (0, 1), (1, 1), (2, -1))) if self.dice.chance(0.35) \
            else None
        for axis in range(3):
            for sign in (-1, 1):
                own = shared if self.dice.chance(0.4) else self.materials.wall()
                material = [plugin("bsdf", "twosided", own)] if self.dice.chance(0.3) else [own]
                hole = self.window(axis) if (axis, sign) == window else None
                self.parts += self.wall(axis, sign, material, hole)
                if hole:
                    self.parts += self.pane(axis, sign, hole)
        if window:
            self.sky(window)

    def window(self, axis):
        u, v = [a for a in range(3) if a != axis]
        ends = [sorted(self.dice.range(-0.9, 0.9) * self.half[a] for _ in range(2)) for a in (u, v)]
        return (ends[0][0], ends[1][0]), (ends[0][1] + 0.05, ends[1][1] + 0.05)

    def sky(self, window):
        self.lights += 1
        inward = [0, -0.3, 0]
        inward[window[0]] = -window[1]
        if self.dice.chance(0.3):
            sun = [-inward[0], max(-inward[1], 0.2), -inward[2]]
            self.parts.append(plugin(
                "emitter", "preethamsky", real("turbidity", self.dice.range(2, 8)),
                element("point", {"name": "sun_direction", "value": triple(sun)}),
                real("sky_scale", 0.3 * self.power), real("sun_scale", 0.3 * self.power)))
            return
        self.parts.append(plugin("emitter", "constant",
                                 rgb("radiance", *self.light(self.dice.log(0.3, 10)))))
        if self.dice.chance(0.4):
            inward = [x + self.dice.range(-0.4, 0.4) for x in inward]
            self.parts.append(plugin(
                "emitter", "directional", rgb("irradiance", *self.light(self.dice.log(1, 30))),
                element("vector", {"name": "direction", "value": triple(inward)})))

    # ---- Lamps -----------------------------------------------------------------------------------

    def light(self, strength):
        return [self.power * strength * self.dice.range(0.7, 1) for _ in range(3)]

    def lamp(self):
        self.lights += 1
        self.dice.pick((self.ceiling_lamp, self.ceiling_lamp, self.ceiling_lamp, self.ball_lamp,
                        self.ball_lamp, self.spot, self.spot, self.bulb, self.beam))()

    def place_of_lamp(self):
        x, y, z = (self.dice.range(-0.8, 0.8) * h for h in self.half)
        return x, self.half[1] * self.dice.range(0.4, 0.9) if self.dice.chance(0.7) else y, z

    def ceiling_lamp(self):
        """A rectangle or disk under the ceiling that faces the floor, now and then the ceiling."""
        a, b = self.dice.log(0.02, 0.8), self.dice.log(0.02, 0.8)
        x, _, z = self.place_of_lamp()
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
        place = self.place_of_lamp()
        self.ball(place, radius, area_light(*self.light(0.8 / radius ** 2)))
        if self.dice.chance(0.2):
            self.ball(place, radius * self.dice.range(1.1, 2), self.materials.dielectric())

    def spot(self):
        origin = self.place_of_lamp()
        target = (origin[0] * 0.3, -self.half[1], origin[2] * 0.3 + 0.1)
        self.parts.append(plugin(
            "emitter", "spot", rgb("intensity", *self.light(20 * self.k ** 2)),
            real("cutoff_angle", self.dice.range(5, 60)),
            to_world(self.look(origin, target))))

    def bulb(self):
        place = element("point", {"name": "position",
                                  "value": triple([self.k * v for v in self.place_of_lamp()])})
        self.parts.append(plugin("emitter", "point", place,
                                 rgb("intensity", *self.light(3 * self.k ** 2))))

    def beam(self):
        size = self.dice.log(0.02, 0.5)
        x, y, z = self.place_of_lamp()
        self.parts.append(plugin(
            "shape", self.dice.pick(("rectangle", "disk")),
            to_world(self.grow(size, size, 1), rotate("x", self.dice.range(50, 130)),
                     self.move(x, y, z)),
            plugin("emitter", "directionalarea", rgb("radiance", *self.light(4 / size ** 2)))))

    # ---- Things ----------------------------------------------------------------------------------

    def ball(self, centre, radius, *material):
        where = element("point", {"name": "center", "value": triple([self.k * v for v in centre])})
        self.parts.append(plugin("shape", "sphere", where, real("radius", self.k * radius),
                                 *material))

    def thing(self, floor, limit):
        """Stands on height `floor`, no wider than `limit`; returns its x, z, top and width."""
        half = [self.dice.log(0.03, 0.6) for _ in range(3)]
        half[0], half[2] = min(half[0], limit), min(half[2], limit)
        if self.dice.chance(0.4):
            half = [min(half)] * 3
        x, z = self.spot_on_floor(math.hypot(half[0], half[2]))
        return self.thing_at(x, z, floor + self.gap(), half)

    def thing_at(self, x, z, foot, half):
        self.seen.append((x, foot + half[1], z))
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
        self.parts.append(plugin("shape", kind, to_world(self.grow(*size), *self.turn(),
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
        """A ball of a group, at three places."""
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

    def look(self, origin, target):
        return element("lookat", {"origin": triple([self.k * v for v in origin]),
                                  "target": triple([self.k * v for v in target]),
                                  "up": "0, 1, 0"})

    def eye(self):
        origin = (self.dice.range(-0.8, 0.8) * self.half[0],
                  self.dice.range(-0.6, 0.8) * self.half[1], 0.93 * self.half[2])
        target = [self.dice.range(-0.6, 0.6) * h for h in self.half]
        if self.dice.chance(0.7):
            target = list(self.dice.pick(self.seen))
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
