# SPDX-License-Identifier: GPL-3.0-or-later
"""The tab in the 3-D view's sidebar, one module a stage of the work.

`bl_order` puts the stages in their order: Scan 1, Levelling 2, Bake 3, Material 4, Viewport 5 (of the package
`viewport`), Evaluate 6. A new sub-panel names its stage as `bl_parent_id` and joins the module's `CLASSES`.
"""

from . import bake, entrances, evaluate, levelling, material, paint, scan, sidebar

CLASSES = tuple(
    cls for module in (sidebar, scan, levelling, bake, material, paint, evaluate, entrances) for cls in module.CLASSES
)


def register() -> None:
    """What hangs on Blender's own menus."""
    entrances.register()


def unregister() -> None:
    """Take it off."""
    entrances.unregister()
