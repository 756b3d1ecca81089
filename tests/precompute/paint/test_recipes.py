# SPDX-License-Identifier: GPL-3.0-or-later
"""Each recipe against the grating equation: from which directions each place shines."""

import numpy as np
import pytest

from precompute.bake import bake
from precompute.errors import ParameterError
from precompute.evaluate.directions import from_angles
from precompute.evaluate.scaled import painted_brdf
from precompute.light.colour import xyz_to_rgb_matrix
from precompute.paint import RECIPES, load_paint, make_paint, save_paint
from precompute.parameters import BakeParameters
from precompute.presets import make_preset

PERIOD = 1.6e-6


@pytest.fixture(scope="module")
def grating():
    """A shallow sinusoid of 1.6 um whose orders are narrow."""
    field = make_preset("sinusoid", 48e-6, 640, period_um=1.6, amplitude_nm=25)
    return bake(field, BakeParameters(sigma_s_m=5e-6, level="none"))


def lit(grating, paint, lamp, eye):
    """Luminance of each place, and the wavelength of a spectral line that order 1 would send there."""
    xyz = painted_brdf(grating, lamp, eye, *paint.maps)
    return xyz[..., 1]


def k_vector(paint):
    """``(rows, cols, 2)`` 1 / period along the grating vector, from the maps alone."""
    frequency = paint.mask / (paint.scale * PERIOD)
    return np.stack([frequency * np.cos(paint.rotation), frequency * np.sin(paint.rotation)], axis=-1)


def coordinates(shape):
    longer = max(shape)
    return np.meshgrid(*((np.arange(n) + 0.5 - 0.5 * n) * (2.0 / longer) for n in shape[::-1]))


def test_rings_shine_along_the_line_to_the_lamp(grating):
    """On a disc's rings order 1 reaches a viewer above only where the radius points to the lamp or away."""
    paint = make_paint("rings", PERIOD, pixels=128)
    for azimuth in (0.0, 40.0, 115.0):
        seen = lit(grating, paint, from_angles(*np.radians((20.0, azimuth))), np.array([0.0, 0.0, 1.0]))
        x, y = coordinates(paint.shape)
        away = np.arctan2(y, x) - np.radians(azimuth)
        across = np.abs(np.sin(away))
        ring = (np.hypot(x, y) > 0.3) & (np.hypot(x, y) < 0.95)
        assert seen[ring & (across < 0.03)].min() > 30 * seen[ring & (across > 0.5)].max()


def test_rays_are_rings_turned_by_a_right_angle():
    turned = make_paint("rays", PERIOD, pixels=64).rotation - make_paint("rings", PERIOD, pixels=64).rotation
    np.testing.assert_allclose(np.cos(turned), 0.0, atol=1e-6)


@pytest.mark.parametrize("pitch", [-60.0, 0.0, 30.0, 90.0])
def test_spirals_meet_each_ray_under_their_pitch(pitch):
    paint = make_paint("spiral", PERIOD, pixels=64, pitch_deg=pitch)
    x, y = coordinates(paint.shape)
    groove = paint.rotation + 0.5 * np.pi
    angle = groove - np.arctan2(y, x) - np.radians(pitch)
    np.testing.assert_allclose(np.sin(angle), 0.0, atol=1e-5)  # either sense along the groove


def test_guilloche_grooves_follow_its_lines():
    """The grating vector of each family is the gradient of its rosette, taken here by differences."""
    n, a = 7, 0.3
    paint = make_paint("guilloche", PERIOD, pixels=400, petals=n, swing=a, lines=3, cover=1.0)
    x, y = coordinates(paint.shape)
    r, phi = np.hypot(x, y), np.arctan2(y, x)
    rosette = r * (1.0 + a * np.cos(n * phi))
    down, across = np.gradient(rosette, y[:, 0], x[0])
    first = (np.mod(3 * rosette, 1.0) < 0.5) & (r > 0.15)
    turned = np.sin(paint.rotation - np.arctan2(down, across))[first]
    assert np.percentile(np.abs(turned), 95) < 0.02
    assert 0.7 < paint.mask.mean() < 0.8  # two families of half the surface each leave a quarter bare


def test_every_dot_has_one_direction_and_neighbours_differ():
    paint = make_paint("dots", PERIOD, pixels=160, cells=16, fill=0.8)
    cells = paint.rotation.reshape(16, 10, 16, 10).swapaxes(1, 2)
    assert (cells.max((2, 3)) == cells.min((2, 3))).all()
    first = cells[:, :, 0, 0]
    assert np.abs(np.diff(first, axis=0)).min() > 0.1 and np.abs(np.diff(first, axis=1)).min() > 0.1
    assert paint.mask.mean() == pytest.approx(np.pi / 4 * 0.8**2, abs=0.05)


