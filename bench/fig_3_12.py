#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Radiance records of a hall of metal sheets (Lafortune, three lobes) beside glossy rays in equal
time, in two views [K05 figures 3.7, 3.12 and 3.13: 10,200 and 13,500 records, 30 rays].

  bench/fig_3_12.py DIR [--size 1600x1000] [--rays 2000]

Sun, sky and the ground in full, as in the thesis; gather rays continue as paths. The metal has
records even where harmonics of order 10 hold it badly. Prints a table in Markdown; the images stay
in DIR. timings.py says what is measured.
"""
import timings

RAYS, REFERENCE_RAYS = 30, 256  # per point: those of the thesis, and the most that there can be
THESIS = [["10,200", "251", "31.4", "538", "30", ""], ["13,500", "380", "35.1", "659", "30", ""]]
VIEWS = [{"frame": 1, "origin": [-2.5, 2.2, 14], "target": [0.8, 3.9, -2]},
         {"frame": 2, "origin": [7, 1.8, 9], "target": [0.5, 3.6, -2]}]


def main():
    options = timings.parser(__doc__, "1600x1000", 0, 1, 2000).parse_args()
    views = timings.Views(options, "hall", "first-pass=path", "irradiance-rays=2000",
                          "material-cache=sheets=on")
    found = [timings.measure_still(views, f"hall-{view['frame']}",
                                   timings.write_view(options, view), RAYS, REFERENCE_RAYS)
             for view in VIEWS]
    timings.print_stills(("view I", "view II"), THESIS, found)


if __name__ == "__main__":
    main()
