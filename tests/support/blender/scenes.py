# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes with an exact counterpart in numpy: a sphere (or ellipsoid) before an orthographic camera."""

import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix


def add_sphere(name="sphere", segments=512, rings=256, matrix=None, parent=None):
    """A unit sphere, smooth; u grows with longitude, v with latitude."""
    # No custom normals: Blender stores them in 16 bits, and tangents then differ from face to face. The seam shares
    # its vertices; a hole of a hundredth of a radian stands at each pole.
    columns, rows = np.arange(segments + 1), np.linspace(-np.pi / 2 + 0.01, np.pi / 2 - 0.01, rings + 1)
    lon, lat = np.meshgrid(columns[:-1] * (2 * np.pi / segments), rows)
    points = np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], -1).reshape(-1, 3)
    corner_u, corner_v = np.meshgrid(columns / segments, rows / np.pi + 0.5)
    uv_grid = np.stack([corner_u, corner_v], -1).reshape(-1, 2)

    def quads(stride, last):
        index = np.arange(rings + 1)[:, None] * stride + (columns % stride if last else columns)[None]
        return np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], -1).reshape(-1, 4)

    faces, uv = quads(segments, True), uv_grid[quads(segments + 1, False).ravel()]
    ob = _mesh_object(name, points, faces, uv)
    if parent is not None:
        ob.parent = parent
    if matrix is not None:
        ob.matrix_local = Matrix(matrix)
    return ob


def add_plane(name="plane", half=1.0, mirrored=False):
    """A square in the xy plane, normal +z, u along x and v along y (u against x where mirrored)."""
    points = np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], float)
    uv = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    if mirrored:
        uv[:, 0] = 1 - uv[:, 0]
    return _mesh_object(name, points, np.array([[0, 1, 2, 3]]), uv)


def _mesh_object(name, points, faces, corner_uv):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    mesh.shade_smooth()
    layer = mesh.uv_layers.new(name="UVMap")
    layer.uv.foreach_set("vector", np.asarray(corner_uv, np.float32).ravel())
    ob = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(ob)
    return ob


def add_sun(direction, strength=1.0, angle=0.0, name="sun", parent=None):
    """A sun whose light comes from `direction` (world space unless parented)."""
    light = bpy.data.lights.new(name, "SUN")
    light.energy = strength
    light.angle = angle
    light.cycles.use_multiple_importance_sampling = False
    ob = bpy.data.objects.new(name, light)
    ob.rotation_mode = "QUATERNION"
    from mathutils import Vector

    ob.rotation_quaternion = Vector(direction).to_track_quat("Z", "Y")
    ob.parent = parent
    bpy.context.scene.collection.objects.link(ob)
    return ob


def add_camera(direction=(0, 0, 1), extent=2.2, distance=10.0, up="Y"):
    """An orthographic camera that looks at the origin from `direction`."""
    from mathutils import Vector

    data = bpy.data.cameras.new("camera")
    data.type = "ORTHO"
    data.ortho_scale = extent
    data.clip_end = 10 * distance
    ob = bpy.data.objects.new("camera", data)
    ob.matrix_world = (
        Matrix.Translation(Vector(direction).normalized() * distance)
        @ Vector(direction).to_track_quat("Z", up).to_matrix().to_4x4()
    )
    bpy.context.scene.collection.objects.link(ob)
    bpy.context.scene.camera = ob
    return ob


def render(size=96, samples=1, scene=None, centred=False, denoise=False):
    """Render and return linear RGB, float (size, size, 3), row 0 at the bottom.

    One sample sees the middle of its pixel, more of them all of it; `centred` keeps them in the middle.
    """
    import OpenEXR

    scene = scene or bpy.context.scene
    settings = scene.render
    settings.resolution_x = settings.resolution_y = size
    settings.resolution_percentage = 100
    settings.dither_intensity = 0.0
    scene.cycles.samples = samples
    scene.cycles.use_denoising = denoise
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type = "BLACKMAN_HARRIS" if centred else "BOX"
    scene.cycles.filter_width = 0.01  # of no effect on the box
    settings.filter_size = 0.0 if centred else 1.5  # of EEVEE
    scene.view_settings.view_transform = "Raw"
    settings.image_settings.file_format = "OPEN_EXR"
    settings.image_settings.color_depth = "32"
    settings.image_settings.color_mode = "RGBA"
    with tempfile.TemporaryDirectory() as folder:
        settings.filepath = str(Path(folder) / "render.exr")
        bpy.ops.render.render(write_still=True)
        with OpenEXR.File(settings.filepath) as image:
            pixels = image.channels()["RGBA"].pixels
    return np.ascontiguousarray(pixels[::-1, :, :3], dtype=np.float64)


def camera_rays(size, camera=None):
    """Origins (size, size, 3) and the one direction (3,) of the pixel centres of an orthographic camera."""
    camera = camera or bpy.context.scene.camera
    bpy.context.view_layer.update()
    matrix = np.array(camera.matrix_world)
    axis = ((np.arange(size) + 0.5) / size - 0.5) * camera.data.ortho_scale
    x, y = np.meshgrid(axis, axis)
    origins = matrix[:3, 3] + x[..., None] * matrix[:3, 0] + y[..., None] * matrix[:3, 1]
    return origins, -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])


def sphere_frames(sphere, size):
    """What the camera sees of `add_sphere`: hit mask, points, and the frame (t, b, n) at each pixel, world space."""
    origins, direction = camera_rays(size)
    matrix = np.array(sphere.matrix_world)
    inverse = np.linalg.inv(matrix)
    o = origins @ inverse[:3, :3].T + inverse[:3, 3]
    d = inverse[:3, :3] @ direction
    a, half_b, c = d @ d, o @ d, (o * o).sum(-1) - 1
    discriminant = half_b**2 - a * c
    hit = discriminant > 0
    distance = (-half_b - np.sqrt(np.where(hit, discriminant, 0))) / a
    p = o + distance[..., None] * d
    p /= np.linalg.norm(p, axis=-1, keepdims=True)
    east = np.stack([-p[..., 1], p[..., 0], np.zeros_like(p[..., 0])], -1)
    north = np.cross(p, east)
    n = p @ inverse[:3, :3]  # normals go with the inverse transpose
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    t = east @ matrix[:3, :3].T
    t -= (t * n).sum(-1, keepdims=True) * n
    t /= np.linalg.norm(t, axis=-1, keepdims=True)
    b = np.cross(n, t)
    b *= np.sign((b * (north @ matrix[:3, :3].T)).sum(-1, keepdims=True))
    return hit, p @ matrix[:3, :3].T + matrix[:3, 3], t, b, n


def plane_with_table(folder):
    """A selected plane under a sun in a file saved in a folder, whose scene has a table beside it."""
    from tests.support.blender import tables

    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"))
    tables.make_table(folder / "diffraction" / "t.exr", tables.lobes)
    bpy.context.scene.diffraction.table_path = "//diffraction/t.exr"
    ob = add_plane()
    add_sun((0.1, 0.2, 1.0))
    bpy.context.view_layer.update()
    ob.select_set(True)
    bpy.context.view_layer.objects.active = ob
    return ob
