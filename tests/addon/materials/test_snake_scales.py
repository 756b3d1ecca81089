# SPDX-License-Identifier: GPL-3.0-or-later
"""The node *Snake Scales* against the same sheet of scales in numpy, and its way into a material."""

import bpy
import numpy as np
import pytest

from tests.support.blender import extension, materials, scenes, tables
from tests.truth import scales as truth

pytestmark = pytest.mark.usefixtures("blender")

#: Pixels across, and the length of a scale on a plane of 2 m.
SIZE, LENGTH = 160, 0.2


@pytest.fixture
def scales():
    from diffraction_shader.addon.materials.scales import group, measure, sockets, species, wire

    class Wing:
        pass

    wing = Wing()
    wing.group, wing.measure, wing.sockets, wing.species, wing.wire = group, measure, sockets, species, wire
    return wing


@pytest.fixture
def sheet(scales):
    """A plane seen from above that emits an output of the node: ``sheet(output, **values)`` gives its picture."""
    ob = scenes.add_plane()
    scenes.add_camera(extent=2.0).rotation_euler = (0.0, 0.0, 0.0)
    made = bpy.data.materials.new("scales")
    tree = extension.give_nodes(made) or made.node_tree
    tree.nodes.clear()
    ob.data.materials.append(made)
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = scales.group.build()
    light, out = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(light.outputs[0], out.inputs["Surface"])

    def shown(output, osl=False, **values):
        chosen = {"Scale Size": LENGTH, "Scale Width": 1.0, "Belly": 0.0} | values
        for name, value in chosen.items():
            node.inputs[name].default_value = value
        tree.links.new(node.outputs[output], light.inputs["Color"])
        bpy.context.scene.cycles.shading_system = osl
        return scenes.render(SIZE, centred=True)

    shown.ob, shown.node = ob, node
    return shown


def places(scale_x=1.0, scale_y=1.0, length=LENGTH, width=1.0):
    """x towards the tail (+y of the object) and y sideways of each pixel, in lengths and half widths of scales."""
    axis = (np.arange(SIZE) + 0.5) / SIZE * 2 - 1
    px, py = np.meshgrid(axis, axis)
    # From above, with the tail up and away, the body's own left is on the left.
    return py * scale_y / length, -px * scale_x / (0.5 * width * length)


def away_from_edges(x, y, margin=0.03):
    """Pixels that rounding does not put onto the next scale."""
    _, place = truth.covering(x, y)
    return ((place > margin) & (place < 1 - margin)).all(-1)


def by_scale(values, x, y):
    """Values of each scale that is seen by several pixels: a list of ``(n, channels)``."""
    cells, _ = truth.covering(x, y)
    sure = away_from_edges(x, y)
    names, which = np.unique(cells[sure], axis=0, return_inverse=True)
    return [values[sure][which.ravel() == k] for k in range(len(names)) if (which.ravel() == k).sum() > 3]


def test_sockets_and_reuse(scales):
    tree = scales.group.build()
    items = [i for i in tree.interface.items_tree if i.item_type == "SOCKET"]
    inputs = {i.name for i in items if i.in_out == "INPUT"}
    assert inputs == {socket.name for socket in scales.sockets.SOCKETS}
    assert {i.name for i in items if i.in_out == "OUTPUT"} == set(scales.sockets.OUTPUTS)
    assert scales.group.build() == tree  # one group for all materials
    tree[scales.group.KEY] = 0  # of another version
    before = [i.identifier for i in items]
    assert scales.group.build() == tree
    assert [i.identifier for i in tree.interface.items_tree if i.item_type == "SOCKET"] == before


def test_species_name_sockets(scales):
    from diffraction_shader.precompute.presets import PRESETS

    known = {socket.name for socket in scales.sockets.SOCKETS}
    for snake in scales.species.SPECIES.values():
        assert set(snake.values) <= known and snake.preset in PRESETS


@pytest.mark.parametrize("osl", [False, True])
def test_each_scale_has_one_turn(sheet, osl):
    """Constant on a scale, within the limit, spread over it, and another on each."""
    most = np.radians(20.0)
    x, y = places()
    turns = by_scale(sheet("Rotation", osl, Turn=most)[..., 0], x, y)
    assert len(turns) > 80
    assert max(np.ptp(each) for each in turns) < 1e-6
    means = np.array([each.mean() for each in turns])
    assert np.abs(means).max() <= most and np.ptp(means) > 1.6 * most
    assert np.std(means) == pytest.approx(most / np.sqrt(3), rel=0.2)  # even between the limits
    assert len(np.unique(means.round(6))) > 0.95 * len(means)


