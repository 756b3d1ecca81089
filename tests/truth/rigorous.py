# SPDX-License-Identifier: GPL-3.0-or-later
"""Maxwell's equations for gratings: order efficiencies against which the scalar model is measured.

Two methods that share no code with each other or with `precompute`: rigorous coupled-wave analysis of
lamellar gratings (package meent, Fourier factorisation after Li), and for smooth profiles the coordinate
transformation of Chandezon, Dupuis, Cornet and Maystre, J. Opt. Soc. Am. 72 (1982) 839. Coupled waves cut a
smooth profile into a staircase, which is well for dielectrics but hardly converges for TM on metals (Popov et
al., J. Opt. Soc. Am. A 19 (2002) 33).

Light comes in air along (sin theta, -cos theta); order m leaves with the sine sin theta + m lambda / d.
Refractive indices of metals are n - ik. Lengths are in metres.
"""

from __future__ import annotations

import numpy as np

#: Aluminium at 550 nm (Palik, Handbook of Optical Constants), and keratin.
ALUMINIUM = 0.958 - 6.69j
KERATIN = 1.55

TE, TM = 0, 1


def fresnel(index: complex, theta: float) -> tuple[float, float]:
    """Reflectances (TE, TM) of a flat surface at the angle ``theta`` in radians."""
    cos = np.cos(theta)
    inside = np.sqrt(1.0 - (np.sin(theta) / index) ** 2 + 0j)
    te = (cos - index * inside) / (cos + index * inside)
    tm = (index * cos - inside) / (index * cos + inside)
    return float(abs(te) ** 2), float(abs(tm) ** 2)


def orders(period: float, wavelength: float, theta: float) -> np.ndarray:
    """Orders that propagate in air, ascending."""
    limit = int(2.0 * period / wavelength) + 1
    m = np.arange(-limit, limit + 1)
    return m[np.abs(np.sin(theta) + m * wavelength / period) < 1.0]


def coupled_waves(
    index: complex,
    layers: np.ndarray,
    depth: float,
    period: float,
    wavelength: float,
    theta: float,
    polarisation: int,
    harmonics: int = 30,
) -> np.ndarray:
    """Efficiencies of `orders` by meent.

    Parameters
    ----------
    layers
        ``(n_layers, pixels)`` bool from the top down, True where there is material.
    harmonics
        Fourier orders kept on either side of the zeroth.
    """
    import meent

    metal = np.iscomplexobj(index)
    cell = np.where(layers, index, 1.0)[:, None, :]
    thickness = [depth / len(layers)] * len(layers)
    if metal:
        # The package takes the wrong branch of the root in a substrate that absorbs: a layer takes its place,
        # so thick that nothing comes back through it.
        cell = np.concatenate([cell, np.full_like(cell[:1], index)])
        thickness.append(30.0 * wavelength / (2.0 * np.pi * abs(index.imag)))
    result = meent.call_mee(
        backend=0,
        n_top=1.0,
        n_bot=1.0 if metal else index,
        theta=theta,
        phi=None,
        pol=polarisation,
        period=[period],
        wavelength=wavelength,
        ucell=cell,
        thickness=thickness,
        fto=[harmonics],
        fourier_type=1,
    ).conv_solve()
    return np.ravel(result.de_ri)[harmonics + orders(period, wavelength, theta)]


def lamellar(index, depth, period, wavelength, theta, polarisation, harmonics=30, duty=0.5):
    """Efficiencies of `orders` of rectangular ridges that fill the part ``duty`` of the period."""
    pixels = 20
    ridge = np.arange(pixels) < round(duty * pixels)
    return coupled_waves(index, ridge[None], depth, period, wavelength, theta, polarisation, harmonics)


def staircase(index, depth, period, wavelength, theta, polarisation, harmonics=20, steps=20):
    """Efficiencies of `orders` of ``depth / 2 sin(2 pi x / d)`` cut into ``steps`` rectangular layers."""
    x = (np.arange(512) + 0.5) / 512
    level = 0.5 + 0.5 * np.sin(2.0 * np.pi * x)
    top = 1.0 - (np.arange(steps) + 0.5) / steps
    layers = level[None, :] > top[:, None]
    return coupled_waves(index, layers, depth, period, wavelength, theta, polarisation, harmonics)


def sawtooth(index, depth, period, wavelength, theta, polarisation, harmonics=30, steps=30, mirror=False):
    """Efficiencies of `orders` of ``depth frac(x / d)``, which falls at a vertical wall, cut into ``steps`` layers."""
    level = (np.arange(32 * steps) + 0.5) / (32 * steps)
    level = level[::-1] if mirror else level
    top = 1.0 - (np.arange(steps) + 0.5) / steps
    return coupled_waves(index, level > top[:, None], depth, period, wavelength, theta, polarisation, harmonics)


def groove(index, depth, period, wavelength, theta, polarisation, width, wall, harmonics=30, steps=8):
    """Efficiencies of `orders` of a ridge ``width`` wide at half its height, whose walls lean over ``wall``."""
    x = (np.arange(800) + 0.5) / 800 * period
    level = np.clip((0.5 * (width + wall) - np.abs(x - 0.5 * period)) / wall, 0.0, 1.0)
    top = 1.0 - (np.arange(steps) + 0.5) / steps
    return coupled_waves(index, level > top[:, None], depth, period, wavelength, theta, polarisation, harmonics)


