#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Error, records and CPU seconds on the data scenes at each quality, as a table in Markdown.

  bench/records_table.py DIR [--binary NAME=SATIN ...] [--scene NAME ...] [--quality NAME ...]

Several binaries are set side by side, for a change before and after. DIR holds the references of
`bench/quality.py references DIR`. Figures are means over N seeds.
"""
import resource

import runs

SCENES = ["indirect-room", "cornell-glossy", "cornell-metal", "caustic", "sphere-on-floor", "vase"]
QUALITIES = ["draft", "preview", "production"]
COLUMNS = ["relMSE", "mean", "irradiance", "radiance", "CPU s"]


def cpu_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def measure(options, satin, scene, quality):
    """Means over the seeds of what COLUMNS name."""
    sums = [0.0] * len(COLUMNS)
    for seed in range(options.seeds):
        start = cpu_seconds()
        image, stats = runs.render(options, runs.scene_file(scene), scene + "-records",
                                   "--quality", quality, "--seed", str(seed), satin=satin)
        seconds = cpu_seconds() - start
        relmse, mean = runs.error(options, image, scene)
        row = (relmse, mean, stats["records.irradiance"], stats["records.radiance"], seconds)
        sums = [a + b / options.seeds for a, b in zip(sums, row)]
    return "{:.6f} | {:+.2%} | {:.0f} | {:.0f} | {:.1f}".format(*sums)


def main():
    parser = runs.parser(__doc__)
    parser.add_argument("--binary", action="append", metavar="NAME=SATIN")
    parser.add_argument("--scene", action="append", choices=SCENES)
    parser.add_argument("--quality", action="append", choices=QUALITIES)
    parser.add_argument("--seeds", type=int, default=1)
    options = parser.parse_args()
    binaries = [b.split("=", 1) for b in options.binary or ["satin=" + options.satin]]
    heads = [f"{name}: {column}" if len(binaries) > 1 and column == COLUMNS[0] else column
             for name, _ in binaries for column in COLUMNS]
    print("| scene | quality | " + " | ".join(heads) + " |")
    print("|---|---|" + "---|" * len(heads))
    for scene in options.scene or SCENES:
        for quality in options.quality or QUALITIES:
            cells = [measure(options, satin, scene, quality) for _, satin in binaries]
            print(f"| {scene} | {quality} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
