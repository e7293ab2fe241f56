#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders what export_scene.py wrote with Cycles (worker.py has the arguments).

Phong is not among the BRDFs of Cycles: a scene that has it is left out. Plastic is Blender's
Principled BSDF, whose diffuse lobe has the albedo that Mitsuba's has. Cycles clamps no light and
filters no glossy lobe, so that its images converge. Needs `pip install bpy`.
"""
import json
import os
import sys

import bpy
import numpy as np
import OpenEXR

import worker

BOUNCES = 64  # where the scene has no limit
PLASTIC_DIFFUSE_FRESNEL = 0.596  # inner diffuse reflectance of an IOR of 1.5
PASSES = {"color": "Combined", "albedo": "Denoising Albedo", "normal": "Denoising Normal"}


class Shader:
    """Nodes of one material."""

    def __init__(self, tree):
        self.tree, self.images = tree, bpy.data.images
        tree.nodes.clear()

    def node(self, kind, modes=(), **inputs):
        """A node; inputs by their names, or _0, _1 and so on."""
        node = self.tree.nodes.new("ShaderNode" + kind)
        for name, given in modes:
            setattr(node, name, given)
        for name, given in inputs.items():
            socket = node.inputs[int(name[1:]) if name[1:].isdigit() else name.replace("_", " ")]
            if isinstance(given, bpy.types.NodeSocket):
                self.tree.links.new(given, socket)
            elif given is not None:
                default = [*given, 1.0] if socket.type == "RGBA" and len(given) == 3 else given
                socket.default_value = default
        return node

    def color(self, given, data=False):
        """A socket or the numbers of a texture."""
        if not isinstance(given, dict):
            return given
        if "checkers" in given:
            x, y = given["scale"]  # of squares in pairs
            at = self.node("Mapping", Vector=self.node("TexCoord").outputs["UV"],
                           Scale=(2 * x, 2 * y, 1))
            one, two = given["checkers"]
            return self.node("TexChecker", Vector=at.outputs[0], Color1=one, Color2=two,
                             Scale=1.0).outputs[0]
        node = self.node("TexImage")
        node.image = self.images.load(given["file"], check_existing=True)
        if data:
            node.image.colorspace_settings.name = "Non-Color"
        return node.outputs["Color"]

    def mix(self, fraction, one, other):
        return self.node("MixShader", _0=fraction, _1=one, _2=other).outputs[0]

    def vector(self, operation, a, b):
        return self.node("VectorMath", [("operation", operation)], _0=a, _1=b).outputs[0]

    def plastic_albedo(self, given, nonlinear):
        """The albedo of the diffuse lobe, which is reflected at the coat's inner side."""
        if not nonlinear:
            return self.color(given)
        f = PLASTIC_DIFFUSE_FRESNEL
        color = self.color(given)
        above = self.vector("MULTIPLY", color, (1 - f,) * 3)
        below = self.vector("SUBTRACT", (1, 1, 1), self.vector("MULTIPLY", color, (f,) * 3))
        return self.vector("DIVIDE", above, below)

    def metal(self, m):
        roughness = m.get("alpha", 0.1) ** 0.5 if m["type"] == "roughconductor" else 0.0
        tint = m.get("specular_reflectance", [1, 1, 1])
        if m.get("material") == "none":
            return self.node("BsdfAnisotropic", [("distribution", "GGX")], Color=self.color(tint),
                             Roughness=roughness).outputs[0]
        kind = "GGX" if m.get("distribution") == "ggx" else "BECKMANN"
        node = self.node("BsdfMetallic", [("fresnel_type", "PHYSICAL_CONDUCTOR"),
                                          ("distribution", kind)],
                         Roughness=roughness, IOR=m["eta"], Extinction=m["k"])
        fraction = self.color(tint)  # a texture of greys, or greys
        if not isinstance(fraction, bpy.types.NodeSocket):
            fraction = sum(fraction) / 3
        return self.mix(fraction, None, node.outputs[0])

    def surface(self, m):
        kind = m["type"]
        if kind == "diffuse":
            return self.node("BsdfDiffuse", Color=self.color(m.get("reflectance", [0.5] * 3)),
                             Roughness=0.0).outputs[0]
        if kind in ("conductor", "roughconductor"):
            return self.metal(m)
        if kind == "dielectric":
            ior = m.get("int_ior", 1.5046) / m.get("ext_ior", 1.000277)
            return self.node("BsdfGlass", Color=(1, 1, 1), Roughness=0.0, IOR=ior).outputs[0]
        albedo = self.plastic_albedo(m.get("diffuse_reflectance", [0.5] * 3),
                                     m.get("nonlinear") == "true")
        roughness = m.get("alpha", 0.1) ** 0.5 if kind == "roughplastic" else 0.0
        return self.node("BsdfPrincipled", Base_Color=albedo, Roughness=roughness,
                         IOR=m.get("int_ior", 1.5)).outputs[0]

    def material(self, m, radiance):
        out = self.surface(m)
        if radiance:  # from the front alone
            back = self.node("NewGeometry").outputs["Backfacing"]
            light = self.node("Emission", Color=[c / max(radiance) for c in radiance],
                              Strength=max(radiance)).outputs[0]
            out = self.node("AddShader", _0=out, _1=self.mix(back, light, None)).outputs[0]
        if "opacity" in m:
            opacity = self.color(m["opacity"], data=True)
            out = self.mix(opacity, self.node("BsdfTransparent").outputs[0], out)
        self.node("OutputMaterial", Surface=out)

    def sky(self, environment):
        """Mitsuba's environment: its y is up, and Blender's z."""
        matrix = np.linalg.inv(np.array(environment["to_world"])[:3, :3])
        direction = self.node("TexCoord").outputs["Generated"]
        parts = []
        for row in matrix[[2, 0, 1]]:
            dot = self.node("VectorMath", [("operation", "DOT_PRODUCT")], _0=direction,
                            _1=tuple(row))
            parts.append(dot.outputs["Value"])
        vector = self.node("CombineXYZ", _0=parts[0], _1=parts[1], _2=parts[2]).outputs[0]
        node = self.node("TexEnvironment", Vector=vector)
        node.image = self.images.load(environment["file"])
        light = self.node("Background", Color=node.outputs[0], Strength=environment["scale"])
        self.node("OutputWorld", Surface=light.outputs[0])


