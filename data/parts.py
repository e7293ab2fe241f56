# SPDX-License-Identifier: Apache-2.0
"""The parts that generate.py puts scenes together from: XML elements, shapes, meshes."""
import math
import struct


def number(x):
    """Shortest text of a number to 6 digits: the same on every machine."""
    return f"{x:.6g}"


def triple(values):
    return ", ".join(number(v) for v in values)


def indent(text, by=4):
    return "\n".join(" " * by + line if line else line for line in text.split("\n"))


def element(tag, attributes, *children):
    head = "<" + tag + "".join(f' {k}="{v}"' for k, v in attributes.items())
    if not children:
        return head + "/>"
    return "\n".join([head + ">", *map(indent, children), f"</{tag}>"])


def value(kind, name, text):
    return element(kind, {"name": name, "value": text})


def real(name, x):
    return value("float", name, number(x))


def rgb(name, *color):
    return value("rgb", name, triple(color))


def plugin(tag, kind, *children, **attributes):
    return element(tag, {"type": kind, **attributes}, *children)


def ref(name):
    return element("ref", {"id": name})


def diffuse(name, *color):
    return plugin("bsdf", "diffuse", rgb("reflectance", *color), id=name)


def area_light(*radiance):
    return plugin("emitter", "area", rgb("radiance", *radiance))


# ---- Shapes --------------------------------------------------------------------------------------


def to_world(*steps):
    return element("transform", {"name": "to_world"}, *steps)


def scale(x, y, z):
    return element("scale", {"x": number(x), "y": number(y), "z": number(z)})


def rotate(axis, angle):
    return element("rotate", {axis: "1", "angle": number(angle)})


def translate(x, y, z):
    return element("translate", {"x": number(x), "y": number(y), "z": number(z)})


# How the rectangle of the xy plane, normal +z, is rotated to face each direction.
FACING = {"+z": [], "-z": [rotate("y", 180)], "+x": [rotate("y", 90)], "-x": [rotate("y", -90)],
          "+y": [rotate("x", -90)], "-y": [rotate("x", 90)]}


def rectangle(facing, centre, half, *children, **attributes):
    """A rectangle with half extents `half`, before it is rotated to face one of six directions."""
    return plugin("shape", "rectangle",
                  to_world(scale(half[0], half[1], 1), *FACING[facing], translate(*centre)),
                  *children, **attributes)


def box(centre, half, angle, *children, **attributes):
    """A box that is rotated about the vertical by `angle` degrees."""
    steps = [scale(*half)] + ([rotate("y", angle)] if angle else []) + [translate(*centre)]
    return plugin("shape", "cube", to_world(*steps), *children, **attributes)


def sphere(centre, radius, *children, **attributes):
    point = element("point", {"name": "center", **{k: number(v) for k, v in zip("xyz", centre)}})
    return plugin("shape", "sphere", point, real("radius", radius), *children, **attributes)


def tube(foot, height, radius, *children):
    """An open upright cylinder without caps."""
    ends = [element("point", {"name": name, "x": number(foot[0]), "y": number(y),
                              "z": number(foot[2])})
            for name, y in (("p0", foot[1]), ("p1", foot[1] + height))]
    return plugin("shape", "cylinder", *ends, real("radius", radius), *children)


# ---- Scenes --------------------------------------------------------------------------------------


def sensor(origin, target, fov, *more):
    view = element("lookat", {"origin": triple(origin), "target": triple(target), "up": "0, 1, 0"})
    sampler = plugin("sampler", "independent", value("integer", "sample_count", "$spp"))
    film = plugin("film", "hdrfilm", value("integer", "width", "$resx"),
                  value("integer", "height", "$resy"), plugin("rfilter", "$filter"))
    return plugin("sensor", "perspective", real("fov", fov), *more, to_world(view), sampler, film)


def scene(comment, *children, depth=None):
    """A scene file; depth: longest light path in edges."""
    defaults = [element("default", {"name": name, "value": text})
                for name, text in (("spp", "256"), ("resx", "400"), ("resy", "400"),
                                   ("filter", "gaussian"))]
    bound = [value("integer", "max_depth", str(depth))] if depth else []
    integrator = plugin("integrator", "path", *bound)
    body = "\n\n".join(["\n".join(defaults), integrator, *children])
    lines = "\n".join(line.rstrip() for line in comment.strip().split("\n"))
    return f"<!-- {lines} -->\n<scene version=\"3.0.0\">\n{indent(body)}\n</scene>\n"


