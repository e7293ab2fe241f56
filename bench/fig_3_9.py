#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Radiance records of a curved body of metal beside glossy rays, in three views and in the 280
frames of a walk around it [K05 figures 3.7, 3.9 and 3.10: 15 s per frame, and 27 s with 2 rays].

  bench/fig_3_9.py DIR [--size 1280x1280] [--frames 280] [--images 8] [--rays 1000]

Four bounces; gather rays continue as paths, as in the thesis, and diffuse surfaces have irradiance
records, whose seconds are in those of the whole render alone. The views are rendered each with
records of its own. With fewer frames the camera takes larger steps along the same path. Prints two
tables in Markdown; the images stay in DIR. timings.py says what is measured.
"""
import timings

RAYS, REFERENCE_RAYS = 2, 256  # per point: of the thesis' animation, and the most there can be
THESIS = [["", "63.5", "4.42", "108", "12", ""], ["", "53.2", "11.4", "101", "4", ""],
          ["", "63.9", "8.7", "104", "6", ""]]


def main():
    options = timings.parser(__doc__, "1280x1280", 280, 8, 1000).parse_args()
    views = timings.Views(options, "flamingo", "first-pass=path", "irradiance-rays=1000")
    found = [timings.measure_still(views, f"flamingo-{key['frame']}",
                                   timings.write_view(options, key), RAYS, REFERENCE_RAYS)
             for key in timings.keyframes("flamingo")]
    timings.print_stills(("view I", "view II", "view III"), THESIS, found)
    walk = timings.measure_frames(views, "flamingo", "flamingo", RAYS)
    timings.print_rows([f"{options.frames} frames", "thesis", "satin"], timings.frame_rows(
        walk, RAYS, ["", "", "", "15", "27", "1.8"]))


if __name__ == "__main__":
    main()
