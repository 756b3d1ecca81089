# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffraction in the 3-D view while you move."""


def register() -> None:
    """Register settings, operator and panel, and begin to draw."""
    import bpy

    from . import handlers, operator, panel, settings

    for cls in (*settings.CLASSES, *operator.CLASSES, *panel.CLASSES):
        bpy.utils.register_class(cls)
    settings.register()
    handlers.register()


def unregister() -> None:
    """Remove everything in reverse order and free all GPU memory."""
    import bpy

    from . import handlers, operator, panel, settings

    handlers.unregister()
    settings.unregister()
    for cls in reversed((*settings.CLASSES, *operator.CLASSES, *panel.CLASSES)):
        bpy.utils.unregister_class(cls)
