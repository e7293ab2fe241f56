#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Low steps with and without the clamping of neighbours' radii: irradiance records at equal number,
and how many it takes without [K05 figure 6.5: 7,750 and 20,000].

  bench/fig_6_5.py DIR [--size N] [--a A]

What counts is the part of the image with the steps; placement.py says what is measured. Prints a
table in Markdown; the images stay in DIR. Needs the Python packages numpy, scipy and OpenEXR.
"""
import placement
import runs

TOP, BOTTOM, LEFT, RIGHT = 0.48, 0.7, 0.16, 0.76  # of the image


def main():
    parser = runs.parser(__doc__)
    parser.add_argument("--size", type=int, default=640)
    parser.add_argument("--a", type=float, default=0.2, help="accuracy with clamping")
    options = parser.parse_args()
    n = options.size
    print(placement.HEAD)
    steps = (slice(int(TOP * n), int(BOTTOM * n)), slice(int(LEFT * n), int(RIGHT * n)))
    placement.Placement(
        options, "steps", "irradiance", "indirect_diffuse", ("irradiance-cache=off",),
        ("adaptive-cache=off", "irradiance-widen=1"), steps,
    ).compare(options.a, "irradiance-neighbour-clamp=on", "irradiance-neighbour-clamp=off", 0.01)


if __name__ == "__main__":
    main()
