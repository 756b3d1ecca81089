# SPDX-License-Identifier: GPL-3.0-or-later
"""Bright spots of an equirectangular image of the surroundings: direction and size, found once and kept with it.

A spot is what stands out so far that random mirrors miss it: a sun, a lamp. Wide bright areas (windows, softboxes) and
the sky are left to the environment.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

import bpy
import numpy as np

#: Custom properties of images: what was found, and of which size and file.
KEY, KEY_EEVEE, KEY_EEVEE_OWN = "diffraction_spots", "diffraction_eevee_sun", "diffraction_eevee_own_suns"

#: Spots of an image at most, and what one has to be: radiance over the mean, part of all light, radius in radians.
MOST, STANDS_OUT, PART, RADIUS_MAX = 4, 100.0, 0.02, 0.1

#: Radius (rad) of the sun that EEVEE makes of a studio light, and how far from a spot what is bright belongs to it.
EEVEE_SUN_RADIUS, ABOUT = math.radians(0.526) / 2.0, 0.3

#: Number of the search: what an older one found is searched for anew.
_SEARCH = 2

#: Suns in place of EEVEE's one at most, as many as it reads, and how long the means of the directions of their light
#: are where so many suns stand for it.
EEVEE_OWN, EEVEE_ONE = 4, 0.98

Spot = tuple[float, float, float, float, float]

#: What was found in images of libraries, which cannot keep it themselves, newest last; how many are remembered.
_linked: dict[tuple, list[Any]] = {}
_LINKED_MOST = 32


def of(image: bpy.types.Image) -> list[Spot]:
    """Spots of an image, brightest first: unit direction x, y, z, radius (rad), irradiance in the image's units."""
    return _kept(image, KEY, [_SEARCH], lambda pixels: search(pixels.mean(-1)))


def eevee_sun(image: bpy.types.Image, threshold: float) -> list[Spot]:
    """The sun that EEVEE makes of all that is brighter than a radiance in the image's units: one spot, or none.

    EEVEE takes that light out of the world and lets it shine from its mean direction alone.
    """
    return _kept(image, KEY_EEVEE, [threshold], lambda pixels: mean_above(pixels, threshold))


def eevee_own_suns(image: bpy.types.Image, threshold: float) -> list[tuple[float, ...]]:
    """`own_suns` of an image, brightest first."""
    return _kept(image, KEY_EEVEE_OWN, [_SEARCH, threshold], lambda pixels: own_suns(pixels, threshold))


def _kept(image: bpy.types.Image, key: str, more: list[float], find: Callable[[np.ndarray], list[Any]]) -> list[Any]:
    """What is found in an image's pixels ``(height, width, 1 to 3)``, once for each file and size of it."""
    stamp = [image.filepath, *image.size, *more]
    linked = (image.library.filepath, image.name, key, *stamp) if image.library is not None else None
    if linked in _linked:
        return _linked[linked]
    try:
        kept = json.loads(image.get(key, "[]"))
        if kept and kept[0] == stamp:
            return [tuple(row) for row in kept[1]]
    except ValueError:
        pass
    width, height = image.size
    if not image.has_data and not width * height:
        return []
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    spots = find(pixels.reshape(height, width, image.channels)[..., : min(3, image.channels)])
    if image.is_editable:
        image[key] = json.dumps([stamp, spots])
    elif linked is not None:
        while len(_linked) >= _LINKED_MOST:
            del _linked[next(iter(_linked))]
        _linked[linked] = spots
    return spots


def search(luminance: np.ndarray, most: int = MOST, part: float = PART) -> list[Spot]:
    """Spots of an equirectangular picture, brightest first.

    From the brightest pixel outwards all that is brighter than a tenth of it belongs to a spot; its axis is the mean
    by power, its radius that of the smallest cone that holds it. What touches the cone of a brighter one, as the halo
    of a sun does, is no spot: two lobes that overlap would count what lies in both twice.

    Parameters
    ----------
    luminance
        ``(height, width)``, row 0 at the bottom.
    most
        Regions to look at.
    part
        Of all light that a spot has at least.
    """
    height, width = luminance.shape
    power = np.maximum(luminance, 0.0) * _texel_sizes(height, width)[:, None]
    total = float(power.sum())
    if not total > 0.0 or not math.isfinite(total):
        return []
    mean, left = total / (4.0 * math.pi), luminance.copy()
    texel = 0.5 * math.hypot(math.pi / height, 2.0 * math.pi / width)
    found: list[Spot] = []
    for _ in range(most):
        row, column = np.unravel_index(int(left.argmax()), left.shape)
        peak = float(left[row, column])
        if peak < STANDS_OUT * mean:
            break
        rows, columns = _region(left, int(row), int(column), 0.1 * peak)
        vectors, light = _directions(rows, columns, height, width), power[rows, columns]
        left[rows, columns] = 0.0
        spot = _spot(vectors, light, texel)
        if spot[3] <= RADIUS_MAX and spot[4] >= part * total and not any(_touch(spot, other) for other in found):
            found.append(spot)
    return sorted(found, key=lambda spot: -spot[4])


