# SPDX-License-Identifier: GPL-3.0-or-later
"""What diffraction adds to a redraw: a mesh of 126,000 quads that deforms each time, and 300 objects.

The floor beside the first: Blender's tangents of the same mesh, reading places, normals and tangents, their upload, and
a draw by a shader of one colour.
"""

import sys

import numpy as np

#: Segments and rings of the sphere: 126,000 quads.
SPHERE = (500, 252)
ROUNDS = 7
SIZE = 256


def measure(table_path, clock):
    """Seconds of both, printed and returned by name."""
    import bpy
    import gpu
    from diffraction_shader.addon.viewport import handlers, looks, offscreen

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    mesh = _sphere(*SPHERE)
    ball = bpy.data.objects.new("ball", mesh)
    scene.collection.objects.link(ball)
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    scene.collection.objects.link(sun)
    shaded = _material(table_path)
    mesh.materials.append(shaded)
    ball.shape_key_add(name="Basis")
    key = ball.shape_key_add(name="wave")
    places = np.array([point.co for point in key.data], np.float32)
    places *= (1.0 + 0.05 * np.sin(9.0 * places[:, 2:])).astype(np.float32)
    key.data.foreach_set("co", places.ravel())

    target = gpu.types.GPUOffScreen(SIZE, SIZE, format="RGBA32F")
    view = np.eye(4)
    view[2, 3] = -5.0
    projection = np.diag([0.8, 0.8, -0.1, 1.0])
    plain = _plain_shader()

    def draw():
        handlers.renderer.draw(
            bpy.context.evaluated_depsgraph_get(), view, projection, looks.View(), False, lambda ob: True
        )
        if handlers.renderer.message:
            sys.exit(handlers.renderer.message)

    def floor():
        _draw_plainly(ball.evaluated_get(bpy.context.evaluated_depsgraph_get()), plain, projection @ view)

    def rounds(change, *draws):
        """Median seconds of each, in alternation; of the first also those until the call returns."""
        seconds, calls = [[] for _ in draws], []
        for index in range(ROUNDS + 1):
            for each, kept in zip(draws, seconds, strict=True):
                change(index)
                bpy.context.view_layer.update()
                with target.bind():
                    gpu.state.active_framebuffer_get().clear(color=(0, 0, 0, 0), depth=1.0)
                    offscreen.read(target)
                    start = clock()
                    each()
                    if kept is seconds[0]:
                        calls.append(clock() - start)
                    offscreen.read(target)
                kept.append(clock() - start)
        return [float(np.median(kept[1:])) for kept in (*seconds, calls)]

    def deform(index):
        key.value = 0.1 + 0.1 * index

    ours, least, _ = rounds(deform, draw, floor)
    bpy.data.objects.remove(ball)
    small = _sphere(16, 8)
    small.materials.append(shaded)
    balls = []
    for index in range(300):
        ob = bpy.data.objects.new("ball", small.copy())
        ob.location, ob.scale = (np.cos(index), np.sin(0.3 * index), 0.0), (0.05, 0.05, 0.05)
        scene.collection.objects.link(ob)
        balls.append(ob)

    def move(index):
        balls[index].location.z += 0.01

    many, call = rounds(move, draw)
    print(
        f"  a mesh of {len(mesh.polygons)} quads that deforms: {ours:.3f} s a redraw, the floor {least:.3f} s:"
        f" {ours / least:.2f} times; 300 objects of which one moves: {many:.3f} s, {call:.3f} s without their pixels"
    )
    return {"deform_s": ours, "deform_floor_s": least, "deform_over_floor": ours / least, "objects_300_s": many,
            "objects_300_call_s": call}  # fmt: skip


def _sphere(segments, rings):
    import bpy

    lon, lat = np.meshgrid(np.arange(segments) * (2 * np.pi / segments), np.linspace(-1.56, 1.56, rings + 1))
    points = np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], -1).reshape(-1, 3)
    index = np.arange((rings + 1) * segments).reshape(rings + 1, segments)
    right = np.roll(index, -1, axis=1)
    faces = np.stack([index[:-1], right[:-1], right[1:], index[1:]], -1).reshape(-1, 4)
    mesh = bpy.data.meshes.new("ball")
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    mesh.shade_smooth()
    layer = mesh.uv_layers.new(name="UVMap")
    uv = np.stack([lon / (2 * np.pi), lat], -1).reshape(-1, 2)[faces.ravel()].reshape(-1, 4, 2)
    uv[:, 1:3, 0][uv[:, 1:3, 0] < uv[:, :1, 0]] += 1.0  # the last column closes the round
    layer.uv.foreach_set("vector", uv.astype(np.float32).ravel())
    return mesh


def _material(table_path):
    import bpy
    from diffraction_shader.addon.materials import material
    from diffraction_shader.addon.versions import give_nodes

    shaded = bpy.data.materials.new("ball")
    give_nodes(shaded)
    shaded.node_tree.nodes.clear()
    bpy.context.view_layer.update()
    return material.apply(shaded, str(table_path), material.Settings())


def _plain_shader():
    import gpu

    info = gpu.types.GPUShaderCreateInfo()
    info.push_constant("MAT4", "to_clip")
    info.vertex_in(0, "VEC3", "pos")
    info.fragment_out(0, "VEC4", "out_colour")
    info.vertex_source("void main() { gl_Position = to_clip * vec4(pos, 1.0); }")
    info.fragment_source("void main() { out_colour = vec4(1.0); }")
    return gpu.shader.create_from_info(info)


def _draw_plainly(ob, shader, to_clip):
    import gpu

    def read(collection, name, width, dtype=np.float32):
        values = np.empty(len(collection) * width, dtype)
        collection.foreach_get(name, values)
        return values.reshape(-1, width)

    mesh = ob.to_mesh()
    mesh.calc_loop_triangles()
    mesh.calc_tangents(uvmap=mesh.uv_layers.active.name)
    vertex = read(mesh.loops, "vertex_index", 1, np.int32).ravel()
    values = {
        "pos": read(mesh.vertices, "co", 3)[vertex],
        "nor": read(mesh.corner_normals, "vector", 3),
        "tan": read(mesh.loops, "tangent", 3),
        "sign": read(mesh.loops, "bitangent_sign", 1),
    }
    form = gpu.types.GPUVertFormat()
    for name, array in values.items():
        form.attr_add(id=name, comp_type="F32", len=array.shape[1], fetch_mode="FLOAT")
    points = gpu.types.GPUVertBuf(len=len(vertex), format=form)
    for name, array in values.items():
        points.attr_fill(name, array)
    triangles = gpu.types.GPUIndexBuf(type="TRIS", seq=read(mesh.loop_triangles, "loops", 3, np.int32))
    ob.to_mesh_clear()
    batch = gpu.types.GPUBatch(type="TRIS", buf=points, elem=triangles)
    gpu.state.depth_test_set("LESS_EQUAL")
    shader.bind()
    shader.uniform_float("to_clip", np.asarray(to_clip, np.float32).T.ravel())
    batch.draw(shader)
