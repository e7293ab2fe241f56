#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares daylight with Mitsuba 3's: the light on a white plate beneath the sky or the sun.

    tests/image/sunsky.py SATIN

The plate lies flat or is inclined towards the sun. For each turbidity and elevation of the sun it
prints the ratio of satin's light to Mitsuba's in red, green and blue, and Mitsuba's light. The exit
status is 1 if a channel of the sky differs by over .5 % of the brightest channel, or of the sun by
over 1 % where it stands 15 degrees high or more. Needs `pip install mitsuba numpy`.
"""
import pathlib
import subprocess
import sys
import tempfile

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")

SCENE = """<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="2"/></integrator>
<sensor type="orthographic">
  <transform name="to_world"><scale value="4"/>
    <lookat origin="0,0,50" target="0,0,0" up="0,1,0"/></transform>
  <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="64"/>
    <rfilter type="box"/></film>
</sensor>
<shape type="rectangle">
  <transform name="to_world"><scale value="4"/><rotate y="1" angle="{angle}"/></transform>
  <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="1,1,1"/></bsdf></bsdf>
</shape>
<emitter type="sunsky">
  <float name="turbidity" value="{turbidity}"/><float name="{without}" value="0"/>
  <vector name="sun_direction" x="{x}" y="0" z="{z}"/>
</emitter></scene>
"""


def mean_light(satin, folder, text):
    """The mean colours of satin's and Mitsuba's images."""
    scene, image = folder / "sunsky.xml", folder / "sunsky.exr"
    scene.write_text(text, encoding="utf-8")
    subprocess.run([satin, "render", scene, "-o", image, "--integrator", "path", "--spp", "64",
                    "--quiet"], check=True)
    ours = np.array(mi.Bitmap(str(image)))[:, :, :3].mean((0, 1))
    theirs = np.array(mi.render(mi.load_file(str(scene)), spp=64)).mean((0, 1))
    return ours, theirs


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    different = False
    print("turbidity, elevation, plate, light: satin / Mitsuba; Mitsuba")
    with tempfile.TemporaryDirectory() as folder:
        for turbidity in (1, 2.5, 3, 6, 10):
            for elevation in (3, 15, 45, 80):
                sun = np.radians(elevation)
                for angle in (0, 40):
                    for light, without in (("sky", "sun_scale"), ("sun", "sky_scale")):
                        text = SCENE.format(turbidity=turbidity, x=np.cos(sun), z=np.sin(sun),
                                            angle=angle, without=without)
                        ours, theirs = mean_light(sys.argv[1], pathlib.Path(folder), text)
                        ratio = ours / theirs
                        print(f"{turbidity}, {elevation}, {angle}, {light}:", ratio.round(4), ";",
                              theirs.round(3), flush=True)
                        bound = 0.005 if light == "sky" else 0.01 if elevation >= 15 else np.inf
                        different |= bool(abs(ours - theirs).max() > bound * theirs.max())
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