def test_a_picture_turns_the_dots():
    picture = np.zeros((8, 8, 3))
    picture[:, 4:] = 0.25  # linear: half way for the eye
    paint = make_paint("dots", PERIOD, pixels=64, pictures=[picture], cells=8)
    assert np.allclose(paint.rotation[:, :32], 0.0)
    assert np.allclose(paint.rotation[:, 32:], 0.5 * np.pi, atol=1e-6)


def test_glitter_is_seeded_and_covers_all_directions():
    one, same, other = (make_paint("glitter", PERIOD, pixels=512, cells=40, seed=s) for s in (3, 3, 4))
    assert (one.rotation == same.rotation).all() and (one.rotation != other.rotation).mean() > 0.9
    cells = np.unique(one.rotation)
    assert 1400 < cells.size < 1900  # 40 x 40 squares, one point each, and some at the rim
    share = np.histogram(one.rotation, 8, (0, np.pi))[0] / one.rotation.size
    assert share.min() > 0.09 and share.max() < 0.16
    assert one.scale.min() >= 0.7 and one.scale.max() <= 1.0


def test_lens_sends_the_light_to_its_focus():
    """K(r) = grad sqrt(r^2 + f^2) / lambda: with light straight down the ray leaves towards the focus."""
    size, focus, wavelength = 0.03, 0.02, 550e-9
    paint = make_paint("lens", PERIOD, pixels=200, size_m=size, focus_mm=20.0)
    x, y = (0.5 * size * axis for axis in coordinates(paint.shape))
    there = paint.mask > 0
    leaves = -wavelength * k_vector(paint)[there]  # horizontal part of wr, order 1
    wanted = -np.stack([x, y], -1)[there] / np.sqrt(x**2 + y**2 + focus**2)[there, None]
    np.testing.assert_allclose(leaves, wanted, atol=1e-6)
    r = np.hypot(x, y)
    assert (there == (r / np.hypot(r, focus) >= wavelength / PERIOD * (1 - 1e-9))).all()
    assert paint.info["without_structure"] == pytest.approx(1 - there.mean())


def test_stereo_shows_each_eye_its_picture(grating):
    left, right = np.zeros((2, 60, 60, 3))
    left[:, :30] = 1.0
    right[30:] = 1.0
    paint = make_paint("stereo", PERIOD, pixels=120, pictures=[left, right], eye_deg=8.0, lamp_deg=32.0)
    lamp = from_angles(np.radians(32.0), 0.5 * np.pi)
    eyes = [from_angles(np.radians(8.0), azimuth) for azimuth in (np.pi, 0.0)]
    seen = [lit(grating, paint, lamp, eye).reshape(60, 2, 60, 2).sum((1, 3)) for eye in eyes]
    for view, picture, other in zip(seen, (left, right), (right, left), strict=True):
        own, foreign = picture[..., 0] > 0, (other[..., 0] > 0) & (picture[..., 0] == 0)
        assert view[own].min() > 20 * max(view[foreign].max(), view[~own & ~foreign].max())


def test_stereo_refuses_what_the_table_cannot_hold():
    picture = np.ones((4, 4, 3))
    with pytest.raises(ParameterError, match=r"would be .* times the table's"):
        make_paint("stereo", 0.6e-6, pictures=[picture, picture], lamp_deg=10.0)


def spectral_rgb(wavelengths):
    """Linear Rec.709 of spectral lines, moved towards white until no component is negative."""
    from precompute.light.colour import spectral_weights

    grid, weights = spectral_weights(illuminant="E")
    xyz = np.stack([np.interp(wavelengths, grid, weights[:, i]) for i in range(3)], -1)
    rgb = xyz @ xyz_to_rgb_matrix().T
    rgb = rgb - np.minimum(rgb.min(-1, keepdims=True), 0.0)
    return rgb / rgb.max(-1, keepdims=True)


def dominant(xyz):
    """Dominant wavelength by colour-science, metres; an independent way."""
    import colour

    white = colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"]["D65"]
    xy = colour.XYZ_to_xy(xyz)
    return np.array([float(colour.dominant_wavelength(each, white)[0]) for each in xy]) * 1e-9


