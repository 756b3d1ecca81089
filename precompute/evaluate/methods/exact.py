# SPDX-License-Identifier: GPL-3.0-or-later
"""`direct`: the reference evaluator with the interface of the methods; one sum over all pixels a point."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...scan.heightfield import HeightField
from ..direct import DirectEvaluator
from ..surface import coherence_area


class Exact:
    """See `precompute.evaluate.direct.DirectEvaluator`."""

    def __init__(self, field: HeightField, sigma_s_m: float, ensemble: str = "single") -> None:
        self._evaluator = DirectEvaluator(field, sigma_s_m, ensemble)
        self.area_m2 = coherence_area(field.shape, field.dx, field.dy, sigma_s_m, ensemble)
        self.facts: dict[str, Any] = {"series": "none", "pixels": int(field.heights.size)}

    def transform(self, u: np.ndarray, v: np.ndarray, w: np.ndarray, wavelength_m: float) -> np.ndarray:
        """T_lambda in 1/sr for arrays (u, v, w) that broadcast."""
        u, v, w = np.broadcast_arrays(*(np.asarray(a, float) for a in (u, v, w)))
        points = zip(u.ravel(), v.ravel(), w.ravel(), strict=True)
        return np.array([self._evaluator.transform(*point, wavelength_m) for point in points]).reshape(u.shape)
