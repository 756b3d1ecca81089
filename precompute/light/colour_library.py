# SPDX-License-Identifier: GPL-3.0-or-later
"""colour-science without its plots.

With its plots it imports matplotlib, which makes folders in the user's home, looks through all fonts in
subprocesses and stores a list of them, and takes as long as all the rest. The library itself does
without matplotlib where that is missing (it puts placeholders in its place), so for the moment of the import it is.
"""

from __future__ import annotations

import sys
import threading
import warnings
from types import ModuleType
from typing import Any

_LOCK = threading.Lock()
_REPLACED = ("matplotlib", "mpl_toolkits", "cycler")


def load_colour() -> Any:
    """The module ``colour``; takes seconds the first time."""
    with _LOCK:
        if "colour" in sys.modules or "matplotlib" in sys.modules:
            import colour

            return colour
        warnings.filterwarnings("ignore", message='"Matplotlib" related API features are not available')
        held = _take_out(_REPLACED)
        sys.modules["matplotlib"] = None  # type: ignore[assignment]
        try:
            import colour
        finally:
            # Neither the placeholders nor the plots made of them may meet another user of these libraries.
            _take_out((*_REPLACED, "colour.plotting"))
            sys.modules.update(held)
        return colour


def _take_out(roots: tuple[str, ...]) -> dict[str, ModuleType]:
    """Remove modules and those below them from the list of what is imported."""
    names = [name for name in sys.modules if name in roots or name.startswith(tuple(f"{root}." for root in roots))]
    return {name: sys.modules.pop(name) for name in names}
