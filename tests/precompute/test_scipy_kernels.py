# SPDX-License-Identifier: GPL-3.0-or-later
"""scipy's kernels loaded alone give what scipy gives, and a bake in a fresh process loads no more of scipy."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from precompute import scipy_kernels as k

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(params=["extension", "public"])
def kernels(request, monkeypatch):
    """The module with scipy's extensions, and as if a release of scipy kept them elsewhere."""
    if request.param == "public":
        monkeypatch.setattr(k, "FOURIER", (("fft", "nowhere"),))
        monkeypatch.setattr(k, "SPARSE", (("sparse", "nowhere"),))
    k._fourier.cache_clear()
    yield k
    k._fourier.cache_clear()


def test_the_bundled_scipy_has_them():
    assert k.extension(k.FOURIER) is not None
    assert k.extension(k.SPARSE) is not None


@pytest.mark.parametrize("kind", [np.complex64, np.complex128])
@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("forward", [True, False])
def test_complex_transforms(kernels, kind, axis, forward):
    """On a view, in place, against numpy."""
    random = np.random.default_rng(5)
    a = (random.normal(size=(30, 44)) + 1j * random.normal(size=(30, 44))).astype(kind)
    view = a[2:26, 3:39]
    expected = np.fft.fft(view, axis=axis) if forward else np.fft.ifft(view, axis=axis, norm="forward")
    outside = a[:2].copy()
    kernels.transform(view, axis, view, forward)
    tolerance = 1e-5 if kind == np.complex64 else 1e-12
    assert np.abs(view - expected).max() < tolerance * np.abs(expected).max()
    assert np.array_equal(a[:2], outside)


@pytest.mark.parametrize("axis", [0, 1])
def test_real_transforms_and_back(kernels, axis):
    random = np.random.default_rng(6)
    a = random.normal(size=(28, 36)).astype(np.float32)
    shape = [28, 36]
    shape[axis] = shape[axis] // 2 + 1
    half = kernels.real_transform(a, axis, np.empty(shape, np.complex64))
    assert np.abs(half - np.fft.rfft(a, axis=axis)).max() < 1e-5 * np.abs(half).max()
    back = kernels.real_inverse(half, axis, np.empty_like(a))
    assert np.abs(back / a.shape[axis] - a).max() < 1e-5


def test_fast_lengths(kernels):
    from scipy.fft import next_fast_len

    for least in (1, 7, 13, 101, 1999, 4097):
        for real in (False, True):
            assert kernels.fast_length(least, real) == next_fast_len(least, real)


def test_sparse_product(kernels):
    random = np.random.default_rng(7)
    indices = random.integers(0, 50, (40, 16)).astype(np.int32)
    weights = random.normal(size=(40, 16)).astype(np.float32)
    dense = random.normal(size=(50, 5)).astype(np.float32)
    expected = np.einsum("ij,ijk->ik", weights.astype(float), dense[indices].astype(float))
    assert np.abs(kernels.sparse_product(indices, weights, dense) - expected).max() < 1e-5


def test_rows_of_any_number_of_terms(kernels):
    random = np.random.default_rng(8)
    pointers = np.array([0, 3, 3, 10, 12], np.int32)
    indices, weights = random.integers(0, 9, 12).astype(np.int32), random.normal(size=12).astype(np.float32)
    dense = random.normal(size=(9, 4)).astype(np.float32)
    rows = np.repeat(np.arange(4), np.diff(pointers))
    expected = np.zeros((4, 4))
    np.add.at(expected, rows, weights[:, None] * dense[indices])
    assert kernels.sparse_product(indices, weights, dense, pointers) == pytest.approx(expected, rel=1e-5, abs=1e-6)


def test_spread_product(kernels):
    random = np.random.default_rng(10)
    indices = random.integers(0, 9, (30, 4)).astype(np.int32)
    weights, dense = (random.normal(size=(30, k)).astype(np.float32) for k in (4, 6))
    expected = np.zeros((9, 6))
    np.add.at(expected, indices, weights[:, :, None] * dense[:, None, :])
    assert kernels.spread_product(indices, weights, dense, 9) == pytest.approx(expected, rel=1e-5, abs=1e-5)


def test_scattered(kernels):
    """Weights for one place are added up."""
    random = np.random.default_rng(9)
    indices = random.integers(0, 7, (5, 12)).astype(np.int32)
    weights = random.normal(size=(5, 12)).astype(np.float32)
    expected = np.zeros((5, 7))
    np.add.at(expected, (np.arange(5)[:, None], indices), weights)
    assert kernels.scattered(indices, weights, 7) == pytest.approx(expected, rel=1e-5, abs=1e-6)


PROGRAM = """
import sys
from precompute.bake import bake
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
table = bake(make_preset("sinusoid", 6e-6, 64), BakeParameters(detail=0.2))
print(sorted(name for name in sys.modules if name.startswith("scipy")))
import scipy.fft, scipy.sparse
import numpy as np
a = np.random.default_rng(1).normal(size=(4, 12))
assert np.allclose(scipy.fft.fft2(a), np.fft.fft2(a))
assert np.allclose((scipy.sparse.csr_array(a) @ a.T), a @ a.T)
"""


def test_a_bake_loads_these_kernels_and_scipy_works_afterwards():
    done = subprocess.run([sys.executable, "-c", PROGRAM], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    fourier = next(name for name in (".".join(("scipy", *place)) for place in k.FOURIER) if name in done.stdout)
    assert done.stdout.strip() == str([fourier, "scipy.sparse._sparsetools"])
