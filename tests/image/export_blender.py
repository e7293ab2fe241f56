#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes a scene in Blender, without a window, and writes it as the Mitsuba add-on writes scenes.

    tests/image/export_blender.py FOLDER [WIDTH HEIGHT]      needs `pip install bpy mitsuba`

FOLDER gets scene.xml, meshes/*.ply, textures/*. The scene is blender_scene.py's. The names,
parameters and units are those of the add-on's exporter (4.x): meshes as PLY through Mitsuba's own
reader of Blender's memory, one per material; cameras and lights rotated from Blender's axes; lights
in watts; a principled BRDF in twosided; instances of a shapegroup. Mitsuba's own writer makes the
file.
"""
import math
import pathlib
import sys

import bpy  # first: it brings its own libraries
import mathutils
import mitsuba as mi

import blender_scene

mi.set_variant("scalar_rgb")
Y_UP = mathutils.Matrix.Rotation(-math.pi / 2, 4, "X")  # Blender's z is up
BACK = mathutils.Matrix.Rotation(math.pi, 4, "X")
SLOTS = {"spec_tint": "Specular Tint", "metallic": "Metallic", "anisotropic": "Anisotropic",
         "roughness": "Roughness", "sheen": "Sheen Weight", "sheen_tint": "Sheen Tint",
         "clearcoat": "Coat Weight", "clearcoat_gloss": "Coat Roughness"}


def transform(matrix):
    return mi.ScalarTransform4f(mi.ScalarMatrix4f([list(row) for row in Y_UP @ matrix]))


def rgb(values, factor=1.0):
    return {"type": "rgb", "value": [float(v) * factor for v in values[:3]]}


class Exporter:
    def __init__(self, folder):
        self.folder, self.scene = folder, {"type": "scene"}
        self.emitters = {}  # of materials
        self.graph = bpy.context.evaluated_depsgraph_get()

    # ---- Textures and materials -----------------------------------------------------------------

    def file(self, image):
        (self.folder / "textures").mkdir(exist_ok=True)
        image.save(filepath=str(self.folder / "textures" / image.name))
        return f"textures/{image.name}"

    def texture(self, node):
        out = {"type": "bitmap", "filename": self.file(node.image)}
        if node.inputs["Vector"].is_linked:
            where = node.inputs["Vector"].links[0].from_node
            out["to_uv"] = mi.ScalarTransform4f().scale(list(where.inputs["Scale"].default_value))
        if node.image.colorspace_settings.name == "Non-Color":
            out["raw"] = True
        return out

    def value(self, socket):
        if not socket.is_linked:
            value = socket.default_value
            return rgb(value) if socket.type == "RGBA" else float(value)
        node = socket.links[0].from_node
        if node.type == "VERTEX_COLOR":
            return {"type": "mesh_attribute", "name": f"vertex_{node.layer_name}"}
        return self.texture(node)

    def principled(self, node):
        out = {"type": "principled", "base_color": self.value(node.inputs["Base Color"])}
        out |= {name: self.value(node.inputs[socket]) for name, socket in SLOTS.items()}
        out["specular"] = max(self.value(node.inputs["Specular IOR Level"]), 1 + 1e-3)
        normal = node.inputs["Normal"]
        if normal.is_linked:
            image = normal.links[0].from_node.inputs["Color"].links[0].from_node
            out = {"type": "normalmap", "normalmap": self.texture(image) | {"raw": True},
                   "bsdf": out}
        return {"type": "twosided", "bsdf": out}

    def shader(self, node):
        """The dictionary of a BRDF, or of what emits."""
        colour = node.inputs.get("Color")
        if node.type == "BSDF_PRINCIPLED":
            return self.principled(node)
        if node.type == "BSDF_GLASS":
            return {"type": "dielectric", "int_ior": self.value(node.inputs["IOR"]),
                    "specular_transmittance": self.value(colour)}
        if node.type == "EMISSION":
            return {"type": "area", "radiance": rgb(colour.default_value,
                                                    node.inputs["Strength"].default_value)}
        if node.type == "MIX_SHADER":
            parts = [self.shader(s.links[0].from_node) for s in node.inputs[1:]]
            return {"type": "blendbsdf", "weight": self.value(node.inputs["Fac"]),
                    "bsdf1": parts[0], "bsdf2": parts[1]}
        if node.type == "BSDF_GLOSSY":
            return {"type": "twosided", "bsdf": {
                "type": "roughconductor", "alpha": self.value(node.inputs["Roughness"]) ** 2,
                "distribution": "ggx", "specular_reflectance": self.value(colour)}}
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": self.value(colour)}}

    def add_material(self, material):
        name = f"mat-{material.name}"
        if name in self.scene or name in self.emitters:
            return
        output = material.node_tree.nodes["Material Output"].inputs["Surface"]
        made = self.shader(output.links[0].from_node)
        if made["type"] == "area":
            self.emitters[name] = made
            made = {"type": "diffuse", "reflectance": rgb((0, 0, 0))}
        self.scene[name] = made

    # ---- Shapes ---------------------------------------------------------------------------------

    def mesh(self, data, name, number, matrix):
        """The faces of one material, by Mitsuba's reader of Blender's memory."""
        def pointer(attribute):
            return data.attributes[attribute].data[0].as_pointer()

        data.calc_loop_triangles()
        props = {"type": "blender", "version": ".".join(map(str, bpy.app.version)), "name": name,
                 "loop_tri_count": len(data.loop_triangles), "vert_count": len(data.vertices),
                 "loop_tris": data.loop_triangles[0].as_pointer(), "loops": pointer(".corner_vert"),
                 "polys": data.loop_triangle_polygons[0].as_pointer(),
                 "verts": pointer("position"), "normals": data.vertex_normals[0].as_pointer(),
                 "mat_nr": number, "mat_indices": 0}
        for key, attribute in (("sharp_face", "sharp_face"), ("mat_indices", "material_index")):
            if attribute in data.attributes:
                props[key] = pointer(attribute)
        if data.uv_layers:
            props["uvs"] = pointer(data.uv_layers.active.name)
        for layer in data.color_attributes:
            props[f"vertex_{layer.name}"] = pointer(layer.name)
        if matrix:
            props["to_world"] = transform(matrix)
        return mi.load_dict(props)

    def parts(self, thing, matrix):
        """One shape for each of an object's materials."""
        (self.folder / "meshes").mkdir(exist_ok=True)
        for number, material in enumerate(thing.data.materials):
            self.add_material(material)
            name = f"{thing.name}-{material.name}".replace(".", "_")
            made = self.mesh(thing.data, name, number, matrix)
            made.write_ply(str(self.folder / "meshes" / f"{name}.ply"))
            shape = {"type": "ply", "filename": f"meshes/{name}.ply",
                     "bsdf": {"type": "ref", "id": f"mat-{material.name}"}}
            if not made.has_vertex_normals():
                shape["face_normals"] = True
            if f"mat-{material.name}" in self.emitters:
                shape["emitter"] = self.emitters[f"mat-{material.name}"]
            yield name, shape

    def add_object(self, instance, thing):
        group = f"group-{thing.name}"
        if not instance.is_instance:
            self.scene |= dict(self.parts(thing, thing.matrix_world))
            return
        if group not in self.scene:
            made = {"type": "shapegroup"} | dict(self.parts(thing, None))
            self.scene[group] = made
        self.scene[f"instance-{len(self.scene)}"] = {
            "type": "instance", "shape": {"type": "ref", "id": group},
            "to_world": transform(instance.matrix_world)}

    # ---- Lights and camera ----------------------------------------------------------------------

    def light(self, thing):
        data, matrix = thing.data, thing.matrix_world
        if data.type == "POINT":
            return {"type": "point", "position": list((Y_UP @ matrix).translation),
                    "intensity": rgb(data.color, data.energy / (4 * math.pi))}
        if data.type == "SUN":
            return {"type": "directional", "irradiance": rgb(data.color, data.energy),
                    "to_world": transform(matrix @ BACK)}
        if data.type == "SPOT":
            half, blend = data.spot_size / 2, data.spot_blend
            inner = math.acos(blend + (1 - blend) * math.cos(half))
            return {"type": "spot", "intensity": rgb(data.color, data.energy / (4 * math.pi)),
                    "cutoff_angle": math.degrees(half), "beam_width": math.degrees(inner),
                    "to_world": transform(matrix @ BACK)}
        size = mathutils.Matrix.Diagonal((data.size / 2, data.size_y / 2, 0.5, 1))
        power = data.energy / (data.size * data.size_y * math.pi)
        return {"type": "rectangle", "flip_normals": True, "to_world": transform(matrix @ size),
                "emitter": {"type": "area", "radiance": rgb(data.color, power)},
                "bsdf": {"type": "null"}}

    def world(self):
        node = bpy.context.scene.world.node_tree.nodes["Background"]
        image = node.inputs["Color"].links[0].from_node.image
        axes = mathutils.Matrix(((0, 0, 1, 0), (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 0, 1)))
        return {"type": "envmap", "filename": self.file(image),
                "scale": node.inputs["Strength"].default_value, "to_world": transform(axes)}

    def camera(self, thing):
        data, render = thing.data, bpy.context.scene.render
        width, height = render.resolution_x, render.resolution_y
        flip = mathutils.Matrix.Rotation(math.pi, 4, "Y")
        return {"type": "perspective", "fov_axis": "x" if width >= height else "y",
                "fov": math.degrees(data.angle_x),
                "principal_point_offset_x": data.shift_x / width * max(width, height),
                "principal_point_offset_y": -data.shift_y / height * max(width, height),
                "near_clip": data.clip_start, "far_clip": data.clip_end,
                "to_world": transform(thing.matrix_world @ flip),
                "sampler": {"type": "independent", "sample_count": 64},
                "film": {"type": "hdrfilm", "width": width, "height": height,
                         "pixel_format": "rgb", "rfilter": {"type": "box"}}}

    def run(self):
        self.scene["integrator"] = {"type": "path", "max_depth": 12}
        self.scene["world"] = self.world()
        for instance in self.graph.object_instances:
            thing = instance.object
            if thing.type == "MESH":
                self.add_object(instance, thing)
            elif thing.type == "LIGHT":
                self.scene[f"emit-{thing.name}"] = self.light(thing)
            elif thing.type == "CAMERA":
                self.scene["camera"] = self.camera(thing)
        config = mi.parser.ParserConfig("scalar_rgb")
        mi.parser.write_file(mi.parser.parse_dict(config, self.scene),
                             str(self.folder / "scene.xml"))


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(exist_ok=True)
    blender_scene.make(*map(int, sys.argv[2:4] or ("96", "64")))
    Exporter(folder).run()


if __name__ == "__main__":
    main()
