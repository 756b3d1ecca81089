# SPDX-License-Identifier: GPL-3.0-or-later
"""From a patch to the smoothed intensity of one kappa: four rounds of transforms along lines, in threads.

1. rows: p is made, padded and transformed along x; the band of visible frequencies is kept;
2. columns: transformed along y, squared, and transformed along y again to the lags, of which few are kept;
3. rows of lags: along x to the lags, weighted, and back along x to the fine frequencies;
4. columns: back along y.

A thread takes some lines at a time through all steps of a round, so that they stay in its cache; what lies between two
rounds is kept once, whatever the number of threads. No array is padded to two dimensions.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ..constants import FREQUENCY_MAX
from ..scipy_kernels import fast_length, real_inverse, real_transform, transform

#: Lags beyond this many sigma_s are cut: exp(-6.5^2 / 4) = 2.6e-5.
LAG_CUT = 6.5

#: Part of the light that may wrap around to other lags: as much as the lag at the cut weighs.
WRAPPED = float(np.exp(-(LAG_CUT**2) / 4.0))

#: Side of the lag square that the last transform sees, in cut lags: room for the B-spline.
LAG_ROOM = 1.2

#: Frequencies kept beyond the visible band, in widths of the coherence lobe.
BAND_MARGIN = 6.0

#: Bytes of the lines that a thread works on at a time: within the second level of its cache.
_LINE_BYTES = 2**19

#: Fills lines ``(n, pixels)`` of complex numbers: the rows of p that the slice names.
Rows = Callable[[slice, np.ndarray], None]


def lobe_width(sigma_s_m: float) -> float:
    """Standard deviation s_f = 1 / (2 pi sqrt(2) sigma_s) of the intensity's lobe in spatial frequency (1/m)."""
    return 1.0 / (2.0 * np.pi * np.sqrt(2.0) * sigma_s_m)


