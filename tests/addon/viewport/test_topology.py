# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept of a mesh while it deforms gives the same drawing as a mesh read anew."""

from itertools import pairwise

import bpy
import numpy as np
import pytest

from tests.support.blender import drawing, scenes


def read(mesh, topologies=None, mode="UV"):
    from diffraction_shader.addon.viewport.data import corners, orientation, topology

    return corners.of(mesh, orientation.Orientation(mode), topologies or topology.Topologies())


def columns(arrays):
    """All that is drawn: place, normal, tangent and UV of every corner of every triangle, slot by slot."""
    values = np.concatenate([arrays.places, arrays.normals, arrays.tangents, arrays.uv], axis=1)
    return {slot: values[triangles] for slot, triangles in arrays.triangles.items()}


def folded(mesh, random):
    """The same faces somewhere else: many quads are cut along their other diagonal."""
    places = random.uniform(-1.0, 1.0, (len(mesh.vertices), 3)).astype(np.float32)
    mesh.vertices.foreach_set("co", places.ravel())
    mesh.update()


def test_folded_quads_other_uv_and_other_slots(blender):
    from diffraction_shader.addon.viewport.data import topology

    mesh = scenes.add_sphere(segments=24, rings=12).data
    random = np.random.default_rng(5)
    kept = topology.Topologies()
    first = read(mesh, kept)
    cuts = [first.triangles[0]]
    for _ in range(4):
        folded(mesh, random)
        again = read(mesh, kept)
        assert again.topology is first.topology
        cuts.append(again.triangles[0])
        for slot, values in columns(read(mesh)).items():
            assert np.array_equal(columns(again)[slot], values, equal_nan=True)
    assert any(not np.array_equal(a, b) for a, b in pairwise(cuts))

    # A mirrored map turns the signs.
    uv = mesh.uv_layers[0].uv
    values = np.empty(2 * len(uv), np.float32)
    uv.foreach_get("vector", values)
    values[::2] *= -1.0
    uv.foreach_set("vector", values)
    again = read(mesh, kept)
    assert np.array_equal(columns(again)[0], columns(read(mesh))[0], equal_nan=True)
    assert (again.tangents[:, 3] == -first.tangents[:, 3]).mean() > 0.9

    # Faces of another slot are another topology.
    mesh.polygons.foreach_set("material_index", np.arange(len(mesh.polygons), dtype=np.int32) % 2)
    mesh.update()
    again = read(mesh, kept)
    assert again.topology is not first.topology and sorted(again.triangles) == [0, 1]
    fresh = columns(read(mesh))
    for slot, values in columns(again).items():
        assert np.array_equal(values, fresh[slot], equal_nan=True)


@pytest.mark.parametrize("corners", [3, 4, 6])
def test_faces_of_any_size(blender, corners):
    """A fan of faces with different slots: every slot has its own triangles and they cover the faces."""
    turn = np.arange(corners) * 2 * np.pi / corners
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(corners)], -1)
    points = np.concatenate([ring + np.array([3.0 * i, 0.0, 0.0]) for i in range(3)])
    mesh = bpy.data.meshes.new("faces")
    mesh.from_pydata(points.tolist(), [], np.arange(3 * corners).reshape(3, corners).tolist())
    layer = mesh.uv_layers.new(name="UVMap")
    layer.uv.foreach_set("vector", points[:, :2].astype(np.float32).ravel())
    mesh.polygons.foreach_set("material_index", [1, 0, 1])
    mesh.update()
    arrays = read(mesh)
    area = 0.5 * corners * np.sin(2 * np.pi / corners)
    for slot, faces in ((0, 1), (1, 2)):
        a, b, c = np.moveaxis(arrays.places[arrays.triangles[slot]], 1, 0)
        assert 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=-1).sum() == pytest.approx(faces * area, rel=1e-5)
    assert arrays.tangents[:, :3] == pytest.approx(np.tile([1.0, 0.0, 0.0], (len(arrays.tangents), 1)), abs=1e-5)


def test_a_deformed_mesh_is_drawn_as_a_fresh_one(renderer, sphere):
    """Redraws of a shape key, against the renderer that has seen nothing before."""
    sphere.shape_key_add(name="Basis")
    key = sphere.shape_key_add(name="wave")
    for point in key.data:
        point.co.z *= 0.6 + 0.3 * np.sin(5.0 * point.co.x)
    for value in (0.3, 0.9):
        key.value = value
        image = drawing.alone(renderer)
        renderer.clear()
        assert np.array_equal(drawing.alone(renderer), image)
