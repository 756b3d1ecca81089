# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference evaluator: the BRDF of a heightfield by direct summation, slow and exact.

It takes any two directions and any wavelength and shares no shortcut with the spectral table: no series and
no interpolation in kappa, no grid of radii and angles, no cut of lags. Only `geometry_factor` of ``surface.py`` is
common to both.

``single``: one Gaussian window g in the middle of the patch,

    P = integral g p exp(i k (u x + v y)) dx dy,     p = exp(i k w h),     T = |P|^2 / (A lambda^2),  A = integral g^2

``periodic``: the same with g = 1 over all copies of the period that the heightfield already holds.

``average``: the mean over all window positions. With the taper t of the patch's rim, R(D) the autocorrelation of
p t and R_t = integral t^2,

    T = 1 / (lambda^2 R_t) integral R(D) exp(-|D|^2 / (4 sigma_s^2)) exp(i k (u Dx + v Dy)) dD

which the convolution theorem turns into a sum over spatial frequencies near f0 = (u, v) / lambda,

    T = 1 / (lambda^2 R_t) integral |F{p t}(f)|^2 G(f0 - f) df,     G(f) = 4 pi sigma_s^2 exp(-4 pi^2 sigma_s^2 |f|^2).

F is summed pixel by pixel at each f (two matrix products; the patch is a product grid). The frequency
step keeps every alias of the lags where the lag Gaussian is below 1e-10, and the range leaves out 1e-10 of G,
so the sum over all lags is met to about ten digits.
"""

from __future__ import annotations

import numpy as np

from ..bake.window import check_ensemble, check_sigma_s, window_axis
from ..constants import WAVELENGTH_MIN_M
from ..errors import ParameterError, ScanError
from ..light.colour import spectral_weights
from ..light.illuminant import Illuminant
from ..parameters import BakeParameters
from ..scan.heightfield import HeightField
from ..stack import Material, Stack
from .surface import coherence_area, geometry_factor, lacquer_factor, lacquer_uvw, relative_factor

#: Aliased lags lie at least this many sigma_s beyond the patch, where the lag Gaussian is exp(-25).
_LAG_MARGIN = 10.0

#: Half width of the frequency range in standard deviations of G.
_FREQUENCY_RANGE = 7.0

#: Steps of the wavelength integral that are tried, coarsest first (metres).
_STEPS_M = (5e-9, 4e-9, 2.5e-9, 2e-9, 1e-9, 0.5e-9)

NORMALISATIONS = ("absolute", "relative")


class DirectEvaluator:
    """T(u, v, w) of one heightfield at one wavelength after another.

    Parameters
    ----------
    field
        A prepared heightfield: levelled, filled, refined to pixels that show no false orders.
    sigma_s_m
        Standard deviation of the coherence window in metres.
    ensemble
        ``average``, ``single`` or ``periodic``.
    dtype
        complex128, or complex64 for three times the speed at a relative error of about 1e-6.

    Raises
    ------
    ScanError
        If heights are missing, or the patch is too small to carry a taper.
    """

    def __init__(self, field: HeightField, sigma_s_m: float, ensemble: str, dtype: type = np.complex128) -> None:
        if field.missing.any():
            raise ScanError("The scan has missing heights; fill them before the BRDF is evaluated.")
        self.field = field
        self.sigma_s_m = check_sigma_s(sigma_s_m)
        self.ensemble = check_ensemble(ensemble)
        self.dtype = np.dtype(dtype)
        # The modulus of P does not see a common height.
        self._cycles = field.heights - 0.5 * (field.heights.min() + field.heights.max())
        rows, cols = field.shape
        sides = ((rows, field.dy), (cols, field.dx))
        self._axes = [window_axis(n, d, self.sigma_s_m, self.ensemble) for n, d in sides]
        squares = [float(a @ a) for a in self._axes]
        if min(squares) == 0.0:
            raise ScanError(f"The scan of {rows} x {cols} pixels is too small for the ensemble average; use 'single'.")
        #: integral g^2 (``single``) or integral t^2 (``average``), m^2.
        self.norm_m2 = squares[0] * squares[1] * field.dx * field.dy

    def phase(self, w: float, wavelength_m: float) -> np.ndarray:
        """``(rows, cols)`` p = exp(i k w h), up to a constant of modulus 1."""
        cycles = self._cycles * (w / wavelength_m)
        # Whole cycles go first, in double precision, so that single precision keeps its seven digits.
        cycles -= np.rint(cycles)
        cycles *= 2.0 * np.pi
        angle = cycles.astype(self.dtype.type(0).real.dtype, copy=False)
        p = np.empty(angle.shape, self.dtype)
        np.cos(angle, out=p.real)
        np.sin(angle, out=p.imag)
        return p

    def transform(self, u: float, v: float, w: float, wavelength_m: float) -> float:
        """T_lambda(u, v, w) in 1/sr: numbers, not arrays."""
        p = self.phase(w, wavelength_m)
        f0 = (v / wavelength_m, u / wavelength_m)
        steps = (self.field.dy, self.field.dx)
        if self.ensemble != "average":
            offsets = weights = [np.zeros(1), np.zeros(1)]
        else:
            offsets, weights = zip(
                *(self._frequencies(n * d) for n, d in zip(p.shape, steps, strict=True)), strict=True
            )
        kernels = []
        for count, step, axis, centre, offset in zip(p.shape, steps, self._axes, f0, offsets, strict=True):
            # The phase at the middle of the axis is 0: smallest angles, best precision.
            x = (np.arange(count) - (count - 1) / 2.0) * step
            kernels.append((axis * np.exp(2j * np.pi * np.outer(centre + offset, x))).astype(self.dtype))
        # Long rows times few columns first: BLAS takes a quarter of the time of few rows times the patch.
        spectrum = kernels[0] @ (p @ kernels[1].T) * (steps[0] * steps[1])
        power = (spectrum.real.astype(float) ** 2) + spectrum.imag.astype(float) ** 2
        total = power[0, 0] if self.ensemble != "average" else weights[0] @ power @ weights[1]
        return float(total) / (self.norm_m2 * wavelength_m**2)

    def _frequencies(self, side_m: float) -> tuple[np.ndarray, np.ndarray]:
        """Offsets f - f0 along one axis (1/m) and the weights G df of the trapezoid rule (without unit)."""
        width = self._frequency_width
        step = 1.0 / (side_m + _LAG_MARGIN * self.sigma_s_m)
        half = int(np.ceil(_FREQUENCY_RANGE * width / step))
        offsets = np.arange(-half, half + 1) * step
        # One axis of G: sqrt(4 pi) sigma_s exp(-f^2 / (2 width^2)).
        return offsets, np.sqrt(4 * np.pi) * self.sigma_s_m * step * np.exp(-0.5 * (offsets / width) ** 2)

    @property
    def _frequency_width(self) -> float:
        """Standard deviation of G along an axis, 1/m."""
        return 1.0 / (2.0 * np.pi * np.sqrt(2.0) * self.sigma_s_m)

    def wavelength_step(self, u: float, v: float, w: float) -> float:
        """Step in metres that resolves T as a function of wavelength at fixed (u, v, w).

        With the wavelength the point f0 = (u, v) / lambda crosses features no narrower than the coherence lobe
        (or the patch's own, if that is wider); 1.2 of its standard deviations leave exp(-2 pi^2 / 1.44) = 1e-6
        to the trapezoid rule. Along kappa the phase k |w| h of the whole height range turns by no more than
        a quarter of a cycle a step.
        """
        sides = self.field.size_m
        patch = 1.0 / (2.0 * np.pi * 0.41 * max(sides))  # 0.41: deviation of the lags of a patch, in sides
        lobe = np.hypot(self._frequency_width, patch)
        turns = 4.0 * abs(w) * np.ptp(self._cycles)
        need = WAVELENGTH_MIN_M**2 * min(1.2 * lobe / max(np.hypot(u, v), 1e-30), 1.0 / max(turns, 1e-30))
        return next((step for step in _STEPS_M if step <= need), need)


def check_wavelength(wavelength_m: float) -> float:
    """A usable wavelength in metres, or ParameterError."""
    if not (np.isfinite(wavelength_m) and wavelength_m > 0):
        raise ParameterError(f"A wavelength of {wavelength_m * 1e9:g} nm makes no sense; give a positive number.")
    return float(wavelength_m)


def direct_f(
    field: HeightField,
    sigma_s_m: float,
    ensemble: str,
    wi: np.ndarray,
    wr: np.ndarray,
    wavelength_m: float,
    normalisation: str = "absolute",
    dtype: type = np.complex128,
    stack: Stack | None = None,
    lacquer: Material | None = None,
) -> np.ndarray:
    """The BRDF at one wavelength: R = 1, or that of a stack.

    Parameters
    ----------
    field
        A prepared heightfield.
    sigma_s_m
        Standard deviation of the coherence window in metres.
    ensemble
        ``average`` or ``single``.
    wi, wr
        ``(..., 3)`` unit vectors towards the light and the viewer; they broadcast.
    wavelength_m
        Metres.
    normalisation
        ``absolute`` (1/sr) or ``relative`` (1 in the mirror direction of a flat patch at normal incidence).
    dtype
        Precision of the sums, see `DirectEvaluator`.
    stack, lacquer
        The surface's stuff, whose R at the half angle is multiplied in, and a clear layer over the relief, see
        `precompute.evaluate.surface.lacquer_factor`.

    Returns
    -------
    ndarray
        ``(...)``; 0 where a direction is not above the surface.
    """
    check_wavelength(wavelength_m)
    evaluator = DirectEvaluator(field, sigma_s_m, ensemble, dtype)
    scale = _scale(evaluator, normalisation)
    wi, wr = np.broadcast_arrays(np.asarray(wi, float), np.asarray(wr, float))
    stuff = _Stuff(stack, lacquer)
    factor = stuff.factor(wi, wr) * scale(wi, wr, wavelength_m)
    lam = np.array([wavelength_m])
    result = np.zeros(factor.shape)
    for at in np.ndindex(factor.shape):
        if factor[at] > 0:
            u, v, w = stuff.uvw(wi[at], wr[at])
            reflected = stuff.reflectance(lam, u, v, w)[0]
            result[at] = factor[at] * reflected * evaluator.transform(u, v, w, wavelength_m)
    return result


def direct_xyz(
    field: HeightField,
    sigma_s_m: float,
    ensemble: str,
    wi: np.ndarray,
    wr: np.ndarray,
    illuminant: Illuminant = "D65",
    step_m: float | None = None,
    normalisation: str = "absolute",
    dtype: type = np.complex64,
    stack: Stack | None = None,
    lacquer: Material | None = None,
) -> np.ndarray:
    """The BRDF in XYZ, R = 1 or that of a stack: ``integral f S xyz dlambda / integral S ybar dlambda``.

    Parameters
    ----------
    step_m
        Step of the wavelength integral in metres; None takes a step for each pair of directions that resolves
        the lobes, see `DirectEvaluator.wavelength_step`.
    field, sigma_s_m, ensemble, wi, wr, normalisation, dtype, stack, lacquer
        As in `direct_f`; the sum over wavelengths takes single precision unless told otherwise.
    illuminant
        Spectral distribution of the light, by name.

    Returns
    -------
    ndarray
        ``(..., 3)``; 0 where a direction is not above the surface.
    """
    evaluator = DirectEvaluator(field, sigma_s_m, ensemble, dtype)
    scale = _scale(evaluator, normalisation)
    wi, wr = np.broadcast_arrays(np.asarray(wi, float), np.asarray(wr, float))
    stuff = _Stuff(stack, lacquer)
    factor = stuff.factor(wi, wr)
    result = np.zeros((*factor.shape, 3))
    for index in np.ndindex(factor.shape):
        if factor[index] > 0:
            u, v, w = stuff.uvw(wi[index], wr[index])
            step = evaluator.wavelength_step(u, v, w) if step_m is None else step_m
            wavelengths, weights = spectral_weights(illuminant=illuminant, step_m=step)
            spectrum = np.array([evaluator.transform(u, v, w, lam) for lam in wavelengths])
            spectrum *= scale(wi[index], wr[index], wavelengths) * stuff.reflectance(wavelengths, u, v, w)
            result[index] = factor[index] * (spectrum @ weights)
    return result


class _Stuff:
    """What stack and lacquer make of directions."""

    def __init__(self, stack: Stack | None, lacquer: Material | None) -> None:
        self.stack, self.lacquer = stack, lacquer
        self.index = BakeParameters(lacquer=lacquer).index

    def factor(self, wi: np.ndarray, wr: np.ndarray) -> np.ndarray:
        """What T is multiplied by, R apart."""
        return geometry_factor(wi, wr) if self.lacquer is None else lacquer_factor(wi, wr, self.index)

    def uvw(self, wi: np.ndarray, wr: np.ndarray) -> tuple[float, float, float]:
        """Coordinates of T for one pair of directions."""
        u, v, w = (float(x) for x in lacquer_uvw(wi, wr, self.index))
        return u, v, w

    def reflectance(self, wavelengths_m: np.ndarray, u: float, v: float, w: float) -> np.ndarray:
        """``(L,)`` R at the half angle."""
        if self.stack is None:
            return np.ones(len(wavelengths_m))
        cosine = np.sqrt(u**2 + v**2 + w**2) / (2.0 * self.index)
        return self.stack.reflectance(wavelengths_m, np.minimum(cosine, 1.0)[None], self.lacquer)[:, 0]


def _scale(evaluator: DirectEvaluator, normalisation: str):
    """A function of (wi, wr, wavelengths) that turns absolute values into the wanted normalisation."""
    if normalisation not in NORMALISATIONS:
        raise ParameterError(f"Unknown normalisation '{normalisation}'; choose one of {', '.join(NORMALISATIONS)}.")
    if normalisation == "absolute":
        return lambda wi, wr, wavelengths: np.ones(np.broadcast_shapes(wi.shape[:-1], np.shape(wavelengths)))
    field = evaluator.field
    area = coherence_area(field.shape, field.dx, field.dy, evaluator.sigma_s_m, evaluator.ensemble)
    return lambda wi, wr, wavelengths: relative_factor(wi, wr, wavelengths, area)
