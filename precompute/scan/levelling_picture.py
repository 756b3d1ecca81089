# SPDX-License-Identifier: GPL-3.0-or-later
"""One picture of what levelling did: heights before and after, their histogram, and the spectrum with its lattice."""

from __future__ import annotations

from typing import Any

import numpy as np

from .heightfield import HeightField
from .lattice import Lattice, find_lattice, power_spectrum

_BACKGROUND, _INK, _BEFORE, _AFTER, _MARK = "#1d1d1d", "#d8d8d8", "#8a8a8a", "#e8a33d", "#4fd0e0"

#: Decades of power that the spectrum shows below its largest value.
_DECADES = 6.0


def levelling_picture(before: HeightField, after: HeightField, size: tuple[int, int] = (1280, 960)) -> np.ndarray:
    """Draw the levelling preview.

    Parameters
    ----------
    before
        The scan as read.
    after
        As it will be diffracted.
    size
        Width and height in pixels.

    Returns
    -------
    ndarray
        ``(height, width, 3)`` display values 0 to 1, row 0 at the bottom.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(size[0] / 100, size[1] / 100), dpi=100, facecolor=_BACKGROUND, layout="constrained")
    axes = figure.subplots(2, 2).ravel()
    _heights(figure, axes[0], before, "Before")
    _heights(figure, axes[1], after, "After")
    _histogram(axes[2], before, after)
    _spectrum(axes[3], after)
    for one in axes:
        _style(one)
    return _pixels(FigureCanvasAgg(figure))


def levelling_thumbnail(before: HeightField, after: HeightField, side: int = 320) -> np.ndarray:
    """The same for the width of a sidebar: what is left of it there can be read.

    Parameters
    ----------
    before, after
        See `levelling_picture`.
    side
        Of the square picture, in pixels.

    Returns
    -------
    ndarray
        ``(side, side, 3)`` display values 0 to 1, row 0 at the bottom.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.2, 3.2), dpi=side / 3.2, facecolor=_BACKGROUND, layout="constrained")
    axes = figure.subplots(2, 2).ravel()
    for axis, field, title in zip(axes, (before, after), ("Before", "After"), strict=False):
        nm = _shown_heights(axis, field)[0]
        axis.set_title(f"{title}\n{np.nanmax(nm) - np.nanmin(nm):.4g} nm high")
    _histogram(axes[2], before, after, legend=False)
    axes[2].set_title("Histogram")
    found = _spectrum(axes[3], after, spacings=False)
    axes[3].set_title(f"Period {1e6 * found.spacings_m[0]:.4g} um" if len(found.frequencies) else "No lattice")
    for one in axes:
        _style(one)
        one.set(xticks=[], yticks=[], xlabel="", ylabel="")
    return _pixels(FigureCanvasAgg(figure))


def _pixels(canvas) -> np.ndarray:
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[::-1, :, :3] / 255.0


def _shown_heights(axis, field: HeightField) -> tuple[np.ndarray, Any]:
    nm = 1e9 * np.where(field.missing, np.nan, field.heights)
    low, high = np.nanpercentile(nm, [0.5, 99.5])
    extent = (0.0, 1e6 * field.size_m[0], 0.0, 1e6 * field.size_m[1])
    return nm, axis.imshow(
        nm, origin="lower", extent=extent, cmap="cividis", vmin=low, vmax=high, interpolation="nearest"
    )


def _heights(figure, axis, field: HeightField, title: str) -> None:
    nm, shown = _shown_heights(axis, field)
    bar = figure.colorbar(shown, ax=axis, label="nm", fraction=0.05)
    bar.ax.tick_params(colors=_INK, labelsize=8)
    bar.ax.yaxis.label.set_color(_INK)
    rows, cols = field.shape
    rms = float(np.nanstd(nm))
    axis.set_title(f"{title}: {cols} x {rows} px, {np.nanmax(nm) - np.nanmin(nm):.4g} nm high, rms {rms:.4g} nm")
    axis.set_xlabel("x (um)")
    axis.set_ylabel("y (um)")


def _histogram(axis, before: HeightField, after: HeightField, legend: bool = True) -> None:
    values = [1e9 * (field.valid - np.median(field.valid)) for field in (before, after)]
    low, high = min(v.min() for v in values), max(v.max() for v in values)
    edges = np.linspace(low, max(high, low + 1e-3), 161)
    for heights, colour, label in zip(values, (_BEFORE, _AFTER), ("before", "after"), strict=True):
        counts = np.histogram(heights, edges)[0] / heights.size * 100.0
        axis.stairs(counts, edges, fill=True, color=colour, alpha=0.6, label=label)
    axis.set_title("Histogram of the heights")
    axis.set_xlabel("height above the median (nm)")
    axis.set_ylabel("% of the pixels")
    if legend:
        axis.legend(facecolor=_BACKGROUND, edgecolor="none", labelcolor=_INK, fontsize=9)


def _spectrum(axis, field: HeightField, spacings: bool = True) -> Lattice:
    power, fx, fy = power_spectrum(field)
    level = np.log10(np.maximum(power, power.max() * 10.0**-_DECADES) + np.finfo(float).tiny)
    lattice = find_lattice(field)
    found = lattice.frequencies * 1e-6
    # Up to three times the lattice, so that its points stand apart; all of it where there is none.
    reach = 3.0 * np.hypot(found[:, 0], found[:, 1]).max() if len(found) else 5.0
    reach = min(reach, np.abs(fx).max() * 1e-6, np.abs(fy).max() * 1e-6)
    half = 0.5 * (fx[1] - fx[0]) * 1e-6, 0.5 * (fy[1] - fy[0]) * 1e-6
    extent = (1e-6 * fx[0] - half[0], 1e-6 * fx[-1] + half[0], 1e-6 * fy[0] - half[1], 1e-6 * fy[-1] + half[1])
    axis.imshow(level, origin="lower", extent=extent, cmap="inferno", interpolation="nearest")
    axis.set_xlim(-reach, reach)
    axis.set_ylim(-reach, reach)
    for vector, spacing in zip(found, lattice.spacings_m, strict=True):
        for sign in (1.0, -1.0):
            axis.plot(*(sign * vector), "o", markersize=13, markerfacecolor="none", markeredgecolor=_MARK)
        axis.annotate("", vector, (0.0, 0.0), arrowprops={"arrowstyle": "->", "color": _MARK})
        if spacings:
            axis.annotate(
                f"{1e6 * spacing:.4g} um", vector, color=_MARK, textcoords="offset points", xytext=(10, 6), fontsize=10
            )
    axis.set_title("Spectrum and lattice" if len(found) else "Spectrum (no lattice found)")
    axis.set_xlabel("fx (1/um)")
    axis.set_ylabel("fy (1/um)")
    return lattice


def _style(axis) -> None:
    axis.set_facecolor("black")
    axis.tick_params(colors=_INK, labelsize=8)
    for part in (axis.title, axis.xaxis.label, axis.yaxis.label):
        part.set_color(_INK)
        part.set_fontsize(10)
    for spine in axis.spines.values():
        spine.set_color("#606060")
