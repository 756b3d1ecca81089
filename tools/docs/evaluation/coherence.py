# SPDX-License-Identifier: GPL-3.0-or-later
"""Convergence in the wavelength step and in sigma_s: the thesis's blazed grating at six coherence lengths.

Its labels are coherence lengths, 4 sigma_s (its window is "the gaussian window with 4 sigma_s").
"""

import numpy as np

from precompute.evaluate.directions import disc_directions, from_angles, uvw
from precompute.evaluate.disc_map import map_to_srgb
from precompute.evaluate.methods import make_method
from precompute.evaluate.methods.bins import Band
from precompute.evaluate.methods.flss import method_xyz
from precompute.presets import make_preset
from tools.docs.fill_page import table

from .common import difference_cells, new_figure, snake

_LENGTHS_UM = (3.25, 6.5, 15.0, 30.0, 45.0, 65.0)
_STEPS_NM = (40, 20, 10, 5, 2.5, 1)
_FINEST_NM = 0.5

#: Everything in the plane of incidence: v = 0.
_LINE = Band(fy=(0.0, 0.0))


def _blazed():
    return make_preset("blazed", 65e-6, 1300, period_um=2.5, depth_nm=250)


def _in_plane(theta_r):
    """Views in the plane x, z with exactly v = 0 together with `_LIGHT`."""
    return np.stack([np.sin(theta_r), np.zeros_like(theta_r), np.cos(theta_r)], axis=-1)


_LIGHT = np.array([np.sin(np.radians(20.0)), 0.0, np.cos(np.radians(20.0))])


def _wavelength_steps():
    wi = from_angles(np.radians(20.0), np.radians(225.0))
    directions, inside = disc_directions(64)
    some = np.random.default_rng(4).choice(directions[inside], 80, replace=False)
    cases = {
        "snake, sigma_s = 1.6 um": (make_method("windowed", snake(10.0, 128), 1.6e-6), wi, some),
        "blazed, sigma_s = 16.25 um": (
            make_method("windowed", _blazed(), 16.25e-6, band=_LINE),
            _LIGHT,
            _in_plane(np.radians(np.linspace(-80.0, 80.0, 641))),
        ),
    }
    rows = {step: [f"{step:g}"] for step in _STEPS_NM}
    for method, light, views in cases.values():
        reference = method_xyz(method, light, views, step_m=_FINEST_NM * 1e-9)
        for step in _STEPS_NM:
            rows[step] += difference_cells(method_xyz(method, light, views, step_m=step * 1e-9), reference)
    head = ["step, nm", *[f"{name}: {what}" for name in cases for what in ("median", "95 %", "largest")]]
    return table(head, rows.values())


def _width(method, wavelength=550e-9, period=2.5e-6):
    """Full width at half maximum in u of order 1 at one wavelength."""
    centre = wavelength / period
    u = centre + np.linspace(-0.2, 0.2, 40001) * min(1.0, 10e-6 / method.sigma_s_m)
    w = -1.9
    values = method.transform(u, np.zeros_like(u), np.full_like(u, w), wavelength)
    above = np.nonzero(values >= 0.5 * values.max())[0]
    return u[above[-1]] - u[above[0]]


def _sigmas(pictures):
    views = np.radians(np.linspace(-80.0, 80.0, 801))
    wr = _in_plane(views)
    figure = new_figure(9.0, 7.0)
    axes = figure.subplots(len(_LENGTHS_UM), 2, sharex="col", width_ratios=[2, 1])
    field, rows = _blazed(), []
    for (left, right), length in zip(axes, _LENGTHS_UM, strict=True):
        sigma = length / 4.0
        method = make_method("windowed", field, sigma * 1e-6, band=_LINE)
        xyz = method_xyz(method, _LIGHT, wr, step_m=1e-9)
        left.imshow(map_to_srgb(xyz)[None], aspect="auto", extent=(-80, 80, 0, 1))
        left.set_yticks([])
        left.set_ylabel(f"{length:g} um", rotation=0, ha="right", va="center")
        near = np.radians(np.linspace(-37.0, -31.0, 301))
        u, _, w = uvw(_LIGHT, _in_plane(near))
        response = method.transform(u, np.zeros_like(u), w, 550e-9)
        right.plot(np.degrees(near), response / response.max())
        right.set_yticks([])
        # |P|^2 of an endless surface is a Gaussian of this width in u; of the patch alone sinc^2 of that.
        window = 2.0 * np.sqrt(np.log(2.0)) * 550e-9 / (2.0 * np.pi * sigma * 1e-6)
        patch = 0.886 * 550e-9 / 65e-6
        rows.append([f"{length:g}", f"{sigma:g}", *[f"{1e3 * value:.2f}" for value in (_width(method), window, patch)]])
    axes[0, 0].set_title("colours in the plane of incidence, light at 20 degrees", fontsize=10)
    axes[0, 1].set_title("order 1 at 550 nm", fontsize=10)
    for axis in axes[-1]:
        axis.set_xlabel("view angle, degrees")
    figure.savefig(pictures / "evaluation_sigma.png")
    head = [
        "coherence length, um",
        "sigma_s, um",
        "width of order 1 in u, 1e-3",
        "of the window alone",
        "of the patch alone (65 um)",
    ]
    return table(head, rows)


def run(pictures):
    """Blocks `wavelength step` and `sigma`."""
    blocks = {"wavelength step": _wavelength_steps()}
    print("wavelength step", flush=True)
    blocks["sigma"] = _sigmas(pictures)
    print("sigma", flush=True)
    return blocks
