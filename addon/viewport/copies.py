# SPDX-License-Identifier: GPL-3.0-or-later
"""Array textures that are filled over several drawings: none of them waits for the copy of a hundred megabytes."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from ..versions import draws_into_layers
from .data.blocks import buffer

_VERTEX = "void main() { gl_Position = vec4(pos, 0.0, 1.0); }"
_FRAGMENT = "void main() { texel = texelFetch(df_layer, ivec2(gl_FragCoord.xy), 0); }"


class Copy:
    """An array texture of half floats on its way to the GPU.

    Each layer goes there as a texture of its own, which is drawn into the array: Blender's Python fills a texture when
    it is made, or never. Half floats come out as they went in. Blender 4.5 cannot draw there and copies all at once.

    Parameters
    ----------
    layers
        ``(n, height, width, 4)`` float32.

    Attributes
    ----------
    texture : gpu.types.GPUTexture
        The array.
    done : int
        Layers that are there.

    Raises
    ------
    RuntimeError, MemoryError
        If the GPU has no room.
    """

    def __init__(self, layers: np.ndarray) -> None:
        import gpu

        count, height, width, _ = layers.shape
        in_parts = draws_into_layers()
        data = {} if in_parts else {"data": buffer(layers)}
        self.texture = gpu.types.GPUTexture((width, height), layers=count, format="RGBA16F", **data)
        self._layers, self.done = layers, 0 if in_parts else count

    def go_on(self, most_bytes: float) -> bool:
        """Copy about so many bytes, one layer at least; whether all is there."""
        import gpu

        if self.done == len(self._layers):
            return True
        state = gpu.state.blend_get(), gpu.state.depth_test_get()
        gpu.state.blend_set("NONE")
        gpu.state.depth_test_set("NONE")
        gpu.state.face_culling_set("NONE")
        try:
            count = int(min(most_bytes, self._layers.nbytes) // self._layers[0].nbytes)
            for index in range(self.done, min(self.done + max(1, count), len(self._layers))):
                self._copy(index)
                self.done = index + 1
        finally:
            gpu.state.blend_set(state[0])
            gpu.state.depth_test_set(state[1])
        return self.done == len(self._layers)

    def _copy(self, index: int) -> None:
        import gpu

        _, height, width, _ = self._layers.shape
        layer = gpu.types.GPUTexture((width, height), format="RGBA32F", data=buffer(self._layers[index]))
        target: Any = gpu.types.GPUFrameBuffer(color_slots=({"texture": self.texture, "layer": index},))
        shader, triangle = _painter()
        with target.bind():
            shader.bind()
            shader.uniform_sampler("df_layer", layer)
            triangle.draw(shader)


@cache
def _painter() -> tuple[Any, Any]:
    """A shader that copies a texture texel by texel, and a triangle that covers all of them."""
    import gpu

    info = gpu.types.GPUShaderCreateInfo()
    info.vertex_in(0, "VEC2", "pos")
    info.sampler(0, "FLOAT_2D", "df_layer")
    info.fragment_out(0, "VEC4", "texel")
    info.vertex_source(_VERTEX)
    info.fragment_source(_FRAGMENT)
    form = gpu.types.GPUVertFormat()
    form.attr_add(id="pos", comp_type="F32", len=2, fetch_mode="FLOAT")
    points = gpu.types.GPUVertBuf(len=3, format=form)
    points.attr_fill("pos", ((-1.0, -1.0), (3.0, -1.0), (-1.0, 3.0)))
    return gpu.shader.create_from_info(info), gpu.types.GPUBatch(type="TRIS", buf=points)
