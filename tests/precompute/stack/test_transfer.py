# SPDX-License-Identifier: GPL-3.0-or-later
"""What films reflect: closed forms, and the package tmm as independent truth."""

import numpy as np
import pytest
import tmm

from precompute.stack import Stack, fresnel_exact, material_of, parse_stack, reflectance

LAM = np.array([380e-9, 500e-9, 633e-9, 780e-9])
COS = np.cos(np.radians([0.0, 10.0, 45.0, 60.0, 80.0, 89.5]))


def by_tmm(indices, thicknesses_nm, lam, cos):
    """The mean of both polarisations, one wavelength and one angle at a time."""
    inside = [np.inf, *thicknesses_nm, np.inf]
    return tmm.unpolarized_RT(list(indices), inside, np.arccos(cos), lam * 1e9)["R"]


def truth(stack, outer=None):
    films = stack.layers
    out = np.empty((len(LAM), len(COS)))
    for i, lam in enumerate(LAM):
        at = np.array([lam])
        outside = 1.0 if outer is None else outer.index(at)[0].real
        indices = [outside, *(f.material.index(at)[0] for f in films), stack.substrate.index(at)[0]]
        for j, cos in enumerate(COS):
            out[i, j] = by_tmm(indices, [f.thickness_m * 1e9 for f in films], lam, cos)
    return out


@pytest.mark.parametrize(
    ("substrate", "films", "outer"),
    [
        ("au", (), None),
        ("Ti", ("TiO2:60",), None),
        ("Au", ("1.46:250",), None),
        ("Si", ("SiO2:1200", "TiO2:55", "MgF2:90"), None),
        ("melanin", ("(chitin:100,melanin:80)x12",), None),
        ("Ag", ("ZnS:60", "Cr:3", "0.2,3.4:20"), None),
        ("Al", ("SiO2:400",), "polycarbonate"),
        ("1.33", ("1.0:80", "1.58:3000"), "1.58"),  # an air gap under lacquer: total reflection, tunnelled through
        ("Fe", ("(Al2O3:120,water:300,PMMA:90)x5", "polystyrene:700"), "PMMA"),
    ],
)
def test_stacks_reflect_what_tmm_says(substrate, films, outer):
    stack = parse_stack(substrate, films)
    outer = None if outer is None else material_of(outer)
    assert np.abs(stack.reflectance(LAM, COS, outer) - truth(stack, outer)).max() < 1e-10


def test_random_stacks_reflect_what_tmm_says():
    rng = np.random.default_rng(5)
    for _ in range(40):
        count = int(rng.integers(0, 7))
        indices = [
            1.0,
            *(rng.uniform(1.1, 3.0, count) + 1j * rng.choice([0.0, 0.3, 4.0], count)),
            rng.uniform(1, 4) + 2j,
        ]
        thick = rng.uniform(0.0, 400.0, count)
        cos = float(np.cos(rng.uniform(0.0, 1.55)))
        found = reflectance([np.full(1, n) for n in indices], thick * 1e-9, LAM[1:2], np.array([cos]))[0, 0]
        assert found == pytest.approx(by_tmm(indices, thick, LAM[1], cos), abs=1e-10)


def test_bare_face_is_fresnels():
    theta = np.radians(np.linspace(0, 89.9, 50))
    inner = np.arcsin(np.sin(theta) / 1.5)
    s = (np.sin(theta[1:] - inner[1:]) / np.sin(theta[1:] + inner[1:])) ** 2
    p = (np.tan(theta[1:] - inner[1:]) / np.tan(theta[1:] + inner[1:])) ** 2
    stack = parse_stack(1.5)
    found = stack.reflectance(LAM[:1], np.cos(theta))[0]
    assert found[0] == pytest.approx(0.04, abs=1e-12)
    assert found[1:] == pytest.approx(0.5 * (s + p), abs=1e-12)
    assert fresnel_exact(1.5, np.cos(theta)) == pytest.approx(found, abs=1e-12)


def test_brewster_leaves_half_of_s():
    """At Brewster's angle p vanishes, and s is ((n^2 - 1) / (n^2 + 1))^2."""
    n = 1.53
    cos = 1.0 / np.hypot(1.0, n)
    assert parse_stack(n).reflectance(LAM[:1], np.array([cos]))[0, 0] == pytest.approx(
        0.5 * ((n**2 - 1) / (n**2 + 1)) ** 2, abs=1e-12
    )


def test_quarter_wave_layer_cancels_and_half_wave_layer_is_not_there():
    lam, n, ns = 550e-9, 1.38, 1.52
    quarter = parse_stack(ns, [f"{n}:{lam * 1e9 / (4 * n)}"])
    assert quarter.reflectance([lam], [1.0])[0, 0] == pytest.approx(((n**2 - ns) / (n**2 + ns)) ** 2, abs=1e-12)
    perfect = parse_stack(n**2, [f"{n}:{lam * 1e9 / (4 * n)}"])
    assert perfect.reflectance([lam], [1.0])[0, 0] < 1e-20
    half = parse_stack(ns, [f"{n}:{lam * 1e9 / (2 * n)}"])
    assert half.reflectance([lam], [1.0])[0, 0] == pytest.approx(((ns - 1) / (ns + 1)) ** 2, abs=1e-12)


def test_quarter_wave_mirror_of_many_pairs():
    """(HL)^N on a substrate: R = ((1 - Y) / (1 + Y))^2 with Y = (n_H / n_L)^(2 N) n_s (Macleod, 6.1)."""
    lam, high, low, ns, times = 600e-9, 2.3, 1.38, 1.5, 6
    stack = parse_stack(ns, [f"({high}:{lam * 1e9 / 4 / high},{low}:{lam * 1e9 / 4 / low})x{times}"])
    y = (high / low) ** (2 * times) * ns
    assert stack.reflectance([lam], [1.0])[0, 0] == pytest.approx(((1 - y) / (1 + y)) ** 2, abs=1e-12)


def test_everything_reflects_on_the_horizon_and_nothing_exceeds_one():
    for substrate, films in (("Au", ("SiO2:100",)), ("1.5", ()), ("water", ("1.0:50",))):
        r = parse_stack(substrate, films).reflectance(LAM, np.linspace(0, 1, 200))
        assert r[:, 0] == pytest.approx(1.0, abs=1e-4)
        assert r.min() >= 0.0
        assert r.max() <= 1.0


def test_a_layer_of_the_outer_medium_is_not_there():
    lacquer = material_of("PMMA")
    bare, padded = (Stack(material_of("Cu"), films) for films in ((), parse_stack("Cu", ["PMMA:700"]).films))
    assert padded.reflectance(LAM, COS, lacquer) == pytest.approx(bare.reflectance(LAM, COS, lacquer), abs=1e-12)


def test_samples_over_the_cosine_carry_linear_interpolation():
    for films in (("SiO2:20000",), ("(chitin:100,melanin:80)x12",), ()):
        stack = parse_stack("Al", films)
        cosines, r = stack.sampled(LAM)
        between = 0.5 * (cosines[1:] + cosines[:-1])
        exact = stack.reflectance(LAM, between)
        inside = between > 0.02
        assert np.abs(0.5 * (r[:, 1:] + r[:, :-1]) - exact)[:, inside].max() < 1.5e-3
