#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Adaptive and uniform placing of radiance records: error at equal number, and how many uniform
ones reach the error of the adaptive [K05 figure 6.9].

  bench/quality.py references DIR data/scenes/figures/{box-pyramid,teapot,hall}.xml
  bench/fig_6_9.py DIR [SCENE ...]

The largest radius in pixels is lifted: it places records evenly whatever the light does, and so
hides what is compared. Prints a table in Markdown; the images stay in DIR. The thesis found 3.3,
1.8 and 7 times as many.
"""
import contest
import runs


def main():
    parser = runs.parser(__doc__)
    parser.add_argument("scene", nargs="*", default=["box-pyramid", "teapot", "hall"])
    options = parser.parse_args()
    print(contest.HEAD)
    for name in options.scene:
        contest.Contest(options, runs.scene_file("figures", name), name, "adaptive-cache=on",
                        "adaptive-cache=off", "radiance-a", "records.radiance",
                        ("--set", "radiance-max-pixels=1000")).run()


if __name__ == "__main__":
    main()
