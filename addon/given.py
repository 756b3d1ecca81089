# SPDX-License-Identifier: GPL-3.0-or-later
"""What the caller of an operator gave, told from what Blender remembers of the operator's last run.

The rule of all operators: what a caller passes is used; what it leaves out comes from the scene, which a panel shows.
An operator that a button starts is filled by Blender with the values of its last run. Those are nobody's wish, and
would hide what the panel shows now; Blender marks them as *ghosts*.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any


def is_given(operator: Any, name: str) -> bool:
    """Whether the caller passed a property, rather than Blender remembering it."""
    return operator.properties.is_property_set(name, ghost=True)


def left_out(operator: Any, names: Iterable[str]) -> list[str]:
    """Of the names those that the caller did not pass."""
    return [name for name in names if not is_given(operator, name)]


def take(operator: Any, source: Any, names: Iterable[str], prefix: str = "") -> None:
    """Fill what the caller left out.

    Parameters
    ----------
    operator
        Its properties are set.
    source
        The scene's group, whose properties are called `prefix` + name.
    names
        Of the operator's properties.
    prefix
        Of the source's.
    """
    for name in left_out(operator, names):
        setattr(operator, name, getattr(source, prefix + name))
