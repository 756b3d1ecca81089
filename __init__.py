# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffraction Shader: structural colours of measured nanostructured surfaces, for Blender."""


def register() -> None:
    """Called by Blender when the extension is enabled."""
    from . import addon

    addon.register()


def unregister() -> None:
    """Called by Blender when the extension is disabled."""
    from . import addon

    addon.unregister()
