# SPDX-License-Identifier: GPL-3.0-or-later
"""Spectral tables in the memory of the GPU."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ....precompute.errors import DiffractionError, SizeLimitError
from ....precompute.table import importance, scaled_albedo
from ....precompute.table.layout import TableLayout
from ....precompute.table.table import SpectralTable, read_sidecar
from ...versions import smooth_lookups
from ..copies import Copy
from .blocks import ALBEDO_SIDE, buffer
from .display import redraw
from .readings import Readings, table_stamp

#: Bytes of a table, in single precision, that a drawing copies to the GPU: some milliseconds of memory's time.
AT_ONCE = 12e6


@dataclass(eq=False)
class TableTextures:
    """A table's slices as the layers of an array texture, its albedo as another texture.

    An array, not a 3-D texture: those end at 2048 texels a side on most GPUs, which the angles of a
    `single` table pass.
    """

    layout: TableLayout
    info: dict[str, Any]
    slices: Any
    albedo: Any
    tiles: Any = None


def _upload_tiles(tiles: np.ndarray) -> Any:
    import gpu

    rgba = np.ones((*tiles.shape[:2], 4), np.float32)
    rgba[..., :3] = tiles
    texture = gpu.types.GPUTexture((tiles.shape[1], tiles.shape[0]), format="RGBA16F", data=buffer(rgba))
    smooth_lookups(texture)
    return texture


def find_directions(path: Path) -> np.ndarray:
    """``(HEIGHT, WIDTH, 3)``: the image of directions beside a table, else one made now, in a second or so.

    Raises
    ------
    TableError
        If the table cannot be read.
    """
    beside = path.with_name(f"{path.stem}.importance.exr")
    origin = importance.read_origin(beside)
    if origin is not None and origin[0] == read_sidecar(path)["atlas"]["sha256"]:
        return importance.load_image(beside)
    return importance.importance(SpectralTable.load(path)).image()


@dataclass(frozen=True)
class TableTexels:
    """A table as the GPU takes it.

    Parameters
    ----------
    slices
        ``(n_w, tile height, n_r, 4)`` float32.
    albedo
        Of `albedo_map`.
    """

    layout: TableLayout
    info: dict[str, Any]
    slices: np.ndarray
    albedo: np.ndarray


def texels(table: SpectralTable) -> TableTexels:
    """What `Uploading` copies."""
    layout = table.layout
    stack = np.ones((layout.n_w, layout.tile_height, layout.n_r, 4), np.float32)
    for index in range(layout.n_w):
        x, y = layout.tile_origin(index)
        stack[index, :, :, :3] = table.atlas[y : y + layout.tile_height, x : x + layout.n_r]
    return TableTexels(layout, table.info, stack, albedo_map(table))


def read_texels(path: Path) -> TableTexels:
    """`texels` of the table at a path.

    Raises
    ------
    TableError
        If it cannot be read.
    """
    return texels(SpectralTable.load(path))


class Uploading:
    """A table on its way to the GPU.

    Parameters
    ----------
    stamp
        Of its files.
    found
        The table.

    Raises
    ------
    SizeLimitError
        If this GPU has no texture that large.
    """

    def __init__(self, stamp: tuple, found: TableTexels) -> None:
        import gpu

        self.stamp = stamp
        layout = found.layout
        side, layers = gpu.capabilities.max_texture_size_get(), gpu.capabilities.max_texture_layers_get()
        if max(layout.n_r, layout.tile_height) > side or layout.n_w > layers:
            raise SizeLimitError(
                f"The table of {layout.n_r} x {layout.n_phi} x {layout.n_w} texels is too large for this GPU, which"
                f" takes {side} x {side} x {layers}; bake it with a smaller sigma_s or a lower detail."
            )
        self._megabytes = found.slices.nbytes / 2e6
        try:
            self._slices = Copy(found.slices)
            albedos = gpu.types.GPUTexture((ALBEDO_SIDE, ALBEDO_SIDE), format="R16F", data=buffer(found.albedo))
        except (RuntimeError, MemoryError) as error:
            raise self._no_room() from error
        for texture in (self._slices.texture, albedos):
            smooth_lookups(texture)
        self._textures = TableTextures(layout, found.info, self._slices.texture, albedos)

    def go_on(self, most_bytes: float) -> TableTextures | None:
        """Copy about so many bytes; the textures when all is there.

        After several drawings not in that of the last copy: the next one has a shader to compile.

        Raises
        ------
        SizeLimitError
            If the GPU has no room left.
        """
        before = self._slices.done
        try:
            is_there = self._slices.go_on(most_bytes)
        except (RuntimeError, MemoryError) as error:
            raise self._no_room() from error
        return self._textures if is_there and before in (0, self._slices.done) else None

    def _no_room(self) -> SizeLimitError:
        return SizeLimitError(
            f"The GPU has no memory for the table ({self._megabytes:.0f} MB); bake it with a lower detail."
        )


def upload(found: TableTexels) -> TableTextures:
    """Copy a table to the GPU at once.

    Raises
    ------
    SizeLimitError
        If this GPU has no texture that large.
    """
    made = Uploading((), found).go_on(float("inf"))
    assert made is not None
    return made


def albedo_map(table: SpectralTable) -> np.ndarray:
    """``(ALBEDO_SIDE, ALBEDO_SIDE)`` albedos over the hemisphere in stereographic projection.

    A direction (x, y, z) lies at (x, y) / (1 + z) of the unit disc; outside of it its rim goes on. Steps are a fifth of
    the table's own straight above, and a ninth towards the horizon, where albedos rise most.
    """
    layout = table.layout
    first = layout.conserving_y
    tile = table.atlas[first : first + layout.n_albedo_phi + 2, : layout.n_theta, 0].astype(np.float32)
    along = np.linspace(-1.0, 1.0, ALBEDO_SIDE, dtype=np.float32)
    x, y = np.meshgrid(along, along)
    theta = 2.0 * np.arctan(np.minimum(np.hypot(x, y), 1.0))
    column = theta * ((layout.n_theta - 1) / (0.5 * np.pi))
    row = 1.0 + np.mod(np.arctan2(y, x) * (layout.n_albedo_phi / (2.0 * np.pi)), layout.n_albedo_phi)
    left, below = np.minimum(column.astype(int), layout.n_theta - 2), np.minimum(row.astype(int), len(tile) - 2)
    right, up = column - left, row - below
    lower = tile[below, left] * (1.0 - right) + tile[below, left + 1] * right
    upper = tile[below + 1, left] * (1.0 - right) + tile[below + 1, left + 1] * right
    return lower * (1.0 - up) + upper * up


class Tables:
    """Textures by the path of their table; read again when the file changes, dropped when no longer asked for."""

    def __init__(self) -> None:
        self._held: dict[Path, tuple[tuple, TableTextures]] = {}
        self._uploading: dict[Path, Uploading] = {}
        self._texels = Readings(read_texels)
        self._tiles = Readings(find_directions)

    def __len__(self) -> int:
        return len(self._held)

    def get(self, path: Path, wait: bool = True) -> TableTextures | None:
        """Textures of the table at a path; while a changed one is on its way, those of before, if there were any.

        Parameters
        ----------
        wait
            Read and copy it now, not in a thread and over several drawings.

        Raises
        ------
        TableError, SizeLimitError
            If the table cannot be read or does not fit.
        """
        stamp = table_stamp(path)
        held = self._held.get(path)
        if held is not None and held[0] == stamp:
            return held[1]
        try:
            made = self._go_on(path, stamp, wait)
        except DiffractionError:
            self._held.pop(path, None)
            self._uploading.pop(path, None)
            raise
        if made is None:
            return held[1] if held is not None else None
        self._held[path] = stamp, made
        return made

    def _go_on(self, path: Path, stamp: tuple, wait: bool) -> TableTextures | None:
        """Read and copy a table, or a part of it; its textures when all is done."""
        underway = self._uploading.get(path)
        if underway is None or underway.stamp != stamp:
            found = self._texels.take(path, stamp, wait)
            if found is None:
                return None
            underway = self._uploading[path] = Uploading(stamp, found)
        made = underway.go_on(float("inf") if wait else AT_ONCE)
        if wait and made is None:
            made = underway.go_on(0.0)
        if made is not None:
            del self._uploading[path]
        else:
            bpy.app.timers.register(redraw, first_interval=0.0)  # Blender forgets what is asked for while it draws
        return made

    def tiles(self, path: Path, wait: bool = True) -> Any:
        """Albedos of the scaled surfaces of a table that `get` found; None while a thread reads them.

        Raises
        ------
        TableError
            If the table cannot be read.
        """
        stamp, textures = self._held[path]
        if textures.tiles is None:
            image = self._tiles.take(path, stamp, wait)
            if image is None:
                return None
            textures.tiles = _upload_tiles(image[importance.VIEWS :][: scaled_albedo.HEIGHT, : scaled_albedo.WIDTH])
        return textures.tiles

    def keep(self, paths: set[Path]) -> None:
        """Drop all but these."""
        self._texels.keep(paths)
        self._tiles.keep(paths)
        for held in (self._held, self._uploading):
            for path in held.keys() - paths:
                del held[path]

    def clear(self) -> None:
        """Drop all."""
        self._held.clear()
        self._uploading.clear()
        self._texels.clear()
        self._tiles.clear()
