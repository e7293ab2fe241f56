# SPDX-License-Identifier: Apache-2.0
"""Rows of matrix.py: shapes, emitters, cameras, colours, the language."""
import struct
import zlib

FLOOR = """<shape type="rectangle">
  <transform name="to_world"><scale value="6"/><rotate x="1" angle="-90"/></transform>
  <bsdf type="diffuse"><rgb name="reflectance" value="0.5, 0.45, 0.4"/></bsdf>
</shape>
"""
SKY = '<emitter type="constant"><rgb name="radiance" value="0.6, 0.7, 0.8"/></emitter>\n'
LAMP = """<shape type="rectangle">
  <transform name="to_world"><scale value="0.7"/><rotate x="1" angle="90"/>
    <translate x="1.5" y="4"/></transform>
  <emitter type="area"><rgb name="radiance" value="12, 10, 8"/></emitter>
</shape>
"""
LIT = FLOOR + SKY + LAMP
BALL = """<shape type="sphere"><point name="center" x="0" y="1" z="0"/>
  <bsdf type="diffuse"><rgb name="reflectance" value="0.2, 0.5, 0.7"/></bsdf></shape>
"""
TWOSIDED = """<bsdf type="twosided"><bsdf type="diffuse">
  <rgb name="reflectance" value="0.7, 0.4, 0.2"/></bsdf></bsdf>
"""
CHECKS = """<texture type="checkerboard" name="{}"><rgb name="color0" value="0.9, 0.2, 0.1"/>
  <rgb name="color1" value="0.1, 0.3, 0.8"/>
  <transform name="to_uv"><scale x="6" y="4"/></transform></texture>
"""
VOLPATH = '<integrator type="volpath"/>\n'
CHECKS_OPACITY = '''<texture type="checkerboard" name="opacity">
  <float name="color0" value="0"/><float name="color1" value="0.8"/>
  <transform name="to_uv"><scale x="3" y="2"/></transform></texture>
'''


def shape(kind, *parts, bsdf=TWOSIDED):
    return f'<shape type="{kind}">{"".join(parts)}{bsdf}</shape>\n'


def to_world(*steps):
    return f'<transform name="to_world">{"".join(steps)}</transform>'


UP = '<translate y="1.1"/>'
TILT = '<rotate x="0.96" y="0.28" angle="-35"/>'


# ---- Files ---------------------------------------------------------------------------------------


def torus(rings=24, sides=12):
    """Points, normals, texture coordinates and quads of a torus around y."""
    from math import cos, pi, sin
    points, normals, uvs, quads = [], [], [], []
    for i in range(rings + 1):
        for j in range(sides + 1):
            a, b = 2 * pi * i / rings, 2 * pi * j / sides
            n = (cos(a) * cos(b), sin(b), sin(a) * cos(b))
            points.append((cos(a) + 0.4 * n[0], 0.4 * n[1], sin(a) + 0.4 * n[2]))
            normals.append(n)
            uvs.append((i / rings, j / sides))
    for i in range(rings):
        for j in range(sides):
            k = i * (sides + 1) + j
            quads.append((k, k + 1, k + sides + 2, k + sides + 1))
    return points, normals, uvs, quads


def write_obj(path, mesh):
    points, normals, uvs, quads = mesh
    lines = ["mtllib none.mtl", "o torus"]
    lines += ["v %g %g %g" % p for p in points]
    lines += ["vt %g %g" % t for t in uvs]
    lines += ["vn %g %g %g" % n for n in normals]
    for at, quad in enumerate(quads):
        if at % 100 == 0:
            lines += [f"g part{at}", f"usemtl m{at}"]
        lines.append("f " + " ".join(f"{k + 1}/{k + 1}/{k + 1}" for k in quad))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_ply(path, mesh, form, normals=True):
    points, vertex_normals, uvs, quads = mesh
    faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    head = ["ply", f"format {form} 1.0", f"element vertex {len(points)}"]
    head += [f"property float {c}" for c in ("x", "y", "z")]
    head += [f"property float {c}" for c in ("nx", "ny", "nz")] if normals else []
    head += [f"property float {c}" for c in ("u", "v", "r", "g", "b")]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    order = ">" if "big" in form else "<"
    body = []
    for p, n, t in zip(points, vertex_normals, uvs):
        row = [*p, *(n if normals else ()), *t, 0.5 + 0.4 * p[0] / 1.4, 0.3, 0.5 - 0.4 * p[2] / 1.4]
        body.append(" ".join("%.9g" % x for x in row).encode() + b"\n" if form == "ascii"
                    else struct.pack(f"{order}{len(row)}f", *row))
    for face in faces:
        body.append(b"3 %d %d %d\n" % face if form == "ascii"
                    else struct.pack(f"{order}B3i", 3, *face))
    path.write_bytes("\n".join(head).encode() + b"\n" + b"".join(body))


