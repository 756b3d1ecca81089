# SPDX-License-Identifier: GPL-3.0-or-later
"""The viewport's picture of a sphere equals numpy's evaluation of the same table, pixel by pixel."""

import numpy as np
import pytest

from precompute.light.colour import xyz_to_rgb_matrix
from tests.support.blender import drawing, scenes, tables
from tests.support.blender import viewport_scene as scene
from tests.support.compare import assert_images_agree
from tests.truth import lamps as truth
from tests.truth import radiance

SIZE = 96


def expected(table, sphere, lamps, ior=None, conserve=False, rotation=0.0, tangent=None, form=radiance.dielectric):
    """Linear RGB (SIZE, SIZE, 3) of the sphere and the mask of pixels well inside it that see every lamp wholly or not.

    Where the horizon cuts a wide lamp, a few points cannot tell how much of it is left.

    `lamps`: functions from points (..., 3) to directions and irradiances; `tangent`: from points to other tangents.
    """
    hit, points, t, b, n = scenes.sphere_frames(sphere, SIZE)
    if tangent is not None:
        t = tangent(points)
        t = t - (t * n).sum(-1, keepdims=True) * n
        t /= np.linalg.norm(t, axis=-1, keepdims=True)
        b = np.cross(n, t)
    t, b = np.cos(rotation) * t + np.sin(rotation) * b, np.cos(rotation) * b - np.sin(rotation) * t
    _, direction = scenes.camera_rays(SIZE)
    wr = radiance.local(np.broadcast_to(-direction, n.shape), t, b, n)
    matrix = xyz_to_rgb_matrix("Linear Rec.709", "D65")
    image = np.zeros((SIZE, SIZE, 3))
    clear = np.ones((SIZE, SIZE), bool)
    for lamp in lamps:
        above = []
        for towards, irradiance in zip(*lamp(points), strict=True):
            wi = radiance.local(towards, t, b, n)
            value = radiance.gamut_step(radiance.f_cos_xyz(table, wi, wr, conserve), matrix)
            if ior is not None:
                value = value * form(ior, wi, wr)[..., None]
            image += irradiance[..., None] * value
            above.append(wi[..., 2] > 0)
        clear &= np.all(above, axis=0) | ~np.any(above, axis=0)
    image = np.where(hit[..., None], image, 0.0)
    return image, hit & clear & (wr[..., 2] > 0.15)


@pytest.fixture
def table(tmp_path):
    return tables.make_table(tmp_path / "table.exr", tables.lobes)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "table.exr"


