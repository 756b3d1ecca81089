# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums over the directions above a surface: even grids, grids that are fine near the mirror direction, and the spread
of the sampler that follows f cos exactly.
"""

import numpy as np

from tests.truth import radiance


def hemisphere(steps=400):
    """Directions above the surface and the solid angle of each."""
    theta = (np.arange(steps) + 0.5) / steps * np.pi / 2
    phi = (np.arange(steps) + 0.5) / steps * 2 * np.pi
    theta, phi = np.meshgrid(theta, phi)
    wi = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    return wi, np.sin(theta) * (np.pi / 2 / steps) * (2 * np.pi / steps)


def direction(theta, phi):
    """Unit vector of polar angle and azimuth in degrees."""
    theta, phi = np.radians(theta), np.radians(phi)
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def around_the_mirror(wr, radii=500, turns=360):
    """Directions above the surface and their solid angles: polar in (u, v), fine near the specular direction."""
    edges = 0.004 * np.sinh(np.linspace(0.0, np.arcsinh(2.0 / 0.004), radii + 1))
    phi = (np.arange(turns) + 0.5) * (2 * np.pi / turns)
    r, phi = np.meshgrid(0.5 * (edges[1:] + edges[:-1]), phi)
    x, y = -r * np.cos(phi) - wr[0], -r * np.sin(phi) - wr[1]
    z2 = 1 - x**2 - y**2
    good = z2 > 1e-6
    wi = np.stack([x[good], y[good], np.sqrt(z2[good])], -1)
    area = np.broadcast_to(np.diff(edges**2) * (np.pi / turns), r.shape)
    return wi, area[good] / wi[:, 2]


def ideal_spread(table, wr, light):
    """Mean and relative spread of one sample of the sampler whose density is the luminance of f cos."""
    wi, cell = around_the_mirror(wr)
    f_cos = radiance.f_cos_xyz(table, wi, wr)[:, 1] * cell
    mean = (f_cos * light(wi)).sum()
    return mean, np.sqrt(f_cos.sum() * (f_cos * light(wi) ** 2).sum() / mean**2 - 1)
