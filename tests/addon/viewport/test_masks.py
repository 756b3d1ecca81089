# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a material diffracts in the viewport: its mask and the alpha of its pigment; the mirror of a lacquer's face."""

import subprocess
import sys

import numpy as np
import pytest

from tests.support.blender import drawing
from tests.support.blender.masked import node_of, share, stripes
from tests.support.blender.worlds import picture


def test_a_number(renderer, plane):
    whole = drawing.alone(renderer, 32)
    node_of(plane).inputs["Mask"].default_value = 0.25
    assert whole.max() > 0.1
    assert drawing.alone(renderer, 32) == pytest.approx(0.25 * whole, rel=1e-5, abs=1e-7)


@pytest.mark.parametrize("output", ["Color", "Alpha"])
def test_an_image(renderer, plane, output):
    """Half of the plane; taken from 1, the other half."""
    whole = drawing.alone(renderer, 32)
    node = node_of(plane)
    tree = node.id_data
    image = stripes(tree)
    tree.links.new(image.outputs[output], node.inputs["Mask"])
    found = drawing.alone(renderer, 32)
    left = share(found, whole)
    assert 0.4 < (left < 1e-6).mean() < 0.55
    assert 0.4 < (np.abs(left - 1.0) < 1e-4).mean() < 0.55
    turned = tree.nodes.new("ShaderNodeMath")
    turned.operation = "SUBTRACT"
    turned.inputs[0].default_value = 1.0
    tree.links.new(image.outputs[output], turned.inputs[1])
    tree.links.new(turned.outputs[0], node.inputs["Mask"])
    assert drawing.alone(renderer, 32) + found == pytest.approx(whole, rel=1e-4, abs=1e-6)


def test_more_than_one_image_is_left_out(blender, plane):
    from diffraction_shader.addon.viewport.data import masks

    node = node_of(plane)
    tree = node.id_data
    a, b = stripes(tree), stripes(tree)
    b.image = picture(np.ones((4, 4, 3)))
    product = tree.nodes.new("ShaderNodeMath")
    product.operation = "MULTIPLY"
    tree.links.new(a.outputs[0], product.inputs[0])
    tree.links.new(b.outputs[0], product.inputs[1])
    tree.links.new(product.outputs[0], node.inputs["Mask"])
    assert masks.of(plane) == masks.Mask()
    product.inputs[1].default_value = 0.5
    tree.links.remove(product.inputs[1].links[0])
    assert masks.of(plane) == masks.Mask(0.0, 0.5, a.image)


@pytest.mark.parametrize(
    "name", ["test_a_transparent_pigment_is_cut_out", "test_no_light_is_lost_where_nothing_diffracts"]
)
def test_in_place_of_the_surface(root_dir, name):
    """In a process of its own: in one that had run a thousand other tests these two were drawn, in about every second
    run, as if the surface was added to; alone they never were, and what brings it about is not known."""
    case = f"tests/addon/viewport/replaced.py::{name}"
    command = [sys.executable, "-m", "pytest", "--quiet", "-p", "no:xdist", "-p", "no:cacheprovider", case]
    done = subprocess.run(command, cwd=root_dir, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1 passed" in done.stdout or "1 skipped" in done.stdout
