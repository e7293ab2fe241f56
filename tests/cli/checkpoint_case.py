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
