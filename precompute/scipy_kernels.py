# SPDX-License-Identifier: GPL-3.0-or-later
"""scipy's transforms and sparse product without the rest of scipy.

``import scipy.fft`` loads special functions, linear algebra and numpy's compiler of Fortran, which takes as long as
half a bake; ``scipy.sparse`` is little better. What computes is one extension module each, which is loaded alone here,
under its own name, so that scipy finds it where it is imported after all. Where a release of scipy keeps it elsewhere,
its public functions do the same with the same results.

All run in the caller's thread and free the interpreter: a bake has its threads work on different lines. The transforms
run along one axis, without a factor; they read and write views, and ``out`` may be the input.
"""

from __future__ import annotations

import importlib.util
import sys
import threading
from functools import lru_cache
from importlib.machinery import EXTENSION_SUFFIXES, ExtensionFileLoader, FileFinder
from pathlib import Path
from typing import Any

import numpy as np

#: Where the releases of scipy that are bundled keep their kernels: packages below scipy, and module in them.
FOURIER = (("fft", "_duccfft", "pyduccfft"), ("fft", "_pocketfft", "pypocketfft"))
SPARSE = (("sparse", "_sparsetools"),)

_LOCK = threading.Lock()


def fast_length(least: int, real: bool = False) -> int:
    """The shortest length of small prime factors that is at least ``least``."""
    return _fourier().good_size(least, real)


def transform(a: np.ndarray, axis: int, out: np.ndarray, forward: bool) -> np.ndarray:
    """``sum a exp(-+ 2 pi i j k / n)`` of complex values along an axis, with - where ``forward``."""
    return _fourier().c2c(a, (axis,), forward, 0, out, 1)


def real_transform(a: np.ndarray, axis: int, out: np.ndarray) -> np.ndarray:
    """``sum a exp(-2 pi i j k / n)`` of real values; ``out`` has ``n // 2 + 1`` values along the axis."""
    return _fourier().r2c(a, (axis,), True, 0, out, 1)


def real_inverse(a: np.ndarray, axis: int, out: np.ndarray) -> np.ndarray:
    """``sum a exp(+2 pi i j k / n)`` of the half ``a`` of a spectrum whose other half is its conjugate; real."""
    return _fourier().c2r(a, (axis,), out.shape[axis], False, 0, out, 1)


def sparse_product(
    indices: np.ndarray,
    weights: np.ndarray,
    dense: np.ndarray,
    pointers: np.ndarray | None = None,
    out: np.ndarray | None = None,
) -> np.ndarray:
    """``sum_j weights[i, j] dense[indices[i, j]]``, every row with as many terms, or as `pointers` say.

    Parameters
    ----------
    indices, weights
        ``(n, m)`` int32 and float32, contiguous; flat with pointers.
    dense
        ``(rows, k)`` float32, contiguous.
    pointers
        ``(n + 1,)`` int32: the first term of each row, and the end.
    out
        ``(n, k)`` float32, contiguous, overwritten; a new array for None.

    Returns
    -------
    ndarray
        ``(n, k)`` float32.
    """
    if pointers is None:
        pointers = _pointers(indices)
    rows = len(pointers) - 1
    tools = extension(SPARSE)
    if tools is None:
        from scipy.sparse import csr_array

        product = csr_array((weights.ravel(), indices.ravel(), pointers), shape=(rows, len(dense))) @ dense
        if out is None:
            return product
        out[...] = product
        return out
    if out is None:
        out = np.zeros((rows, dense.shape[1]), np.float32)
    else:
        out[...] = 0.0
    flat = (weights.reshape(-1), dense.reshape(-1), out.reshape(-1))
    tools.csr_matvecs(rows, len(dense), dense.shape[1], pointers, indices.reshape(-1), *flat)
    return out


