# SPDX-License-Identifier: GPL-3.0-or-later
"""Images of the surroundings in the memory of the GPU: a mip map over the sphere, filtered once.

The sphere is laid out in the equal-area square of Clarberg (2008, "Fast equal-area mapping of the (hemi)sphere using
SIMD"): every texel of a level stands for the same solid angle, so that levels are plain means, and which one a sample
asks for follows from its solid angle alone.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from ...lights import hot_spots
from ...versions import smooth_lookups
from . import panorama
from .blocks import buffer
from .display import redraw
from .panorama import Panorama
from .sources import DIFFUSE_CORNER, DIFFUSE_SIDE, SKY_LEVELS, SKY_SIDE

#: Width of an image after it was reduced by whole factors: steps of a third of a degree.
_WIDTH = 1024

#: What stands out of the rest is smaller than what directions find: so many spots at most, of at least so much of the
#: light, shine as suns here beside those that materials know (`hot_spots.of`).
_MORE, _PART = 8, 0.005

#: Skies kept.
_KEPT = 3

#: Radiance all around ``(rows, cols, 3)``, row 0 at the bottom, and the suns that stand out of it, see `Lit`.
Light = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Sky:
    """An image that surrounds the scene.

    Parameters
    ----------
    image
        Name (with its library) of an image data-block, or empty.
    path
        Of a picture file where there is no data-block.
    world
        Name (with its library) of a world that has to be rendered all around first, or empty.
    stamp
        Changes when the pixels do.
    turn
        ``(9,)`` rotation from the world's directions to the image's, row by row.
    strength
        ``(3,)`` factors.
    """

    image: str
    path: str
    stamp: tuple
    turn: tuple[float, ...]
    strength: tuple[float, float, float]
    world: str = ""

    @property
    def pixels(self) -> tuple:
        """What decides the texture."""
        return self.image, self.path, self.world, self.stamp

    def rows(self) -> np.ndarray:
        """``(4, 4)`` of the frame's block."""
        rows = np.zeros((4, 4), np.float32)
        rows[:3, :3] = np.reshape(self.turn, (3, 3))
        rows[:3, 3] = self.strength
        width, height = atlas_size()
        rows[3, :2] = 1.0 / width, 1.0 / height
        return rows


def square_directions(side: int) -> np.ndarray:
    """``(side, side, 3)`` directions of the texels' middles, row 0 at the bottom."""
    along = (np.arange(side) + 0.5) * (2.0 / side) - 1.0
    u, v = np.meshgrid(along, along)
    return square_to_direction(u, v)


