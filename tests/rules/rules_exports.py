#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""rules_exports.py PREFIX LIBRARY HEADERS...: the shared library exports what the public headers
declare with PREFIX_API, and nothing else."""
import re
import subprocess
import sys


def main():
    prefix, library, headers = sys.argv[1], sys.argv[2], sys.argv[3:]
    declared = set()
    for header in headers:
        text = re.sub(r"//.*|#.*", "", open(header, encoding="utf-8").read())
        declared |= set(re.findall(
            rf"{prefix}_API[^;{{]*?\b({prefix.lower()}_\w+)\s*(?:\(|;)", text))
    table = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True,
                           check=True).stdout
    exported = {line.split()[-1].split("@")[0] for line in table.splitlines()}
    for name in sorted(declared - exported):
        print(f"{name} is declared but not exported")
    for name in sorted(exported - declared):
        print(f"{name} is exported but not declared")
    return declared != exported or not declared


if __name__ == "__main__":
    sys.exit(main())
