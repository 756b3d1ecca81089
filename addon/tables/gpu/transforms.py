# SPDX-License-Identifier: GPL-3.0-or-later
"""The transforms of a bake on the GPU: what `PolarIntensity.coefficients` computes with scipy.

The lengths are scipy's, so both devices sum the same numbers on the same grid, in single precision.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ....precompute.bake.intensity import PolarIntensity
from .shaders import GROUP, stage

#: Largest difference of the trial's spectra, in parts of the largest value. In single precision they differ by 2e-7.
TOLERANCE = 1e-5

#: Calls a function where the GPU may be used, waits, and returns its result.
OnGpu = Callable[[Callable[[], Any]], Any]


class GpuError(RuntimeError):
    """The GPU could not do it; the processor can."""


class GpuTransforms:
    """Computes a bake's transforms with compute shaders, after a trial against the processor.

    The first spectrum is computed on both devices. Where they differ by more than `TOLERANCE` of the largest value the
    GPU is not used: drivers have errors.

    Parameters
    ----------
    on_gpu
        Blender's GPU may be used from its main thread only, while a bake works in another: calls a function there.
    race
        Whether the processor takes over if it was the faster one.

    Attributes
    ----------
    device : str
        What computed the transforms, for the user: ``processor``, or ``GPU``; with the reason where the GPU was tried
        and not used.
    """

    def __init__(self, on_gpu: OnGpu, race: bool) -> None:
        self.device = "processor"
        self._on_gpu = on_gpu
        self._race = race
        self._plan: _Plan | None = None

    def __call__(
        self, polar: PolarIntensity, kappas: np.ndarray, progress: Callable[[float], None] | None = None
    ) -> np.ndarray:
        """See `PolarIntensity.coefficients`."""
        out = np.empty((polar.y.fine * polar.x.fine, len(kappas)), np.float32)
        # The largest kappa has the widest spectrum, so the trial sees all of it and not the peak alone.
        first = int(np.argmax(kappas))
        start = time.perf_counter()
        out[:, first] = _by_processor(polar, kappas[first])
        self._try(polar, kappas[first], out[:, first], time.perf_counter() - start)
        others = [index for index in range(len(kappas)) if index != first]
        for done, index in enumerate(others, 2):
            out[:, index] = self._one(polar, kappas[index])
            if progress is not None:
                progress(done / len(kappas))
        return out

    def _try(self, polar: PolarIntensity, kappa: float, reference: np.ndarray, seconds: float) -> None:
        """Decide from one spectrum, which took the processor some seconds, who computes the others."""
        try:
            # Kept here, not in this thread's variables: textures have to be freed where they may be used.
            self._plan = self._on_gpu(partial(_Plan, polar))
            found = self._on_gpu(partial(self._plan.run, kappa))
            error = float(np.abs(found - reference).max() / np.abs(reference).max())
            if not error <= TOLERANCE:
                raise GpuError(f"the GPU is wrong by {error:.1e}")
            if self._race:
                start = time.perf_counter()
                self._on_gpu(partial(self._plan.run, kappa))  # compiled by now
                taken = time.perf_counter() - start
                if taken > seconds:
                    raise GpuError(f"the GPU takes {taken / seconds:.1f} times as long")
        except GpuError as error:
            self.device = f"processor: {error}"
        else:
            self.device = "GPU"

    def _one(self, polar: PolarIntensity, kappa: float) -> np.ndarray:
        if self.device == "GPU" and self._plan is not None:
            try:
                return self._on_gpu(partial(self._plan.run, kappa))
            except GpuError as error:
                self.device = f"processor: {error}"
        return _by_processor(polar, kappa)

    def close(self) -> None:
        """Give the GPU's memory back; from Blender's main thread."""
        if self._plan is not None:
            self._plan.free()
            self._plan = None


def _by_processor(polar: PolarIntensity, kappa: float) -> np.ndarray:
    return polar.coefficients(np.array([kappa]))[:, 0]


def radices(length: int) -> list[int]:
    """Factors of a transform's length, the large ones first; 4 where two twos allow it."""
    found = []
    for radix in (4, 2, 3, 5, 7, 11, 13):
        while length % radix == 0:
            found.append(radix)
            length //= radix
    if length > 1:
        raise GpuError(f"no transform has a prime factor as large as {length}")
    return sorted(found, reverse=True)