def test_each_scale_leans_one_way(sheet):
    most = np.radians(8.0)
    x, y = places()
    leans = by_scale(sheet("Normal", Relief=0.0, Tilt=most), x, y)
    assert max(np.ptp(each, axis=0).max() for each in leans) < 1e-6
    slopes = np.array([each[0, :2] / each[0, 2] for each in leans])
    assert np.abs(slopes).max() <= np.tan(most) * 1.0001 and np.abs(slopes).max() > 0.8 * np.tan(most)
    assert np.abs(slopes.mean(0)).max() < 0.2 * np.tan(most)


@pytest.mark.parametrize("keel", [0.0, 0.04])
def test_relief_is_the_slope_of_the_height(sheet, keel):
    """The normal against central differences of numpy's height, in metres."""
    width = 1.4
    normal = sheet("Normal", Tilt=0.0, Keel=keel, **{"Scale Width": width})
    x, y = places(width=width)
    step = 1e-5
    along = (truth.height(x + step, y, keel) - truth.height(x - step, y, keel)) / (2 * step)
    across = (truth.height(x, y + step, keel) - truth.height(x, y - step, keel)) / (2 * step) * 2 / width
    expected = np.stack([across, -along, np.ones_like(x)], -1)  # y of the sheet runs against x of the world
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    _, place = truth.covering(x, y)
    kinks = np.abs(place[..., 0] - place[..., 1])
    creases = np.minimum(*(np.abs(each - np.round(each)) for each in (x + y / 2, x - y / 2)))  # of the bulges
    smooth = (
        away_from_edges(x, y)
        & (creases > 1e-3)
        & ((keel == 0.0) | ((kinks > 0.01) & (np.abs(kinks - truth.KEEL) > 0.01)))
    )
    assert np.abs(normal - expected)[smooth].max() < 2e-3
    assert np.abs(expected[..., 1]).max() > 0.1


def test_height_in_metres(sheet):
    x, y = places()
    shown = sheet("Height", Relief=2.0)[..., 0]
    sure = away_from_edges(x, y)
    assert np.abs(shown - 2.0 * LENGTH * truth.height(x, y))[sure].max() < 1e-5


def test_scale_size_is_in_metres_on_a_scaled_object(sheet):
    """A plane of 2 m that is three times as wide holds three times as many scales across, none is stretched."""
    sheet.ob.scale = (3.0, 1.5, 1.0)
    bpy.context.scene.camera.data.ortho_scale = 2.0
    x, y = places()  # the camera still sees 2 m
    turns = by_scale(sheet("Rotation", Turn=0.3)[..., 0], x, y)
    assert max(np.ptp(each) for each in turns) < 1e-6


def test_a_uv_map_closes_round_the_body(sheet):
    """Rows fit the girth in whole numbers: left and right edge of the map show halves of the same scales."""
    values = {"Space": 0, "Length": 2.0, "Girth": 2.0, "Along": 1, "Back": 0.5, "Turn": 0.3}
    shown = sheet("Rotation", **values)[..., 0]
    axis = (np.arange(SIZE) + 0.5) / SIZE
    u, v = np.meshgrid(axis, axis)
    rows = 2 * round(2.0 / LENGTH)
    x, y = v * 2.0 / LENGTH, u * rows
    assert max(np.ptp(each) for each in by_scale(shown, x, y)) < 1e-6
    cells, _ = truth.covering(x, y)
    wrapped = np.stack([cells[..., 0], cells[..., 1] % rows], -1)
    sure = away_from_edges(x, y)
    across = 0
    for name in np.unique(wrapped[sure], axis=0):
        mine = sure & (wrapped == name).all(-1)
        if np.ptp(u[mine]) > 0.5:
            across += 1
            assert np.ptp(shown[mine]) < 1e-6
    assert across > 5


def test_reverse_turns_the_scales_round(sheet):
    values = {"Space": 0, "Length": 2.0, "Girth": 2.0, "Along": 1, "Back": 0.5, "Tilt": 0.0}
    one = sheet("Normal", **values)
    other = sheet("Normal", Reverse=1, **values)
    assert np.corrcoef(one[::-1, :, 1].ravel(), -other[..., 1].ravel())[0, 1] > 0.95


def test_saddles_have_borders_and_lie_on_the_back(sheet, scales):
    corn = scales.species.SPECIES["CORN"].values
    values = {name: (*v, 1.0) if isinstance(v, tuple) else v for name, v in corn.items()}
    values |= {"Space": 0, "Length": 2.0, "Girth": 2.0, "Along": 1, "Back": 0.5, "Scale Size": 0.05}
    colour = sheet("Color", **values)
    red = (colour[..., 0] > 3.0 * colour[..., 1]) & (colour[..., 0] > 0.1) & (colour[..., 1] < 0.06)
    black = colour.max(-1) < 0.03
    middle, side = slice(70, 90), slice(36, 46)
    assert 0.3 < red[:, middle].mean() < 0.75 and red[:, side].mean() < 0.25
    assert 0.03 < black[:, middle].mean() < 0.35
    belly = np.r_[0:14, SIZE - 14 : SIZE]
    white = colour.min(-1) > 0.25
    assert white[:, belly].mean() > 0.3 and white[:, middle].mean() < 0.02


