# SPDX-License-Identifier: GPL-3.0-or-later
"""The heightfield: what every reader returns and every computation takes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..errors import ScanError


@dataclass(frozen=True, eq=False)
class HeightField:
    """A rectangular patch of surface heights.

    Parameters
    ----------
    heights
        ``(rows, cols)`` float64, metres, growing along the surface normal. Row 0 is the
        *bottom* of the scan (y up), column 0 its left. Finite wherever ``missing`` is False.
    dx, dy
        Pixel size along x (columns) and y (rows) in metres; the patch is ``cols * dx`` by
        ``rows * dy``. Pixel (r, c) has its centre at ``((c + 1/2) dx, (r + 1/2) dy)``.
    missing
        ``(rows, cols)`` bool, True where the instrument gave no height.
    metadata
        What is known of the origin: ``format``, ``channel``, ``channels``, ``instrument`` ...
    processing
        One dict a step, in order, e.g. ``{"step": "level", "method": "poly2"}``.

    Raises
    ------
    ScanError
        If the array is not two-dimensional with at least 2 x 2 pixels, a size is not positive
        and finite, or a height that is not marked missing is not finite.
    """

    heights: np.ndarray
    dx: float
    dy: float
    missing: np.ndarray = None  # type: ignore[assignment]  # None stands for a mask without any point
    metadata: dict[str, Any] = field(default_factory=dict)
    processing: tuple[dict[str, Any], ...] = ()

    def __post_init__(self) -> None:
        heights = np.ascontiguousarray(self.heights, dtype=np.float64)
        if heights.ndim != 2 or min(heights.shape) < 2:
            raise ScanError(
                f"The scan has the shape {tuple(heights.shape)}; a heightfield needs at least 2 x 2 pixels."
            )
        for name, size in (("x", self.dx), ("y", self.dy)):
            if not (np.isfinite(size) and size > 0):
                raise ScanError(f"The pixel size along {name} is {size} m; give the scan a positive size.")
        missing = np.zeros(heights.shape, bool) if self.missing is None else np.asarray(self.missing, bool)
        if missing.shape != heights.shape:
            raise ScanError(f"The missing-data mask has the shape {missing.shape}, the heights {heights.shape}.")
        if missing.all():
            raise ScanError("The scan holds no valid height at all; choose another channel or file.")
        if not np.isfinite(heights[~missing]).all():
            raise ScanError("The scan holds infinite or undefined heights that are not marked as missing.")
        object.__setattr__(self, "heights", heights)
        object.__setattr__(self, "missing", missing)
        object.__setattr__(self, "dx", float(self.dx))
        object.__setattr__(self, "dy", float(self.dy))
        object.__setattr__(self, "processing", tuple(self.processing))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.heights.shape

    @property
    def size_m(self) -> tuple[float, float]:
        """Side lengths along x and y in metres."""
        return self.shape[1] * self.dx, self.shape[0] * self.dy

    @property
    def valid(self) -> np.ndarray:
        """The heights that were measured, as a flat array in metres."""
        return self.heights[~self.missing]

    def processed(self, step: dict[str, Any], **changes: Any) -> HeightField:
        """A copy with ``changes`` (field values) and ``step`` appended to the processing list."""
        return replace(self, processing=(*self.processing, step), **changes)
