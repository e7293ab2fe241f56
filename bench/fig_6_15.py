#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Records follow the sharpness of a BRDF: their number and the error on a Ward-Duer floor of
falling roughness, with adaptive and uniform placement [K05 figure 6.15: 335, 516, 993 records].

  bench/fig_6_15.py DIR [--spp N]      references are made in DIR if they are not there

Prints a table in Markdown; the images stay in DIR.
"""
import os

import runs

ALPHAS = ["0.60", "0.30", "0.15"]
SCENE = runs.scene_file("figures", "ward-floor")
PARTS = 4


def reference(options, alpha):
    """Renders the reference in parts, so that its own noise is known, unless it is there."""
    name = "ward-floor-" + alpha
    path = os.path.join(options.dir, name + ".exr")
    if not os.path.exists(path):
        define = ["-D", "alpha=" + alpha]
        parts = [runs.render(options, SCENE, f"{name}-part{i}", *define, "--integrator", "path",
                             "--spp", str(options.spp // PARTS), "--seed", str(1000 + i),
                             "--float")[0] for i in range(PARTS)]
        runs.run([options.satin, "average", *parts, "-o", path])
    return name


def main():
    parser = runs.parser(__doc__)
    parser.add_argument("--spp", type=int, default=4096, help="of references")
    options = parser.parse_args()
    print("| alpha | adapted: records | relMSE x 10^4 | uniform: records | relMSE x 10^4 |")
    print("|---|---|---|---|---|")
    for alpha in ALPHAS:
        name, cells = reference(options, alpha), [alpha]
        for fill, switch in (("adaptive", "on"), ("uniform", "off")):
            # Every alpha is cached, also those that harmonics hold less well.
            image, stats = runs.render(options, SCENE, f"{name}-{fill}", "-D", "alpha=" + alpha,
                                       "--set", "adaptive-cache=" + switch, "--set",
                                       "radiance-curvature-clamp=off", "--set",
                                       "material-cache=floor=on", "--spp", "64", "--set",
                                       "adaptive-sampling=off")
            relmse, _ = runs.error(options, image, name)
            cells += [f"{stats['records.radiance']:.0f}", f"{1e4 * relmse:.2f}"]
        print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
