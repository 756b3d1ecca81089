# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's entry: Blender calls register() and unregister()."""


def register():
    from . import addon

    addon.register()


def unregister():
    from . import addon

    addon.unregister()
