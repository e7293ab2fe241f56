# SPDX-License-Identifier: Apache-2.0
"""A scene made in Blender, without a window, of what people build: meshes with several materials,
textures over UV maps, normal maps, vertex colours, glass, blends, instances of a collection, lamps
of every kind, a sky, a shifted camera. For export_blender.py."""
import math

import bpy
import numpy as np


def image(name, pixels, data=False):
    """An image from values in [0, 1], rows from the top."""
    rows, columns, _ = pixels.shape
    out = bpy.data.images.new(name, columns, rows, float_buffer=name.endswith("exr"),
                              is_data=data)
    alpha = np.ones((rows, columns, 1))
    out.pixels = np.concatenate([pixels, alpha], axis=2)[::-1].ravel().astype(float)
    out.file_format = "OPEN_EXR" if name.endswith("exr") else "PNG"
    return out


def waves(size, *frequency):
    x, y = np.meshgrid(np.linspace(0, 1, size, False), np.linspace(0, 1, size, False))
    return np.stack([0.5 + 0.4 * np.sin(2 * np.pi * (a * x + b * y)) for a, b in frequency], axis=2)


def bumps(size):
    x, y = np.meshgrid(np.linspace(0, 1, size, False), np.linspace(0, 1, size, False))
    n = np.stack([0.35 * np.cos(16 * np.pi * x), 0.35 * np.sin(12 * np.pi * y), np.ones_like(x)], 2)
    return 0.5 + 0.5 * n / np.linalg.norm(n, axis=2, keepdims=True)


class Material:
    """A material of one shader, whose inputs are numbers, colours or other nodes."""

    def __init__(self, name, shader="ShaderNodeBsdfPrincipled", **inputs):
        self.made = bpy.data.materials.new(name)
        self.made.use_nodes = True
        self.tree = self.made.node_tree
        self.tree.nodes.remove(self.tree.nodes["Principled BSDF"])
        self.node = self.add(shader, **inputs)
        self.tree.links.new(self.node.outputs[0],
                            self.tree.nodes["Material Output"].inputs["Surface"])

    def add(self, kind, **inputs):
        node = self.tree.nodes.new(kind)
        for name, value in inputs.items():
            socket = node.inputs[name.replace("_", " ")]
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            else:
                socket.default_value = (*value, 1) if isinstance(value, tuple) else value
        return node

    def connect(self, name, socket):
        self.tree.links.new(socket, self.node.inputs[name])
        return self

    def texture(self, what, scale=None):
        node = self.add("ShaderNodeTexImage")
        node.image = what
        if scale:
            where = self.add("ShaderNodeMapping",
                             Vector=self.add("ShaderNodeUVMap").outputs[0])
            where.inputs["Scale"].default_value = scale
            self.tree.links.new(where.outputs[0], node.inputs["Vector"])
        return node.outputs["Color"]


def thing(name, where, *materials, smooth=False, scale=1.0):
    """The object that an operator has just added."""
    made = bpy.context.object
    made.name, made.location, made.scale = name, where, [scale] * 3
    for material in materials:
        made.data.materials.append(material.made)
    if smooth:
        bpy.ops.object.shade_smooth()
    return made


