# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators: they read properties, call the core and write the scene."""

from ..jobs import threaded
from . import (
    add_node,
    add_scales,
    apply_material,
    asset_library,
    bake,
    brdf_map,
    coherence,
    files,
    fit,
    import_scan,
    make_preset,
    preview_levelling,
    reflectance,
    setting_presets,
    show_image,
)
from .farm import bake_lights, pack
from .painting import paint

_MODULES = (
    import_scan, make_preset, preview_levelling, bake, coherence, apply_material, files, brdf_map, reflectance,
    setting_presets, add_node, add_scales, paint, fit, asset_library, show_image, pack, bake_lights,
)  # fmt: skip

CLASSES = tuple(cls for module in _MODULES for cls in module.CLASSES)


def unregister() -> None:
    """End what is at work."""
    threaded.stop()