def square_to_direction(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """``(..., 3)`` directions of places in [-1, 1]^2."""
    a, b = np.abs(u), np.abs(v)
    below = a + b > 1.0
    x, y = np.where(below, 1.0 - b, a), np.where(below, 1.0 - a, b)
    r = x + y
    phi = np.where(r > 0.0, y / np.maximum(r, 1e-12), 0.0) * (0.5 * np.pi)
    z = 1.0 - r**2
    ring = r * np.sqrt(np.maximum(2.0 - r**2, 0.0))
    z = np.where(below, -z, z)
    return np.stack([np.sign(u) * np.cos(phi) * ring, np.sign(v) * np.sin(phi) * ring, z], -1)


def equirectangular(pixels: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Values ``(..., 3)`` of a picture of the sphere, ``(rows, cols, 3)``, as an Environment Texture looks them up."""
    rows, cols, _ = pixels.shape
    x, y, z = np.moveaxis(directions, -1, 0)
    column = (0.5 - np.arctan2(y, x) / (2.0 * np.pi)) * cols - 0.5
    row = np.clip((0.5 + np.arctan2(z, np.hypot(x, y)) / np.pi) * rows - 0.5, 0.0, rows - 1.0)
    left, below = np.floor(column), np.minimum(np.floor(row), max(rows - 2, 0))
    right, up = (column - left)[..., None], (row - below)[..., None]
    i, j = left.astype(int) % cols, below.astype(int)
    following, above = (i + 1) % cols, np.minimum(j + 1, rows - 1)
    lower = pixels[j, i] * (1.0 - right) + pixels[j, following] * right
    upper = pixels[above, i] * (1.0 - right) + pixels[above, following] * right
    return lower * (1.0 - up) + upper * up


def reduced(pixels: np.ndarray, width: int = _WIDTH) -> np.ndarray:
    """A picture made smaller by a whole factor, as means of blocks."""
    factor = max(1, -(-pixels.shape[1] // width))
    rows, cols = (n // factor * factor for n in pixels.shape[:2])
    if factor == 1 or not rows or not cols:
        return pixels
    return pixels[:rows, :cols].reshape(rows // factor, factor, cols // factor, factor, -1).mean(axis=(1, 3))


def levels(pixels: np.ndarray) -> list[np.ndarray]:
    """Squares ``(side, side, 3)`` from `SKY_SIDE` down, each the mean of four texels of the one before."""
    pixels = reduced(np.asarray(pixels, np.float32))
    fine = square_directions(2 * SKY_SIDE)
    found = [equirectangular(pixels, fine)]
    while len(found) <= SKY_LEVELS:
        last = found[-1]
        side = len(last) // 2
        found.append(last.reshape(side, 2, side, 2, 3).mean(axis=(1, 3)))
    return found[1:]


def atlas_size() -> tuple[int, int]:
    """Width and height of the texture that holds all levels."""
    return SKY_SIDE + SKY_SIDE // 2 + 4, SKY_SIDE + 2 * SKY_LEVELS


def atlas(squares: list[np.ndarray]) -> np.ndarray:
    """``(height, width, 4)``: the first level on the left, the others above one another on its right.

    Beside the third, which leaves room there, lies what a diffuse surface sees.
    """
    width, height = atlas_size()
    texels = np.zeros((height, width, 4), np.float32)
    x, y = DIFFUSE_CORNER
    texels[y : y + DIFFUSE_SIDE + 2, x : x + DIFFUSE_SIDE + 2, :3] = _bordered(diffuse(squares))
    y = 0
    for level, square in enumerate(squares):
        side = len(square)
        x = 0 if level == 0 else SKY_SIDE + 2
        texels[y : y + side + 2, x : x + side + 2, :3] = _bordered(square)
        y = 0 if level == 0 else y + side + 2
    return np.minimum(texels, 6e4)  # of half floats


def diffuse(squares: list[np.ndarray]) -> np.ndarray:
    """Square ``(DIFFUSE_SIDE, DIFFUSE_SIDE, 3)``: irradiance over pi of a surface that faces each direction."""
    coarse = next(square for square in squares if len(square) == DIFFUSE_SIDE)
    towards = square_directions(DIFFUSE_SIDE).reshape(-1, 3)
    cosines = np.maximum(towards @ towards.T, 0.0).astype(np.float32)
    # Of even radiance it is that radiance, whatever the texels' number.
    light = cosines @ coarse.reshape(-1, 3) / cosines.sum(-1, keepdims=True)
    return light.reshape(coarse.shape)


def _bordered(square: np.ndarray) -> np.ndarray:
    """The square with a border of what lies next to it on the sphere: its sides are folded in their middles."""
    side = len(square)
    out = np.empty((side + 2, side + 2, 3), np.float32)
    out[1:-1, 1:-1] = square
    out[0, 1:-1], out[-1, 1:-1] = square[0, ::-1], square[-1, ::-1]
    out[1:-1, 0], out[1:-1, -1] = square[::-1, 0], square[::-1, -1]
    out[0, 0], out[0, -1], out[-1, 0], out[-1, -1] = square[-1, -1], square[-1, 0], square[0, -1], square[0, 0]
    return out


def read_pixels(sky: Sky) -> np.ndarray | None:
    """``(rows, cols, 3)`` scene-linear values, row 0 at the bottom; None if there are none. Not while Blender draws."""
    if sky.image:
        image = next((each for each in bpy.data.images if each.name_full == sky.image), None)
        return None if image is None else _linear(image)
    try:
        image = bpy.data.images.load(sky.path, check_existing=False)
    except RuntimeError:
        return None
    try:
        return _linear(image)
    finally:
        bpy.data.images.remove(image)


def _linear(image: bpy.types.Image) -> np.ndarray | None:
    width, height = image.size
    if not width or not height:
        return None
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    channels = pixels.reshape(height, width, -1)
    rgb = channels[..., :3] if channels.shape[-1] >= 3 else np.repeat(channels[..., :1], 3, axis=-1)
    if not image.is_float and not image.colorspace_settings.is_data:
        rgb = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return np.nan_to_num(rgb, nan=0.0, posinf=6e4, neginf=0.0)


def read_light(sky: Sky) -> Light | None:
    """`read_pixels`, bright spots apart. Not while Blender draws."""
    pixels = read_pixels(sky)
    if pixels is None:
        return None
    image = next((each for each in bpy.data.images if sky.image and each.name_full == sky.image), None)
    spots = hot_spots.of(image) if image is not None else hot_spots.search(pixels.mean(-1))
    return hot_spots.split(pixels, spots)


@dataclass(frozen=True)
class Lit:
    """A sky on the GPU.

    Parameters
    ----------
    texture
        Of all levels.
    suns
        ``(n, 7)`` what stands out of it and is not in the texture, in the image's directions, at a strength of 1.
    spots, rest
        ``(m, 7)`` those of them that materials know, and the image ``(rows, cols, 3)`` without these.
    """

    texture: Any
    suns: np.ndarray
    spots: np.ndarray
    rest: np.ndarray
    _above: dict[float, np.ndarray] = field(default_factory=dict, compare=False)

    def suns_above(self, threshold: float) -> np.ndarray:
        """`hot_spots.suns_above` of it."""
        if threshold not in self._above:
            self._above[threshold] = hot_spots.suns_above(self.rest, self.spots, threshold)
        return self._above[threshold]


class _Texels:
    """The texture of a sky in the making: its levels take a third of a second."""

    def __init__(self, light: Light | None) -> None:
        self._light = light
        self._texels: np.ndarray | None = None
        self._rest, self._suns = np.zeros((1, 1, 3), np.float32), np.zeros((0, 7), np.float32)
        self._thread = threading.Thread(target=self._work, daemon=True)

    def start(self) -> None:
        """Make it in a thread."""
        self._thread.start()

    def is_done(self) -> bool:
        """Whether it is there."""
        return not self._thread.is_alive()

    def upload(self) -> Lit | None:
        """The sky on the GPU; None where there is no light."""
        import gpu

        if self._light is None:
            return None
        if self._texels is None:
            self._work()
        texels: Any = self._texels
        texture = gpu.types.GPUTexture(atlas_size(), format="RGBA16F", data=buffer(texels))
        smooth_lookups(texture)
        return Lit(texture, self._suns, self._light[1], self._rest)

    def _work(self) -> None:
        if self._light is not None:
            self._rest = reduced(self._light[0])
            spots = hot_spots.search(self._rest.mean(-1), _MORE - min(len(self._light[1]), _MORE), _PART)
            rest, more = hot_spots.split(self._rest, spots)
            self._suns = np.concatenate([self._light[1], more])
            self._texels = atlas(levels(rest))


class Skies:
    """Textures of the last few skies; made between two drawings."""

    def __init__(self, read: Callable[[Sky], Light | None] = read_light) -> None:
        self._read = read
        self._held: OrderedDict[tuple, Lit | None] = OrderedDict()
        self._waiting: set[tuple] = set()
        self._rendering: tuple[Sky, Panorama] | None = None
        self._making: tuple[Sky, _Texels] | None = None
        #: By world: what was shown last, until what is asked for is there.
        self._last: dict[str, tuple] = {}
        #: What to tell the user; empty while all is well.
        self.message = ""

    def get(self, sky: Sky, wait: bool = False) -> Lit | None:
        """The sky, or None while it is in the making or where the image holds nothing.

        Parameters
        ----------
        wait
            Make it now: allowed in operators, not while Blender draws.
        """
        key = sky.pixels
        if key not in self._held:
            if wait:
                self._make(sky)
            elif key not in self._waiting:
                self._waiting.add(key)
                bpy.app.timers.register(lambda: self._make_soon(sky), first_interval=0.0)
            key = key if key in self._held else self._last.get(sky.world, key)
        if key not in self._held:
            return None
        self._held.move_to_end(key)
        return self._held[key]

    def clear(self) -> None:
        """Let go of all."""
        if self._rendering is not None:
            self._rendering[1].stop()
            self._rendering = None
        self._making = None
        self._held.clear()
        self._waiting.clear()
        self._last.clear()
        self.message = ""

    def _make_soon(self, sky: Sky) -> float | None:
        if sky.pixels not in self._waiting:
            return None
        if self._making is not None:
            made, texels = self._making
            if not texels.is_done():
                return 0.05
            self._making = None
            self._waiting.discard(made.pixels)
            self._keep(made, texels)
            redraw()
            return None if made == sky else 0.0
        if not sky.world:
            self._start(sky, self._read(sky))
            return 0.05
        if self._rendering is None:
            world = _world(sky.world)
            if world is None or panorama.stamp(world) != sky.stamp:  # it has changed since, and is asked for anew
                self._waiting.discard(sky.pixels)
                redraw()
                return None
            self._rendering = sky, Panorama(world)
        rendered, job = self._rendering
        if not job.is_done():
            return 0.1
        self._rendering = None
        self._start(rendered, job.result())
        return 0.05

    def _start(self, sky: Sky, light: Light | None) -> None:
        self._making = sky, _Texels(light)
        self._making[1].start()

    def _make(self, sky: Sky) -> None:
        world = _world(sky.world) if sky.world else None
        self._keep(sky, _Texels(Panorama(world).result() if world is not None else self._read(sky)))

    def _keep(self, sky: Sky, texels: _Texels) -> None:
        made = texels.upload()
        if sky.world:
            self._last[sky.world] = sky.pixels
            self.message = "" if made is not None else "the world, which a second Blender could not render"
        self._held[sky.pixels] = made
        while len(self._held) > _KEPT:
            self._held.popitem(last=False)


def _world(name: str) -> bpy.types.World | None:
    return next((each for each in bpy.data.worlds if each.name_full == name), None)
