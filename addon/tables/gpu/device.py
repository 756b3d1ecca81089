# SPDX-License-Identifier: GPL-3.0-or-later
"""Which device computes the transforms of a bake."""

from __future__ import annotations

from ....precompute.errors import ParameterError
from ...gpu_context import NoGpu, ensure_gpu
from ...versions import computes

ITEMS = [
    (
        "AUTO",
        "Automatic",
        "The GPU that Blender draws with, where there is one and it is the faster; else the processor",
    ),
    ("CPU", "Processor", "All processors, in scipy"),
    ("GPU", "GPU", "Compute shaders on the GPU that Blender draws with"),
]


def renderer() -> tuple[str, bool] | None:
    """Name of the GPU of this process and whether it is hardware; None where Blender has no GPU context."""
    import gpu

    try:
        return gpu.platform.renderer_get(), gpu.platform.device_type_get() != "SOFTWARE"
    except SystemError:  # what the module raises without a context
        return None


def use_gpu(wish: str) -> bool:
    """Whether a bake starts on the GPU.

    Parameters
    ----------
    wish
        Of `ITEMS`. ``AUTO`` takes a context that exists and makes none: a render farm's machine may have no driver
        to make one with. A software rasteriser is never faster than scipy, so ``AUTO`` leaves it alone.

    Raises
    ------
    ParameterError
        If ``GPU`` is wanted and Blender cannot have one, or cannot compute with it.
    """
    if wish == "CPU":
        return False
    if not computes():
        if wish == "GPU":
            raise ParameterError("This Blender computes transforms wrongly on a GPU; bake with the device Processor.")
        return False
    if wish == "GPU":
        try:
            ensure_gpu()
        except NoGpu as error:
            raise ParameterError("Blender has no GPU context here; bake with the device Processor.") from error
        return True
    found = renderer()
    return found is not None and found[1]
