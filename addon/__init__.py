# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that imports bpy: operators, panels, properties, material, lamps."""


def register() -> None:
    """Register all classes and handlers."""


def unregister() -> None:
    """Remove them in reverse order."""
