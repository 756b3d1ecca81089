# SPDX-License-Identifier: GPL-3.0-or-later
"""What a painting leaves behind: its file beside the table, and a sentence."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

from ....precompute.files.output_folder import ensure_folder
from ....precompute.paint.maps import Paint, save_paint
from ....precompute.paint.recipes import RECIPES

#: Of `precompute.paint.picture`.
_WHY = {
    "grey": "too grey", "purple": "purple, which no wavelength is", "period_too_large": "of a period above the table's",
    "band_too_wide": "at the ends of the spectrum",
}  # fmt: skip


def store(made: Paint, table: Path) -> Path:
    """The paint's file beside the table. Its name follows its content: what undo goes back to is still there."""
    content = hashlib.sha256(np.ascontiguousarray(np.stack(made.maps)).tobytes()).hexdigest()[:10]
    path = ensure_folder(table.parent) / f"{table.stem}.{made.info['recipe']}.{content}.paint.exr"
    return path if path.is_file() else save_paint(made, path)


def told(made: Paint, material: str) -> str:
    """What was painted, and what could not be shown."""
    text = f"{material} is painted with {RECIPES[made.info['recipe']].label}, {made.shape[1]} x {made.shape[0]}"
    left = {name: part for name, part in made.info.get("marked", {}).items() if part >= 0.005}
    bare = made.info.get("without_structure", 0.0)
    if bare >= 0.005:
        text += f"; {100 * bare:.0f} % would need a period above the table's and stay without structure"
    if left:
        text += "; without structure: " + ", ".join(f"{100 * part:.0f} % {_WHY[name]}" for name, part in left.items())
    return text
