# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of ours with a mask: their node, an image of stripes, and what a mask leaves of a picture."""

import numpy as np

from tests.support.blender.worlds import picture


def node_of(shaded):
    from diffraction_shader.addon.materials import material

    return material.shader_node(shaded)


def stripes(tree):
    """An Image Texture of a quarter, whose left half is 0 and right half 1, in colour and alpha alike."""
    rgb = np.zeros((32, 32, 3))
    rgb[:, 16:] = 1.0
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = picture(rgb)
    values = np.concatenate([rgb, rgb[..., :1]], -1).astype(np.float32)
    node.image.pixels.foreach_set(values.ravel())
    node.image.update()
    return node


def share(found, whole):
    """What is left of each pixel that shone, red."""
    return (found / np.maximum(whole, 1e-9))[..., 0][whole[..., 0] > 0.01]