def write_painted_ply(path, mesh):
    """With attributes of vertices, in bytes and floats, and of faces."""
    points, normals, uvs, quads = mesh
    head = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    head += [f"property float {c}" for c in ("x", "y", "z", "nx", "ny", "nz", "u", "v")]
    head += [f"property uchar {c}" for c in ("red", "green", "blue")]
    head += ["property float part_x", f"element face {2 * len(quads)}"]
    head += ["property list uchar int vertex_indices"]
    head += [f"property float tint_{c}" for c in "rgb"] + ["end_header"]
    body = [" ".join("%.9g" % x for x in (*p, *n, *t)) + " %d %d %d %g" % (
        i % 200, 50 + 3 * i % 150, 200 - i % 200, i % 7 / 6)
            for i, (p, n, t) in enumerate(zip(points, normals, uvs))]
    for i, (a, b, c, d) in enumerate(quads):
        for face in ((a, b, c), (a, c, d)):
            body.append("3 %d %d %d %g %g %g" % (*face, i % 5 / 5, i % 3 / 3, 0.4))
    path.write_text("\n".join(head + body) + "\n", encoding="utf-8")


def write_serialized(path, mesh, version):
    points, normals, uvs, quads = mesh
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    data = struct.pack("<I", 1 | 2 | 0x1000)
    data += b"torus\0" if version == 4 else b""
    data += struct.pack("<QQ", len(points), len(triangles))
    for values in (points, normals, uvs):
        data += b"".join(struct.pack(f"<{len(v)}f", *v) for v in values)
    data += b"".join(struct.pack("<3I", *t) for t in triangles)
    one = struct.pack("<HH", 0x041C, version) + zlib.compress(data)
    form = "<QQI" if version == 4 else "<III"
    path.write_bytes(one + one + struct.pack(form, 0, len(one), 2))


def write_files(folder):
    import numpy as np
    import mitsuba as mi
    mesh = torus()
    write_obj(folder / "torus.obj", mesh)
    for form in ("ascii", "binary_little_endian", "binary_big_endian"):
        write_ply(folder / f"torus_{form}.ply", mesh, form)
    write_ply(folder / "plain.ply", torus(12, 8), "binary_little_endian", normals=False)
    write_painted_ply(folder / "painted.ply", mesh)
    write_serialized(folder / "torus3.serialized", mesh, 3)
    write_serialized(folder / "torus4.serialized", mesh, 4)
    rng = np.random.default_rng(1)
    small = rng.random((8, 16, 3)).astype(np.float32)
    mi.Bitmap((small * 255).astype(np.uint8)).write(str(folder / "noise.png"))
    y, x = np.mgrid[0:64, 0:128]
    sky = np.stack([0.3 + 0.2 * np.sin(x / 20), 0.4 + 0.3 * np.cos(y / 15), 0.5 + 0 * x], axis=2)
    sky[12:18, 30:38] = 30.0
    mi.Bitmap(sky.astype(np.float32)).write(str(folder / "sky.exr"))
    (folder / "slope.spd").write_text("# nm, value\n400 0.2\n500 0.5\n550 0.7\n700 0.9\n")
    (folder / "curve.txt").write_text("\n".join(
        ["-1.6 0.3 0 0.15", "-1 0.9 0.6 0.2", "-0.3 1.5 -0.5 0.25", "0.4 0.6 0.3 0.2",
         "1 1.6 0 0.3", "1.7 0.8 0.5 0.2", "", "-1 0.2 1 0.1", "0 0.5 1.2 0.2", "0.6 0.3 1 0.1",
         "1.4 0.9 1.4 0.15"]) + "\n")


# ---- Rows ----------------------------------------------------------------------------------------


def real(name, value):
    return f'<float name="{name}" value="{value}"/>'


def text(name, value):
    return f'<string name="{name}" value="{value}"/>'


def true(name):
    return f'<boolean name="{name}" value="true"/>'


def diffuse(texture=""):
    return f'<bsdf type="diffuse">{texture}</bsdf>'


