# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside the window's Blender: what lies under the mouse, what the screen shows, what the mouse and keys do.

A button is found as a user finds it, by pointing at it. Blender then tells what it would do: its context menu offers
*Copy Python Command* for the button of an operator and *Copy Full Data Path* for that of a property.
"""

import bpy


def window(number=0):
    return bpy.context.window_manager.windows[number]


def area(kind="VIEW_3D", number=0):
    return next(each for each in window(number).screen.areas if each.type == kind)


def region(kind="VIEW_3D", name="UI", number=0):
    return next(each for each in area(kind, number).regions if each.type == name)


def within(kind="VIEW_3D", name="UI", number=0):
    return bpy.context.temp_override(window=window(number), area=area(kind, number), region=region(kind, name, number))


def rectangle(kind="VIEW_3D", name="UI", number=0):
    """Left, bottom, width and height in pixels of the window."""
    found = region(kind, name, number)
    return [found.x, found.y, found.width, found.height]


def send(kind, value, x, y, number=0, **more):
    window(number).event_simulate(type=kind, value=value, x=int(x), y=int(y), **more)


def under(kind="VIEW_3D", name="UI", number=0):
    """The command or the data path of the button under the mouse; empty where there is none."""
    manager = bpy.context.window_manager
    calls = ((bpy.ops.ui.copy_python_command_button, {}), (bpy.ops.ui.copy_data_path_button, {"full_path": True}))
    with within(kind, name, number):
        for call, options in calls:
            manager.clipboard = ""
            if call.poll():
                try:
                    call(**options)
                except RuntimeError:
                    continue
            if manager.clipboard:
                return manager.clipboard
    return ""


def shot(path, number=0):
    with bpy.context.temp_override(window=window(number)):
        bpy.ops.screen.screenshot(filepath=path)


def show_tab(name="Diffraction", number=0):
    """The sidebar's tab, as a click on it would choose it."""
    area("VIEW_3D", number).spaces.active.show_region_ui = True
    region("VIEW_3D", "UI", number).active_panel_category = name
