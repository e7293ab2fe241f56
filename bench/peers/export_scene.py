#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a scene as arrays and JSON, for renderers that do not read Mitsuba's files.

  export_scene.py SCENE OUT.npz

Mitsuba 3 loads the shapes; materials are read from the XML. OUT.npz has for shape number N the
arrays N.vertices, N.faces, N.uv and, if it is smooth, N.normals, and `scene`, a JSON text: camera,
shapes, materials, environment and number of bounces, or the `reason` why the scene cannot be
described.
"""
import json
import pathlib
import re
import sys
import xml.etree.ElementTree as ET

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests" / "image"))
import mitsuba_plugins  # pylint: disable=wrong-import-position

SPHERE_RINGS = 128
DISK_CORNERS = 256
KNOWN = {"diffuse", "conductor", "roughconductor", "dielectric", "plastic", "roughplastic", "phong"}


class Unknown(Exception):
    """A scene that has something that is not described here."""


def snake(name):
    """A name of Mitsuba 0.6 as Mitsuba 3 spells it."""
    return re.sub(r"(?<=[a-z])([A-Z]+)", lambda m: "_" + m.group(1).lower(), name)


def numbers(element):
    found = [float(x) for x in re.split(r"[,\s]+", element.get("value").strip())]
    return found * 3 if len(found) == 1 else found


def texture(element, folder):
    if element.get("type") == "checkerboard":
        colors = [numbers(element.find(f"rgb[@name='color{i}']")) for i in range(2)]
        scale = element.find("transform/scale")
        return {"checkers": colors, "scale": [float(scale.get(c, 1)) for c in "xy"]}
    if element.get("type") != "bitmap":
        raise Unknown(f"a texture {element.get('type')}")
    name = element.find("string[@name='filename']").get("value")
    scale = element.find("transform")
    if scale is not None and len(scale):
        raise Unknown("a texture with a transform")
    return {"file": str(folder / name)}


def material(element, folder):
    """Type and parameters of a BSDF; `twosided` and `mask` are parameters of what they contain."""
    kind = element.get("type")
    if kind in ("twosided", "mask", "bumpmap"):
        inner = material(element.find("bsdf"), folder)
        opacity = [c for c in element if snake(c.get("name", "")) == "opacity"]
        if opacity:
            inner["opacity"] = value(opacity[0], folder)
        return {**inner, kind: True}
    if kind not in KNOWN:
        raise Unknown(f"a BSDF {kind}")
    found = {"type": kind}
    for child in element:
        found[snake(child.get("name"))] = value(child, folder)
    if found.get("material", "none") != "none":
        raise Unknown(f"the metal {found['material']}")
    return found


def value(child, folder):
    if child.tag == "texture":
        return texture(child, folder)
    if child.tag in ("rgb", "spectrum"):
        return numbers(child)
    return float(child.get("value")) if child.tag == "float" else child.get("value")


def circle():
    angle = np.linspace(0, 2 * np.pi, DISK_CORNERS, endpoint=False)
    return np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)


def rectangle():
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=float)
    return corners, [[0, 1, 2], [0, 2, 3]], None, (corners[:, :2] + 1) / 2


def disk():
    faces = [[0, 1 + i, 1 + (i + 1) % DISK_CORNERS] for i in range(DISK_CORNERS)]
    return np.vstack([[0, 0, 0], circle()]), faces, None, None


def cylinder():
    """Open at both ends, and smooth."""
    low = np.arange(DISK_CORNERS)
    high, following = low + DISK_CORNERS, np.roll(low, -1)
    faces = [*zip(low, following, high), *zip(following, following + DISK_CORNERS, high)]
    return np.vstack([circle(), circle() + [0, 0, 1]]), faces, np.vstack([circle()] * 2), None


def sphere():
    columns = 2 * SPHERE_RINGS
    theta, phi = np.meshgrid(np.linspace(0, np.pi, SPHERE_RINGS + 1),
                             np.linspace(0, 2 * np.pi, columns, endpoint=False), indexing="ij")
    points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)],
                      axis=-1).reshape(-1, 3)
    faces = []
    for i in range(SPHERE_RINGS):
        for j in range(columns):
            a, b = i * columns + j, i * columns + (j + 1) % columns
            faces += [[a, a + columns, b], [b, a + columns, b + columns]]
    return points, faces, points, None


# Vertices, faces, normals and texture coordinates of shapes that are no meshes.
GRIDS = {"rectangle": rectangle, "disk": disk, "cylinder": cylinder, "sphere": sphere}


def mesh(kind, params):
    """Arrays of a shape in the world, by its plugin and what Mitsuba knows of it."""
    if "vertex_positions" in params:
        vertices = np.array(params["vertex_positions"]).reshape(-1, 3)
        normals = np.array(params["vertex_normals"]).reshape(-1, 3)
        uv = np.array(params["vertex_texcoords"]).reshape(-1, 2)
        return vertices, np.array(params["faces"]).reshape(-1, 3), normals, uv
    if kind not in GRIDS:
        raise Unknown(f"a shape {kind}")
    vertices, faces, normals, uv = GRIDS[kind]()
    matrix = np.array(params["to_world"].matrix).reshape(4, 4)
    vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
    if normals is not None:
        normals = normals @ np.linalg.inv(matrix[:3, :3])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return vertices, np.array(faces), normals, uv


def camera(sensor):
    params = mi.traverse(sensor)
    width, height = (int(x) for x in params["film.size"])
    return {"to_world": np.array(params["to_world"].matrix).reshape(4, 4).tolist(),
            "x_fov": float(np.array(params["x_fov"]).flat[0]), "width": width, "height": height}


def environment(scene, root, folder):
    if not scene.environment():
        return None
    element = root.find("emitter")
    if element.get("type") != "envmap":
        raise Unknown(f"an emitter {element.get('type')}")
    params = mi.traverse(scene.environment())
    return {"file": str(folder / element.find("string[@name='filename']").get("value")),
            "scale": float(np.array(params["scale"]).flat[0]),
            "to_world": np.array(params["to_world"].matrix).reshape(4, 4).tolist()}


def bounces(root):
    depth = root.find("integrator/integer[@name='max_depth']")
    name = depth.get("value") if depth is not None else "-1"
    default = root.find(f"default[@name='{name[1:]}']") if name.startswith("$") else None
    return int(default.get("value") if default is not None else name)


def shape_of(number, shape, element, arrays):
    """A shape's light, after its arrays."""
    params = mi.traverse(shape)
    for name, array in zip(("vertices", "faces", "normals", "uv"),
                           mesh(element.get("type"), params)):
        if array is not None and len(array):
            arrays[f"{number}.{name}"] = np.asarray(array, "i4" if name == "faces" else "f4")
    if not shape.is_emitter():
        return None
    return np.array(params["emitter.radiance.value"]).flatten().tolist()


