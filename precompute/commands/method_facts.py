# SPDX-License-Identifier: GPL-3.0-or-later
"""What a method took, in lines for people."""

from __future__ import annotations

from typing import Any


def method_lines(result: dict[str, Any]) -> list[str]:
    """Series, number of terms and the like; for Taylor the argument x, the chosen N and the bound of the error."""
    names = ("series", "terms", "neighbours", "replicas", "pixels")
    facts = ", ".join(f"{name} {result[name]}" for name in names if name in result)
    lines = [f"method    {result['method']}, {facts}" if "method" in result else f"method    {facts}"] if facts else []
    if "bound" in result:
        lines.append(f"Taylor    x = {result['x']:.3f}, N = {result['terms'] - 1}, error at most {result['bound']:.2g}")
    return lines
