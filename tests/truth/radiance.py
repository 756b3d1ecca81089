# SPDX-License-Identifier: GPL-3.0-or-later
"""Radiance under directional light, written down from the formulas of docs/architecture.md."""

import numpy as np


def local(direction, t, b, n):
    """Components of world directions along the frames."""
    return np.stack([(direction * axis).sum(-1) for axis in np.broadcast_arrays(t, b, n)], -1)


def f_cos_xyz(table, wi, wr, conserve=True):
    """f cos(theta_i) with R = 1 as XYZ, for local directions above the surface (0 elsewhere)."""
    wi, wr = np.broadcast_arrays(wi, wr)
    lit = (wi[..., 2] > 0) & (wr[..., 2] > 0)
    safe_i, safe_r = (np.where(lit[..., None], x, (0.0, 0.0, 1.0)) for x in (wi, wr))
    u, v, w = np.moveaxis(-(safe_i + safe_r), -1, 0)
    factor = (1 + (safe_i * safe_r).sum(-1)) ** 2 / (safe_r[..., 2] * w**2)
    if conserve:
        factor = factor / np.maximum(1.0, np.maximum(table.conserving_albedo(safe_i), table.conserving_albedo(safe_r)))
    return np.where(lit[..., None], factor[..., None] * table.transform(u, v, w), 0.0)


def gamut_step(xyz, to_rgb):
    """RGB moved towards the grey of luminance Y until no component is negative."""
    rgb = xyz @ np.asarray(to_rgb).T
    grey, lowest = xyz[..., 1:2], rgb.min(-1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        moved = grey + (rgb - grey) * grey / (grey - lowest)
    return np.where(lowest < 0, np.maximum(np.where(grey > 0, moved, 0.0), 0.0), rgb)


def dielectric(ior, wi, wr):
    """Fresnel's reflectance of unpolarised light at the half-angle, by the angles inside and outside."""
    out = np.arccos(np.sqrt(np.clip(0.5 * (1 + (wi * wr).sum(-1)), 0, 1 - 1e-12)))
    inside = np.arcsin(np.sin(out) / ior)
    return 0.5 * (
        (np.sin(out - inside) / np.sin(out + inside)) ** 2 + (np.tan(out - inside) / np.tan(out + inside)) ** 2
    )


def schlick(ior, wi, wr):
    """Schlick's reflectance at the half-angle."""
    cos_half = np.sqrt(np.clip(0.5 * (1 + (wi * wr).sum(-1)), 0, 1))
    r0 = ((ior - 1) / (ior + 1)) ** 2
    return r0 + (1 - r0) * (1 - cos_half) ** 5
