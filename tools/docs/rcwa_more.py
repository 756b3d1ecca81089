# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/rcwa.md, what is not a sinusoid or a lamellar grating in air: sawteeth, films that follow a relief, a disc."""

import numpy as np

from precompute.evaluate.orders import order_efficiencies
from precompute.stack import parse_stack
from tests.truth.rigorous import ALUMINIUM, TE, TM, fresnel, groove, sawtooth, sinusoidal
from tools.docs.fill_page import table

WAVELENGTH = 550e-9
ALUMINIUM_TYPED = f"{ALUMINIUM.real},{-ALUMINIUM.imag}"

#: Period in metres of the sawteeth; all are 275 nm deep, as the preset's.
SAWTEETH = (2.5e-6, 1e-3 / 1200)
SAWTOOTH_DEPTH = 275e-9

#: Thickness of the film of SiO2 in nm, and angles of incidence in degrees; the sinusoid is 2.5 um long, 100 nm deep.
FILMS_NM, FILM_ANGLES = (50, 100, 200), (0, 20, 30)
SINUSOID_PERIOD, SINUSOID_DEPTH, SILICA = 2.5e-6, 100e-9, 1.46

#: A CD's groove under polycarbonate: pitch, width, lean of a wall, depth in metres; index.
DISC = {"period": 1.6e-6, "width": 0.6e-6, "wall": 0.072e-6, "depth": 120e-9}
POLYCARBONATE, DISC_ANGLES = 1.58, (0, 10, 20, 30)


def sawtooth_row(period, side):
    """Order -1 in Littrow mount, light from the facets' side (1) or from that of the walls (-1).

    Rigorous TE and TM, the model with R = 1, and that cut to the light that comes in.
    """
    theta = np.arcsin(0.5 * WAVELENGTH / period)
    x = (np.arange(2000) + 0.5) / 2000
    profile = SAWTOOTH_DEPTH * x[::side]
    m, plain = order_efficiencies(profile, period, WAVELENGTH, theta)
    _, capped = order_efficiencies(profile, period, WAVELENGTH, theta, conserving=True)
    # Light from the other side of the same grating is light from this side of its mirror image.
    rigorous = [
        sawtooth(ALUMINIUM, SAWTOOTH_DEPTH, period, WAVELENGTH, theta, p, 35, 40, mirror=side < 0) for p in (TE, TM)
    ]
    order = m == -1
    return [float(values[order][0]) for values in (*rigorous, plain, capped)]


def sawtooth_table():
    """Blazed gratings in Littrow mount."""
    rows = []
    for period in SAWTEETH:
        for side, name in ((1, "facets"), (-1, "walls")):
            te, tm, plain, capped = sawtooth_row(period, side)
            flat = np.mean(fresnel(ALUMINIUM, np.arcsin(0.5 * WAVELENGTH / period)))
            values = (te, tm, plain, capped, capped * flat)
            rows.append([f"{1e-3 / period:.0f}/mm, light on the {name}", *[f"{value:.3f}" for value in values]])
    return table(["order -1 in Littrow mount", "TE", "TM", "scalar, R = 1", "capped, R = 1", "capped times R"], rows)


def film_errors(thickness_nm, angle_deg):
    """Part of the light that the model misplaces on the coated sinusoid, and on the bare one."""
    theta = np.radians(angle_deg)
    x = (np.arange(1000) + 0.5) / 1000
    profile = 0.5 * SINUSOID_DEPTH * np.sin(2.0 * np.pi * x)
    errors = []
    for film in ((SILICA, thickness_nm * 1e-9), None):
        films = [] if film is None else [f"{SILICA}:{thickness_nm}"]
        truth = 0.5 * sum(
            sinusoidal(ALUMINIUM, SINUSOID_DEPTH, SINUSOID_PERIOD, WAVELENGTH, theta, p, 20, film) for p in (TE, TM)
        )
        stack = parse_stack(ALUMINIUM_TYPED, films)
        _, model = order_efficiencies(profile, SINUSOID_PERIOD, WAVELENGTH, theta, stack=stack)
        errors.append(float(np.abs(model - truth).sum() / truth.sum()))
    return errors


def film_table():
    """SiO2 on aluminium, in percent."""
    rows = []
    for angle in FILM_ANGLES:
        cells = [f"{100 * film_errors(thickness, angle)[0]:.2f}" for thickness in FILMS_NM]
        rows.append([f"{angle} deg", *cells, f"{100 * film_errors(FILMS_NM[0], angle)[1]:.2f}"])
    return table(["misplaced, percent", *[f"SiO2 {t} nm" for t in FILMS_NM], "bare"], rows)


def disc_errors(angle_deg):
    """Part of the light that leaves the plastic in the wrong order: under a lacquer, and with the depth times n.

    Relative to the flat layer's reflectance; under the lacquer wavelength and index are those inside.
    """
    theta, n = np.arcsin(np.sin(np.radians(angle_deg)) / POLYCARBONATE), POLYCARBONATE
    period, width, wall, depth = (DISC[name] for name in ("period", "width", "wall", "depth"))
    inside = WAVELENGTH / n
    truth = 0.5 * sum(groove(ALUMINIUM / n, depth, period, inside, theta, p, width, wall, 24, 6) for p in (TE, TM))
    truth /= np.mean(fresnel(ALUMINIUM / n, theta))
    x = (np.arange(2000) + 0.5) / 2000 * period
    profile = depth * np.clip((0.5 * (width + wall) - np.abs(x - 0.5 * period)) / wall, 0.0, 1.0)
    m, model = order_efficiencies(profile, period, inside, theta)
    leaves = np.abs(np.sin(theta) + m * inside / period) < 1.0 / n
    _, imitated = order_efficiencies(profile * n, period, WAVELENGTH, np.radians(angle_deg))
    return [float(np.abs(values - truth[leaves]).sum() / truth[leaves].sum()) for values in (model[leaves], imitated)]


def disc_table():
    """The disc under its plastic, in percent."""
    rows = [[f"{angle} deg", *[f"{100 * value:.1f}" for value in disc_errors(angle)]] for angle in DISC_ANGLES]
    return table(["misplaced, percent", "under polycarbonate", "in air, depth times 1.58"], rows)


def blocks():
    """Of the page."""
    return {"sawtooth": sawtooth_table(), "films": film_table(), "disc": disc_table()}
