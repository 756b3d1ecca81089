# SPDX-License-Identifier: GPL-3.0-or-later
"""The spectral table: its coordinates, its two files, the cache that keeps it, and what renderers need beside it.

`TableLayout` is the one place where direction becomes texel; Python, OSL, GLSL and shader nodes share its numbers.
`SpectralTable` loads, saves and looks up. Albedos and the densities for random directions of light are derived from it.
"""

from typing import TYPE_CHECKING

from ..faces import on_demand

if TYPE_CHECKING:
    from .cache import TableCache, table_key
    from .layout import TableLayout
    from .table import SpectralTable, read_sidecar

__all__ = ["SpectralTable", "TableCache", "TableLayout", "read_sidecar", "table_key"]

__getattr__, __dir__ = on_demand(__name__)