def workers() -> int:
    """Threads for transforms: all processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def least_period(window: np.ndarray, cut: int, step: float, sigma_s_m: float, smoothed: bool) -> int:
    """Least length of a periodic transform whose lags are right up to some cut.

    A lag D of period P also holds the lag P - D. Of that a window w lets through ``a(P - D) / a(0)`` at most, a its
    autocorrelation, and the lags' own weights ``exp(-D^2 / (4 sigma_s^2))`` of that: together no more than
    `WRAPPED` of the whole light.

    Parameters
    ----------
    window
        ``(pixels,)`` w.
    cut
        Lags that are looked at, in pixels.
    step, sigma_s_m
        Metres.
    smoothed
        Whether lags have these weights.
    """
    count = len(window)
    own = np.fft.irfft(np.abs(np.fft.rfft(window, 2 * count)) ** 2, 2 * count)[:count]
    # The largest of what lies beyond each lag, from the longest lag inwards: growing.
    beyond = np.maximum.accumulate(np.maximum(own[::-1] / own[0], 0.0))
    lags = np.arange(cut + 1)
    weights = np.exp(-((lags * step / sigma_s_m) ** 2) / 4.0) if smoothed else np.ones(cut + 1)
    nearest = count - np.searchsorted(beyond, WRAPPED / weights, side="right")
    return max(int((lags + nearest).max()), count) + 1


@dataclass(frozen=True)
class Axis:
    """One axis of the transforms: from pixels to cropped frequencies, lags and fine frequencies."""

    pixels: int
    step: float  # pixel size, m
    padded: int  # length of the first transform
    band: int  # frequencies kept (even)
    cut: int  # lags kept on either side
    fine: int  # length of the last transform

    @classmethod
    def plan(
        cls,
        pixels: int,
        step: float,
        sigma_s_m: float,
        frequency_max: float = FREQUENCY_MAX,
        window: np.ndarray | None = None,
        smoothed: bool = False,
    ) -> Axis:
        """Lengths for one axis of a patch.

        Parameters
        ----------
        pixels, step
            Number and size (metres).
        sigma_s_m, frequency_max
            Coherence window, metres; largest frequency, 1/m.
        window, smoothed
            ``(pixels,)`` what the patch is multiplied by, and whether its lags are weighted with
            ``exp(-D^2 / (4 sigma_s^2))``: lags that hardly count may then wrap around. None pads until none does.
        """
        length = pixels * step
        lag_cut = min(length, LAG_CUT * sigma_s_m)
        if window is None:
            padded = fast_length(int(np.ceil((length + lag_cut) / step)) + 1)
        else:
            # Of factors 2, 3 and 5 alone, which transforms are quick with.
            padded = fast_length(least_period(window, int(np.ceil(lag_cut / step)), step, sigma_s_m, smoothed), True)
        top = frequency_max + BAND_MARGIN * lobe_width(sigma_s_m)
        # Even and of small prime factors.
        band = 2 * fast_length(int(np.ceil(top * padded * step)) + 1, real=True)
        lag_step = padded * step / band
        cut = min(int(np.ceil(lag_cut / lag_step)), band // 2 - 1)
        fine = 2 * fast_length(int(np.ceil(LAG_ROOM * cut)) + 4, real=True)
        return cls(pixels, step, padded, band, cut, fine)

    @property
    def lag_step(self) -> float:
        return self.padded * self.step / self.band

    @property
    def frequency_step(self) -> float:
        """Step of the fine frequency grid, 1/m."""
        return 1.0 / (self.fine * self.lag_step)

    def band_runs(self) -> list[tuple[slice, slice]]:
        """Where the band, in FFT order, stands in the padded transform: runs of (places in the band, places in it).

        The transform is periodic, and a band wider than it takes values twice.
        """
        runs = []
        half = self.band // 2
        for place, frequency in ((0, 0), (half, -half)):
            end = place + half
            while place < end:
                start = frequency % self.padded
                count = min(end - place, self.padded - start)
                runs.append((slice(place, place + count), slice(start, start + count)))
                place, frequency = place + count, frequency + count
        return runs


class Transforms:
    """The four rounds for patches of one size.

    Parameters
    ----------
    x, y
        Lengths and steps along both axes.
    lag_axes
        ``(fine_y,)`` and ``(fine_x,)`` weights of the lags, in FFT order.
    """

    def __init__(self, x: Axis, y: Axis, lag_axes: tuple[np.ndarray, np.ndarray]) -> None:
        self.x, self.y = x, y
        # Every second lag with the other sign: frequency zero comes to lie in the middle of the fine grid.
        sign_y, sign_x = (1.0 - 2.0 * (np.arange(axis.fine) % 2) for axis in (y, x))
        self._lag_y = (lag_axes[0] * sign_y)[: y.cut + 1, None].astype(np.float32)
        self._lag_x = (lag_axes[1] * sign_x).astype(np.float32)
        self._local = threading.local()
        self._rooms: dict[str, np.ndarray] = {}

    def band(self, rows: Rows, kind: np.dtype | type, pool: ThreadPoolExecutor) -> np.ndarray:
        """``(rows, band)`` round 1: ``sum p exp(+2 pi i f x)`` along x; overwritten by the next."""
        x = self.x
        out = self._room("band", (self.y.pixels, x.band), kind)
        runs = x.band_runs()

        def work(here: slice) -> None:
            lines = self._buffer("padded x", (here.stop - here.start, x.padded), kind)
            rows(here, lines[:, : x.pixels])
            lines[:, x.pixels :] = 0.0
            transform(lines, 1, lines, forward=False)
            for place, source in runs:
                out[here, place] = lines[:, source]

        _all(pool, work, self.y.pixels, out.itemsize * x.padded)
        return out

    def spectrum(self, band: np.ndarray, pool: ThreadPoolExecutor) -> np.ndarray:
        """``(band, band)`` the spectrum itself, of the same kind as the band, frequencies in FFT order."""
        out = np.empty((self.y.band, self.x.band), band.dtype)

        def work(here: slice) -> None:
            lines = self._along_y(band, here)
            for place, source in self.y.band_runs():
                out[place, here] = lines[source]

        _all(pool, work, self.x.band, out.itemsize * self.y.padded)
        return out

    def of_band(self, band: np.ndarray, out: np.ndarray, pool: ThreadPoolExecutor) -> None:
        """Rounds 2 to 4 of what `band` gave; ``out`` ``(fine_y, fine_x)`` gets the intensity, frequency zero amid."""
        runs = self.y.band_runs()

        def power(here: slice, target: np.ndarray, spare: np.ndarray) -> None:
            lines = self._along_y(band, here)
            for place, source in runs:
                _square(lines[source], target[place], spare[place])

        self._smoothed(power, out, pool)

    def of_spectrum(self, spectrum: np.ndarray, out: np.ndarray, pool: ThreadPoolExecutor) -> None:
        """The same of what `spectrum` gave."""

        def power(here: slice, target: np.ndarray, spare: np.ndarray) -> None:
            _square(spectrum[:, here], target, spare)

        self._smoothed(power, out, pool)

    def _along_y(self, band: np.ndarray, here: slice) -> np.ndarray:
        """``(padded, n)`` some columns of a band transformed along y."""
        lines = self._buffer("padded y", (self.y.padded, here.stop - here.start), band.dtype)
        lines[: self.y.pixels] = band[:, here]
        lines[self.y.pixels :] = 0.0
        return transform(lines, 0, lines, forward=False)

    def _smoothed(
        self, power: Callable[[slice, np.ndarray, np.ndarray], None], out: np.ndarray, pool: ThreadPoolExecutor
    ) -> None:
        x, y = self.x, self.y
        # R(D) belongs to a real power: the half with D_y >= 0 holds it all.
        lags = self._room("lags", (y.cut + 1, x.band), np.complex64)
        half = self._room("half", (y.cut + 1, x.fine), np.complex64)

        def to_lags(here: slice) -> None:
            count = here.stop - here.start
            squares = self._buffer("power", (y.band, count), np.float32)
            power(here, squares, self._buffer("spare", (y.band, count), np.float32))
            found = self._buffer("lags", (y.band // 2 + 1, count), np.complex64)
            lags[:, here] = real_transform(squares, 0, found)[: y.cut + 1]

        def weigh(here: slice) -> None:
            line = lags[here]
            transform(line, 1, line, forward=True)
            fine = half[here]
            fine[:, : x.cut + 1] = line[:, : x.cut + 1]
            fine[:, x.cut + 1 : x.fine - x.cut] = 0.0
            fine[:, x.fine - x.cut :] = line[:, x.band - x.cut :]
            fine *= self._lag_x
            fine *= self._lag_y[here]
            transform(fine, 1, fine, forward=False)

        def to_frequencies(here: slice) -> None:
            count = here.stop - here.start
            lines = self._buffer("half y", (y.fine // 2 + 1, count), np.complex64)
            lines[: y.cut + 1] = half[:, here]
            lines[y.cut + 1 :] = 0.0
            out[:, here] = real_inverse(lines, 0, self._buffer("fine y", (y.fine, count), np.float32))

        _all(pool, to_lags, x.band, 8 * y.padded)
        _all(pool, weigh, y.cut + 1, 8 * x.band)
        _all(pool, to_frequencies, x.fine, 8 * y.fine)

    def _room(self, name: str, shape: tuple[int, int], kind: np.dtype | type) -> np.ndarray:
        """Room for what lies between two rounds, used again for the next kappa."""
        room = self._rooms.get(name)
        if room is None or room.shape != shape or room.dtype != kind:
            room = self._rooms[name] = np.empty(shape, kind)
        return room

    def free(self) -> None:
        """Give the room between the rounds back."""
        self._rooms.clear()

    def _buffer(self, name: str, shape: tuple[int, int], kind: np.dtype | type) -> np.ndarray:
        """Room that this thread uses again and again."""
        size = shape[0] * shape[1]
        room = getattr(self._local, name, None)
        if room is None or room.size < size or room.dtype != kind:
            room = np.empty(size, kind)
            setattr(self._local, name, room)
        return room[:size].reshape(shape)


def interleave(planes: np.ndarray, out: np.ndarray, pool: ThreadPoolExecutor) -> None:
    """Copy planes ``(n, rows, cols)`` to ``out`` ``(rows, cols, n)``, a group of rows a thread."""

    def work(here: slice) -> None:
        out[here] = planes[:, here].transpose(1, 2, 0)

    _all(pool, work, planes.shape[1], 8 * planes.shape[0] * planes.shape[2])


def _square(values: np.ndarray, out: np.ndarray, spare: np.ndarray) -> None:
    np.square(values.real, out=out, casting="same_kind", dtype=np.float32)
    np.square(values.imag, out=spare, casting="same_kind", dtype=np.float32)
    out += spare


def _all(pool: ThreadPoolExecutor, work: Callable[[slice], None], count: int, line_bytes: int) -> None:
    """Do the work on all lines, a group of them at a time; whole multiples of 8, which transforms take at once."""
    step = max(8, _LINE_BYTES // line_bytes // 8 * 8)
    groups = iter([slice(start, min(start + step, count)) for start in range(0, count, step)])

    def next_groups() -> None:
        for group in groups:  # a list's iterator gives each to one thread, and threads need not be woken for each
            work(group)

    for done in [pool.submit(next_groups) for _ in range(workers())]:
        done.result()
