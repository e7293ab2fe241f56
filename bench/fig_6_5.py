#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Stairs with and without the clamping of neighbours' radii: error at equal number of irradiance
records, and how many it takes without [K05 figure 6.5: 7,750 and 20,000].

  bench/quality.py references DIR data/scenes/cases/stairs.xml
  bench/fig_6_5.py DIR

Prints a table in Markdown; the images stay in DIR.
"""
import contest
import runs


def main():
    options = runs.parser(__doc__).parse_args()
    print(contest.HEAD)
    contest.Contest(options, runs.scene_file("cases", "stairs"), "stairs",
                    "irradiance-neighbours=on", "irradiance-neighbours=off", "irradiance-a",
                    "records.irradiance").run()


if __name__ == "__main__":
    main()
