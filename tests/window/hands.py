# SPDX-License-Identifier: GPL-3.0-or-later
"""Code for the window's Blender: where its buttons are, what the mouse and the keyboard do.

The text `HELP` is run there once. A button is found as a user finds it, by pointing: Blender tells which operator or
property lies under the mouse (the entries *Copy Python Command* and *Copy Full Data Path* of its context menu).
"""

HELP = '''
import bpy, json

def _window(number=0):
    return bpy.context.window_manager.windows[number]

def _area(kind="VIEW_3D", number=0):
    return next(a for a in _window(number).screen.areas if a.type == kind)

def _region(kind="VIEW_3D", region="UI", number=0):
    return next(r for r in _area(kind, number).regions if r.type == region)

def _send(kind, value, x, y, number=0, **more):
    _window(number).event_simulate(type=kind, value=value, x=int(x), y=int(y), **more)

def _under(kind="VIEW_3D", region="UI", number=0):
    """What lies under the mouse: the command of an operator's button or the path of a property."""
    manager = bpy.context.window_manager
    with bpy.context.temp_override(window=_window(number), area=_area(kind, number), region=_region(kind, region, number)):
        manager.clipboard = ""
        for call in (bpy.ops.ui.copy_python_command_button, bpy.ops.ui.copy_data_path_button):
            if call.poll():
                try:
                    call(**({"full_path": True} if call is bpy.ops.ui.copy_data_path_button else {}))
                except RuntimeError:
                    pass
            if manager.clipboard:
                return manager.clipboard
    return ""

def _rect(kind="VIEW_3D", region="UI", number=0):
    r = _region(kind, region, number)
    return [r.x, r.y, r.width, r.height]

def _shot(path, number=0):
    with bpy.context.temp_override(window=_window(number)):
        bpy.ops.screen.screenshot(filepath=path)
'''