class _Plan:
    """Textures of one bake and the steps between them."""

    def __init__(self, polar: PolarIntensity) -> None:
        import gpu

        x, y = polar.x, polar.y
        self.x, self.y = x, y
        # Every step writes the lower left corner of one of two textures and reads the other.
        size = max(x.padded, x.band, x.fine), max(y.pixels, y.padded, y.band, y.fine)
        limit = gpu.capabilities.max_texture_size_get()
        if max(size) > limit:
            raise GpuError(f"the GPU's textures end at {limit} texels a side, the transforms need {max(size)}")
        try:
            self._from, self._to = (gpu.types.GPUTexture(size, format="RG32F") for _ in range(2))
            self._real = gpu.types.GPUTexture((x.fine, y.fine), format="R32F")
            self._heights = _texture(polar.series.heights)
            self._window = [_texture(axis[None]) for axis in polar.window_axes]
            self._lags = [_texture(axis[None]) for axis in polar.lag_axes]
            self._roots = {n: _roots(n) for n in {x.padded, y.padded, x.band, y.band, x.fine, y.fine}}
        except (RuntimeError, MemoryError, ValueError) as error:
            raise GpuError(f"the GPU has no room for textures of {size[0]} x {size[1]} complex numbers") from error

    def run(self, kappa: float) -> np.ndarray:
        """``(fine_y * fine_x,)`` coefficients at one kappa."""
        try:
            return self._run(kappa)
        except (RuntimeError, MemoryError, ValueError) as error:
            raise GpuError(f"the GPU failed ({error})") from error

    def _run(self, kappa: float) -> np.ndarray:
        x, y = self.x, self.y
        window_y, window_x = self._window
        lags_y, lags_x = self._lags
        self._step(
            "PHASE",
            (x.padded, y.pixels, x.pixels, y.pixels),
            {"df_src": self._heights, "df_along_x": window_x, "df_along_y": window_y},
            floats={"df_kappa": kappa},
        )
        self._transform(x.padded, (x.padded, y.pixels), (1, 0), 1)
        self._step("BAND", (x.band, y.padded, x.padded, y.pixels))
        self._transform(y.padded, (x.band, y.padded), (0, 1), 1)
        self._step("POWER", (x.band, y.band, 0, y.padded))
        self._transform(x.band, (x.band, y.band), (1, 0), -1)
        self._transform(y.band, (x.band, y.band), (0, 1), -1)
        self._step(
            "LAGS",
            (x.fine, y.fine, x.band, y.band),
            {"df_along_x": lags_x, "df_along_y": lags_y},
            {"df_cut": (x.cut, y.cut)},
        )
        self._transform(x.fine, (x.fine, y.fine), (1, 0), 1)
        self._transform(y.fine, (x.fine, y.fine), (0, 1), 1)
        self._step("REAL", (x.fine, y.fine, 0, 0), target=self._real)
        return np.array(self._real.read(), np.float32).reshape(-1)

    def free(self) -> None:
        """Give the memory back."""
        self.__dict__.clear()

    def _transform(self, length: int, size: tuple[int, int], along: tuple[int, int], sign: int) -> None:
        """Unnormalised discrete Fourier transform of every row or column of a corner of ``size``."""
        done = 1
        for radix in radices(length):
            self._step(
                "PASS",
                (*size, 0, 0),
                {"df_roots": self._roots[length]},
                {"df_pass": (length, done, radix, sign), "df_along": along},
            )
            done *= radix

    def _step(
        self,
        name: str,
        size: tuple[int, int, int, int],
        textures: dict[str, Any] | None = None,
        numbers: dict[str, tuple[int, ...]] | None = None,
        floats: dict[str, float] | None = None,
        target: Any = None,
    ) -> None:
        import gpu

        shader = stage(name)
        shader.uniform_int("df_size", size)
        for key, numbers_of in (numbers or {}).items():
            shader.uniform_int(key, numbers_of)
        for key, number in (floats or {}).items():
            shader.uniform_float(key, number)
        for key, texture in {"df_src": self._from, **(textures or {})}.items():
            shader.uniform_sampler(key, texture)
        shader.image("df_dst", target or self._to)
        gpu.compute.dispatch(shader, -(-size[0] // GROUP[0]), -(-size[1] // GROUP[1]), 1)
        if target is None:
            self._from, self._to = self._to, self._from


def _texture(values: np.ndarray) -> Any:
    """``(rows, cols)`` numbers, or ``(rows, cols, 2)``, as a texture of single precision."""
    import gpu

    flat = np.ascontiguousarray(values, np.float32)
    data = gpu.types.Buffer("FLOAT", flat.size, flat.reshape(-1))
    return gpu.types.GPUTexture((flat.shape[1], flat.shape[0]), format="R32F" if flat.ndim == 2 else "RG32F", data=data)


def _roots(length: int) -> Any:
    """exp(2 pi i t / length) for t = 0 ... length - 1."""
    angle = 2.0 * np.pi * np.arange(length) / length
    return _texture(np.stack([np.cos(angle), np.sin(angle)], axis=-1)[None])
