#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Radiance records of a glossy wall beside glossy rays, in two views of a Cornell box and in the
180 frames between them [K05 figures 3.7 and 3.8: 600 records, then 164 more; 7 times as fast].

  bench/fig_3_7.py DIR [--size 1280x1280] [--frames 180] [--images 10] [--rays 6000]

Only the gloss of the back wall is computed, with direct light at the hits of gather rays; indirect
diffuse light, which the thesis leaves out, is made from as few rays as possible. The error is that
of the layer indirect_glossy, against 256 glossy rays from the same points. Prints two tables in
Markdown; the images stay in DIR. timings.py says what is measured.
"""
import timings

RAYS, REFERENCE_RAYS = 12, 256  # per point: those of the thesis, and the most that there can be
FIRST = ["600", "28.7", "4.6", "82.9", "12", "35"]
SECOND = ["164", "9.2", "4.6", "68.7", "12", "35"]


def main():
    options = timings.parser(__doc__, "1280x1280", 180, 10, 6000).parse_args()
    views = timings.Views(options, "cornell", "first-pass=none", "irradiance-a=2",
                          "irradiance-rays=4", "irradiance-min-pixels=50")
    keys = timings.keyframes("cornell")
    found = [timings.measure_still(views, f"cornell-{key['frame']}",
                                   timings.write_view(options, key), RAYS, REFERENCE_RAYS,
                                   common="cornell") for key in keys]
    timings.print_stills(("view I", "view II"), (FIRST, SECOND), found)
    walk = timings.measure_frames(views, "cornell", "cornell", RAYS)
    timings.print_rows([f"{options.frames} frames", "thesis", "satin"], timings.frame_rows(
        walk, RAYS, ["", "", "", "4.9", "35", "7"]))


if __name__ == "__main__":
    main()