def test_uv_map_is_measured(scales):
    points = np.stack(np.meshgrid(np.linspace(0, 2 * np.pi, 129), np.linspace(0, 3.0, 9)), -1)
    mesh = bpy.data.meshes.new("tube")
    where = np.stack([0.1 * np.cos(points[..., 0]), 0.1 * np.sin(points[..., 0]), points[..., 1]], -1)
    index = np.arange(points[..., 0].size).reshape(points.shape[:2])
    quads = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], -1).reshape(-1, 4)
    mesh.from_pydata(where.reshape(-1, 3).tolist(), [], quads.tolist())
    uv = (points / [2 * np.pi, 3.0]).reshape(-1, 2)[quads.ravel()]
    mesh.uv_layers.new(name="UVMap").uv.foreach_set("vector", uv.astype(np.float32).ravel())
    ob = bpy.data.objects.new("tube", mesh)
    bpy.context.scene.collection.objects.link(ob)
    ob.scale = (2.0, 2.0, 2.0)
    bpy.context.view_layer.update()
    body = scales.measure.uv_map(ob)
    assert body.along_v and body.length_m == pytest.approx(6.0, rel=1e-3)
    assert body.girth_m == pytest.approx(2 * np.pi * 0.2, rel=1e-3)
    bpy.context.view_layer.objects.active = ob
    assert bpy.ops.diffraction.add_snake_scales(species="CORN", space="UV") == {"FINISHED"}
    inputs = ob.active_material.node_tree.nodes["Snake Scales"].inputs
    assert inputs["Girth"].default_value == pytest.approx(0.4 * np.pi, rel=1e-3)
    assert inputs["Scale Size"].default_value == pytest.approx(0.0045 * 4 * np.pi, rel=1e-2)  # in proportion


def test_without_a_uv_map_a_sentence(scales):
    mesh = bpy.data.meshes.new("bare")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    ob = bpy.data.objects.new("bare", mesh)
    bpy.context.scene.collection.objects.link(ob)
    bpy.context.view_layer.objects.active = ob
    with pytest.raises(RuntimeError, match="bare has no UV map"):
        bpy.ops.diffraction.add_snake_scales(space="UV")


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_wired_to_the_diffraction_and_kept_by_apply(scales, tmp_path, implementation):
    ob = scenes.plane_with_table(tmp_path)
    bpy.ops.diffraction.apply_material(implementation=implementation)
    assert bpy.ops.diffraction.add_snake_scales(species="SUNBEAM") == {"FINISHED"}
    tree = ob.active_material.node_tree
    for _ in range(2):
        node, made = tree.nodes["Diffraction"], tree.nodes["Snake Scales"]
        for name in ("Base", "Normal", "Tangent", "Rotation", "Mask"):
            assert node.inputs[name].links[0].from_socket == made.outputs[name]
        assert node.inputs["TangentIsDirection"].default_value == 1
        assert "Pigment" not in tree.nodes
        bpy.ops.diffraction.apply_material(implementation=implementation)
    assert bpy.ops.diffraction.add_snake_scales(species="CORN") == {"FINISHED"}
    assert sum(scales.group.is_scales(getattr(n, "node_tree", None)) for n in tree.nodes) == 1
    assert made.inputs["Saddles"].default_value == 1.0


def test_before_apply_the_pigment_shows(scales):
    ob = scenes.add_plane()
    bpy.context.view_layer.objects.active = ob
    bpy.ops.diffraction.add_snake_scales(species="CORN", scale_size=0.1)
    tree = ob.active_material.node_tree
    made = tree.nodes["Snake Scales"]
    assert made.inputs["Scale Size"].default_value == pytest.approx(0.1)
    assert tree.get_output_node("CYCLES").inputs["Surface"].links[0].from_node == made
    assert not scales.wire.is_wired(tree)


def test_osl_and_nodes_shine_alike(scales, tmp_path):
    """The same skin by both implementations, a smooth table, in one light."""
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    ob = scenes.add_sphere(segments=128, rings=64)
    scenes.add_sun((0.3, -0.4, 1.0))
    scenes.add_camera((0.0, -0.5, 1.0))
    images = []
    for implementation in ("OSL", "NODES"):
        made = materials.diffracting(ob, tmp_path / "t.exr", implementation, environment=0)
        scales.wire.add(made, "SUNBEAM", "OBJECT", scale_size_m=0.25)
        bpy.context.scene.cycles.shading_system = implementation == "OSL"
        images.append(scenes.render(64, centred=True))
    one, other = images
    assert one.max() > 0.05
    off = np.abs(one - other).sum(-1) / (one.sum(-1) + 0.02 * one.max())
    assert np.median(off) < 0.01 and np.quantile(off, 0.95) < 0.05