def _spot(vectors: np.ndarray, light: np.ndarray, texel: float) -> Spot:
    """The spot of pixels in the directions ``(n, 3)``, each half a `texel` wide (rad), by their light ``(n,)``."""
    axis = (vectors * light[:, None]).sum(0)
    axis /= max(float(np.linalg.norm(axis)), 1e-12)
    x, y, z = map(float, axis)
    return x, y, z, float(np.arccos(np.clip(vectors @ axis, -1.0, 1.0)).max()) + texel, float(light.sum())


def _touch(one: Spot, other: Spot) -> bool:
    return sum(a * b for a, b in zip(one[:3], other[:3], strict=True)) > math.cos(min(one[3] + other[3], math.pi))


def split(pixels: np.ndarray, spots: list[Spot]) -> tuple[np.ndarray, np.ndarray]:
    """A picture without its spots, and the spots as suns.

    Parameters
    ----------
    pixels
        ``(height, width, 3)`` radiance, row 0 at the bottom.
    spots
        Of it, see `of`.

    Returns
    -------
    rest
        As `pixels`; each spot is as bright as what surrounds it.
    suns
        ``(n, 7)``: direction, irradiance (3,) on a surface that faces it, radius in radians.
    """
    rest, suns = np.array(pixels, np.float32), []
    height, width, _ = rest.shape
    elevation, sizes = _elevation(height), _texel_sizes(height, width)
    for x, y, z, radius, _ in spots:
        # Only rows that the ring about the spot touches.
        lies = math.asin(min(max(z, -1.0), 1.0))
        rows = np.flatnonzero(np.abs(elevation - lies) < 2.0 * radius)
        grid = np.repeat(rows, width), np.tile(np.arange(width), len(rows))
        apart = np.arccos(np.clip(_directions(*grid, height, width) @ np.array([x, y, z]), -1.0, 1.0))
        inside, ring = apart <= radius, (apart > radius) & (apart < 2.0 * radius)
        r, c = grid[0][inside], grid[1][inside]
        if not len(r) or not ring.any():
            continue
        about = np.median(rest[grid[0][ring], grid[1][ring]], axis=0)
        more = np.maximum(rest[r, c] - about, 0.0)
        size = sizes[r]
        rest[r, c] -= more
        # A spot seldom fills the cone that holds it: as a disc of even brightness it has the same mean square.
        power = more.sum(-1) * size
        spread = math.sqrt(2.0 * float((power * apart[inside] ** 2).sum() / max(float(power.sum()), 1e-30)))
        suns.append((x, y, z, *(more * size[:, None]).sum(0), min(spread, radius)))
    return rest, np.array(suns, np.float32).reshape(-1, 7)


def mean_above(pixels: np.ndarray, threshold: float) -> list[Spot]:
    """The mean direction of what is brighter than a threshold, if it is a good part of all light: one spot or none.

    Parameters
    ----------
    pixels
        ``(height, width, 1 to 3)`` radiance, row 0 at the bottom.
    threshold
        For the brightest channel: what lies above it counts.
    """
    total = float((np.maximum(pixels.mean(-1), 0.0) * _texel_sizes(*pixels.shape[:2])[:, None]).sum(dtype=float))
    towards, light = _above(pixels, threshold)
    more = np.maximum(light.mean(-1), 0.0)
    part, axis = float(more.sum(dtype=float)), _mean_direction(towards, more)
    if axis is None or not (math.isfinite(total) and part > PART * total):
        return []
    x, y, z = map(float, axis)
    return [(x, y, z, EEVEE_SUN_RADIUS, part)]


