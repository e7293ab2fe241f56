# SPDX-License-Identifier: Apache-2.0
"""Rows of matrix.py: textures. What a bitmap's parameters do, the file formats it is read from,
textures that give numbers, and the coordinates of every shape."""
import struct

from matrix_scene import (CHECKS, FLOOR, LIT, TILT, UP, diffuse, to_world, real, shape, text, true,
                          twosided)

SIZE = (24, 16)  # of the images: few texels, so that interpolation shows


def picture():
    """A smooth picture in [0, 1], different along both axes and in each channel."""
    import numpy as np
    x, y = np.meshgrid(np.arange(SIZE[0]) / SIZE[0], np.arange(SIZE[1]) / SIZE[1])
    waves = (np.sin(5 * x + 4 * y), np.cos(7 * x) * np.sin(3 * y + 1), np.sin(9 * y - 2 * x))
    return (np.stack(waves, axis=2) * 0.42 + 0.48).astype(np.float32)


def write_tga(path, pixels):
    """Uncompressed, 24 bits, from the top row on; Mitsuba knows it by the last bytes."""
    height, width, _ = pixels.shape
    head = struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, width, height, 24, 0x20)
    path.write_bytes(head + pixels[:, :, ::-1].tobytes() + bytes(8) + b"TRUEVISION-XFILE.\0")


def write_bmp(path, pixels):
    """24 bits, from the bottom row on; the rows here are multiples of four bytes."""
    height, width, _ = pixels.shape
    body = pixels[::-1, :, ::-1].tobytes()
    path.write_bytes(struct.pack("<2sIHHI", b"BM", 54 + len(body), 0, 0, 54)
                     + struct.pack("<IiiHHIIiiII", 40, width, height, 1, 24, 0, len(body), 2835,
                                   2835, 0, 0) + body)


def write_images(folder):
    import mitsuba as mi
    import numpy as np
    linear = picture()
    grey, eight = linear[:, :, :1].copy(), (linear * 255 + 0.5).astype(np.uint8)
    alpha = np.concatenate([eight, eight[:, ::-1, :1]], axis=2)
    images = {
        "eight.png": eight, "sixteen.png": (linear * 65535).astype(np.uint16),
        "grey.png": eight[:, :, :1].copy(), "alpha.png": alpha, "picture.jpg": eight,
        "float.exr": linear, "half.exr": linear.astype(np.float16), "grey.exr": grey,
        "picture.hdr": linear, "picture.pfm": linear, "picture.ppm": eight,
    }
    for name, pixels in images.items():
        mi.Bitmap(pixels).write(str(folder / name), quality=100 if "jpg" in name else -1)
    write_tga(folder / "picture.tga", eight)
    write_bmp(folder / "picture.bmp", eight)


# Coordinates are rotated, and go from below 0 to beyond 1.
AROUND = ('<transform name="to_uv"><translate x="-0.4" y="-0.3"/><rotate z="1" angle="30"/>'
          '<scale x="2.3" y="1.7"/></transform>')


def bitmap(name, file, *parts):
    inside = text("filename", file) + "".join(parts)
    return f'<texture type="bitmap" name="{name}">{inside}</texture>'


def nested(name, *parts):
    return (f'<texture type="checkerboard" name="{name}">{"".join(parts)}'
            '<transform name="to_uv"><scale x="2" y="3"/></transform></texture>')


def floor_of(texture):
    return (shape("rectangle", to_world('<scale value="2.6"/>', '<rotate x="1" angle="-90"/>',
                                     '<translate y="0.1"/>'), bsdf=diffuse(texture)))


def parameters():
    for kind in ("bilinear", "nearest"):
        yield kind, bitmap("reflectance", "eight.png", text("filter_type", kind))
        for wrap in ("repeat", "mirror", "clamp"):
            yield f"{kind}_{wrap}", bitmap("reflectance", "eight.png", text("filter_type", kind),
                                           text("wrap_mode", wrap), AROUND)
    yield "raw", bitmap("reflectance", "eight.png", true("raw"))
    yield "raw_grey", bitmap("reflectance", "grey.png", true("raw"))
    yield "raw_float", bitmap("reflectance", "float.exr", true("raw"))
    yield "checkerboard", CHECKS.format("reflectance")
    yield "checkerboard_rotated", (
        '<texture type="checkerboard" name="reflectance"><rgb name="color1" value="0.8, 0.2, 0.3"/>'
        '<transform name="to_uv"><translate x="-0.1" y="0.2"/><scale x="5" y="-3"/>'
        '<rotate z="1" angle="25"/></transform></texture>')
    yield "checkerboard_nested", nested("reflectance", bitmap("color1", "eight.png", AROUND),
                                        CHECKS.format("color0"))


FORMATS = ("sixteen.png", "grey.png", "alpha.png", "picture.jpg", "float.exr", "half.exr",
           "grey.exr", "picture.hdr", "picture.pfm", "picture.ppm", "picture.tga", "picture.bmp")


def numbers():
    """Parameters that take one number, from images of three channels and of one."""
    metal = '<bsdf type="roughconductor">{}</bsdf>'
    black, white = (f'<bsdf type="diffuse"><rgb name="reflectance" value="{v}"/></bsdf>'
                    for v in ("0.05", "0.9"))
    for name, file, parts in (("", "eight.png", ()), ("_raw", "eight.png", (true("raw"),)),
                              ("_grey", "grey.exr", ()), ("_grey_png", "grey.png", ())):
        yield f"weight{name}", twosided('<bsdf type="blendbsdf">' + bitmap("weight", file, *parts)
                                        + black + white + "</bsdf>")
    yield "alpha", twosided(metal.format(bitmap("alpha", "float.exr", true("raw"))))
    yield "weight_checkerboard", twosided(
        '<bsdf type="blendbsdf"><texture type="checkerboard" name="weight">'
        + real("color0", 0.1) + real("color1", 0.8)
        + '<transform name="to_uv"><scale x="6" y="3"/></transform></texture>' + black + white
        + "</bsdf>")
    yield "weight_nested", twosided('<bsdf type="blendbsdf">' + nested(
        "weight", bitmap("color0", "eight.png"), real("color1", 0.8)) + black + white + "</bsdf>")


def coordinates():
    look = twosided(diffuse(bitmap("reflectance", "eight.png", text("filter_type", "nearest"))))
    rotated = to_world('<scale value="0.9"/>', TILT, UP)
    for kind in ("sphere", "cube", "cylinder", "rectangle", "disk"):
        yield kind, shape(kind, rotated, bsdf=look)
    yield "sphere_flipped", shape("sphere", true("flip_normals"), rotated, bsdf=look)
    yield "rectangle_mirrored", shape("rectangle", to_world(
        '<scale x="-1.2" y="0.8"/>', TILT, UP), bsdf=look)
    for name in ("torus.obj", "torus_binary_little_endian.ply", "torus4.serialized"):
        kind = name.rsplit(".", maxsplit=1)[1]
        yield kind, shape(kind, text("filename", name), rotated, bsdf=look)


def rows(folder):
    write_images(folder)
    out = {f"texture_{name}": LIT + floor_of(what) for name, what in parameters()}
    out |= {f"texture_of_{file.replace('.', '_')}": LIT + floor_of(bitmap("reflectance", file))
            for file in FORMATS}
    out |= {f"texture_number_{name}": LIT + shape("rectangle", to_world(
        '<scale value="1.3"/>', '<rotate x="1" angle="-40"/>', UP), bsdf=what)
            for name, what in numbers()}
    out |= {f"texture_on_{name}": LIT + what for name, what in coordinates()}
    return out
