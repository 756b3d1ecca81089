# SPDX-License-Identifier: GPL-3.0-or-later
"""The three ways to the transform of p against a brute-force sum over pixels."""

import math

import numpy as np
import pytest

from precompute.bake.series import Series, bessel_order, chebyshev_nodes, node_weights, taylor_bound, taylor_order
from precompute.bake.terms import load_terms, make_terms, save_terms
from precompute.errors import ParameterError
from precompute.parameters import BakeParameters
from precompute.scan.heightfield import HeightField

KAPPA_MAX = 4 * np.pi / 380e-9


def rough(pixels=64, rms=50e-9, seed=5):
    rng = np.random.default_rng(seed)
    return rng.normal(0.0, rms, (pixels, pixels)).clip(-150e-9, 150e-9)


@pytest.mark.parametrize("method", ["taylor", "chebyshev", "nodes"])
def test_series_equals_the_brute_force_transform(method):
    heights = rough()
    rng = np.random.default_rng(1)
    frequencies = rng.uniform(-0.5, 0.5, (25, 2))  # cycles a pixel, off every bin
    index = np.arange(64)
    wave_x = np.exp(2j * np.pi * np.outer(index, frequencies[:, 0]))
    wave_y = np.exp(2j * np.pi * np.outer(frequencies[:, 1], index))

    def transform(p):
        return np.einsum("fy,yx,xf->f", wave_y, np.asarray(p, np.complex128), wave_x)

    series = Series(heights, np.ones((64, 64)), KAPPA_MAX, method, 1e-6, transform)
    kappas = np.array([0.02, 0.3, 0.71, 1.0]) * KAPPA_MAX
    for kappa, amplitude in zip(kappas, series.amplitudes(kappas, group=3), strict=True):
        p = np.exp(-1j * kappa * heights)
        truth = transform(p)
        largest = np.abs(p).sum()  # |P| cannot be larger than at the frequency where all pixels add up
        largest = min(largest, max(np.abs(truth).max(), np.abs(p.sum())))
        # heights are centred on their range, which turns every transform by one phase
        centre = 0.5 * (heights.min() + heights.max())
        assert np.abs(amplitude * np.exp(-1j * kappa * centre) - truth).max() <= 1e-5 * largest


def test_taylor_bound_gives_the_numbers_of_the_thesis():
    x = 1.5 * np.pi
    for order, bound in ((20, 2.9950e-4), (25, 8.8150e-8), (30, 1.0050e-11)):
        assert taylor_bound(x, order) == pytest.approx(bound, rel=1e-3)
    assert taylor_order(x, 2.9950e-4 * 1.001) == 20
    assert taylor_order(x, 8.8150e-8 * 1.001) == 25


def test_taylor_refuses_what_double_precision_cannot_reach():
    with pytest.raises(ParameterError, match="double precision"):
        taylor_order(30.0, 1e-6)


def test_bessel_order_bounds_the_remainder():
    from scipy.special import jv

    for x in (0.1, 2.0, 6.6, 13.5):
        for tolerance in (1e-3, 1e-6):
            order = bessel_order(x, tolerance)
            tail = 2 * np.abs(jv(np.arange(order + 1, order + 80), x)).sum()
            assert tail <= tolerance
            assert 2 * np.abs(jv(np.arange(order, order + 80), x)).sum() > tolerance or order <= math.ceil(x)


def test_node_weights_are_exact_for_polynomials():
    nodes = chebyshev_nodes(3.0, 7)
    at = np.linspace(0.0, 3.0, 11)
    weights = node_weights(nodes, 3.0, at)
    for degree in range(7):
        assert weights @ nodes**degree == pytest.approx(at**degree, abs=1e-9)


@pytest.mark.parametrize("method", ["taylor", "chebyshev"])
def test_stored_terms_give_the_dft_of_p(tmp_path, method):
    heights = rough(48, 30e-9)
    field = HeightField(heights, 60e-9, 80e-9)
    parameters = BakeParameters(series=method, tolerance=1e-5)
    folder = save_terms(field, parameters, tmp_path / "patch.exr")
    assert make_terms(field, parameters).images.shape[0] == len(list(folder.glob("*.exr")))
    terms = load_terms(folder)
    for kappa in (0.1 * KAPPA_MAX, 0.9 * KAPPA_MAX):
        p = np.exp(-1j * kappa * heights)
        x = (np.arange(48) * 60e-9)[None, :]
        y = (np.arange(48) * 80e-9)[:, None]
        got = np.abs(terms.evaluate(kappa))
        for row, col in ((3, 5), (20, 30), (len(terms.fy) - 2, 1)):
            truth = abs((p * np.exp(2j * np.pi * (terms.fx[col] * x + terms.fy[row] * y))).sum())
            assert got[row, col] == pytest.approx(truth, abs=2e-5 * np.abs(p.sum()))


def test_bessel_functions_are_scipys():
    from scipy.special import jv

    from precompute.bake.series import bessel_functions

    for x in (0.0, 1e-12, 1e-6, 0.3, 1.0, 7.5, 14.9, 60.0, 250.0, 390.0):
        count = int(x) + 120
        found = bessel_functions(count, x)
        assert np.abs(found - jv(np.arange(count), x)).max() < 1e-13
        few = np.arange(int(x) + 10)
        assert np.allclose(found[: len(few)], jv(few, x), rtol=1e-9, atol=1e-13 if x > 1 else 1e-17)
