# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample scene's body and its set-up."""

import importlib.util

import numpy as np
import pytest


def load(root_dir, name):
    spec = importlib.util.spec_from_file_location(name, root_dir / "sample_blend" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def mesh(root_dir):
    return load(root_dir, "snake_mesh").build(detail=0.3)


def test_faces_look_outwards_and_u_runs_towards_the_neck(mesh):
    points, quads, uv = mesh
    corners = points[quads]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0])
    # Away from the body's axis: upper faces look up, wherever the coil lies.
    ring = corners.mean(1)
    top = uv[..., 1].mean(1)
    upper = np.abs(top - 0.25) < 0.05  # v = 1/4 is the back of the snake
    assert (normal[upper, 2] > 0).mean() > 0.99
    assert ring[upper, 2].mean() > ring[~upper, 2].mean()
    assert (uv[..., 0] >= 0).all()
    grows = uv[:, 1, 0] - uv[:, 0, 0]
    assert (grows > 0).all()
    distance = np.hypot(points[quads[:, 0], 0], points[quads[:, 0], 1])
    assert np.corrcoef(uv[:, 0, 0], distance)[0, 1] > 0.9  # the coil opens towards the neck


def test_scales_overlap_like_tiles_on_a_roof(root_dir):
    """Along the middle of a scale the height rises to its free end and falls steeply there, never below zero."""
    scale_height = load(root_dir, "snake_mesh").scale_height
    along = np.linspace(0, 4, 4001)
    height = scale_height(along, np.full_like(along, 0.5))
    assert height.min() > 0.0
    step = np.diff(height)
    assert -step.min() > 20 * step.max()
    assert (step > 0).mean() > 0.5


def test_scene_is_ready_for_the_operators(root_dir, empty_blender):
    skin = load(root_dir, "build_scene").build_scene(detail=0.1)
    bpy = empty_blender
    scene = bpy.context.scene
    assert [ob.name for ob in bpy.context.selected_objects] == [ob.name for ob in skin] == ["Snake"]
    assert bpy.context.object == skin[0]
    assert scene.camera is not None
    assert sum(ob.type == "LIGHT" for ob in scene.objects) == 2
    assert skin[0].data.uv_layers.active is not None
    assert max(skin[0].active_material.node_tree.nodes["Shader"].inputs["Color"].default_value[:3]) < 0.02
