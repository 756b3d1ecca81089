# SPDX-License-Identifier: GPL-3.0-or-later
"""How long the window stands still while the extension works, beside a redraw of the same window without it.

Prints a table and writes it to out/window/freezes.md. What is asserted is the work of Blender's main thread, which
other programs of the machine lengthen little: beyond a redraw of the same window a fifth of a second.
"""

import math

import pytest

from precompute.presets import make_preset
from precompute.scan.gsf import write_gsf

#: Seconds that the main thread may work in one go beyond a redraw.
MOST = 0.2

MODULE = "bl_ext.user_default.diffraction_shader"


def longest(desk):
    """Of the gaps since the last call: the longest in wall time, and the longest work of Blender's main thread."""
    gaps = desk.driver.gaps()
    return max((gap for gap, _ in gaps), default=0.05), max((busy for _, busy in gaps), default=0.05)


def draw_again(desk, times=8):
    """The whole window, several times."""
    for _ in range(times):
        desk.run("for a in window().screen.areas: a.tag_redraw()")
        desk.driver.turn()


def redraws(desk):
    """The longest gap of a redraw of the whole window."""
    desk.driver.gaps()
    draw_again(desk)
    return longest(desk)


@pytest.fixture(scope="module")
def scan(work):
    """A scan of a million heights."""
    path = work / "large.gsf"
    write_gsf(make_preset("blazed", 40e-6, 1024), path)
    return path


def test_table_of_freezes(enabled, scan, capsys):
    enabled.new_file()
    enabled.run(f"with anywhere(): bpy.ops.preferences.addon_disable(module={MODULE!r})")
    enabled.settle()
    rows = [("redraw without the extension", *redraws(enabled))]
    enabled.run(f"with anywhere(): bpy.ops.preferences.addon_enable(module={MODULE!r})")
    enabled.open_sidebar()
    rows.append(("redraw with it, its tab open", *redraws(enabled)))

    def measure(name, act):
        enabled.driver.gaps()
        act()
        rows.append((name, *longest(enabled)))

    imports = (
        f"with within('VIEW_3D', 'WINDOW'): bpy.ops.diffraction.import_scan('INVOKE_DEFAULT', filepath={str(scan)!r})"
    )
    measure("import of 1024 x 1024 heights", lambda: (enabled.run(imports), enabled.settle(), enabled.wait()))
    measure("preview of the levelling", lambda: enabled.press("diffraction.preview_levelling"))
    enabled.run("bpy.context.scene.diffraction.use_crop = True\nbpy.context.scene.diffraction.crop_um = (0, 20, 0, 20)")
    measure("bake of 20 x 20 um", lambda: enabled.press("diffraction.bake"))
    enabled.choose("implementation", "NODES")
    measure("apply, Nodes", lambda: enabled.press("diffraction.apply_material"))
    measure("first drawings with the table", lambda: draw_again(enabled, 20))
    measure("apply once more", lambda: enabled.press("diffraction.apply_material"))
    rows.append(("redraw that shows the surface", *redraws(enabled)))
    if enabled.has_osl():
        enabled.choose("implementation", "OSL")
        measure("apply, OSL", lambda: enabled.press("diffraction.apply_material"))
    begin = "with within('VIEW_3D', 'WINDOW'): bpy.ops.diffraction.make_asset_library('INVOKE_DEFAULT')"

    def library():
        enabled.run(begin)
        enabled.settle()
        enabled.watch(20.0)
        enabled.over_view()
        enabled.driver.key("ESC")
        enabled.wait()

    measure("asset library, first 20 s", library)
    floor, floor_busy = rows[0][1:]
    lines = ["| step | longest gap | over the floor | main thread at work | over the floor |", "|---|---|---|---|---|"]
    for name, gap, busy in rows:
        lines.append(f"| {name} | {gap:.2f} s | {gap - floor:+.2f} s | {busy:.2f} s | {busy - floor_busy:+.2f} s |")
    text = "\n".join(lines)
    enabled.keep("freezes.md", text + "\n")
    with capsys.disabled():
        print("\n" + text)
    assert len(rows) >= 10 and all(gap > 0.0 and not math.isinf(gap) for _, gap, _ in rows)
    if not math.isnan(floor_busy):  # a rig does not tell
        over = {name: busy - floor_busy for name, _, busy in rows if busy - floor_busy > MOST}
        assert over == {}
