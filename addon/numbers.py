# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers as the user typed them."""

from __future__ import annotations

import numpy as np


def decimal(value: float) -> float:
    """The shortest decimal number that Blender's 32-bit property stands for.

    A property set to 818.69 reads back as 818.690002...; the command line gets 818.69, and both
    must give the same table bit for bit.
    """
    return float(str(np.float32(value)))
