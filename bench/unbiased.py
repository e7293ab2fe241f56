# SPDX-License-Identifier: Apache-2.0
"""Squared errors without an exact reference. Of an image A and two unbiased ones of independent
noise, B and C, the mean of (A - B) (A - C) is the squared error of A, whatever their noise.
"""
import numpy as np
import OpenEXR


def channels(path):
    """The color of an image, and where it sees emitters."""
    found = OpenEXR.File(str(path)).channels()

    def rgb(name):
        return np.asarray(found[name].pixels, dtype=np.float64)[..., :3]

    emission = rgb("emission") if "emission" in found else np.zeros(rgb("RGB").shape)
    return rgb("RGB"), emission.max(axis=-1) > 0


def relative(image, b, c, over):
    """The squared error of `image` by the unbiased images b and c, relative to `over`, by pixel."""
    return ((image - b) * (image - c) / over).mean(axis=-1)
