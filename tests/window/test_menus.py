# SPDX-License-Identifier: GPL-3.0-or-later
"""Menus of the panels: channels of a file, and settings that users keep under names of their own."""

import numpy as np
import pytest

from precompute.presets import make_preset
from precompute.scan.gsf import write_gsf


@pytest.fixture(scope="module")
def channels(work):
    """A file of two channels."""
    from gwyfile.objects import GwyContainer, GwyDataField

    wave = np.sin(np.linspace(0.0, 30.0, 48))[None].repeat(48, 0)
    container = GwyContainer()
    for index, (title, height) in enumerate((("Trace", 12e-9), ("Retrace", 10e-9))):
        container[f"/{index}/data/title"] = title
        container[f"/{index}/data"] = GwyDataField(height * wave, 6e-6, 6e-6, si_unit_xy="m", si_unit_z="m")
    path = work / "channels.gwy"
    container.tofile(str(path))
    return path


def test_other_channels_of_the_file(enabled, channels):
    enabled.new_file()
    enabled.console()
    call = f"bpy.ops.diffraction.import_scan(filepath={str(channels)!r})"
    enabled.run(f"with within('VIEW_3D', 'WINDOW'): {call}")
    enabled.open_sidebar()
    for number, high in ((1, "19.99 nm high"), (0, "23.99 nm high")):
        told = enabled.state("scan_info").split(", ")  # a line each, below the scan's name
        enabled.press_near("diffraction.import_scan", 0.5, lines=2.5 + len(told))
        enabled.shot("65_channels")
        enabled.pick(number)
        assert high in enabled.state("scan_info")
    assert enabled.console() == []


@pytest.mark.parametrize(
    ("button", "field", "values"),
    [("bake_preset_add", "sigma_s_um", (1.5, 2.5)), ("structure_preset_add", "preset_size_um", (7.0, 9.0))],
)
def test_kept_settings_come_back_from_their_menu(enabled, work, button, field, values):
    enabled.new_file()
    path = work / "kept.gsf"
    write_gsf(make_preset("sinusoid", 6e-6, 48), path)
    enabled.run(f"with within('VIEW_3D', 'WINDOW'): bpy.ops.diffraction.import_scan(filepath={str(path)!r})")
    enabled.console()
    with enabled.only("scan", "preset", "bake"):
        for index, value in enumerate(values):
            enabled.enter(field, value)
            x, y = enabled.find(f"diffraction.{button}", share=0.79)
            enabled.driver.click(x, y)
            enabled.settle()
            line = enabled.look("bpy.context.preferences.system.ui_scale")
            enabled.driver.click(x, round(y - 4 * line))  # the name in the dialog that has opened there
            enabled.driver.key("A", ctrl=True)
            enabled.driver.type("abcd"[2 * index : 2 * index + 2])
            enabled.driver.key("RET")
            enabled.settle()
            enabled.shot(f"66_{button}")
            enabled.driver.click(x, round(y - 34 * line))  # OK
            enabled.settle()
        for index in (0, 1, 0):
            enabled.press_near(f"diffraction.{button}", 0.715, found_at=0.79)
            enabled.shot(f"67_{button}")
            enabled.pick(index)
            assert enabled.state(field) == pytest.approx(values[index])
    assert enabled.console() == []
