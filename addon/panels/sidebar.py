# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panels share, and the one that holds the others."""

from __future__ import annotations

import textwrap
from types import SimpleNamespace
from typing import Any

import bpy

from .. import notices
from ..jobs import progress
from ..materials import refresh
from ..watch import report

#: At a user interface scale of 1, in pixels: a character of ordinary text, and what margins and an icon take.
_CHARACTER, _MARGINS = 6.4, 72.0

#: Width of a sidebar where there is none to ask.
_SIDEBAR = 290.0


class Sidebar:
    """Mixin: the tab Diffraction in the 3-D view's sidebar."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Diffraction"


class Stage(Sidebar):
    """Mixin: a sub-panel of the main panel."""

    bl_parent_id = "DIFFRACTION_PT_main"


def split(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    """A layout with labels on the left, without animation dots."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout


def vector(layout: bpy.types.UILayout, owner: bpy.types.bpy_struct, name: str) -> None:
    """Several numbers under one label; split into label and column they would have a line each."""
    column = layout.column()
    column.use_property_split = False
    column.prop(owner, name)


def note(layout: bpy.types.UILayout, text: str, icon: str = "INFO") -> None:
    """A sentence, wrapped; its icon stands before the first line."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    region = bpy.context.region
    width = region.width / bpy.context.preferences.system.ui_scale if region is not None else _SIDEBAR
    for index, line in enumerate(textwrap.wrap(text, max(16, int((width - _MARGINS) / _CHARACTER)))):
        column.label(text=line, icon=icon if index == 0 else "BLANK1")


def button(layout: bpy.types.UILayout, name: str, **options: Any) -> Any:
    """A button, or while its operator runs the progress in its place, so that nothing jumps.

    Returns
    -------
    OperatorProperties
        To set what it passes; while it runs nobody reads what is set there.
    """
    now = progress.running()
    if now is not None and now.owner == name:
        layout.progress(factor=now.fraction, text=f"{now.text}, Esc stops")
        return SimpleNamespace()
    return layout.operator(name, **options)


def number(layout: bpy.types.UILayout, owner: bpy.types.bpy_struct, name: str, zero: str) -> None:
    """A number whose 0 has a meaning, said beside it."""
    if getattr(owner, name) != 0:
        layout.prop(owner, name)
        return
    row = layout.row(align=True)
    row.prop(owner, name)
    word = row.row()
    word.ui_units_x = 2.6
    word.label(text=zero)


def file_name(path: str) -> str:
    """Last part of a path that may begin with ``//``."""
    return bpy.path.basename(path.removeprefix("//"))


def megabytes(count: float) -> str:
    """Bytes as people say them."""
    if count < 1e6:
        return f"{count / 1e3:.0f} kB"
    return f"{count / 1e9:.2f} GB" if count >= 1e9 else f"{count / 1e6:.0f} MB"


def duration(seconds: float) -> str:
    """Seconds as people say them; an estimate needs no digits."""
    if seconds < 10.0:
        return f"{max(seconds, 1.0):.0f} s"
    return f"{5 * round(seconds / 5)} s" if seconds < 100.0 else f"{seconds / 60:.0f} min"


class DIFFRACTION_PT_main(Sidebar, bpy.types.Panel):
    """From a scan to colours, in the order of the work"""

    bl_label = "Diffraction"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        if context.scene.diffraction.message:
            note(layout, context.scene.diffraction.message, "ERROR")
        for text in notices.said():
            note(layout, text)
        broken = refresh.broken()
        if broken:
            more = f", and {len(broken) - 1} more materials" if len(broken) > 1 else ""
            note(layout, f"{broken[0]}{more}. Material > Files bakes or finds it", "ERROR")
        for text in report.in_panels(context.scene):
            note(layout, text, "ERROR")


CLASSES = (DIFFRACTION_PT_main,)