@pytest.mark.parametrize(("lamp", "view"), [(35.0, 0.0), (50.0, -12.0)])
def test_picture_is_seen_in_its_own_hues(grating, lamp, view):
    """From the designed direction the dominant wavelengths are those painted, within 10 nm.

    Daylight in a narrow order: the hue is that of a band a few nanometres wide.
    """
    wavelengths = np.array([460, 475, 490, 510, 530, 550, 570, 590, 605, 620]) * 1e-9
    picture = np.repeat(spectral_rgb(wavelengths)[None, :, None], 2, 0).reshape(2, -1, 3)
    paint = make_paint("picture", PERIOD, pixels=10, pictures=[picture], lamp_deg=lamp, view_deg=view, sigma_s_um=5.0)
    assert paint.mask.mean() >= 0.8
    wi = from_angles(np.radians(lamp), 0.0)
    wr = from_angles(np.radians(abs(view)), 0.0 if view >= 0 else np.pi)
    seen = painted_brdf(grating, wi, wr, *paint.maps)[0]
    wanted = dominant(picture[0] @ np.linalg.inv(xyz_to_rgb_matrix()).T)
    shown = paint.mask[0] > 0
    assert np.abs(dominant(seen[shown]) - wanted[shown]).max() < 10e-9
    marked = paint.info["marked"]
    assert 1 - shown.mean() == pytest.approx(marked["band_too_wide"] + marked["period_too_large"])


def test_brightness_becomes_brightness(grating):
    """A relief that is shallow beside the wavelength: order 1 grows with the square of its depth."""
    grey = np.array([0.1, 0.25, 0.5, 0.8, 1.0])
    picture = grey[None, :, None] * np.array([0.05, 1.0, 0.1])
    paint = make_paint("picture", PERIOD, pixels=5, pictures=[picture])
    seen = lit(grating, paint, from_angles(np.radians(35.0), 0.0), np.array([0.0, 0.0, 1.0]))[0]
    np.testing.assert_allclose(seen / seen[-1], grey, rtol=0.08)


def test_what_no_period_shows_is_marked_or_refused():
    picture = np.array([[[0.5, 0.5, 0.5], [0.6, 0.0, 0.6], [0.0, 0.6, 0.1], [0.0, 0.0, 0.0]]])
    paint = make_paint("picture", PERIOD, pixels=4, pictures=[picture])
    assert paint.mask.tolist() == [[0.0, 0.0, 1.0, 0.0]]
    assert paint.info["marked"] == {"grey": 0.25, "purple": 0.25, "period_too_large": 0.0, "band_too_wide": 0.0}
    red = np.array([[[0.9, 0.02, 0.01]]])
    with pytest.raises(ParameterError, match="No hue of the picture can be shown"):
        make_paint("picture", 0.5e-6, pictures=[red], lamp_deg=30.0)


def test_stored_maps_come_back(tmp_path):
    paint = make_paint("glitter", PERIOD, pixels=40, seed=5)
    again = load_paint(save_paint(paint, tmp_path / "p.exr"))
    for one, other in zip(paint.maps, again.maps, strict=True):
        assert (one == other).all()
    assert again.info == paint.info and again.info["recipe"] == "glitter"


@pytest.mark.parametrize(
    ("name", "settings", "said"),
    [
        ("plaid", {}, "There is no recipe 'plaid'"),
        ("rings", {"petals": 3}, "has no setting petals"),
        ("rings", {"bands": 0}, "bands is 0; give a whole number from 1"),
        ("rings", {"bands": 2.5}, "give a whole number"),
        ("spiral", {"pitch_deg": float("nan")}, "pitch_deg is nan"),
        ("picture", {}, "takes one picture; 0 given"),
        ("rays", {"pictures": [np.ones((2, 2, 3))]}, "takes no picture; 1 given"),
        ("rays", {"period_m": 0.0}, "A period of 0 m makes no sense"),
        ("rays", {"pixels": 0}, "0 pixels are no picture"),
        ("rays", {"pixels": 9000}, "above the limit of 8192"),
        ("picture", {"pictures": [np.full((2, 2, 3), np.nan)]}, "all finite"),
    ],
)
def test_wrong_input_gets_a_sentence(name, settings, said):
    arguments = {"period_m": PERIOD, "pixels": 8, **settings}
    with pytest.raises(Exception, match=said) as caught:
        make_paint(name, **arguments)
    assert isinstance(caught.value, ValueError | ParameterError.__mro__[1])


@pytest.mark.parametrize("name", sorted(RECIPES))
def test_every_recipe_gives_whole_maps(name):
    picture = np.random.default_rng(0).uniform(0, 1, (30, 40, 3))
    paint = make_paint(name, PERIOD, pixels=48, pictures=[picture] * RECIPES[name].pictures)
    for each in paint.maps:
        assert each.shape == paint.shape and each.dtype == np.float32 and np.isfinite(each).all()
    assert paint.mask.any() and paint.mask.max() <= 1 and paint.scale.min() >= 0.01
