#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Adaptive and uniform placement of radiance records at equal number, and how many uniform records
are as good as the adaptive ones [K05 figure 6.9, which found 3.3, 1.8 and 7 times as many].

  bench/fig_6_9.py DIR [SCENE ...] [--size N] [--a A]

Both interpolate at the accuracy at which they fill, as the thesis does; placement.py says what is
measured. Prints a table in Markdown; the images stay in DIR. Needs the Python packages numpy, scipy
and OpenEXR.
"""
import placement
import runs


def main():
    parser = runs.parser(__doc__)
    parser.add_argument("scene", nargs="*", default=["box-pyramid", "teapot", "hall"])
    parser.add_argument("--size", type=int, default=480)
    parser.add_argument("--a", type=float, default=0.45, help="accuracy before adaptation")
    options = parser.parse_args()
    print(placement.HEAD)
    for name in options.scene:
        placement.Placement(
            options, name, "radiance", "indirect_glossy",
            ("radiance-cache=off", "glossy-samples=32"),
            ("radiance-max-pixels=100000", "radiance-widen=1", "radiance-curvature-clamp=off"),
        ).compare(options.a, "adaptive-cache=on", "adaptive-cache=off", 0.1)


if __name__ == "__main__":
    main()
