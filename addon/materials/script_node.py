# SPDX-License-Identifier: GPL-3.0-or-later
"""Script nodes with compiled OSL inside, so that the .blend needs neither this add-on nor its files."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import tempfile
from pathlib import Path

import bpy

from ...precompute.errors import DiffractionError

#: Types of OSL parameters in compiled shaders, by the sockets that Blender makes for them.
_SOCKETS = {
    "int": "NodeSocketInt",
    "float": "NodeSocketFloat",
    "string": "NodeSocketString",
    "color": "NodeSocketColor",
    "vector": "NodeSocketVector",
    "normal": "NodeSocketVector",
    "point": "NodeSocketVector",
    "closure color": "NodeSocketShader",
}


def fill(node: bpy.types.Node, text: bpy.types.Text) -> None:
    """Compile a text block into a script node (INTERNAL mode) and give the node its sockets.

    Blender does it all where its Python has ``oslquery``; the ``bpy`` module hides that library,
    so there the parameters are read from the compiled shader.

    Raises
    ------
    DiffractionError
        If this Blender cannot compile OSL.
    """
    node.mode = "INTERNAL"
    node.bytecode_hash = ""
    if importlib.util.find_spec("oslquery") is not None:
        node.script = text  # compiles
        if not node.bytecode_hash:  # the same text block was set before, so that nothing was triggered
            node.script = None
            node.script = text
    if not node.bytecode_hash:  # no oslquery; or the scene renders with EEVEE, where Blender compiles nothing
        compiled = _compile(text.as_string())
        node.bytecode = compiled
        node.bytecode_hash = hashlib.md5(compiled.encode(), usedforsecurity=False).hexdigest()
        _make_sockets(node, compiled)
    if not node.bytecode_hash or "BSDF" not in node.outputs:
        raise DiffractionError("The OSL shader does not compile here; use a Blender that was built with OSL.")


def _compile(source: str) -> str:
    try:
        import _cycles
    except ImportError as error:
        raise DiffractionError("This Blender has no Cycles, so it cannot compile the OSL shader.") from error
    with tempfile.TemporaryDirectory() as folder:
        path, compiled = os.path.join(folder, "a.osl"), os.path.join(folder, "a.oso")
        Path(path).write_text(source, encoding="utf-8")
        if not _cycles.osl_compile(path, compiled):
            raise DiffractionError("The OSL shader does not compile here; use a Blender that was built with OSL.")
        return Path(compiled).read_text(encoding="utf-8")


def parameters(compiled: str) -> list[tuple[bool, str, str, list[str]]]:
    """Parameters of a compiled shader: (is output, type, name, default values), in order.

    A parameter line of the .oso format reads ``param TYPE NAME DEFAULTS... %hints``, an output
    begins with ``oparam``; a default that is computed shows as zeros and has an ``%initexpr`` hint.
    """
    found = []
    for line in compiled.splitlines():
        words = line.split("%", 1)[0].split()
        if not words or words[0] not in ("param", "oparam"):
            continue
        kind = "closure color" if words[1] == "closure" else words[1]
        name, *values = words[3:] if words[1] == "closure" else words[2:]
        found.append((words[0] == "oparam", kind, name, [] if "%initexpr" in line else values))
    return found


def _make_sockets(node: bpy.types.Node, compiled: str) -> None:
    wanted = parameters(compiled)
    for is_output, sockets in ((False, node.inputs), (True, node.outputs)):
        names = {name for output, _, name, _ in wanted if output == is_output}
        for socket in [s for s in sockets if s.name not in names]:
            sockets.remove(socket)
    for is_output, kind, name, values in wanted:
        sockets = node.outputs if is_output else node.inputs
        if name in sockets and sockets[name].bl_idname == _SOCKETS[kind]:
            continue
        if name in sockets:
            sockets.remove(sockets[name])
        socket = sockets.new(_SOCKETS[kind], name)
        socket.hide_value = not values
        if not values or (is_output and kind != "float"):
            continue
        if kind == "int":
            socket.default_value = int(values[0])
        elif kind == "float":
            socket.default_value = float(values[0])
        elif kind == "string":
            socket.default_value = values[0].strip('"')
        elif kind == "color":
            socket.default_value = (*map(float, values), 1.0)
        elif kind in ("vector", "normal", "point"):
            socket.default_value = tuple(map(float, values))
