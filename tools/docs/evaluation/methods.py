# SPDX-License-Identifier: GPL-3.0-or-later
"""All methods side by side on one piece of skin: time, and colour difference from direct summation."""

import time

import numpy as np

from precompute.bake.baking import bake
from precompute.evaluate.colour_difference import delta_e_2000
from precompute.evaluate.direct import direct_xyz
from precompute.evaluate.directions import disc_directions, from_angles
from precompute.evaluate.disc_map import exposure_of, map_to_srgb
from precompute.evaluate.methods import make_method
from precompute.evaluate.methods.flss import method_xyz
from precompute.evaluate.surface import brdf
from precompute.parameters import BakeParameters
from tools.docs.fill_page import table

from .common import difference_cells, new_figure, snake

_SIZE_UM, _PIXELS, _SIGMA = 10.0, 128, 1.6e-6
_MAP = 36
_STEP = 5e-9


def _timed(make, evaluate):
    """What was made, its values, seconds of both."""
    start = time.perf_counter()
    made = make()
    middle = time.perf_counter()
    values = evaluate(made)
    return values, middle - start, time.perf_counter() - middle


def _single(field, wi, wr):
    """``{name: (values, seconds to prepare, seconds to evaluate)}`` with one coherence window."""

    def by_method(name, **options):
        return _timed(
            lambda: make_method(name, field, _SIGMA, **options), lambda made: method_xyz(made, wi, wr, step_m=_STEP)
        )

    def by_table(series):
        parameters = BakeParameters(sigma_s_m=_SIGMA, ensemble="single", series=series)
        return _timed(lambda: bake(field, parameters), lambda made: brdf(made, wi, wr))

    return {
        "direct": by_method("direct"),
        "windowed, Chebyshev": by_method("windowed"),
        "windowed, Taylor": by_method("windowed", series="taylor"),
        "windowed 3 x 3": by_method("windowed3x3"),
        "flss": by_method("flss"),
        "table, nodes": by_table("nodes"),
        "table, Chebyshev": by_table("chebyshev"),
        "table, Taylor": by_table("taylor"),
        "pq, one copy": by_method("pq", replicas=(1, 1)),
    }


def _average(field, wi, wr, exposure):
    """The row of the mean over all windows, against direct summation of the same at fewer directions."""
    chosen = np.random.default_rng(3).choice(len(wr), 80, replace=False)
    parameters = BakeParameters(sigma_s_m=_SIGMA, ensemble="average")
    values, prepared, seconds = _timed(lambda: bake(field, parameters), lambda made: brdf(made, wi, wr))
    reference = direct_xyz(field, _SIGMA, "average", wi, wr[chosen])
    cells = difference_cells(values[chosen], reference, exposure)
    return ["table, nodes, average (against direct, average)", f"{prepared:.2f}", _micro(seconds, len(wr)), *cells]


def _micro(seconds, count):
    return f"{1e6 * seconds / count:.3g}"


def _draw(found, inside, exposure, path):
    """Maps above, differences below."""
    shown = [name for name in found if name not in ("windowed, Taylor", "table, Chebyshev", "table, Taylor")]
    reference = found["direct"][0]
    figure = new_figure(2.0 * len(shown), 4.6)
    axes = figure.subplots(2, len(shown))
    for column, name in zip(axes.T, shown, strict=True):
        picture = np.zeros((*inside.shape, 3))
        picture[inside] = map_to_srgb(found[name][0], exposure)
        column[0].imshow(picture, origin="lower")
        column[0].set_title(name, fontsize=9)
        difference = np.full(inside.shape, np.nan)
        difference[inside] = delta_e_2000(found[name][0], reference, exposure)
        image = column[1].imshow(difference, origin="lower", vmin=0, vmax=10, cmap="magma")
        for axis in column:
            axis.axis("off")
    figure.colorbar(image, ax=axes[1], shrink=0.8, label="Delta E 2000")
    figure.savefig(path)


def run(pictures):
    """Block `methods`."""
    field = snake(_SIZE_UM, _PIXELS)
    wi = from_angles(np.radians(20.0), np.radians(225.0))
    directions, inside = disc_directions(_MAP)
    wr = directions[inside]
    # The first call loads colour-science.
    method_xyz(make_method("pq", snake(2.0, 32)), wi, wr[:2])
    found = _single(field, wi, wr)
    print("methods", flush=True)
    reference = found["direct"][0]
    exposure = exposure_of(reference)
    rows = [
        [name, f"{prepared:.2f}", _micro(seconds, len(wr)), *difference_cells(values, reference, exposure)]
        for name, (values, prepared, seconds) in found.items()
    ]
    rows.append(_average(field, wi, wr, exposure))
    _draw(found, inside, exposure, pictures / "evaluation_methods.png")
    head = ["method", "prepare, s", "a direction, us", "Delta E median", "95 %", "largest"]
    return {"methods": table(head, rows)}