def own_suns(pixels: np.ndarray, threshold: float) -> list[tuple[float, ...]]:
    """What EEVEE takes out of a picture, where one sun in its mean direction would not show it; none where it would.

    Parameters
    ----------
    pixels, threshold
        As of `mean_above`.

    Returns
    -------
    list
        Brightest first: direction, irradiance (3,) on a surface that faces it, radius in radians.
    """
    if not mean_above(pixels, threshold):
        return []
    towards, light = _above(pixels, threshold)
    power = np.maximum(light.mean(-1), 0.0)
    moments, total = towards * power[:, None], float(power.sum(dtype=float))
    seeds, owner = towards[[power.argmax()]], np.zeros(len(power), int)
    for number in range(1, EEVEE_OWN + 1):
        for _ in range(8):  # Lloyd's steps: each sun in the mean direction of what is nearest to it
            owner = (towards @ seeds.T).argmax(-1)
            sums = np.stack([np.bincount(owner, axis, number) for axis in moments.T], -1)
            lengths = np.linalg.norm(sums, axis=-1, keepdims=True)
            seeds = np.where(lengths > 0.0, sums / np.maximum(lengths, 1e-30), seeds)
        if float(lengths.sum()) > EEVEE_ONE * total or number == EEVEE_OWN:
            break
        apart = 1.0 - (towards @ seeds.T).max(-1)
        seeds = np.concatenate([seeds, towards[[(power * apart).argmax()]]])
    if len(seeds) == 1:
        return []
    rgb = np.broadcast_to(light, (len(light), 3)) if light.shape[-1] < 3 else light
    found = [
        (*map(float, axis), *(float(channel[owner == i].sum(dtype=float)) for channel in rgb.T), EEVEE_SUN_RADIUS)
        for i, axis in enumerate(seeds)
        if (owner == i).any()
    ]
    return sorted(found, key=lambda row: -sum(row[3:6]))


def suns_above(pixels: np.ndarray, suns: np.ndarray, threshold: float) -> np.ndarray:
    """What EEVEE takes out of a picture as a sun: all that is brighter than a radiance.

    EEVEE makes one sun of it, in its mean direction. Here each spot stays where it is and gets what is bright about it;
    the rest is one sun.

    Parameters
    ----------
    pixels, suns
        What `split` made of a picture.
    threshold
        For the brightest channel: what lies above it is taken out, in its colour.

    Returns
    -------
    ndarray
        ``(n, 7)`` as ``suns``.
    """
    towards, more = _above(pixels, threshold)
    found = np.concatenate([suns, np.zeros((1, 7), np.float32)])
    found[-1, 6] = EEVEE_SUN_RADIUS
    near = np.concatenate([towards @ suns[:, :3].T, np.full((len(more), 1), math.cos(ABOUT))], 1)
    owner = near.argmax(-1)
    for number in range(3):
        found[:, 3 + number] += np.bincount(owner, more[:, number], len(found)).astype(np.float32)
    rest = owner == len(suns)
    axis = _mean_direction(towards[rest], more[rest].mean(-1))
    if axis is None:
        return found[:-1]
    found[-1, :3] = axis
    return found


def _above(pixels: np.ndarray, threshold: float) -> tuple[np.ndarray, np.ndarray]:
    """``(n, 3)`` directions of pixels whose brightest channel is above a threshold, and ``(n, channels)`` the light of
    them, radiance times solid angle, that lies above it."""
    height, width, _ = pixels.shape
    peak = pixels.max(-1)
    rows, columns = np.nonzero(peak > threshold)
    part = (1.0 - threshold / peak[rows, columns]) * _texel_sizes(height, width)[rows]
    return _directions(rows, columns, height, width), pixels[rows, columns] * part[:, None]


def _mean_direction(towards: np.ndarray, light: np.ndarray) -> np.ndarray | None:
    """``(3,)`` of unit directions ``(n, 3)`` by their light ``(n,)``; None where there is none."""
    axis = (towards * light[:, None]).sum(0)
    length = float(np.linalg.norm(axis))
    return axis / length if length > 0.0 else None


def _elevation(height: int) -> np.ndarray:
    """``(height,)`` radians of the rows' middles above the horizon."""
    return ((np.arange(height) + 0.5) / height - 0.5) * math.pi


def _texel_sizes(height: int, width: int) -> np.ndarray:
    """``(height,)`` solid angles of the texels of each row."""
    return np.cos(_elevation(height)) * (math.pi / height) * (2.0 * math.pi / width)


def _region(picture: np.ndarray, row: int, column: int, least: float) -> tuple[np.ndarray, np.ndarray]:
    """Pixels above a value that hang together with one; columns go round."""
    height, width = picture.shape
    seen, waiting = {(row, column)}, [(row, column)]
    most = max(64, int(picture.size * 0.01))
    while waiting and len(seen) < most:
        r, c = waiting.pop()
        for near in ((r - 1, c), (r + 1, c), (r, (c - 1) % width), (r, (c + 1) % width)):
            if 0 <= near[0] < height and near not in seen and picture[near] > least:
                seen.add(near)
                waiting.append(near)
    rows, columns = np.array(sorted(seen)).T
    return rows, columns


def _directions(rows: np.ndarray, columns: np.ndarray, height: int, width: int) -> np.ndarray:
    """Unit vectors ``(n, 3)`` of pixels, as Cycles lays an equirectangular picture about z."""
    theta = ((rows + 0.5) / height - 0.5) * math.pi
    phi = (0.5 - (columns + 0.5) / width) * 2.0 * math.pi
    # direction_to_equirectangular: u = -atan2(y, x) / (2 pi) + 1/2, v = asin(z) / pi + 1/2
    return np.stack([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), np.sin(theta)], -1)
