# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that imports bpy: operators, panels, properties, material, lamps."""

from types import ModuleType

#: Whether the classes are registered. Blender disables its extensions once more after Python's own exit functions.
_registered = False


def _parts() -> tuple[ModuleType, ...]:
    from . import operators, panels, preferences, properties, viewport
    from .materials import file_handlers, handlers
    from .tables import estimates
    from .watch import report

    return preferences, properties, operators, panels, file_handlers, handlers, viewport, estimates, report


def register() -> None:
    """Register all classes, then what hangs on them."""
    global _registered
    import atexit

    import bpy

    for part in _parts():
        if hasattr(part, "prepare"):
            part.prepare()
        for cls in getattr(part, "CLASSES", ()):
            bpy.utils.register_class(cls)
        if hasattr(part, "register"):
            part.register()
    _registered = True
    if bpy.app.module:  # Blender 4.5 as a module crashes at its end where anything is still registered
        atexit.register(unregister)


def unregister() -> None:
    """Remove everything in reverse order; nothing where that was done."""
    global _registered
    import atexit

    import bpy

    if not _registered:
        return
    _registered = False
    atexit.unregister(unregister)
    for part in reversed(_parts()):
        if hasattr(part, "unregister"):
            part.unregister()
        for cls in reversed(getattr(part, "CLASSES", ())):
            bpy.utils.unregister_class(cls)
