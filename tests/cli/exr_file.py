# SPDX-License-Identifier: Apache-2.0
"""Reads OpenEXR files of 32-bit floats in scanlines without compression, as `satin render --float
--compression none` writes them: an independent reader for the tests."""
import struct


def split_exr(path):
    """The attributes of a file, by name as bytes, its bytes, and where the table of chunks is."""
    with open(path, "rb") as file:
        data = file.read()
    attributes, at = {}, 8
    while data[at]:
        end = data.index(0, at)
        kind_end = data.index(0, end + 1)
        size, = struct.unpack_from("<i", data, kind_end + 1)
        attributes[data[at:end].decode()] = data[kind_end + 5:kind_end + 5 + size]
        at = kind_end + 5 + size
    return attributes, data, at + 1


def read_chunks(path):
    """All that follows the header and the table of chunks: the pixels, as they are compressed."""
    _, data, table = split_exr(path)
    return data[struct.unpack_from("<Q", data, table)[0]:]


def read_exr(path):
    """The attributes of a file, by name as bytes, and the rows of each channel, as bytes."""
    attributes, data, table = split_exr(path)
    names, kinds, body = [], [], attributes["channels"]
    while body[0]:
        end = body.index(0)
        names.append(body[:end].decode())
        kinds.append(struct.unpack_from("<i", body, end + 1)[0])
        body = body[end + 17:]
    assert set(kinds) == {2} and attributes["compression"] == b"\0", "not plain floats"
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    row = 4 * (x1 - x0 + 1)
    planes = {name: [] for name in names}
    for offset in struct.unpack_from(f"<{y1 - y0 + 1}Q", data, table):
        for i, name in enumerate(names):
            planes[name].append(data[offset + 8 + row * i:offset + 8 + row * (i + 1)])
    return attributes, planes
