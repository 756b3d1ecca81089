# SPDX-License-Identifier: GPL-3.0-or-later
"""Three ways to the transform of p = exp(-i kappa h) for many kappa: nodes, Chebyshev-Bessel, Taylor.

kappa = k |w| is the only place where wavelength and directions enter p. Since w <= 0 in
``(u, v, w) = -(wi + wr)``, ``p = exp(i k w h) = exp(-i kappa h)``.

The two series write p as a sum of products of a function of kappa and a function of the
heights, so that a finite set of transforms ("terms") serves every kappa:

* Taylor (thesis, eq. 3.19): ``sum_n (-i kappa)^n / n!  F{h^n}``, truncated at N from the
  bound ``exp(x) x^(N+1) / (N+1)! <= eps`` with ``x = kappa_max max|h|`` (eq. 3.26).
* Chebyshev-Bessel (Jacobi-Anger expansion, DLMF 10.12.3), with kappa in [0, 2 kc]:
  ``exp(-i kappa h) = exp(-i kc h) [J_0(kc h) + 2 sum_n (-i)^n J_n(kc h) T_n(kappa / kc - 1)]``.

Heights are centred first; that changes p by a phase only.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from ..errors import ParameterError

#: More terms than this mean that the heights are far outside what the expansion is for.
TERMS_MAX = 400


def taylor_bound(x: float, order: int) -> float:
    """Lagrange bound ``exp(x) x^(N+1) / (N+1)!`` of the Taylor series truncated after N (thesis eq. 3.26)."""
    return math.exp(x + (order + 1) * math.log(x) - math.lgamma(order + 2)) if x > 0 else 0.0


def taylor_order(x: float, tolerance: float) -> int:
    """Smallest N whose bound is at most ``tolerance``.

    Raises
    ------
    ParameterError
        If double precision cannot reach the tolerance: terms grow to e^x, each with a
        rounding error of 2^-53, or more than ``TERMS_MAX`` terms are needed.
    """
    reachable = math.exp(min(x, 600.0)) * 2.0**-53
    if reachable > tolerance:
        raise ParameterError(
            f"The Taylor series cannot reach the tolerance {tolerance:g}: at kappa h = {x:.1f} its terms grow to"
            f" {math.exp(min(x, 600.0)):.1e} and double precision leaves an error of {reachable:.1e};"
            " use the series 'chebyshev' or 'nodes'."
        )
    for order in range(TERMS_MAX):
        if taylor_bound(x, order) <= tolerance:
            return order
    raise ParameterError(f"The Taylor series needs more than {TERMS_MAX} terms; use the series 'nodes'.")


def single_precision_floor(method: str, x: float) -> float:
    """Error that single precision leaves in p at ``kappa h = x``.

    Taylor terms are summed with weights up to e^x, which multiplies the rounding error 2^-24 of each stored
    value; the weights of the other methods are at most 2.
    """
    return math.exp(min(x, 600.0)) * 2.0**-24 if method == "taylor" else 8.0 * 2.0**-24


def check_single_precision(method: str, x: float, tolerance: float) -> None:
    """Refuse a tolerance that terms stored as float32 textures, or transforms in single precision, cannot reach.

    Raises
    ------
    ParameterError
        With the reason and the smallest tolerance that can be reached.
    """
    floor = single_precision_floor(method, x)
    if floor <= tolerance:
        return
    reason = f"its terms grow to {math.exp(min(x, 600.0)):.1e} and" if method == "taylor" else "its values"
    way_out = "take the series 'chebyshev' or 'nodes', level the scan" if method == "taylor" else "ask for less"
    raise ParameterError(
        f"The series '{method}' cannot reach the tolerance {tolerance:g}: at kappa h = {x:.1f} {reason} are stored in"
        f" single precision, which leaves an error of {floor:.1e}; {way_out}, or allow at least that."
    )


def bessel_functions(count: int, x: float) -> np.ndarray:
    """``(count,)`` J_0(x) ... J_(count-1)(x) for x >= 0, by Miller's algorithm (DLMF 3.6(v), 10.74(iv)).

    The recurrence ``J_(n-1) = 2 n / x J_n - J_(n+1)`` is stable downwards; where it starts does not matter far above
    x, and ``J_0 + 2 (J_2 + J_4 + ...) = 1`` gives the scale.
    """
    start = 2 * (max(count, math.ceil(x)) // 2 + 30)
    values = np.zeros(start + 2)
    if x < 1e-8:  # the recurrence would overflow; J_1 = x / 2 is what is left
        values[:2] = 1.0, 0.5 * x
        return values[:count]
    values[start] = 1e-300
    for n in range(start, 0, -1):
        values[n - 1] = 2.0 * n / x * values[n] - values[n + 1]
        if abs(values[n - 1]) > 1e250:
            values[n - 1 :] *= 1e-250
    return values[:count] / (values[0] + 2.0 * values[2::2].sum())


def bessel_order(x: float, tolerance: float) -> int:
    """Smallest N with ``2 sum_{n > N} |J_n(x)| <= tolerance``: the remainder of the Jacobi-Anger series.

    For real x' in [0, x] the remainder is largest at x as long as N > x, where the terms decay.
    """
    tail = 2.0 * np.cumsum(np.abs(bessel_functions(int(x) + 120, x))[::-1])[::-1]
    # tail[n] holds the terms from n on; the remainder after N is tail[N + 1].
    fits = np.nonzero(tail[1:] <= tolerance)[0]
    order = int(fits[fits >= min(math.floor(x), len(tail) - 2)][0]) if len(fits) else len(tail)
    if order > TERMS_MAX:
        raise ParameterError(
            f"The heights need more than {TERMS_MAX} terms (kappa h = {x:.0f}); level the scan, clip its dust,"
            " or check the unit of its heights."
        )
    return order


def node_count(x: float, tolerance: float) -> int:
    """Chebyshev nodes of kappa that interpolate an intensity within ``tolerance``, x = kappa_max h_half.

    The intensity holds differences of two heights, so its band is that of p on twice the half interval: x.
    """
    return max(bessel_order(x, tolerance) + 1, 4)


def chebyshev_nodes(kappa_max: float, count: int) -> np.ndarray:
    """``(count,)`` Chebyshev nodes of the first kind on [0, kappa_max], ascending (1/m)."""
    j = np.arange(count)[::-1]
    return 0.5 * kappa_max * (1.0 + np.cos((2 * j + 1) * np.pi / (2 * count)))


def node_weights(nodes: np.ndarray, kappa_max: float, kappa: np.ndarray) -> np.ndarray:
    """Weights of the polynomial through Chebyshev nodes: ``value(kappa) = weights @ values``.

    Parameters
    ----------
    nodes
        ``(n,)`` from :func:`chebyshev_nodes`.
    kappa
        ``(m,)`` points in [0, kappa_max], 1/m.

    Returns
    -------
    ndarray
        ``(m, n)``. Discrete orthogonality of T_0 ... T_(n-1) on the nodes (Mason and
        Handscomb, *Chebyshev Polynomials*, 2003, section 4.6).
    """
    from numpy.polynomial.chebyshev import chebvander

    count = len(nodes)
    at_nodes = chebvander(2.0 * nodes / kappa_max - 1.0, count - 1)
    at_nodes[:, 1:] *= 2.0
    return chebvander(2.0 * np.asarray(kappa) / kappa_max - 1.0, count - 1) @ at_nodes.T / count


def term_weight(method: str, n: int, kappa: np.ndarray | float, kappa_max: float, half_range: float) -> np.ndarray:
    """Weight of term n of a series at each kappa.

    Taylor: ``(kappa h_half)^n / n!`` (the terms hold heights relative to half their range);
    Chebyshev: ``T_n(2 kappa / kappa_max - 1)``.
    """
    kappa = np.asarray(kappa, np.float64)
    if method == "taylor":
        x = kappa * half_range
        with np.errstate(divide="ignore"):
            return np.exp(n * np.log(x) - math.lgamma(n + 1)) if n else np.ones_like(x)
    return np.cos(n * np.arccos(np.clip(2.0 * kappa / kappa_max - 1.0, -1.0, 1.0)))


class Series:
    """Transforms of ``window * exp(-i kappa h)`` at many kappa by one of the three methods.

    Parameters
    ----------
    heights
        ``(rows, cols)`` metres; centred on the middle of their range here.
    window
        ``(rows, cols)`` or broadcastable real weights.
    kappa_max
        Largest kappa, 1/m.
    method
        ``nodes``, ``chebyshev`` or ``taylor``.
    tolerance
        Largest error of p.
    transform
        Linear map from a ``(rows, cols)`` complex array to its transform.

    Attributes
    ----------
    terms : int
        Number of terms of the series (for ``nodes``: 0, there is one transform a kappa).
    """

    def __init__(
        self,
        heights: np.ndarray,
        window: np.ndarray,
        kappa_max: float,
        method: str,
        tolerance: float,
        transform: Callable[[np.ndarray], np.ndarray],
    ) -> None:
        low, high = float(heights.min()), float(heights.max())
        # One transform a kappa needs the heights in single precision only, which is half the memory.
        kind = np.float32 if method == "nodes" else np.float64
        self.heights = np.empty(heights.shape, kind)
        np.subtract(heights, 0.5 * (low + high), out=self.heights, casting="same_kind")
        self.half_range = 0.5 * (high - low)
        self.window = window
        self.kappa_max = kappa_max
        self.method = method
        self.transform = transform
        x = kappa_max * self.half_range
        if method == "taylor":
            self.terms = taylor_order(x, tolerance) + 1
        elif method == "chebyshev":
            self.terms = bessel_order(0.5 * x, tolerance) + 1
        elif method == "nodes":
            self.terms = 0
        else:
            raise ParameterError(f"The series {method!r} is unknown; choose nodes, chebyshev or taylor.")

    def term(self, n: int) -> np.ndarray:
        """Transform of term n: of ``(-i h / h_half)^n`` (Taylor, heights relative to half their range so that
        every term fits a texture), or of ``exp(-i kc h) (-i)^n J_n(kc h)`` (Chebyshev)."""
        if self.method == "taylor":
            relative = self.heights / self.half_range if self.half_range > 0 else self.heights
            return self.transform(self.window * ((-1j) ** n * relative**n))
        from scipy.special import jv

        kc = 0.5 * self.kappa_max
        phase = kc * self.heights
        factor = 1.0 if n == 0 else 2.0
        return self.transform(self.window * (factor * (-1j) ** n * jv(n, phase) * np.exp(-1j * phase)))

    def weight(self, n: int, kappa: np.ndarray) -> np.ndarray:
        """Weight of term n at each kappa."""
        return term_weight(self.method, n, kappa, self.kappa_max, self.half_range)

    def rows(self, kappa: float, rows: slice, window: np.ndarray, out: np.ndarray) -> None:
        """``window * exp(-i kappa h)`` of some rows, for the method ``nodes``.

        Parameters
        ----------
        kappa
            1/m.
        rows
            Which of the heights' rows.
        window
            ``(n, cols)`` float32 of these rows.
        out
            ``(n, cols)`` complex64, overwritten.
        """
        phase = self.heights[rows] * np.float32(kappa)
        part = np.cos(phase)
        np.multiply(part, window, out=out.real)
        np.sin(phase, out=part)
        np.negative(part, out=part)
        np.multiply(part, window, out=out.imag)

    def amplitudes(self, kappas: np.ndarray, group: int = 8) -> Iterator[np.ndarray]:
        """Transforms of ``window * p`` at each kappa, in order.

        A series needs all its terms for each kappa; ``group`` kappas share one pass over
        the terms, which bounds the memory.
        """
        if self.method == "nodes":
            everything = slice(None)
            window = np.broadcast_to(np.asarray(self.window, np.float32), self.heights.shape)
            for kappa in kappas:
                p = np.empty(self.heights.shape, np.complex64)
                self.rows(kappa, everything, window, p)
                yield self.transform(p)
            return
        for start in range(0, len(kappas), group):
            part = np.asarray(kappas[start : start + group])
            total: list[np.ndarray] = []
            for n in range(self.terms):
                term = self.term(n)
                weights = self.weight(n, part)
                if n == 0:
                    total = [weight * term for weight in weights]
                else:
                    for accumulated, weight in zip(total, weights, strict=True):
                        accumulated += weight * term
            while total:
                yield total.pop(0)
