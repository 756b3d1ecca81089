# SPDX-License-Identifier: GPL-3.0-or-later
"""The compute shaders of `fft.glsl`, one a stage."""

from __future__ import annotations

from functools import cache
from typing import Any

from ...shader_files import SHADERS

#: Threads of a group along x and y.
GROUP = (16, 16)

#: What each stage reads besides `df_src`, and its numbers besides `df_size`.
_SAMPLERS = {
    "PHASE": ("df_along_x", "df_along_y"),
    "PASS": ("df_roots",),
    "BAND": (),
    "POWER": (),
    "LAGS": ("df_along_x", "df_along_y"),
    "REAL": (),
}
_NUMBERS = {
    "PHASE": (("FLOAT", "df_kappa"),),
    "PASS": (("IVEC4", "df_pass"), ("IVEC2", "df_along")),
    "LAGS": (("IVEC2", "df_cut"),),
}


@cache
def stage(name: str) -> Any:
    """The compiled shader of a stage; its output is complex (RG32F), of ``REAL`` real (R32F)."""
    import gpu

    info = gpu.types.GPUShaderCreateInfo()
    info.define(f"STAGE_{name}", "1")
    info.local_group_size(*GROUP)
    info.image(0, "R32F" if name == "REAL" else "RG32F", "FLOAT_2D", "df_dst", qualifiers={"WRITE"})
    for slot, sampler in enumerate(("df_src", *_SAMPLERS[name])):
        info.sampler(slot, "FLOAT_2D", sampler)
    info.push_constant("IVEC4", "df_size")
    for kind, number in _NUMBERS.get(name, ()):
        info.push_constant(kind, number)
    info.compute_source((SHADERS / "fft.glsl").read_text(encoding="utf-8"))
    return gpu.shader.create_from_info(info)
