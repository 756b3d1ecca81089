# SPDX-License-Identifier: GPL-3.0-or-later
"""Hold the scan against the grating equation."""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np

from .. import pictures, properties
from ..given import take
from ..jobs.job import Job, Progress
from ..jobs.threaded import Threaded, busy, has_scan
from ..numbers import decimal
from ..tables import bake_settings, scan_store

#: Name of the image.
IMAGE = "Diffraction Reflectance"

#: Views, and wavelengths in metres.
_VIEWS, _WAVELENGTHS = 600, np.arange(380, 781, 10) * 1e-9


class DIFFRACTION_OT_reflectance(Threaded, bpy.types.Operator):
    """Plot the scan's response over wavelength and view against the grating equation, and estimate its period"""

    bl_idname = "diffraction.reflectance"
    bl_label = "Reflectance Plot"
    bl_options = {"UNDO", "PRESET"}
    title = "Reflectance"

    theta: properties.plot_theta()
    order: properties.plot_order()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return has_scan(cls, context) and not busy(cls)

    def jobs(self, context: bpy.types.Context) -> list[Job]:
        """Read, prepare, sum and draw, away from Blender."""
        take(self, context.scene.diffraction, ("theta", "order"), "plot_")
        source, reading = scan_store.bake_source(context.scene)
        chosen = bake_settings.parameters(context.scene.diffraction)
        theta, order = decimal(self.theta), self.order
        folder = pictures.scratch_folder()

        def work(progress: Progress) -> Any:
            from ...precompute.errors import ParameterError
            from ...precompute.evaluate import reflectance
            from ...precompute.evaluate.reflectance_plot import save_plot, small_plot
            from ...precompute.readers import read_scan
            from ...precompute.scan.lattice import find_lattice
            from ...precompute.scan.preparation import prepare

            progress("read", 0.0)
            patch = prepare(read_scan(source, **reading), chosen)
            lattice = find_lattice(patch)
            if not len(lattice.frequencies):
                raise ParameterError("The scan has no dominant period that the grating equation could be held against.")
            period, vector = float(lattice.spacings_m[0]), lattice.frequencies[0]
            plane = reflectance.Plane(
                theta, views(period, theta, order), _WAVELENGTHS, math.atan2(vector[1], vector[0]), order
            )
            values, _ = reflectance.response(
                patch, plane, progress=lambda text, done: progress(text, 0.1 + 0.8 * done), sigma_s_m=chosen.sigma_s_m
            )
            peaks, periods = reflectance.estimated_periods(plane, values)
            progress("draw", 0.9)
            path = save_plot(folder / "diffraction_reflectance.png", plane, values, peaks, period)
            picture = pictures.Picture(path, small_plot(plane, values, period))
            return picture, float(periods.mean()), float(periods.std()), period

        return [Job(work)]

    def finished(self, context: bpy.types.Context, results: list[Any]) -> str:
        """The plot becomes an image."""
        ((picture, mean, spread, period),) = results
        pictures.show_file(context, IMAGE, picture)
        text = f"Period by the colours {mean * 1e9:.1f} nm (spread {spread * 1e9:.1f} nm), by the heights "
        context.scene.diffraction.plot_result = text + f"{period * 1e9:.1f} nm"
        return context.scene.diffraction.plot_result


def views(period_m: float, theta_i: float, order: int) -> np.ndarray:
    """``(V,)`` view angles round those at which an order leaves, from violet to red.

    Raises
    ------
    ParameterError
        If the order does not leave for any of the wavelengths.
    """
    from ...precompute.errors import ParameterError

    sines = np.sort(order * _WAVELENGTHS[[0, -1]] / period_m - math.sin(theta_i))
    margin = 0.1 * (sines[1] - sines[0])
    low, high = max(sines[0] - margin, -0.98), min(sines[1] + margin, 0.98)
    if high - low < 0.5 * margin:
        raise ParameterError(
            f"Order {order} of a period of {period_m * 1e9:.0f} nm does not leave under this light; turn the light or"
            " take another order."
        )
    return np.linspace(math.asin(low), math.asin(high), _VIEWS)


CLASSES = (DIFFRACTION_OT_reflectance,)