def describe(path, arrays):
    root, folder = ET.parse(path).getroot(), path.parent
    scene = mi.load_file(str(path), optimize=False)
    elements = root.findall("shape")
    if len(scene.shapes()) != len(elements):
        raise Unknown("shapes that are made of others")
    if any(x.get("type") not in ("envmap", "area") for x in root.findall("emitter")):
        raise Unknown("an emitter that is neither an area nor an environment")
    materials = {x.get("id"): material(x, folder) for x in root.findall("bsdf")}
    shapes = []
    for number, (shape, element) in enumerate(zip(scene.shapes(), elements)):
        inner, name = element.find("bsdf"), str(number)
        if inner is not None:
            materials[name] = material(inner, folder)
        else:
            name = element.find("ref").get("id")
        shapes.append({"material": name, "radiance": shape_of(number, shape, element, arrays)})
    return {"camera": camera(scene.sensors()[0]), "shapes": shapes, "materials": materials,
            "environment": environment(scene, root, folder), "max_depth": bounces(root)}


def main():
    mitsuba_plugins.register()
    path, arrays = pathlib.Path(sys.argv[1]).resolve(), {}
    try:
        scene = describe(path, arrays)
    except Unknown as unknown:
        scene = {"reason": f"it has {unknown}"}
    np.savez(sys.argv[2], scene=json.dumps(scene), **arrays)


if __name__ == "__main__":
    main()
