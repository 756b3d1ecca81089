# SPDX-License-Identifier: GPL-3.0-or-later
"""Light of the surroundings, gathered over the drawings of a view that stands still.

A drawing looks in a few directions, the same for all pixels (``shaders/sky.glsl``), between which narrow orders fall.
While nothing changes each drawing looks in others, and what the view shows is the mean of all of them.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

#: Directions in all, of views that stand still.
DIRECTIONS = 512

#: Views whose means are kept.
_VIEWS = 4

#: Step of the lattice that the directions of one drawing are (``sky_places`` in ``shaders/sky.glsl``).
_STEP = 0.6180339887


@cache
def moves(together: int, directions: int) -> tuple[tuple[float, float], ...]:
    """Where each of several drawings looks into the surroundings, see `blocks.Frame`.

    All their directions together are one lattice of rank 1, k / n and the fraction of g k: with n g = `_STEP` each
    drawing is every n-th point of it, and of the n such g that one is taken whose points keep apart most. The first
    drawings lie evenly among all (van der Corput 1935).

    Parameters
    ----------
    together
        Drawings that make a mean.
    directions
        Of each drawing.
    """
    number = np.arange(together)
    inverse, base, left = np.zeros(together), 0.5, number.copy()
    while left.any():
        inverse, base, left = inverse + base * (left & 1), 0.5 * base, left >> 1
    rank = np.empty(together, int)
    rank[np.argsort(inverse, kind="stable")] = number
    n = together * directions
    k = np.arange(1, int(1.2 * n**0.5) + 2)  # n points are never farther apart than 1.08 / sqrt(n)
    steps = (_STEP + number) / together
    beside = (np.outer(steps, k) + 0.5) % 1.0 - 0.5
    step = steps[np.hypot(k / n, beside).min(-1).argmax()]
    x, y = ((rank + 0.5) / together + 0.5) % 1.0, rank * step % 1.0
    return tuple(zip(x.tolist(), y.tolist(), strict=True))


@dataclass(eq=False)
class Gathered:
    """The mean of a view, which each drawing that is added reads from one target and writes to the other.

    Without blending, which not every GPU has for numbers that precise.
    """

    size: tuple[int, int]
    drawings: int = 1
    state: Hashable = None
    count: int = 0
    #: What the last drawing read: textures that were still on their way make the mean worthless.
    read: Hashable = None
    _targets: list[tuple[Any, Any, Any]] = field(default_factory=list)

    def due(self) -> range:
        """Numbers of the drawings to add now.

        None at first: while a view moves it is drawn as it is. Then two, so that the mean is better than that.
        """
        first, last = self.count, self.count + (2 if self.count == 0 else 1)
        return range(first, min(last, self.drawings))

    @property
    def is_done(self) -> bool:
        """Whether further drawings would add nothing."""
        return self.count >= self.drawings

    def begin(self) -> tuple[Any, Any]:
        """The framebuffer to write to and the texture to read from."""
        import gpu

        if not self._targets:
            # Not GPUOffScreen, which leaves another framebuffer bound than it found. A framebuffer keeps no textures.
            depth = gpu.types.GPUTexture(self.size, format="DEPTH_COMPONENT32F")
            for _ in range(2):
                colour = gpu.types.GPUTexture(self.size, format="RGBA16F")
                self._targets.append((gpu.types.GPUFrameBuffer(depth_slot=depth, color_slots=(colour,)), colour, depth))
        return self._targets[0][0], self._targets[1][1]

    def end(self, read: Hashable) -> None:
        """A drawing was added."""
        self._targets.reverse()
        self.count = self.count + 1 if self.count == 0 or read == self.read else 0
        self.read = read

    @property
    def mean(self) -> Any:
        """The texture, as large as the view."""
        return self._targets[1][1]


class Gathering:
    """What each view has gathered, by its key; the last few views are kept."""

    def __init__(self) -> None:
        self._views: OrderedDict[Hashable, Gathered] = OrderedDict()

    def of(self, view: Hashable, size: tuple[int, int], state: Hashable, drawings: int) -> Gathered | None:
        """The mean of a view, or None in its first drawing after a change.

        Parameters
        ----------
        view
            Tells views apart.
        size
            Width and height in pixels.
        state
            Changes with whatever the picture shows.
        drawings
            How many make the mean.
        """
        held = self._views.get(view)
        if held is None or held.size != size:
            held = self._views[view] = Gathered(size)
            while len(self._views) > _VIEWS:
                self._views.popitem(last=False)
        self._views.move_to_end(view)
        if held.state != state or held.drawings != drawings:
            held.state, held.drawings, held.count = state, drawings, 0
            return None
        return held

    def wants_more(self, view: Hashable) -> bool:
        """Whether another drawing of a view, as it is, would show it better."""
        held = self._views.get(view)
        return held is not None and held.state is not None and not held.is_done

    def has_begun(self, view: Hashable) -> bool:
        """Whether a view shows what it has gathered."""
        held = self._views.get(view)
        return held is not None and held.count > 0

    def forget(self, view: Hashable) -> None:
        """Nothing is gathered in a view: what was is let go of."""
        self._views.pop(view, None)

    def clear(self) -> None:
        """Let go of all."""
        self._views.clear()