def attribute(slot, name, scale=1):
    return (f'<texture type="mesh_attribute" name="{slot}">{text("name", name)}'
            f'{real("scale", scale)}</texture>')


def twosided(bsdf):
    return f'<bsdf type="twosided">{bsdf}</bsdf>'


def shapes():
    rotated, lift = to_world(TILT, UP), to_world('<scale value="0.9"/>', TILT, UP)
    flat = to_world('<scale x="1.2" y="0.8"/>', TILT, UP)
    checks = diffuse(CHECKS.format("reflectance"))
    yield "sphere", shape("sphere", '<point name="center" x="0" y="1" z="0"/>', real("radius", 0.8))
    yield "sphere_flipped", shape("sphere", true("flip_normals"), rotated)
    yield "disk", shape("disk", flat)
    yield "disk_textured", shape("disk", flat, bsdf=checks)
    yield "cylinder", shape("cylinder", '<point name="p0" x="-1" y="0.6" z="0"/>'
                            '<point name="p1" x="1" y="1.4" z="0.5"/>', real("radius", 0.5))
    yield "cube", shape("cube", to_world('<scale value="0.7"/>', TILT, UP))
    yield "rectangle", shape("rectangle", flat)
    for name in ("torus.obj", "torus_ascii.ply", "torus_binary_little_endian.ply",
                 "torus_binary_big_endian.ply", "torus3.serialized", "torus4.serialized"):
        kind = name.rsplit(".", maxsplit=1)[1]
        yield name.replace(".", "_"), shape(kind, text("filename", name), lift,
                                            bsdf=twosided(checks))
    yield "serialized_second", shape("serialized", text("filename", "torus4.serialized"),
                                     '<integer name="shape_index" value="1"/>', lift)
    file, torus_obj = text("filename", "plain.ply"), text("filename", "torus.obj")
    yield "made_normals", shape("ply", file, lift)
    yield "face_normals", shape("ply", file, true("face_normals"), lift)
    yield "flip_normals", shape("ply", file, true("flip_normals"), lift, bsdf=diffuse())
    yield "mirrored_mesh", shape("obj", torus_obj, bsdf=diffuse() +
                                 to_world('<scale x="-0.9" y="0.8"/>', TILT, UP))
    painted = text("filename", "painted.ply")
    for name, scale in (("vertex_color", 1 / 255), ("face_tint_color", 1), ("vertex_part", 0.9)):
        yield name, shape("ply", painted, lift, bsdf=twosided(
            diffuse(attribute("reflectance", name, scale))))
    yield "vertex_blend", shape("ply", painted, lift, bsdf=twosided(
        '<bsdf type="blendbsdf">' + attribute("weight", "vertex_part") + diffuse() + checks
        + "</bsdf>"))
    for kind in ("bsplinecurve", "linearcurve"):
        yield kind, shape(kind, text("filename", "curve.txt"), bsdf=diffuse())
    yield "merge", ('<shape type="merge">' + shape("cube", to_world('<scale value="0.4"/>', UP))
                    + shape("obj", torus_obj, lift) + "</shape>")
    group = ('<shape type="shapegroup" id="group">' + shape("ply", file, bsdf=twosided(checks))
             + shape("sphere", real("radius", 0.5), bsdf="") + "</shape>\n")
    yield "instance", group + "".join(
        f'<shape type="instance"><ref id="group"/>{to_world(*steps)}</shape>\n' for steps in (
            ('<scale value="0.5"/>', TILT, '<translate x="-1.2" y="0.9"/>'),
            ('<scale x="0.4" y="0.8" z="0.5"/>', '<translate x="0.6" y="0.7" z="1"/>'),
            ('<scale x="-0.5" y="0.4" z="0.5"/>', TILT, '<translate x="1.3" y="1.2" z="-1"/>')))


def film(width=64, height=64, more=""):
    return (f'<film type="hdrfilm"><integer name="width" value="{width}"/>'
            f'<integer name="height" value="{height}"/>{more}<rfilter type="box"/></film>')


