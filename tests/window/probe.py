# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside the window's Blender: what lies under the mouse, what the screen shows, what the mouse and keys do.

A button is found as a user finds it, by pointing at it. Blender then tells what it would do: its context menu offers
*Copy Python Command* for the button of an operator and *Copy Full Data Path* for that of a property.
"""

import json
import re
import sys

import bpy


def window(number=0):
    return bpy.context.window_manager.windows[number]


def area(kind="VIEW_3D", number=0):
    return next(each for each in window(number).screen.areas if each.type == kind)


def region(kind="VIEW_3D", name="UI", number=0):
    return next(each for each in area(kind, number).regions if each.type == name)


def within(kind="VIEW_3D", name="UI", number=0):
    return bpy.context.temp_override(window=window(number), area=area(kind, number), region=region(kind, name, number))


def anywhere():
    """A context with a window, for operators that need one."""
    return bpy.context.temp_override(window=window())


def rectangle(kind="VIEW_3D", name="UI", number=0):
    """Left, bottom, width and height in pixels of the window."""
    found = region(kind, name, number)
    return [found.x, found.y, found.width, found.height]


def send(kind, value, x, y, number=0, **more):
    if number >= len(bpy.context.window_manager.windows):  # a key's press has closed it before its release
        return
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


_sweep = {"todo": [], "at": None, "found": [], "where": (), "until": "", "waits": 0}


def places(kind="VIEW_3D", name="UI", number=0, begin=None, step=18, share=0.6):
    """Where to point in a region: from top to bottom, or from a height outwards."""
    left, bottom, width, height = rectangle(kind, name, number)
    rows = list(range(bottom + height - 12, bottom + 4, -step))
    if begin is not None:
        rows = [begin, *sorted(rows, key=lambda y: abs(y - begin))]
    return [(left + int(width * share), y) for y in rows]


def sweep(kind="VIEW_3D", name="UI", number=0, begin=None, until="", share=0.6):
    """Point at a region, till something is found whose text matches a pattern; `swept` tells what was."""
    todo = places(kind, name, number, begin, share=share)
    _sweep.update(todo=todo, at=None, found=[], where=(kind, name, number), until=until, waits=0)
    bpy.app.timers.register(_sweep_on, first_interval=0.01)


def _sweep_on():
    if _sweep["waits"] > 0:  # Blender leaves the last button in one turn of its loop, and takes up the next in another
        _sweep["waits"] -= 1
        return 0.012
    if _sweep["at"] is not None:
        text = under(*_sweep["where"])
        if text:
            _sweep["found"].append([text, *_sweep["at"]])
            if _sweep["until"] and re.search(_sweep["until"], text):
                return None
    _sweep["at"] = _sweep["todo"].pop(0) if _sweep["todo"] else None
    if _sweep["at"] is None:
        return None
    send("MOUSEMOVE", "NOTHING", *_sweep["at"], number=_sweep["where"][2])
    _sweep["waits"] = 2
    return 0.012


def swept():
    """Commands and data paths with their places, as JSON; empty while the mouse still moves."""
    return "" if bpy.app.timers.is_registered(_sweep_on) else json.dumps(_sweep["found"])


_drawn = set()


def watch_panels():
    """Note which panels draw their bodies: those that are open."""
    for name in dir(bpy.types):
        cls = getattr(bpy.types, name)
        if name.startswith("DIFFRACTION_PT_") and not hasattr(cls.draw, "watched"):
            cls.draw = _watched(name, cls.draw)


def _watched(name, draw):
    def draw_and_note(self, context):
        _drawn.add(name.removesuffix("_guide"))
        return draw(self, context)

    draw_and_note.watched = True
    return draw_and_note


def drawn():
    """Panels that have drawn since the last call."""
    found = sorted(_drawn)
    _drawn.clear()
    return json.dumps(found)


def addon(name):
    """A module of the extension, by the end of its name."""
    return next(module for key, module in sys.modules.items() if key.endswith(f"diffraction_shader.addon.{name}"))


def busy():
    """Whether the extension computes something."""
    return addon("jobs.progress").running() is not None


def _sidebar():
    """Our panels of the sidebar, parents first."""
    classes = [getattr(bpy.types, name) for name in dir(bpy.types) if name.startswith("DIFFRACTION_PT_")]
    classes = [each for each in classes if each.bl_space_type == "VIEW_3D"]

    def depth(each):
        parent = getattr(each, "bl_parent_id", "")
        return 0 if not parent else 1 + depth(getattr(bpy.types, parent))

    return sorted(classes, key=depth)


_hidden, _copies = [], []


def show_only(names):
    """Leave only some panels, by the ends of their names, and open; `show_all` brings the others back."""
    _hidden[:] = _sidebar()
    for each in reversed(_hidden):
        bpy.utils.unregister_class(each)
    for each in _hidden:
        if each.__name__.removeprefix("DIFFRACTION_PT_") in names:
            # Under another name, since Blender remembers by name which panels were closed.
            changes = {"bl_options": set()}
            if hasattr(each, "bl_parent_id"):
                changes["bl_parent_id"] = each.bl_parent_id + "_guide"
            _copies.append(type(each.__name__ + "_guide", (each,), changes))
            bpy.utils.register_class(_copies[-1])


def show_all():
    """All panels as they were."""
    for each in reversed(_copies):
        bpy.utils.unregister_class(each)
    for each in _hidden:
        bpy.utils.register_class(each)
    _copies.clear()
