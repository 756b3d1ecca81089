# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the shaders' sources stand, which materials, viewport and bakes on the GPU read."""

from pathlib import Path

SHADERS = Path(__file__).resolve().parents[1] / "shaders"