def cameras():
    view = to_world('<lookat origin="0, 3, 7" target="0, 0.8, 0" up="0, 1, 0"/>')
    fov = real("fov", 40)

    def sensor(kind, *parts):
        return f'<sensor type="{kind}">{"".join(parts)}</sensor>\n'

    for axis in ("x", "y", "diagonal", "smaller", "larger"):
        yield f"fov_{axis}", sensor("perspective", fov, text("fov_axis", axis), view, film(80, 48))
    yield "focal_length", sensor("perspective", text("focal_length", "35mm"), view, film(57, 71))
    yield "principal_point", sensor("perspective", fov, real("principal_point_offset_x", 0.2),
                                    real("principal_point_offset_y", -0.1), view, film())
    crop = "".join(f'<integer name="crop_{n}" value="{v}"/>' for n, v in (
        ("offset_x", 37), ("offset_y", 21), ("width", 61), ("height", 43)))
    yield "crop", sensor("perspective", fov, view, film(128, 96, crop))
    yield "clip", sensor("perspective", fov, real("near_clip", 6.8), real("far_clip", 8.5), view,
                         film())
    yield "mirrored", sensor("perspective", fov, film(), to_world(
        '<scale x="-1"/>', '<lookat origin="1, 3, 7" target="0, 0.8, 0" up="0.3, 1, 0"/>'))
    yield "no_up", sensor("perspective", fov, film(), to_world(
        '<lookat origin="0, 9, 0.1" target="0, 0, 0" up="0, 0, -1"/>'))
    yield "thinlens", sensor("thinlens", fov, real("aperture_radius", 0.3),
                             real("focus_distance", 6.5), view, film())
    yield "orthographic", sensor("orthographic", film(80, 56), to_world(
        '<scale x="2.5" y="2.5"/>', '<lookat origin="1, 3, 5" target="0, 0.8, 0" up="0, 1, 0"/>'))
    yield "orthographic_clip", sensor("orthographic", real("near_clip", 1), real("far_clip", 1.65),
                                      film(), to_world(
        '<scale x="3" y="2" z="4"/>', '<lookat origin="1, 3, 5" target="0, 0.8, 0" up="0, 1, 0"/>'))