def add_things():
    floor = Material("floor", Roughness=0.6)
    floor.connect("Base Color", floor.texture(
        image("tiles.png", waves(64, (4, 0), (0, 4), (3, 3))), (2, 2, 1)))
    bpy.ops.mesh.primitive_plane_add(size=8)
    thing("Floor", (0, 0, 0), floor)
    wall = Material("wall", Roughness=0.5, Base_Color=(0.5, 0.55, 0.6))
    normal = wall.add("ShaderNodeNormalMap", Color=wall.texture(image("normal.png", bumps(64),
                                                                      True)))
    wall.connect("Normal", normal.outputs[0])
    bpy.ops.mesh.primitive_plane_add(size=6, rotation=(math.pi / 2, 0, 0))
    thing("Wall", (0, 3, 2), wall)
    bpy.ops.mesh.primitive_monkey_add(rotation=(-0.5, 0, 0.4))
    thing("Suzanne", (0, 0.3, 0.9), Material("clay", Base_Color=(0.8, 0.35, 0.2), Roughness=0.4,
                                             Coat_Weight=0.5, Sheen_Weight=0.3), smooth=True)
    bpy.ops.mesh.primitive_cube_add(rotation=(0, 0, 0.6))
    painted = Material("painted", Roughness=0.7)
    colours = painted.add("ShaderNodeVertexColor")
    colours.layer_name = "Col"
    painted.connect("Base Color", colours.outputs[0])
    cube = thing("Cube", (-2.2, 1.2, 0.6), Material("steel", Base_Color=(0.7, 0.7, 0.75),
                                                    Metallic=1.0, Roughness=0.3), painted,
                 scale=0.6)
    for face in cube.data.polygons:
        face.material_index = face.index % 2
    layer = cube.data.color_attributes.new("Col", "BYTE_COLOR", "CORNER")
    for i, corner in enumerate(layer.data):
        corner.color = (0.2 + 0.7 * (i % 2), 0.3 + 0.5 * (i % 3 == 0), 0.4, 1)
    ring = Material("ring", Base_Color=(0.9, 0.7, 0.3), Metallic=1.0)
    ring.connect("Roughness", ring.texture(image("rough.png", np.repeat(
        waves(64, (6, 2)), 3, axis=2), True)))
    bpy.ops.mesh.primitive_torus_add(major_radius=0.6, minor_radius=0.22)
    thing("Ring", (1.9, -0.4, 0.24), ring, smooth=True)
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5)
    thing("Glass", (-1.3, -1.1, 0.5), Material("glass", "ShaderNodeBsdfGlass", IOR=1.45,
                                               Roughness=0.0), smooth=True)
    bpy.ops.mesh.primitive_ico_sphere_add(radius=0.2)
    thing("Bulb", (2.4, 1.6, 0.5), Material("bulb", "ShaderNodeEmission", Color=(1, 0.7, 0.4),
                                            Strength=12.0))
    mixed = Material("mixed", "ShaderNodeMixShader", Fac=0.4)
    parts = (mixed.add("ShaderNodeBsdfDiffuse", Color=(0.2, 0.5, 0.3)),
             mixed.add("ShaderNodeBsdfGlossy", Color=(0.9, 0.9, 0.9), Roughness=0.5))
    for socket, part in zip(mixed.node.inputs[1:], parts):
        mixed.tree.links.new(part.outputs[0], socket)
    bpy.ops.mesh.primitive_cone_add(radius1=0.5, depth=1.2)
    thing("Cone", (1.2, 1.7, 0.6), mixed)


def add_instances():
    group = bpy.data.collections.new("Studs")
    bpy.ops.mesh.primitive_ico_sphere_add(radius=0.18)
    stud = thing("Stud", (0, 0, 0.18), Material("stud", Base_Color=(0.3, 0.4, 0.8)))
    bpy.context.collection.objects.unlink(stud)
    group.objects.link(stud)
    for i in range(5):
        instance = bpy.data.objects.new(f"Instance {i}", None)
        instance.instance_type, instance.instance_collection = "COLLECTION", group
        instance.location, instance.rotation_euler = (-1.8 + 0.9 * i, -2, 0), (0, 0, 0.5 * i)
        bpy.context.collection.objects.link(instance)


def add_light(kind, energy, colour, where, rotation, **more):
    light = bpy.data.lights.new(kind.title(), kind)
    light.energy, light.color = energy, colour
    for name, value in more.items():
        setattr(light, name, value)
    made = bpy.data.objects.new(light.name, light)
    made.location, made.rotation_euler = where, rotation
    bpy.context.collection.objects.link(made)


def add_lights():
    add_light("AREA", 120, (1, 0.95, 0.9), (1.5, -1.5, 4), (0.3, 0.3, 0), shape="RECTANGLE",
              size=1.5, size_y=0.8)
    add_light("POINT", 40, (0.6, 0.7, 1), (-3, -2, 2.5), (0, 0, 0))
    add_light("SUN", 0.4, (1, 0.9, 0.8), (0, 0, 5), (0.7, 0.2, 0))
    add_light("SPOT", 150, (1, 1, 1), (-2.5, -1, 4), (0.4, -0.5, 0), spot_size=0.9, spot_blend=0.3)
    world = bpy.context.scene.world
    world.use_nodes = True
    sky = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    up = np.linspace(1, 0, 32)[:, None, None] * np.ones((32, 64, 3))
    sky.image = image("sky.exr", 0.05 + up * waves(64, (1, 0), (0, 1), (1, 1))[::2] * 0.3)
    world.node_tree.links.new(sky.outputs[0], world.node_tree.nodes["Background"].inputs[0])


def make(width, height):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("World")
    scene.render.resolution_x, scene.render.resolution_y = width, height
    add_things()
    add_instances()
    add_lights()
    camera = bpy.data.cameras.new("Camera")
    camera.lens, camera.shift_x, camera.shift_y = 40, 0.05, -0.08
    eye = bpy.data.objects.new("Camera", camera)
    eye.location, eye.rotation_euler = (0.6, -8, 3.2), (1.25, 0, 0.06)
    scene.collection.objects.link(eye)
    scene.camera = eye
    bpy.context.view_layer.update()
