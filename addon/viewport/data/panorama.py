# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds that their nodes alone do not tell (skies, mixtures, gradients): a second Blender renders them all around.

A render in this Blender would freeze the window, take the user's picture from the Render Result and call everybody's
handlers; the second one gets a copy of the world, and nothing else knows of it.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ....precompute.files.stamp import file_stamp
from ...lights import worlds

#: Pixels along the horizon, and seconds after which a render is given up.
WIDTH, PATIENCE = 1024, 120.0

#: What nodes have that decides no pixel, beside what is `bl_...`.
_LOOKS = {
    "color", "color_tag", "height", "hide", "label", "location", "location_absolute", "name", "parent", "select",
    "show_options", "show_preview", "show_texture", "use_custom_color", "warning_propagation", "width",
}  # fmt: skip


def image_stamp(image: bpy.types.Image) -> tuple:
    """Changes when the pixels do, as far as that can be told without reading them."""
    path = bpy.path.abspath(image.filepath, library=image.library)
    return image.session_uid, tuple(image.size), image.filepath, file_stamp(path)


def stamp(world: bpy.types.World) -> tuple:
    """Changes when the world does: everything that its nodes say."""
    visibility = getattr(world, "cycles_visibility", None)
    seen = visibility.glossy if visibility is not None else True
    return world.session_uid, bool(seen), tuple(_of_tree(world.node_tree, set()))


def _of_tree(tree: bpy.types.NodeTree | None, seen: set[int]) -> Iterator[Any]:
    if tree is None or tree.session_uid in seen:
        return
    seen.add(tree.session_uid)
    for node in tree.nodes:
        yield node.name, node.bl_idname
        for each in node.bl_rna.properties:
            name = each.identifier
            if name not in _LOOKS and not name.startswith("bl_") and (not each.is_readonly or each.type == "POINTER"):
                yield from _of_value(getattr(node, name), seen)
        for socket in node.inputs:
            if not socket.is_linked and hasattr(socket, "default_value"):
                yield from _of_value(socket.default_value, seen)
        if not node.inputs:
            for socket in node.outputs:
                if hasattr(socket, "default_value"):
                    yield from _of_value(socket.default_value, seen)
    for link in tree.links:
        yield link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier


def _of_value(value: Any, seen: set[int]) -> Iterator[Any]:
    if isinstance(value, (bool, int, float, str)):
        yield value
    elif isinstance(value, bpy.types.Image):
        yield image_stamp(value)
    elif isinstance(value, bpy.types.NodeTree):
        yield from _of_tree(value, seen)
    elif isinstance(value, bpy.types.ColorRamp):
        yield value.interpolation, value.color_mode
        for element in value.elements:
            yield element.position, tuple(element.color)
    elif isinstance(value, bpy.types.CurveMapping):
        for curve in value.curves:
            yield tuple((tuple(point.location), point.handle_type) for point in curve.points)
    elif not isinstance(value, bpy.types.bpy_prop_collection) and hasattr(value, "__len__"):
        yield tuple(value) if not isinstance(value, (bytes, set)) else repr(value)


class Panorama:
    """A world that is being rendered.

    Parameters
    ----------
    world
        Copied to a file now, so that it may change meanwhile. Not while Blender draws.
    """

    def __init__(self, world: bpy.types.World) -> None:
        self._folder = Path(tempfile.mkdtemp(prefix="diffraction-world-"))
        blend, self._out = self._folder / "world.blend", self._folder / "world.npz"
        bpy.data.libraries.write(str(blend), {world}, path_remap="ABSOLUTE", fake_user=True)
        colorspace = getattr(bpy.data, "colorspace", None)
        space = colorspace.working_space if colorspace is not None else ""
        words = [str(blend), str(self._out), str(WIDTH), space, *(",".join(map(repr, sun)) for sun in _suns(world))]
        script = str(Path(__file__).with_name("panorama_worker.py"))
        program = bpy.app.binary_path
        # The settings of the user are not loaded. Blender as a module has no program but Python's.
        start = [sys.executable, script]
        if program:
            start = [program, "--background", "--factory-startup", "--python-exit-code", "1", "--python", script]
        self._log = (self._folder / "log.txt").open("wb")
        self._process = subprocess.Popen(
            [*start, "--", *words], stdin=subprocess.DEVNULL, stdout=self._log, stderr=subprocess.STDOUT
        )

    def is_done(self) -> bool:
        """Whether it has ended, well or not."""
        return self._process.poll() is not None

    def result(self) -> tuple[np.ndarray, np.ndarray] | None:
        """`sky.Light`: radiance all around and suns; None if it failed. Waits for the end."""
        try:
            self._process.wait(PATIENCE)
            with np.load(self._out) as found:
                return found["pixels"], found["suns"]
        except (OSError, ValueError, KeyError, subprocess.TimeoutExpired):
            return None
        finally:
            self.stop()

    def stop(self) -> None:
        """End it, and leave nothing behind."""
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        self._log.close()
        shutil.rmtree(self._folder, ignore_errors=True)


def _suns(world: bpy.types.World) -> Iterator[tuple[float, float, float, float]]:
    """Direction and radius of the suns of a world's skies."""
    for source in worlds.of_world(world):
        numbers = [entry if isinstance(entry, (int, float)) else entry.value() for entry in source.entries]
        if isinstance(source.key, tuple) and source.key[0] == "sky" and numbers[3] > 0.0 and numbers[7] > 0.0:
            x, y, z = numbers[:3]
            length = max((x * x + y * y + z * z) ** 0.5, 1e-9)
            yield float(x / length), float(y / length), float(z / length), float(0.5 * numbers[7])