def emitters():
    color = '<rgb name="{}" value="{}"/>'
    noise = ('<texture type="bitmap" name="{}"><string name="filename" value="noise.png"/>'
             '<string name="filter_type" value="{}"/></texture>')
    above = to_world('<lookat origin="1, 4, 2" target="0, 0.5, 0" up="0, 1, 0"/>')

    def emitter(kind, *parts):
        return f'<emitter type="{kind}">{"".join(parts)}</emitter>\n'

    def area(kind, where, radiance, *parts):
        return (f'<shape type="{kind}">{"".join(parts)}{where}'
                + emitter("area", radiance) + "</shape>\n")

    down = to_world('<scale x="1.5" y="0.6"/>', '<rotate x="1" angle="90"/>',
                    '<translate y="3.4"/>')
    grey = color.format("radiance", "4, 5, 6")
    yield "area_rectangle", area("rectangle", down, grey)
    yield "area_textured", area("rectangle", down, noise.format("radiance", "bilinear"))
    yield "area_checkerboard", area("rectangle", down, CHECKS.format("radiance"))
    yield "area_nested", area("rectangle", down, '<texture type="checkerboard" name="radiance">'
                              + noise.format("color0", "bilinear") + CHECKS.format("color1")
                              + "</texture>")
    yield "area_sphere", area("sphere", to_world('<scale value="0.4"/>', '<translate y="3"/>'),
                               grey)
    yield "area_sphere_textured", area("sphere", to_world(
        '<scale value="0.5"/>', TILT, '<translate y="2.7"/>'), noise.format("radiance", "nearest"))
    yield "area_disk", area("disk", down, grey)
    yield "area_disk_textured", area("disk", to_world(
        '<rotate x="1" angle="90"/>', '<translate y="3"/>'), noise.format("radiance", "nearest"))
    # It has no texture, because light samples of a textured one disagree in Mitsuba 3.9 with BSDF
    # samples.
    yield "area_cylinder", area("cylinder", "", grey, '<point name="p0" x="-1" y="2.8" z="0"/>'
                                '<point name="p1" x="1" y="3.2" z="0"/>', real("radius", 0.2))
    yield "area_cube", area("cube", to_world('<scale value="0.3"/>', TILT,
                                                '<translate y="3"/>'), grey)
    # The mesh has facets, because smooth normals decide in Mitsuba how much a light emits.
    yield "area_mesh", area("ply", to_world('<scale value="0.5"/>', TILT, '<translate y="2.8"/>'),
                            grey, text("filename", "plain.ply"), true("face_normals"))
    yield "area_mesh_textured", area(
        "ply", to_world('<scale value="0.5"/>', TILT, '<translate y="2.8"/>'),
        noise.format("radiance", "nearest"), text("filename", "torus_ascii.ply"),
        true("face_normals"))
    # It emits all over, as if it had no mask. Mitsuba's volumetric path tracer, for which see
    # matrix_bsdf.py, without a bound, as it does not count such a segment.
    for name, opacity in (("masked", real("opacity", 0.3)), ("masked_texture", CHECKS_OPACITY)):
        yield f"area_{name}", VOLPATH + area("rectangle", to_world(
            '<rotate y="1" angle="20"/>', '<translate y="1.2" z="1.6"/>'), grey,
            f'<bsdf type="mask">{opacity}{TWOSIDED}</bsdf>')
    yield "area_null", VOLPATH + area(
        "sphere", to_world('<scale value="0.5"/>', '<translate y="1" z="1.7"/>'), grey,
        '<bsdf type="null"/>')
    yield "point", emitter("point", color.format("intensity", "20, 25, 30"),
                           '<point name="position" x="1" y="3" z="2"/>')
    spot = (real("cutoff_angle", 25), above)
    yield "spot", emitter("spot", color.format("intensity", "40, 35, 30"), *spot)
    yield "spot_beam", emitter("spot", color.format("intensity", "40, 35, 30"),
                               real("beam_width", 5), *spot)
    yield "spot_textured", emitter("spot", color.format("intensity", "40, 35, 30"), *spot,
                                   noise.format("texture", "bilinear"))
    fov = real("fov", 35)
    yield "projector", emitter("projector", noise.format("irradiance", "bilinear"), fov,
                               real("scale", 20), above)
    yield "projector_axis", emitter("projector", noise.format("irradiance", "nearest"), fov,
                                    text("fov_axis", "larger"), real("scale", 20), above)
    yield "projector_plain", emitter("projector", color.format("irradiance", "8, 9, 10"), fov,
                                     above)
    yield "directional", emitter("directional", color.format("irradiance", "2, 1.5, 1"),
                                 '<vector name="direction" x="-0.4" y="-1" z="-0.3"/>')
    yield "directional_to_world", emitter("directional", above)
    yield "constant", emitter("constant", color.format("radiance", "0.5, 0.6, 0.7"))
    sky = text("filename", "sky.exr")
    yield "envmap", emitter("envmap", sky)
    yield "envmap_rotated", emitter("envmap", sky, real("scale", 1.7), to_world(
        '<rotate y="1" angle="70"/>', '<rotate x="1" angle="20"/>'))
    rows_of_lamps = ""
    for i in range(30):
        for k in range(34):
            rows_of_lamps += area("rectangle", to_world(
                '<scale value="0.02"/>', '<rotate x="1" angle="90"/>',
                f'<translate x="{0.2 * i - 2.9:.2f}" y="{1.6 + (i * k) % 5 * 0.3:.1f}"'
                f' z="{0.2 * k - 3.3:.2f}"/>'),
                color.format("radiance", f"{3 + i}, {20 + (7 * i + k) % 13}, {3 + k}"))
    yield "thousand_areas", rows_of_lamps


def colours():
    def lit(radiance, reflectance=""):
        reflectance = reflectance or '<rgb name="reflectance" value="0.5"/>'
        return shape("sphere", '<point name="center" x="0" y="1" z="0"/>', bsdf=diffuse(
            reflectance)) + f'<emitter type="constant">{radiance}</emitter>'

    white = '<rgb name="radiance" value="0.5"/>'
    samples = "400:0.2, 500:0.5, 550:0.7, 700:0.9"
    for name, tail in (("constant", 'value="0.6"/>'), ("samples", f'value="{samples}"/>'),
                       ("spd", 'filename="slope.spd"/>'), ("d65", 'type="d65"/>')):
        yield f"radiance_{name}", lit(f'<spectrum name="radiance" {tail}')
        if name != "d65":
            yield f"reflectance_{name}", lit(white, f'<spectrum name="reflectance" {tail}')


def rows(folder):
    write_files(folder)
    out = {f"shape_{name}": LIT + body for name, body in shapes()}
    out |= {f"camera_{name}": sensor + LIT + BALL for name, sensor in cameras()}
    out |= {f"emitter_{name}": FLOOR + BALL + light for name, light in emitters()}
    out |= {f"colour_{name}": FLOOR + body for name, body in colours()}
    return out
