# SPDX-License-Identifier: Apache-2.0
"""What the tests of checkpoints and of ranks have in common."""
import hashlib


def channels(name):
    """A hash of an uncompressed image behind its header, which has times."""
    with open(name, "rb") as file:
        data = file.read()
    # The header ends where the attributes do, with a name of no length.
    at = 8
    while data[at]:
        at = data.index(b"\0", data.index(b"\0", at) + 1) + 1
        at += 4 + int.from_bytes(data[at:at + 4], "little")
    lines = (int.from_bytes(data[at + 1:at + 9], "little") - at - 1) // 8
    first = at + 1 + 8 * lines
    return hashlib.sha256(data[first:]).hexdigest()


MASK = (1 << 64) - 1


def hash_bytes(value, data):
    for byte in data:
        value = ((value ^ byte) * 0x100000001b3) & MASK
    return value


def checksum(head, content):
    """That of an entry: `head` are the 16 bytes before it."""
    lanes = [1, 2, 3, 4]
    whole = len(content) // 32 * 32
    for at in range(0, whole, 8):
        lane = at // 8 % 4
        value = ((lanes[lane] ^ int.from_bytes(content[at:at + 8], "little"))
                 * 0x9e3779b97f4a7c15) & MASK
        lanes[lane] = value ^ (value >> 32)
    value = hash_bytes(0xcbf29ce484222325, head)
    value = hash_bytes(value, b"".join(lane.to_bytes(8, "little") for lane in lanes))
    return hash_bytes(value, content[whole:])


def entries(data):
    """(kind, content) of the entries of a checkpoint."""
    found, at = [], 16
    while at < len(data):
        size = int.from_bytes(data[at + 8:at + 16], "little")
        found.append((data[at], data[at + 24:at + 24 + size]))
        at += 24 + size
    return found


def forged(data, changed):
    """A checkpoint of these entries, with right checksums and the head of another one."""
    parts = [data[:16]]
    for kind, content in changed:
        head = kind.to_bytes(8, "little") + len(content).to_bytes(8, "little")
        parts += [head, checksum(head, content).to_bytes(8, "little"), content]
    return b"".join(parts)
