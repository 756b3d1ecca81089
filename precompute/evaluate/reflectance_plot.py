# SPDX-License-Identifier: GPL-3.0-or-later
"""The reflectance plot: response over wavelength and view angle, its peak, and the grating equation."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import OutputError
from ..files.atomic import atomic_path
from .reflectance import Plane, grating_curve

SUFFIXES = (".png", ".pdf", ".svg")


def check_plot_path(path: str | os.PathLike[str]) -> Path:
    """The path as it is, or OutputError if its suffix is none of `SUFFIXES`."""
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise OutputError(f"Cannot write '{path.name}': give it the suffix {', '.join(SUFFIXES)}.")
    return path


def save_plot(
    path: str | os.PathLike[str], plane: Plane, values: np.ndarray, peaks: np.ndarray, period_m: float, title: str = ""
) -> Path:
    """Draw a reflectance plot and write it atomically.

    Parameters
    ----------
    path
        ``.png``, ``.pdf`` or ``.svg``.
    plane
        What was measured.
    values
        ``(L, V)`` response; each wavelength is shown relative to its own largest value.
    peaks
        ``(L,)`` view angles of the largest response, radians.
    period_m
        The period of the grating-equation curve.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    path = check_plot_path(path)
    figure = Figure(figsize=(7.2, 5.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    nm, views = _map(axes, plane, values)
    axes.plot(nm, np.degrees(peaks), ".", color="cyan", markersize=3, label="largest response")
    label = f"grating equation, d = {period_m * 1e9:.2f} nm, order {plane.order}"
    axes.plot(nm, np.degrees(grating_curve(plane, period_m)), "--", color="white", linewidth=1, label=label)
    axes.set_xlim(nm[0], nm[-1])
    axes.set_ylim(views[0], views[-1])
    axes.set_xlabel("wavelength / nm")
    axes.set_ylabel("view angle / degrees")
    axes.set_title(title or f"light at {np.degrees(plane.theta_i):g} degrees", fontsize=10)
    axes.legend(loc="best", fontsize=8, facecolor="#404040", labelcolor="white")
    figure.colorbar(axes.images[0], label="amplitude relative to each wavelength's peak")
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=120, format=path.suffix[1:].lower())
    return path


def small_plot(plane: Plane, values: np.ndarray, period_m: float, side: int = 240) -> np.ndarray:
    """The same for a narrow panel: the map and the grating equation's curve, with numbers that can be read there.

    Parameters
    ----------
    plane, values, period_m
        As of `save_plot`.
    side
        Of the picture in pixels.

    Returns
    -------
    ndarray
        ``(side, side, 3)`` sRGB in 0..1, row 0 at the bottom.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(side / 100.0, side / 100.0), dpi=100, layout="constrained", facecolor="#303030")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    nm, views = _map(axes, plane, values)
    axes.plot(nm, np.degrees(grating_curve(plane, period_m)), "--", color="white", linewidth=1)
    axes.set_xlim(nm[0], nm[-1])
    axes.set_ylim(views[0], views[-1])
    axes.tick_params(labelsize=7, colors="white")
    axes.set_xticks((400, 500, 600, 700))
    axes.set_xlabel("wavelength / nm", fontsize=7.5, color="white")
    axes.set_ylabel("view angle / degrees", fontsize=7.5, color="white")
    canvas.draw()
    return np.asarray(canvas.buffer_rgba(), np.float32)[::-1, :, :3] / np.float32(255.0)


def _map(axes: Any, plane: Plane, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Draw the amplitude relative to each wavelength's largest; wavelengths in nm and views in degrees."""
    nm, views = plane.wavelengths_m * 1e9, np.degrees(plane.theta_r)
    largest = values.max(axis=1, keepdims=True)
    shown = np.sqrt(values / np.where(largest > 0, largest, 1.0)).T
    around = (nm[0], nm[-1], views[0], views[-1])
    axes.imshow(shown, origin="lower", aspect="auto", cmap="magma", extent=around, vmin=0, vmax=1)
    return nm, views
