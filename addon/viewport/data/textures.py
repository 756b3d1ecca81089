# SPDX-License-Identifier: GPL-3.0-or-later
"""Spectral tables in the memory of the GPU."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ....precompute.errors import SizeLimitError
from ....precompute.files.stamp import file_stamp
from ....precompute.table import importance, scaled_albedo
from ....precompute.table.layout import TableLayout
from ....precompute.table.table import SpectralTable, read_sidecar
from ...versions import smooth_lookups
from .blocks import ALBEDO_SIDE, buffer


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


def upload(table: SpectralTable) -> TableTextures:
    """Copy a table to the GPU.

    Raises
    ------
    SizeLimitError
        If this GPU has no texture that large.
    """
    import gpu

    layout = table.layout
    side, layers = gpu.capabilities.max_texture_size_get(), gpu.capabilities.max_texture_layers_get()
    if max(layout.n_r, layout.tile_height) > side or layout.n_w > layers:
        raise SizeLimitError(
            f"The table of {layout.n_r} x {layout.n_phi} x {layout.n_w} texels is too large for this GPU, which takes"
            f" {side} x {side} x {layers}; bake it with a smaller sigma_s or a lower detail."
        )
    stack = np.ones((layout.n_w, layout.tile_height, layout.n_r, 4), np.float32)
    for index in range(layout.n_w):
        x, y = layout.tile_origin(index)
        stack[index, :, :, :3] = table.atlas[y : y + layout.tile_height, x : x + layout.n_r]
    albedo = albedo_map(table)
    try:
        slices = gpu.types.GPUTexture(
            (layout.n_r, layout.tile_height), layers=layout.n_w, format="RGBA16F", data=buffer(stack)
        )
        albedos = gpu.types.GPUTexture((ALBEDO_SIDE, ALBEDO_SIDE), format="R16F", data=buffer(albedo))
    except (RuntimeError, MemoryError) as error:
        raise SizeLimitError(
            f"The GPU has no memory for the table ({stack.nbytes / 2e6:.0f} MB); bake it with a lower detail."
        ) from error
    for texture in (slices, albedos):
        smooth_lookups(texture)
    return TableTextures(layout, table.info, slices, albedos)


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

    def __len__(self) -> int:
        return len(self._held)

    def get(self, path: Path) -> TableTextures:
        """Textures of the table at a path.

        Raises
        ------
        TableError, SizeLimitError
            If the table cannot be read or does not fit.
        """
        stamp = table_stamp(path)
        held = self._held.get(path)
        if held is None or held[0] != stamp:
            self._held.pop(path, None)
            held = self._held[path] = (stamp, upload(SpectralTable.load(path)))
        return held[1]

    def tiles(self, path: Path) -> Any:
        """Albedos of the table's scaled surfaces; of one whose table `get` found.

        Raises
        ------
        TableError
            If the table cannot be read.
        """
        textures = self.get(path)
        if textures.tiles is None:
            textures.tiles = _upload_tiles(
                find_directions(path)[importance.VIEWS :][: scaled_albedo.HEIGHT, : scaled_albedo.WIDTH]
            )
        return textures.tiles

    def keep(self, paths: set[Path]) -> None:
        """Drop all but these."""
        for path in self._held.keys() - paths:
            del self._held[path]

    def clear(self) -> None:
        """Drop all."""
        self._held.clear()


def table_stamp(path: Path) -> tuple:
    """What changes when a table is baked again; empty where a file is missing."""
    stamps = [file_stamp(path.with_suffix(suffix)) for suffix in (".exr", ".json")]
    return () if None in stamps else tuple(stamps)
