#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes a scene in Blender, without a window, and writes it as the Mitsuba add-on writes scenes.

    tests/image/export_blender.py FOLDER       needs `pip install bpy mitsuba`

FOLDER gets scene.xml, meshes/*.ply. The names, parameters and units are those of the add-on's
exporter (4.x): meshes as PLY through Mitsuba's own Blender reader, one per material; cameras and
lights turned from Blender's axes; lights in watts; a principled BRDF in twosided; instances of a
shapegroup. Mitsuba's own writer makes the file.
"""
import math
import pathlib
import sys

import bpy  # first: it brings its own libraries
import mathutils
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
Y_UP = mathutils.Matrix.Rotation(-math.pi / 2, 4, "X")  # Blender's z is up


def transform(matrix):
    rows = [list(row) for row in Y_UP @ matrix]
    return mi.ScalarTransform4f(mi.ScalarMatrix4f(rows))


def rgb(values):
    return {"type": "rgb", "value": [float(v) for v in values]}


def mesh(folder, thing, matrix):
    """Writes an object's mesh and returns its shape."""
    data = thing.data
    data.calc_loop_triangles()
    points = np.array([v.co for v in data.vertices], dtype=np.float32)
    normals = np.array([v.normal for v in data.vertices], dtype=np.float32)
    corners = np.array([t.vertices for t in data.loop_triangles], dtype=np.uint32)
    smooth = all(p.use_smooth for p in data.polygons)
    out = mi.Mesh(thing.name, len(points), len(corners), has_vertex_normals=smooth)
    params = mi.traverse(out)
    params["vertex_positions"] = points.ravel()
    params["faces"] = corners.ravel()
    if smooth:
        params["vertex_normals"] = normals.ravel()
    params.update()
    (folder / "meshes").mkdir(exist_ok=True)
    name = f"meshes/{thing.name.replace('.', '_')}.ply"
    out.write_ply(str(folder / name))
    shape = {"type": "ply", "filename": name, "bsdf": {"type": "ref", "id": f"mat-{thing.name}"}}
    if matrix is not None:
        shape["to_world"] = transform(matrix)
    if not smooth:
        shape["face_normals"] = True
    return shape


def principled(color, roughness, metallic):
    return {"type": "twosided", "bsdf": {
        "type": "principled", "base_color": rgb(color), "spec_tint": 0.0, "spec_trans": 0.0,
        "metallic": metallic, "anisotropic": 0.0, "roughness": roughness, "sheen": 0.0,
        "sheen_tint": 0.0, "clearcoat": 0.0, "clearcoat_gloss": 0.0, "specular": 0.5}}


def camera(thing, size):
    turn = mathutils.Matrix.Rotation(math.pi, 4, "Y")
    return {"type": "perspective", "fov_axis": "x", "fov": math.degrees(thing.data.angle_x),
            "principal_point_offset_x": thing.data.shift_x,
            "principal_point_offset_y": -thing.data.shift_y,
            "near_clip": thing.data.clip_start, "far_clip": thing.data.clip_end,
            "to_world": transform(thing.matrix_world @ turn),
            "sampler": {"type": "independent", "sample_count": 64},
            "film": {"type": "hdrfilm", "width": size, "height": size, "pixel_format": "rgb",
                     "rfilter": {"type": "box"}}}


def lights():
    """A square lamp, as an area light over a null BRDF, and a spot."""
    place = mathutils.Matrix.Translation((1, -1, 4)) @ mathutils.Matrix.Scale(0.75, 4)
    yield "emit-Area", {"type": "rectangle", "flip_normals": True, "to_world": transform(place),
                        "emitter": {"type": "area", "radiance": rgb((9, 8, 7))},
                        "bsdf": {"type": "null"}}
    place = mathutils.Matrix.Translation((-3, -2, 4)) @ mathutils.Euler((0.5, -0.6, 0)).to_matrix(
    ).to_4x4() @ mathutils.Matrix.Rotation(math.pi, 4, "X")
    yield "emit-Spot", {"type": "spot", "intensity": rgb((30, 35, 40)), "cutoff_angle": 25.0,
                        "beam_width": 20.0, "to_world": transform(place)}


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(exist_ok=True)
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    eye = bpy.data.objects["Camera"]
    bpy.ops.mesh.primitive_monkey_add(location=(0, 0, 1))
    monkey = bpy.context.object
    bpy.ops.object.shade_smooth()
    bpy.context.view_layer.update()
    cube = bpy.data.objects["Cube"]
    scene = {"type": "scene", "integrator": {"type": "path", "max_depth": 8},
             f"mat-{monkey.name}": principled((0.8, 0.4, 0.2), 0.4, 0.0),
             f"mat-{cube.name}": principled((0.5, 0.6, 0.8), 0.3, 1.0),
             "floor": {"type": "rectangle",
                       "bsdf": {"type": "twosided", "bsdf": {"type": "diffuse"}},
                       "to_world": transform(mathutils.Matrix.Scale(6, 4))},
             "camera": camera(eye, 64),
             "world": {"type": "constant", "radiance": rgb((0.05, 0.05, 0.05))}}
    scene |= dict(lights())
    scene["mesh-Suzanne"] = mesh(folder, monkey, monkey.matrix_world)
    scene["group"] = {"type": "shapegroup", "Cube": mesh(folder, cube, None)}
    for i in range(4):
        place = mathutils.Matrix.Translation((2.5 - 1.7 * i, 2, 0.3)) @ mathutils.Matrix.Rotation(
            0.4 * i, 4, "Z") @ mathutils.Matrix.Scale(0.3, 4)
        scene[f"instance-{i}"] = {"type": "instance", "shape": {"type": "ref", "id": "group"},
                                  "to_world": transform(place)}
    config = mi.parser.ParserConfig("scalar_rgb")
    mi.parser.write_file(mi.parser.parse_dict(config, scene), str(folder / "scene.xml"))


if __name__ == "__main__":
    main()
