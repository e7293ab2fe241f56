#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares the channels of an `aov` integrator with Mitsuba 3's, over shapes.

usage: check_aov.py BUILD_DIR      (needs mitsuba and numpy)

Both take their own random samples. Of each channel the median difference of a pixel, and that of
the means, must stay under 1 % of the channel's root mean square. Rectangles are cut into other
triangles here, so their prim_index is left out. Prints a line per channel; exit status 1 if one
is over.
"""
import pathlib
import subprocess
import sys
import tempfile

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
mi.set_log_level(mi.LogLevel.Error)
BOUND = 0.01
SAMPLES = 1024
PAIRS = ("d:depth,n:sh_normal,a:albedo,uv:uv,p:prim_index,pos:position,g:geo_normal,u:dp_du,"
         "v:dp_dv,dx:duv_dx,dy:duv_dy")
SCENE = """<scene version="3.0.0">
<integrator type="aov"><string name="aovs" value="{pairs}"/>
  <integrator type="path" name="q"/></integrator>
<sensor type="perspective"><float name="near_clip" value="0.00001"/>
  <sampler type="independent"><integer name="sample_count" value="{samples}"/></sampler>
  <film type="hdrfilm"><rfilter type="box"/><integer name="width" value="16"/>
    <integer name="height" value="16"/></film></sensor>
{body}<emitter type="constant"/></scene>"""
PLASTIC = ('<bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.2, 0.4, 0.6"/></bsdf>')


def shape(kind, *steps):
    return (f'<shape type="{kind}">{PLASTIC}<transform name="to_world">{"".join(steps)}'
            "</transform></shape>")


ROTATION = '<rotate y="1" angle="40"/><rotate x="1" angle="25"/><translate z="5"/>'
GROUP = f'<shape type="shapegroup" id="g">{shape("cube")}</shape>'
BODIES = {
    "sphere": shape("sphere", '<rotate x="1" angle="30"/><translate z="5"/>'),
    "rectangle": shape("rectangle", '<scale value="4"/><rotate x="1" angle="160"/>',
                       '<translate z="6"/>'),
    "cube": shape("cube", ROTATION),
    "disk": shape("disk", '<scale value="2"/><rotate x="1" angle="160"/><translate z="4"/>'),
    "instance": f'{GROUP}<shape type="instance"><ref id="g"/><transform name="to_world">'
                f'<scale x="0.7" y="1" z="1"/>{ROTATION}</transform></shape>',
}


def channels(bitmap):
    values = np.array(bitmap)
    return {field.name: values[..., i] for i, field in enumerate(bitmap.struct_())}


def render_both(satin, body, folder):
    text = SCENE.format(pairs=PAIRS, samples=SAMPLES, body=body)
    path = folder / "scene.xml"
    path.write_text(text, encoding="utf-8")
    scene = mi.load_string(text)
    mi.render(scene, spp=SAMPLES)
    subprocess.run([satin, "render", path, "-o", folder / "a.exr", "--integrator", "path", "-q"],
                   check=True)
    theirs = channels(scene.sensors()[0].film().bitmap())
    ours = channels(mi.Bitmap(str(folder / "a.exr")))
    return {name: (values, ours[name]) for name, values in theirs.items()
            if "." in name and not name.startswith("q.")}


def main():
    satin = pathlib.Path(sys.argv[1]) / "src/apps/satin"
    over = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, body in BODIES.items():
            for channel, (a, b) in render_both(satin, body, pathlib.Path(folder)).items():
                if (name, channel) == ("rectangle", "p.I"):
                    continue
                finite = np.isfinite(a)  # theirs are not where a sample's ray misses the plane
                a, b = a[finite], b[finite]
                scale = max(np.sqrt(np.mean(a * a)), 1e-4)
                worst = max(np.median(np.abs(a - b)), abs(a.mean() - b.mean())) / scale
                bad = not worst < BOUND
                over += bad
                print(f"{name:10} {channel:6} {worst:.2e}{'  over' if bad else ''}")
    print(f"{over} over")
    return over > 0


if __name__ == "__main__":
    sys.exit(main())
