#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes files as C arrays: study_embed.py OUT.c NAME FILE [NAME FILE ...]"""
import sys


def main():
    out, rest = sys.argv[1], sys.argv[2:]
    with open(out, "w", encoding="ascii") as file:
        file.write("#include <stddef.h>\n")
        for name, path in zip(rest[::2], rest[1::2]):
            with open(path, "rb") as data:
                content = data.read()
            if b"</script" in content and not path.endswith(".html"):
                sys.exit(f"{path}: it would end the script of the page")
            file.write(f"extern const char {name}[];\nextern const size_t {name}_size;\n"
                       f"const size_t {name}_size = {len(content)};\nconst char {name}[] = {{")
            file.write(",".join(str(b if b < 128 else b - 256) for b in content + b"\0"))
            file.write("};\n")


if __name__ == "__main__":
    main()