def coordinate_transformation(
    index: complex,
    heights: np.ndarray,
    period: float,
    wavelength: float,
    theta: float,
    polarisation: int,
    harmonics: int = 25,
    film: tuple[complex, float] | None = None,
) -> np.ndarray:
    """Efficiencies of `orders` of a smooth profile, ``(samples,)`` heights over one period.

    In the coordinates (x, s = y - a(x)) the surface is flat, and a field sum_m F_m exp(i alpha_m x + i rho s)
    obeys ``(beta^2 + rho (alpha A + A alpha) - rho^2 C) F = 0`` with A and C the Toeplitz matrices of a' and
    1 + a'^2 and beta^2 = k^2 n^2 - alpha^2: a linear eigenvalue problem of twice the size. The field and
    ``(rho C - A alpha) F`` (TE; divided by n^2 for TM) are continuous. Propagating waves in air are known exactly.
    A ``film`` (index, thickness along y) that follows the relief is a plane slab in these coordinates, so that it is no
    harder than the surface alone: its waves run from either face, each measured where it starts.
    """
    k = 2.0 * np.pi / wavelength
    index = np.conj(complex(index))  # fields go with exp(-i omega t) here
    order = np.arange(-harmonics, harmonics + 1)
    alpha = k * np.sin(theta) + 2.0 * np.pi * order / period
    samples = len(heights)
    frequency = np.fft.fftfreq(samples, 1.0 / samples)
    slope = np.real(np.fft.ifft(2j * np.pi * frequency / period * np.fft.fft(heights)))

    def toeplitz(values):
        return (np.fft.fft(values) / samples)[(order[:, None] - order[None, :]) % samples]

    A, C = toeplitz(slope), toeplitz(1.0 + slope**2)
    coupling = alpha[:, None] * A + A * alpha[None, :]

    def modes(n):
        beta2 = (k * n) ** 2 - alpha**2
        size = len(order)
        matrix = np.zeros((2 * size, 2 * size), complex)
        matrix[:size, size:] = np.eye(size) * k
        matrix[size:, :size] = np.linalg.solve(C, np.diag(beta2)) / k
        matrix[size:, size:] = np.linalg.solve(C, coupling)
        rho, vectors = np.linalg.eig(matrix)
        return rho, vectors[:size]

    def wave(m, rho):
        """Fourier coefficients at s = 0 of exp(i alpha_m x + i rho y)."""
        return (np.fft.fft(np.exp(1j * rho * heights)) / samples)[(order - m) % samples]

    def flux(rho, field):
        return C @ (field * rho) - A @ (alpha[:, None] * field)

    propagating = orders(period, wavelength, theta)
    beta = np.sqrt(k**2 - (k * np.sin(theta) + 2.0 * np.pi * propagating / period) ** 2)
    size = len(order)
    rho, field = modes(1.0)
    # As many waves decay upwards as the propagating orders leave over: those with the largest imaginary parts.
    decaying = np.argsort(-rho.imag)[: size - len(propagating)]
    up_rho = np.concatenate([beta, rho[decaying]])
    up = np.concatenate(
        [np.stack([wave(m, b) for m, b in zip(propagating, beta, strict=True)], 1), field[:, decaying]], 1
    )
    rho, field = modes(index)
    if abs(index.imag) > 0:
        down = np.argsort(rho.imag)[:size]
    else:
        real = np.abs(rho.imag) < 1e-6 * k
        down = np.nonzero(np.where(real, rho.real < 0, rho.imag < 0))[0]
    if len(down) != size:
        raise ArithmeticError("The downward waves cannot be told apart; take another number of harmonics.")
    low_rho, low = rho[down], field[:, down]

    def weight(n):
        return 1.0 if polarisation == TE else 1.0 / n**2

    incident = wave(0, -k * np.cos(theta))[:, None]
    top = [up, flux(up_rho, up) / k]
    bottom = [low, weight(index) * flux(low_rho, low) / k]
    right = [-incident, -flux(np.array([-k * np.cos(theta)]), incident) / k]
    if film is None:
        matrix = np.block([[over, -below] for over, below in zip(top, bottom, strict=True)])
    else:
        n, thickness = np.conj(complex(film[0])), film[1]
        rho, field = modes(n)
        slab = [field, weight(n) * flux(rho, field) / k]
        falls = rho.imag < 0.0  # as s falls from 0 to -thickness; the others start below
        upper = np.exp(1j * rho * np.where(falls, 0.0, thickness))
        lower = np.exp(1j * rho * np.where(falls, -thickness, 0.0))
        none_up, none_low = np.zeros_like(up), np.zeros_like(low)
        matrix = np.block(
            [[over, -inside * upper, none_low] for over, inside in zip(top, slab, strict=True)]
            + [[none_up, inside * lower, -below] for inside, below in zip(slab, bottom, strict=True)]
        )
        right += [np.zeros((2 * size, 1))]
    right = np.concatenate(right)
    amplitude = np.linalg.solve(matrix, right)[: len(propagating), 0]
    return np.abs(amplitude) ** 2 * beta / (k * np.cos(theta))


def sinusoidal(index, depth, period, wavelength, theta, polarisation, harmonics=25, film=None):
    """Efficiencies of `orders` of the profile ``depth / 2 sin(2 pi x / d)``, and of a film that follows it."""
    x = (np.arange(256) + 0.5) / 256
    heights = 0.5 * depth * np.sin(2.0 * np.pi * x)
    return coordinate_transformation(index, heights, period, wavelength, theta, polarisation, harmonics, film)
