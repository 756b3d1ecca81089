# SPDX-License-Identifier: GPL-3.0-or-later
"""The terms of the reference method in the memory of the GPU."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ....precompute.bake.terms import Terms, load_terms
from ....precompute.constants import COHERENCE_LENGTH_SUN_M
from ....precompute.errors import SizeLimitError, TableError
from ....precompute.files.stamp import file_stamp
from .blocks import buffer, uniform
from .sources import WAVELENGTHS_MAX

#: 380 to 770 nm in steps of 5 nm: the 79 wavelengths of the thesis.
WAVELENGTHS_M = 380e-9 + 5e-9 * np.arange(79)

#: The coherence window of sunlight, where the table was not baked with a single window of its own.
SIGMA_S_M = COHERENCE_LENGTH_SUN_M / 4.0

#: Methods as the shader numbers them.
_METHODS = {"taylor": 0.0, "chebyshev": 1.0}


@dataclass(eq=False)
class SeriesOnGpu:
    """Terms as the layers of an array texture, and the block that says how to sum them."""

    uniform: Any
    terms: Any
    stamp: tuple


def rows(
    terms: Terms,
    sigma_s_m: float,
    shape: tuple[int, int],
    size_m: tuple[float, float],
    illuminant: str,
    adapted: bool = False,
) -> np.ndarray:
    """``(3 + WAVELENGTHS_MAX, 4)`` rows of the block ``DiffractionSeries``.

    Parameters
    ----------
    terms
        From `precompute.bake.terms`.
    sigma_s_m
        Standard deviation of the coherence window.
    shape, size_m
        Rows and columns of the patch that the terms were made of; its sides along x and y in metres.
    illuminant
        Spectrum of the light.
    adapted
        Whether the colours are to be adapted to D65, as those of the table beside it are.
    """
    from ....precompute.bake.window import gaussian_axis
    from ....precompute.light.colour import adaptation, spectral_weights

    count_y, count_x = shape
    dx, dy = size_m[0] / count_x, size_m[1] / count_y
    g_x, g_y = gaussian_axis(count_x, dx, sigma_s_m), gaussian_axis(count_y, dy, sigma_s_m)
    # T = |P|^2 / (A lambda^2), P = dx dy sum g p exp(..), A = dx dy sum g^2.
    scale = dx * dy / ((g_x @ g_x) * (g_y @ g_y))
    step_x, step_y = terms.fx[1] - terms.fx[0], terms.fy[1] - terms.fy[0]
    wavelengths, weights = spectral_weights(WAVELENGTHS_M, illuminant)
    to_adapted = adaptation(illuminant) if adapted else None
    if to_adapted is not None:
        weights = weights @ to_adapted.T
    out = np.zeros((3 + WAVELENGTHS_MAX, 4), np.float32)
    out[0] = terms.fx[0], terms.fy[0], step_x, step_y
    # The window's transform in units of bins: its width, and its height at the centre over the patch's area.
    window = 2.0 * np.pi * sigma_s_m**2 * step_x * step_y
    out[1] = 2.0 * (np.pi * sigma_s_m * step_x) ** 2, 2.0 * (np.pi * sigma_s_m * step_y) ** 2, window**2 * scale, 0.0
    out[2] = len(terms.images), _METHODS[terms.method], terms.kappa_max, terms.half_range
    out[3 : 3 + len(wavelengths), :3] = weights
    out[3 : 3 + len(wavelengths), 3] = wavelengths
    out[1, 3] = len(wavelengths)
    return out


def upload(terms: Terms, block: np.ndarray) -> tuple[Any, Any]:
    """Uniform buffer and array texture.

    Raises
    ------
    SizeLimitError
        If this GPU has no texture that large.
    """
    import gpu

    count, height, width = terms.images.shape
    side, layers = gpu.capabilities.max_texture_size_get(), gpu.capabilities.max_texture_layers_get()
    if max(width, height) > side or count > layers:
        raise SizeLimitError(
            f"The {count} terms of {width} x {height} texels are too large for this GPU; use the method Table."
        )
    texels = np.stack([terms.images.real, terms.images.imag], axis=-1).astype(np.float32)
    try:
        texture = gpu.types.GPUTexture((width, height), layers=count, format="RG32F", data=buffer(texels))
    except (RuntimeError, MemoryError) as error:
        raise SizeLimitError("The GPU has no memory for the terms; use the method Table.") from error
    return uniform(block), texture


class SeriesTextures:
    """Terms by the path of their table."""

    def __init__(self) -> None:
        self._held: dict[Path, SeriesOnGpu] = {}

    def get(self, path: Path, info: dict) -> SeriesOnGpu:
        """Terms that were stored beside a table.

        Raises
        ------
        TableError, SizeLimitError
            If there are none, or they do not fit.
        """
        folder = path.with_name(f"{path.stem}_terms")
        file = folder / "terms.json"
        stamp = file_stamp(file)
        if stamp is None:
            raise TableError(
                f"The method FLSS needs the series terms of {path.stem}: bake with the series 'taylor' or 'chebyshev'"
                " and store the terms, or use the method Table."
            )
        held = self._held.get(path)
        if held is None or held.stamp != stamp:
            self._held.pop(path, None)
            terms = load_terms(folder)
            if terms.key and terms.key != info.get("key", terms.key):
                raise TableError(f"The series terms beside {path.name} are of another bake; bake the scan again.")
            # The window of the thesis, whatever the table was baked with.
            sigma = info["parameters"]["sigma_s_m"] if info["parameters"]["ensemble"] == "single" else None
            block = rows(
                terms,
                sigma or SIGMA_S_M,
                tuple(info["source"]["shape"]),
                tuple(info["source"]["size_m"]),
                info["colour"]["illuminant"],
                bool(info["colour"].get("adapted")),
            )
            held = self._held[path] = SeriesOnGpu(*upload(terms, block), stamp)
        return held

    def keep(self, paths: set[Path]) -> None:
        """Drop all but these."""
        for path in self._held.keys() - paths:
            del self._held[path]

    def clear(self) -> None:
        """Drop all."""
        self._held.clear()
