# SPDX-License-Identifier: GPL-3.0-or-later
"""The illuminant of a bake as the panel holds it: a name, or a file whose values are kept once they were baked.

A file of a light lies anywhere and may go. Its values travel with the table's recipe and its sidecar, so a table
can be made again without the file; while the file is there, what it holds now counts.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ...precompute.errors import ParameterError
from ...precompute.files.stamp import Stamp, file_stamp
from ...precompute.light.illuminant import Illuminant, Spectrum, illuminant_of, read_spectrum, to_json
from .. import paths

#: The choice that stands for a file.
FILE = "FILE"

_read: dict[Path, tuple[Stamp | None, Spectrum | ParameterError]] = {}


def illuminant(owner: Any) -> Illuminant:
    """What ``illuminant``, ``illuminant_file`` and ``illuminant_data`` of a scene or an operator say together.

    Raises
    ------
    ParameterError
        If the file cannot be read or is no light, and no values of it are kept.
    """
    if owner.illuminant != FILE:
        return illuminant_of(owner.illuminant)
    kept = _kept(owner)
    path = paths.absolute(owner.illuminant_file) if owner.illuminant_file else None
    if path is None or (kept is not None and not path.is_file()):
        if kept is None:
            raise ParameterError("The illuminant is a file, but none is chosen; give a text file of two columns.")
        return kept
    found = _look(path)
    if isinstance(found, ParameterError):
        raise found
    return found


def values(owner: Any) -> str:
    """The file's values as JSON, for a recipe; empty where there is no file or it is no light."""
    if owner.illuminant != FILE:
        return ""
    try:
        return json.dumps(to_json(illuminant(owner)), sort_keys=True)
    except ParameterError:
        return ""


def same(one: str, other: str) -> bool:
    """Whether two texts of `values` hold the same values, whatever their files are called."""
    try:
        return illuminant_of(one) == illuminant_of(other)
    except ParameterError:
        return one == other


def lives_on_values(owner: Any) -> bool:
    """Whether the file is gone and its kept values stand for it."""
    there = owner.illuminant_file and paths.absolute(owner.illuminant_file).is_file()
    return owner.illuminant == FILE and not there and _kept(owner) is not None


def _kept(owner: Any) -> Spectrum | None:
    """Kept values, if they are those of the chosen file (or no file is chosen)."""
    try:
        kept = illuminant_of(owner.illuminant_data)
    except ParameterError:
        return None
    name = owner.illuminant_file.replace("\\", "/").rpartition("/")[2]
    return kept if isinstance(kept, Spectrum) and name in ("", "//", kept.name) else None


def _look(path: Path) -> Spectrum | ParameterError:
    """Read once for each state of the file: panels ask at every redraw."""
    stamp = file_stamp(path)
    held = _read.get(path)
    if held is None or held[0] != stamp:
        if len(_read) > 64:
            _read.clear()
        try:
            found: Spectrum | ParameterError = read_spectrum(path)
        except ParameterError as error:
            found = error
        held = _read[path] = (stamp, found)
    return held[1]