def camera_path(comment, *keyframes):
    """A camera path through (frame, origin, target), for `--animation`."""
    return f"# {comment}\n" + "\n".join(
        f"[[keyframe]]\nframe = {frame}\norigin = [{triple(origin)}]\ntarget = [{triple(target)}]\n"
        for frame, origin, target in keyframes)


# ---- Meshes --------------------------------------------------------------------------------------


def catmull_rom(points, steps):
    """A spline through points: positions and tangents, `steps` per span."""
    ends = [points[0], *points, points[-1]]
    spline = []
    for i in range(len(points) - 1):
        p = ends[i:i + 4]
        for k in range(steps + (i == len(points) - 2)):
            t = k / steps
            w = [(-t + 2 * t**2 - t**3) / 2, (2 - 5 * t**2 + 3 * t**3) / 2,
                 (t + 4 * t**2 - 3 * t**3) / 2, (-t**2 + t**3) / 2]
            d = [(-1 + 4 * t - 3 * t**2) / 2, (-10 * t + 9 * t**2) / 2,
                 (1 + 8 * t - 9 * t**2) / 2, (-2 * t + 3 * t**2) / 2]
            spline.append(tuple(sum(c[j] * p[j][axis] for j in range(4))
                               for c in (w, d) for axis in range(len(p[0]))))
    return spline


def lathe(profile, sides, steps):
    """A profile of (radius, height), rotated about the y axis: a binary PLY with smooth normals
    that point to the right of the profile's direction."""
    vertices = []
    spline = catmull_rom(profile, steps)
    for r, y, dr, dy in spline:
        length = math.hypot(dr, dy)
        for k in range(sides):
            c, s = math.cos(2 * math.pi * k / sides), math.sin(2 * math.pi * k / sides)
            n = (dy * c / length, -dr / length, dy * s / length)
            vertices.append((r * c, y, r * s, *n))
    return ply(vertices, strips(len(spline), sides, True))


def sweep(spine, sides, steps):
    """A tube along a spline in the plane z = 0 through points of (x, y, radius), open at its ends:
    a binary PLY with smooth normals, which point outside."""
    vertices = []
    spline = catmull_rom(spine, steps)
    for x, y, r, dx, dy, _ in spline:
        length = math.hypot(dx, dy)
        for k in range(sides):
            c, s = math.cos(2 * math.pi * k / sides), math.sin(2 * math.pi * k / sides)
            n = (c * dy / length, -c * dx / length, s)
            vertices.append((x + r * n[0], y + r * n[1], r * n[2], *n))
    return ply(vertices, strips(len(spline), sides, True))


def curtain(plan, foot, top, rows, steps):
    """An upright sheet over a spline through points of (x, z), between heights that `foot` and
    `top` give for the fraction of the spline in [0, 1]: a binary PLY with smooth normals, which
    point to the right of the spline's direction."""
    vertices = []
    spline = catmull_rom(plan, steps)
    for i in range(rows + 1):
        for k, (x, z, dx, dz) in enumerate(spline):
            low, high = foot(k / (len(spline) - 1)), top(k / (len(spline) - 1))
            length = math.hypot(dx, dz)
            vertices.append((x, low + (high - low) * i / rows, z, -dz / length, 0, dx / length))
    return ply(vertices, strips(rows + 1, len(spline), False))


def strips(rows, columns, closed):
    """Two triangles in each cell of a grid of vertices, row by row; closed: the last column meets
    the first."""
    faces = []
    for row in range(rows - 1):
        for k in range(columns if closed else columns - 1):
            a, b = row * columns + k, row * columns + (k + 1) % columns
            faces += [(a, a + columns, b), (b, a + columns, b + columns)]
    return faces


def ply(vertices, faces):
    """A binary PLY of vertices (x, y, z, nx, ny, nz) and triangles."""
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    header += [f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz")]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices",
               "end_header", ""]
    data = b"".join(struct.pack("<6f", *(round(x, 5) + 0.0 for x in v)) for v in vertices)
    data += b"".join(struct.pack("<B3i", 3, *f) for f in faces)
    return "\n".join(header).encode() + data