def spread_product(indices: np.ndarray, weights: np.ndarray, dense: np.ndarray, rows: int) -> np.ndarray:
    """``(rows, k)``: ``weights[i, j] dense[i]`` added up at the rows ``indices[i, j]``.

    Parameters
    ----------
    indices, weights
        ``(n, m)`` int32 and float32, contiguous.
    dense
        ``(n, k)`` float32, contiguous.
    rows
        How many.
    """
    count, pointers, tools = len(indices), _pointers(indices), extension(SPARSE)
    if tools is None:
        from scipy.sparse import csc_array

        return csc_array((weights.ravel(), indices.ravel(), pointers), shape=(rows, count)) @ dense
    out = np.zeros((rows, dense.shape[1]), np.float32)
    flat = (weights.reshape(-1), dense.reshape(-1), out.reshape(-1))
    tools.csc_matvecs(rows, count, dense.shape[1], pointers, indices.reshape(-1), *flat)
    return out


def scattered(indices: np.ndarray, weights: np.ndarray, columns: int) -> np.ndarray:
    """``(n, columns)`` zeros with ``weights[i, j]`` added at ``[i, indices[i, j]]``.

    Parameters
    ----------
    indices, weights
        ``(n, m)`` int32 and float32, contiguous.
    columns
        How many.
    """
    rows, pointers, tools = len(indices), _pointers(indices), extension(SPARSE)
    if tools is None:
        from scipy.sparse import csr_array

        return csr_array((weights.ravel(), indices.ravel(), pointers), shape=(rows, columns)).toarray()
    out = np.zeros((rows, columns), np.float32)
    tools.csr_todense(rows, columns, pointers, indices.reshape(-1), weights.reshape(-1), out)
    return out


def _pointers(indices: np.ndarray) -> np.ndarray:
    """``(n + 1,)`` the first term of each row of ``(n, m)`` terms, and the end."""
    return np.arange(0, indices.size + 1, indices.shape[1], dtype=np.int32)


@lru_cache(maxsize=1)
def _fourier() -> Any:
    return extension(FOURIER) or _Public()


@lru_cache(maxsize=8)
def extension(places: tuple[tuple[str, ...], ...]) -> Any:
    """The first extension module of scipy that stands in one of some places, loaded alone; None where none does."""
    with _LOCK:
        for place in places:
            name = ".".join(("scipy", *place))
            if name in sys.modules:
                return sys.modules[name]
            found = importlib.util.find_spec("scipy")
            for root in (found.submodule_search_locations or ()) if found else ():
                folder = str(Path(root, *place[:-1]))
                spec = FileFinder(folder, (ExtensionFileLoader, EXTENSION_SUFFIXES)).find_spec(place[-1])
                origin = spec.origin if spec else None
                spec = importlib.util.spec_from_file_location(name, origin) if origin else None
                if spec is not None and spec.loader is not None:
                    module = importlib.util.module_from_spec(spec)
                    spec.loader.exec_module(module)
                    sys.modules[name] = module
                    return module
        return None


class _Public:
    """The transforms by scipy's public functions."""

    def good_size(self, least: int, real: bool) -> int:
        from scipy.fft import next_fast_len

        return next_fast_len(least, real)

    def c2c(self, a: np.ndarray, axes: tuple[int], forward: bool, _: int, out: np.ndarray, __: int) -> np.ndarray:
        from scipy.fft import fft, ifft

        out[...] = fft(a, axis=axes[0]) if forward else ifft(a, axis=axes[0], norm="forward")
        return out

    def r2c(self, a: np.ndarray, axes: tuple[int], _: bool, __: int, out: np.ndarray, ___: int) -> np.ndarray:
        from scipy.fft import rfft

        out[...] = rfft(a, axis=axes[0])
        return out

    def c2r(
        self, a: np.ndarray, axes: tuple[int], size: int, _: bool, __: int, out: np.ndarray, ___: int
    ) -> np.ndarray:
        from scipy.fft import irfft

        out[...] = irfft(a, size, axis=axes[0], norm="forward")
        return out