LAMPS = {
    "sun": (("SUN", (0.5, 0.3, 2), {"power": 2.0, "angle": 0.0}), lambda p: truth.sun(p, (0.5, 0.3, 2), 2.0)),
    "wide sun": (
        ("SUN", (0.5, -0.3, 2), {"power": 2.0, "angle": 0.4}),
        lambda p: truth.sun(p, (0.5, -0.3, 2), 2.0, 0.4),
    ),
    "point": (
        ("POINT", (1.5, 1, 2), {"shadow_soft_size": 0.0}),
        lambda p: truth.ball(p, (1.5, 1, 2), 100.0),
    ),
    "ball": (
        ("POINT", (-1.5, 1, 2), {"shadow_soft_size": 0.5, "use_soft_falloff": False}),
        lambda p: truth.ball(p, (-1.5, 1, 2), 100.0, 0.5),
    ),
    "spot": (
        ("SPOT", (0, -1, 3), {"shadow_soft_size": 0.0, "spot_size": 0.5, "spot_blend": 0.6}),
        lambda p: truth.ball(p, (0, -1, 3), 100.0, aim=(0, 1, -3), spot=(0.5, 0.6)),
    ),
    "rectangle": (
        ("AREA", (0, 0, 3), {"shape": "RECTANGLE", "size": 1.0, "size_y": 0.5}),
        lambda p: truth.area(p, (0, 0, 3), (1, 0, 0), (0, 0.5, 0), (0, 0, -1), 100.0),
    ),
    "ellipse": (
        ("AREA", (0, 0, 3), {"shape": "ELLIPSE", "size": 1.0, "size_y": 0.5}),
        lambda p: truth.area(p, (0, 0, 3), (1, 0, 0), (0, 0.5, 0), (0, 0, -1), 100.0, ellipse=True),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", LAMPS)
def test_each_lamp(renderer, table, path, name):
    (kind, place, data), light = LAMPS[name]
    sphere = scenes.add_sphere(segments=256, rings=128)
    scene.add_lamp(kind, place, **data)
    scenes.add_camera()
    scene.give_material(sphere, path, fresnel="NONE")
    image = drawing.alone(renderer, SIZE, points=16)
    reference, inside = expected(table, sphere, [light])
    lit = inside & (reference.sum(-1) > 1e-3 * reference.max())
    assert_images_agree(image, reference, 0.01, where=lit, name=f"viewport {name}")


@pytest.mark.parametrize(("fresnel", "form"), [("DIELECTRIC", radiance.dielectric), ("SCHLICK", radiance.schlick)])
def test_several_lamps_with_fresnel_from_the_side(renderer, table, path, fresnel, form):
    sphere = scenes.add_sphere(segments=256, rings=128)
    for name in ("sun", "point", "spot"):
        kind, place, data = LAMPS[name][0]
        scene.add_lamp(kind, place, **data)
    scenes.add_camera(direction=(0.6, 0.5, 1.0))
    scene.give_material(sphere, path, fresnel=fresnel, ior=1.7, rotation=0.4)
    image = drawing.alone(renderer, SIZE)
    lamps = [LAMPS[n][1] for n in ("sun", "point", "spot")]
    reference, inside = expected(table, sphere, lamps, ior=1.7, rotation=0.4, form=form)
    lit = inside & (reference.sum(-1) > 1e-3 * reference.max())
    assert_images_agree(image, reference, 0.01, where=lit, name="viewport several")


def test_rotated_stretched_object(renderer, table, path):
    """Normals and tangents of an object that is turned, mirrored and scaled unevenly."""
    matrix = [(-0.9, 0.2, 0.0, 0.05), (0.1, 0.6, 0.3, 0.0), (0.0, -0.2, 0.8, 0.1), (0, 0, 0, 1)]
    sphere = scenes.add_sphere(segments=256, rings=128, matrix=matrix)
    scene.add_lamp("SUN", (0.5, 0.3, 2), power=2.0, angle=0.0)
    scenes.add_camera()
    scene.give_material(sphere, path, fresnel="NONE")
    image = drawing.alone(renderer, SIZE)
    reference, inside = expected(table, sphere, [LAMPS["sun"][1]])
    lit = inside & (reference.sum(-1) > 1e-3 * reference.max())
    assert lit.sum() > 1000
    assert_images_agree(image, reference, 0.01, where=lit, name="viewport stretched")


def _without_bitangent(shaded, make):
    """Replace the nodes that give a material its tangent."""
    tree = shaded.node_tree
    node = make(tree.nodes)
    tree.links.new(node.outputs[-1] if node.bl_idname == "ShaderNodeTangent" else node.outputs["Vector"],
                   tree.nodes["Diffraction"].inputs["Tangent"])  # fmt: skip


def test_radial_tangent(renderer, table, path):
    sphere = scenes.add_sphere(segments=256, rings=128)
    sphere.data.uv_layers.remove(sphere.data.uv_layers[0])
    scene.add_lamp("SUN", (0.5, 0.3, 2), power=2.0, angle=0.0)
    scenes.add_camera(direction=(0.4, -0.2, 1.0))
    shaded = scene.give_material(sphere, path, fresnel="NONE")

    def make(nodes):
        node = nodes.new("ShaderNodeTangent")
        node.direction_type, node.axis = "RADIAL", "Y"
        return node

    _without_bitangent(shaded, make)
    image = drawing.alone(renderer, SIZE)
    reference, inside = expected(table, sphere, [LAMPS["sun"][1]], tangent=lambda p: np.cross(p, (0.0, 1.0, 0.0)))
    _assert_lit_parts_agree(image, reference, inside, "viewport radial")


@pytest.mark.parametrize("domain", ["POINT", "CORNER"])
def test_tangent_from_an_attribute(renderer, table, path, domain):
    sphere = scenes.add_sphere(segments=256, rings=128)
    mesh = sphere.data
    attribute = mesh.attributes.new("along", "FLOAT_VECTOR", domain)
    places = np.array([v.co for v in mesh.vertices])
    if domain == "CORNER":
        index = np.empty(len(mesh.loops), int)
        mesh.loops.foreach_get("vertex_index", index)
        places = places[index]
    attribute.data.foreach_set("vector", (places @ _TURN + (0.3, 0.1, 0)).astype(np.float32).ravel())
    scene.add_lamp("SUN", (0.5, 0.3, 2), power=2.0, angle=0.0)
    scenes.add_camera(direction=(0.4, -0.2, 1.0))
    shaded = scene.give_material(sphere, path, fresnel="NONE")

    def make(nodes):
        node = nodes.new("ShaderNodeAttribute")
        node.attribute_name = "along"
        return node

    _without_bitangent(shaded, make)
    image = drawing.alone(renderer, SIZE)
    reference, inside = expected(table, sphere, [LAMPS["sun"][1]], tangent=lambda p: p @ _TURN + (0.3, 0.1, 0))
    _assert_lit_parts_agree(image, reference, inside, "viewport attribute")


_TURN = np.array([(0.1, 0.9, 0.2), (-0.8, 0.2, 0.1), (0.3, 0.0, 0.4)])


def test_no_uv_map_falls_back_to_the_objects_x(renderer, table, path):
    sphere = scenes.add_sphere(segments=256, rings=128)
    sphere.data.uv_layers.remove(sphere.data.uv_layers[0])
    scene.add_lamp("SUN", (0.5, 0.3, 2), power=2.0, angle=0.0)
    scenes.add_camera()
    scene.give_material(sphere, path, fresnel="NONE")
    image = drawing.alone(renderer, SIZE)
    reference, inside = expected(table, sphere, [LAMPS["sun"][1]], tangent=lambda p: np.array([1.0, 0.0, 0.0]))
    _assert_lit_parts_agree(image, reference, inside, "viewport no UV")


def _assert_lit_parts_agree(image, reference, inside, name):
    lit = inside & (reference.sum(-1) > 1e-3 * reference.max())
    assert lit.sum() > 1000
    assert_images_agree(image, reference, 0.01, where=lit, name=name)


def test_flat_faces_have_one_normal(renderer, table, path):
    """A flat-shaded face under a sun, seen without perspective, has one colour: that of its own normal."""
    plane = scenes.add_plane()
    plane.data.shade_flat()
    plane.rotation_euler = (0.3, 0.2, 0.5)
    scene.add_lamp("SUN", (0.5, 0.3, 2), power=2.0, angle=0.0)
    scenes.add_camera()
    scene.give_material(plane, path, fresnel="NONE")
    image = drawing.alone(renderer, SIZE)
    frame = np.array(plane.matrix_world.to_3x3()).T  # rows: t, b, n
    wi = radiance.local(np.array((0.5, 0.3, 2)) / np.linalg.norm((0.5, 0.3, 2)), *frame)
    wr = radiance.local(np.array((0.0, 0.0, 1.0)), *frame)
    matrix = xyz_to_rgb_matrix("Linear Rec.709", "D65")
    value = 2.0 * radiance.gamut_step(radiance.f_cos_xyz(table, wi, wr, False), matrix)
    drawn = image[image.sum(-1) > 0]
    assert len(drawn) > 1000
    assert drawn == pytest.approx(np.broadcast_to(value, drawn.shape), rel=0.005)


@pytest.mark.parametrize("mirrored", [False, True])
def test_faces_of_many_corners_have_the_tangents_of_their_uv_map(renderer, table, path, mirrored):
    """The same square once as a quad and once as an octagon."""
    import bpy

    images = []
    for corners in (4, 8):
        bpy.data.batch_remove([*bpy.data.objects, *bpy.data.meshes])
        turn = (np.arange(corners) + 0.5) * 2 * np.pi / corners
        points = np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1)
        uv = points[:, :2] * ((-0.5, 0.5) if mirrored else (0.5, 0.5)) @ [[0.8, 0.6], [-0.6, 0.8]] + 0.5
        plane = scenes._mesh_object("plane", points, np.arange(corners)[None], uv)
        plane.rotation_euler = (0.3, 0.2, 0.0)
        scene.add_lamp("SUN", (0.5, 0.3, 2), power=2.0, angle=0.0)
        scenes.add_camera()
        scene.give_material(plane, path, fresnel="NONE")
        image = drawing.alone(renderer, SIZE)
        images.append(image[SIZE // 2, SIZE // 2])
    assert images[0].min() > 0
    assert images[1] == pytest.approx(images[0], rel=1e-3)


def test_perspective_camera(renderer, table, path):
    """Every pixel has its own direction to the viewer: the square under a sun, against numpy."""
    import bpy

    plane = scenes.add_plane()
    scene.add_lamp("SUN", (0.5, 0.3, 2), power=2.0, angle=0.0)
    data = bpy.data.cameras.new("camera")
    data.angle = np.radians(50)
    camera = bpy.data.objects.new("camera", data)
    camera.location = (0.1, 0.2, 3.0)
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    scene.give_material(plane, path, fresnel="DIELECTRIC", ior=1.4)
    image = drawing.alone(renderer, SIZE)
    slope = ((np.arange(SIZE) + 0.5) / SIZE - 0.5) * 2 * np.tan(np.radians(25))
    x, y = np.meshgrid(slope, slope)
    place = np.stack([0.1 + 3 * x, 0.2 + 3 * y], -1)
    inside = (np.abs(place) < 0.98).all(-1)
    wr = np.stack([-x, -y, np.ones_like(x)], -1)
    wr /= np.linalg.norm(wr, axis=-1, keepdims=True)
    wi = np.broadcast_to(np.array((0.5, 0.3, 2)) / np.linalg.norm((0.5, 0.3, 2)), wr.shape)
    matrix = xyz_to_rgb_matrix("Linear Rec.709", "D65")
    value = radiance.gamut_step(radiance.f_cos_xyz(table, wi, wr, False), matrix)
    reference = 2.0 * value * radiance.dielectric(1.4, wi, wr)[..., None]
    assert_images_agree(image, reference, 0.01, where=inside, name="viewport perspective")


def test_energy_is_conserved_by_the_albedo(renderer, tmp_path):
    """Where the albedo passes 1, f is divided by the larger of both directions' albedos."""
    path = tmp_path / "bright.exr"
    bright = tables.make_table(path, tables.lobes, albedo=lambda theta, phi: 1.5 + 0.4 * np.sin(phi) * theta)
    sphere = scenes.add_sphere(segments=256, rings=128)
    scene.add_lamp("SUN", (0.5, 0.3, 2), power=2.0, angle=0.0)
    scenes.add_camera()
    scene.give_material(sphere, path, fresnel="NONE", conserve_energy=True)
    image = drawing.alone(renderer, SIZE)
    reference, inside = expected(bright, sphere, [LAMPS["sun"][1]], conserve=True)
    _assert_lit_parts_agree(image, reference, inside, "viewport conserved")


@pytest.mark.parametrize("orientation", ["UV", "ATTRIBUTE", "RADIAL", "TEXTURE"])
def test_orientations_of_the_material(renderer, table, path, orientation):
    """The add-on's own choices of orientation, as its operator sets them."""
    import bpy

    sphere = scenes.add_sphere(segments=256, rings=128)
    attribute = sphere.data.attributes.new("along", "FLOAT_VECTOR", "POINT")
    places = np.array([v.co for v in sphere.data.vertices])
    attribute.data.foreach_set("vector", (places @ _TURN).astype(np.float32).ravel())
    angles = bpy.data.images.new("angles", 2, 1, float_buffer=True)
    angles.colorspace_settings.name = "Non-Color"
    angles.pixels.foreach_set(np.array([0.2, 0.2, 0.2, 1.0, 0.7, 0.7, 0.7, 1.0], np.float32))
    scene.add_lamp("SUN", (0.5, 0.3, 2), power=2.0, angle=0.0)
    scenes.add_camera(direction=(0.4, -0.2, 1.0))
    scene.give_material(
        sphere, path, fresnel="NONE", orientation=orientation, attribute="along", angle_image="angles", rotation=0.3
    )
    image = drawing.alone(renderer, SIZE)

    def turned(points):
        """Half of the sphere is turned by a fifth, half by seven tenths of a turn."""
        east = np.cross((0.0, 0.0, 1.0), points)
        north = np.cross(points, east)
        first = points[..., 1:2] > 0  # u in the first half
        angle = 2 * np.pi * np.where(first, 0.2, 0.7)
        unit = [v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (east, north)]
        return np.cos(angle) * unit[0] + np.sin(angle) * unit[1]

    tangent = {
        "UV": None,
        "ATTRIBUTE": lambda p: p @ _TURN,
        "RADIAL": lambda p: p * (1.0, 1.0, 0.0),  # away from the axis
        "TEXTURE": turned,
    }[orientation]
    reference, inside = expected(table, sphere, [LAMPS["sun"][1]], rotation=0.3, tangent=tangent)
    _assert_lit_parts_agree(image, reference, inside, f"viewport {orientation}")
