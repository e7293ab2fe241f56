# SPDX-License-Identifier: Apache-2.0
"""The shell of a random room of rooms.py: dice, positions of objects, walls, windows and the sky.

Lengths are metres before the room's unit `k`; a light that has intensity, not radiance, grows with
k^2, so the image does not depend on it.
"""
import random

from materials import Materials
from parts import element, plugin, real, ref, rgb, rotate, to_world, triple


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


class Shell:
    def __init__(self, index):
        self.dice = Dice(index)
        self.k = self.dice.log(1e-3, 1e3) if self.dice.chance(0.5) else 1.0
        self.half = [self.dice.range(1, 3.5), self.dice.range(1, 1.8), self.dice.range(1.2, 4)]
        self.power = self.dice.log(0.01, 100) if self.dice.chance(0.3) else 1.0
        self.materials = Materials(self.dice)
        self.parts, self.lights = [], 0
        self.targets = []  # centres of objects, one of which the eye may look at

    # ---- Placement -------------------------------------------------------------------------------

    def move(self, x, y, z):
        return element("translate", {"value": triple((self.k * x, self.k * y, self.k * z))})

    def grow(self, x, y, z):
        return element("scale", {"value": triple((self.k * x, self.k * y, self.k * z))})

    def rotation(self):
        """None, about the vertical, or any."""
        if self.dice.chance(0.3):
            return []
        upright = rotate("y", self.dice.range(0, 360))
        if self.dice.chance(0.7):
            return [upright]
        return [rotate("x", self.dice.range(0, 90)), upright]

    def gap(self):
        """Between an object and the surface below it: none, small, or slightly inside."""
        return self.dice.pick((0, 0, self.dice.log(1e-4, 0.1), -self.dice.log(1e-4, 0.02)))

    def spot_on_floor(self, radius):
        """x and z off the walls and off the eye, which has the end of large z; or at a wall."""
        if self.dice.chance(0.2):
            side = self.dice.pick((-1, 1))
            x = side * (self.half[0] - radius - self.gap())
        else:
            x = self.dice.range(-1, 1) * max(self.half[0] - radius, 0)
        return x, self.dice.range(-1, 0.2) * max(self.half[2] - radius, 0)

    def look(self, origin, target):
        return element("lookat", {"origin": triple([self.k * v for v in origin]),
                                  "target": triple([self.k * v for v in target]),
                                  "up": "0, 1, 0"})

    def ball(self, centre, radius, *material):
        where = element("point", {"name": "center", "value": triple([self.k * v for v in centre])})
        self.parts.append(plugin("shape", "sphere", where, real("radius", self.k * radius),
                                 *material))

    def light(self, strength):
        return [self.power * strength * self.dice.range(0.7, 1) for _ in range(3)]

    # ---- The shell -------------------------------------------------------------------------------

    def panel(self, axis, sign, low, high, material):
        """A rectangle of the wall at sign * half[axis] that faces inwards, between two corners in
        the other two axes, in their order."""
        u, v = [a for a in range(3) if a != axis]
        rotation = {(0, -1): [rotate("y", 90)], (0, 1): [rotate("y", -90)],
                (1, -1): [rotate("x", -90)], (1, 1): [rotate("x", 90)],
                (2, -1): [], (2, 1): [rotate("y", 180)]}[axis, sign]
        size, centre = [0, 0, 0], [0, 0, 0]
        for a, lo, hi in ((u, low[0], high[0]), (v, low[1], high[1])):
            size[a], centre[a] = (hi - lo) / 2, (hi + lo) / 2
        centre[axis] = sign * self.half[axis]
        flat = {0: (size[2], size[1]), 1: (size[0], size[2]), 2: (size[0], size[1])}[axis]
        steps = [self.grow(flat[0], flat[1], 1), *rotation, self.move(*centre)]
        return plugin("shape", "rectangle", to_world(*steps), material)

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
            return [self.panel(axis, sign, *hole, self.materials.thindielectric())]
        u, v = [a for a in range(3) if a != axis]
        (a, b), (c, d) = hole
        size, centre = [0, 0, 0], [0, 0, 0]
        size[u], size[v], size[axis] = (c - a) / 2, (d - b) / 2, self.dice.log(0.002, 0.05)
        centre[u], centre[v] = (a + c) / 2, (b + d) / 2
        centre[axis] = sign * (self.half[axis] + size[axis])
        return [plugin("shape", "cube", to_world(self.grow(*size), self.move(*centre)),
                       self.materials.dielectric())]

    def paint(self, name):
        """A wall's material under a name, which all of its panels refer to."""
        self.parts.append(plugin("bsdf", "twosided", self.materials.wall(), id=name))
        return ref(name)

    def shell(self):
        """Six walls, one of them perhaps with a window to the sky."""
        shared = self.paint("shared")
        window = self.dice.pick(((0, -1), (0, 1), (1, 1), (2, -1))) if self.dice.chance(0.35) \
            else None
        for axis in range(3):
            for sign in (-1, 1):
                own = None if self.dice.chance(0.4) else self.paint(f"wall{axis}{sign + 1}")
                hole = self.window(axis) if (axis, sign) == window else None
                self.parts += self.wall(axis, sign, own or shared, hole)
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
                "emitter", "sunsky", to_world(rotate("x", -90)),  # y up, as in the room
                real("turbidity", self.dice.range(2, 8)),
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
