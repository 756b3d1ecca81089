# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences of the computations, which name options of the command line, with the names that the window shows."""

from __future__ import annotations

import re

_NAMES = (
    (r"read a part of it with --crop-um(?: [A-Z]+)+", "export a smaller part of it"),
    (r"--crop-um(?: [A-Z]+)*", "Crop"),
    (r"--size-um(?: X Y)?", "Size (um)"),
    (r"--height-nm(?: H)?", "Height (nm)"),
    (r"--trust-units", "Trust Units"),
    (r"--channel", "Channel"),
    (r"--sigma-s-um", "Coherence"),
)


def in_window(sentence: str) -> str:
    """The sentence for someone who sees panels, not a command line."""
    for option, name in _NAMES:
        sentence = re.sub(option, name, sentence)
    return sentence
