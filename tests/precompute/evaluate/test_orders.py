# SPDX-License-Identifier: GPL-3.0-or-later
"""Order efficiencies of gratings against closed forms and against the BRDF itself."""

import numpy as np
import pytest
from scipy.special import jv

from precompute.errors import ParameterError
from precompute.evaluate.direct import direct_f
from precompute.evaluate.directions import from_angles
from precompute.evaluate.orders import order_directions, order_efficiencies
from precompute.scan.heightfield import HeightField

LAMBDA = 550e-9


def geometry(theta_i, sine):
    """(1 + wi.wr)^2 / (cos_i cos_r w^2) from angles alone."""
    theta_r = np.arcsin(sine)
    return (1.0 + np.cos(theta_i + theta_r)) ** 2 / (
        np.cos(theta_i) * np.cos(theta_r) * (np.cos(theta_i) + np.cos(theta_r)) ** 2
    )


@pytest.mark.parametrize("theta_deg", [0.0, 25.0, 70.0])
def test_sinusoid_follows_bessel_functions(theta_deg):
    period, amplitude, theta = 2e-6, 80e-9, np.radians(theta_deg)
    x = (np.arange(400) + 0.5) / 400
    m, found = order_efficiencies(amplitude * np.sin(2 * np.pi * x), period, LAMBDA, theta)
    sine = np.sin(theta) + m * LAMBDA / period
    w = np.cos(theta) + np.sqrt(1.0 - sine**2)
    truth = geometry(theta, sine) * jv(m, 2 * np.pi * w * amplitude / LAMBDA) ** 2
    np.testing.assert_allclose(found, truth, rtol=1e-9, atol=1e-15)


def test_half_wave_step_has_no_mirror_order_and_odd_orders_of_a_square_wave():
    period = 20e-6  # so wide that the orders stay close to the normal
    x = (np.arange(1000) + 0.5) / 1000
    m, found = order_efficiencies(np.where(x < 0.5, LAMBDA / 4, 0.0), period, LAMBDA, 0.0)
    assert found[m == 0] < 1e-12
    assert found[m == 1] == pytest.approx(4 / np.pi**2, rel=2e-3)
    assert found[m == 3] == pytest.approx(4 / (9 * np.pi**2), rel=2e-2)


def test_orders_keep_to_the_grating_equation_and_above_the_surface():
    m, wr = order_directions(1.2e-6, LAMBDA, np.radians(40.0))
    np.testing.assert_allclose(wr[:, 0], np.sin(np.radians(40.0)) + m * LAMBDA / 1.2e-6)
    assert (wr[:, 2] > 0).all()
    np.testing.assert_allclose(np.linalg.norm(wr, axis=1), 1.0)
    # One further order on either side would lie below the horizon.
    assert np.sin(np.radians(40.0)) + (m[-1] + 1) * LAMBDA / 1.2e-6 > 1
    assert np.sin(np.radians(40.0)) + (m[0] - 1) * LAMBDA / 1.2e-6 < -1


def test_fresnel_term_is_schlick_at_the_half_angle():
    theta = np.radians(50.0)
    _, plain = order_efficiencies(np.zeros(8), 3e-6, LAMBDA, theta)
    m, real = order_efficiencies(np.zeros(8), 3e-6, LAMBDA, theta, r0=0.04)
    assert plain[m == 0] == pytest.approx(1.0, abs=1e-12)
    assert real[m == 0] == pytest.approx(0.04 + 0.96 * (1 - np.cos(theta)) ** 5, rel=1e-12)


def test_order_is_the_integral_of_the_brdf_over_its_lobe():
    """f cos_r over the first order's lobe, by the reference evaluator on 12 periods, equals its efficiency."""
    period, amplitude, sigma = 2e-6, 60e-9, 3e-6
    pixels = 240
    x = (np.arange(pixels) + 0.5) * 1e-7
    heights = np.tile(amplitude * np.sin(2 * np.pi * x / period), (pixels, 1))
    field = HeightField(heights, 1e-7, 1e-7, None, {}, ())
    theta = np.radians(20.0)
    wi = from_angles(theta, np.pi)
    m, wr = order_directions(period, LAMBDA, theta)
    _, efficiency = order_efficiencies(heights[0, :20], period, LAMBDA, theta)
    # The lobe's standard deviation in u and v is lambda / (2 pi sqrt(2) sigma); Gauss-Hermite integrates it.
    width = LAMBDA / (2 * np.pi * np.sqrt(2) * sigma)
    node, weight = np.polynomial.hermite_e.hermegauss(5)
    u, v = np.meshgrid(node * width, node * width)
    flat_weight = np.outer(weight, weight) * np.exp(0.5 * (node[:, None] ** 2 + node**2)) * width**2
    chosen = np.nonzero(np.abs(m) <= 1)[0]
    for order in chosen:
        sx, sy = wr[order, 0] + u, v
        views = np.stack([sx, sy, np.sqrt(1 - sx**2 - sy**2)], axis=-1)
        f = direct_f(field, sigma, "single", wi, views, LAMBDA)
        assert (f * flat_weight).sum() == pytest.approx(efficiency[order], rel=0.01)


@pytest.mark.parametrize(
    "arguments",
    [
        (np.zeros(1), 1e-6, LAMBDA, 0.0),
        (np.array([0.0, np.nan]), 1e-6, LAMBDA, 0.0),
        (np.zeros(4), -1e-6, LAMBDA, 0.0),
        (np.zeros(4), 1e-6, 0.0, 0.0),
        (np.zeros(4), 1e-6, LAMBDA, 2.0),
    ],
)
def test_what_makes_no_sense_is_refused(arguments):
    with pytest.raises(ParameterError):
        order_efficiencies(*arguments)