def add_shape(arrays, number, material):
    mesh = bpy.data.meshes.new(str(number))
    faces = arrays[f"{number}.faces"]
    mesh.from_pydata(arrays[f"{number}.vertices"].tolist(), [], faces.tolist())
    if f"{number}.uv" in arrays:
        uv = arrays[f"{number}.uv"][faces.reshape(-1)]
        mesh.uv_layers.new().data.foreach_set("uv", uv.astype(np.float32).reshape(-1))
    if f"{number}.normals" in arrays:
        mesh.shade_smooth()
        mesh.normals_split_custom_set_from_vertices(arrays[f"{number}.normals"].tolist())
    mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(str(number), mesh))


def add_camera(camera):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "HORIZONTAL", np.radians(camera["x_fov"])
    data.clip_start, data.clip_end = 1e-3, 1e4
    item = bpy.data.objects.new("camera", data)
    matrix = np.array(camera["to_world"]) @ np.diag([-1.0, 1.0, -1.0, 1.0])
    item.matrix_world = matrix.T.tolist()  # of columns
    bpy.context.scene.collection.objects.link(item)
    bpy.context.scene.camera = item


def build(found, arrays):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    made = {}
    for number, shape in enumerate(found["shapes"]):
        key = (shape["material"], tuple(shape["radiance"] or ()))
        if key not in made:
            made[key] = bpy.data.materials.new(str(len(made)))
            made[key].use_nodes = True
            made[key].cycles.emission_sampling = "FRONT"
            Shader(made[key].node_tree).material(
                found["materials"][shape["material"]], shape["radiance"])
        add_shape(arrays, number, made[key])
    add_camera(found["camera"])
    if found["environment"]:
        world = bpy.data.worlds.new("world")
        world.use_nodes = True
        Shader(world.node_tree).sky(found["environment"])
        bpy.context.scene.world = world


def settings(found, cpu):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = found["camera"]["width"]
    scene.render.resolution_y = found["camera"]["height"]
    scene.render.resolution_percentage = 100
    if cpu:
        scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.use_exr_interleave = True  # all passes in one part
    cycles = scene.cycles
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    bounces = found["max_depth"] - 1 if found["max_depth"] > 0 else BOUNCES
    for name in ("max", "diffuse", "glossy", "transmission", "transparent_max"):
        setattr(cycles, name + "_bounces", bounces)
    scene.view_layers[0].cycles.denoising_store_passes = True


def render(found, out, spp, seed):
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed = spp, seed
    scene.render.filepath = out + ".exr"
    bpy.ops.render.render(write_still=True)
    pixels = OpenEXR.File(out + ".exr", separate_channels=True).channels()
    os.remove(out + ".exr")
    layer = next(name.split(".")[0] for name in pixels if name.endswith(".Combined.R"))
    shape = (found["camera"]["height"], found["camera"]["width"], 3)
    return {name: np.ascontiguousarray(np.stack(
        [pixels[f"{layer}.{label}.{c}"].pixels for c in ("XYZ" if name == "normal" else "RGB")],
        axis=-1).reshape(shape)) for name, label in PASSES.items()}


def main():
    options = worker.arguments(__doc__)
    with np.load(os.path.join(os.path.dirname(options.scene), "scene.npz")) as arrays:
        arrays = dict(arrays)
    found = json.loads(str(arrays.pop("scene")))
    phong = any(m["type"] == "phong" for m in found.get("materials", {}).values())
    if "reason" in found or phong:
        with open(options.out + ".json", "w", encoding="utf-8") as file:
            json.dump({"reason": found.get("reason", "Cycles has no Phong")}, file)
        return
    sys.stdout.flush()
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # Blender reports each render

    def whole(spp, seed):
        build(found, arrays)
        settings(found, options.cpu)
        return render(found, options.out, spp, seed)

    worker.calibrate(options, whole)


if __name__ == "__main__":
    main()
