# SPDX-License-Identifier: GPL-3.0-or-later
"""Write docs/guide/parameters.md from the properties themselves, so that it cannot go stale (a test compares).

Run it after any change of a property: `python tools/docs/reference.py`.
"""

import importlib.util
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "guide" / "parameters.md"

HEAD = """# Reference of all parameters

Made by `tools/docs/reference.py` from the properties themselves. Angles are degrees in the panels and radians in
scripts; other units stand in the name. Panel values are `bpy.context.scene.diffraction.NAME`; an operator takes what it
is not given from the panel where the two share a name.
"""

#: Scene properties by panel; what is not listed holds state and is no parameter.
PANELS = {
    "Preset Structure": ("preset", "preset_size_um", "preset_pixels"),
    "Levelling": ("level", "align_rows", "clip_percent", "smooth_nm", "tile", "use_crop", "crop_um"),
    "Bake": ("ensemble", "sigma_s_um", "detail", "error_percent"),
    "Bake > Material of the Surface": ("substrate", "films", "lacquer"),
    "Bake > Advanced": ("table_name", "illuminant", "illuminant_file", "series", "tolerance", "energy", "limit_mb",
                        "scale_headroom", "depth_headroom"),
    "Material": (
        "implementation", "fresnel", "ior", "orientation", "uv_map", "attribute", "angle_image", "rotation",
        "conserve_energy", "environment",
    ),
    "Evaluate": ("map_theta", "map_phi", "map_size", "map_linear"),
    "Evaluate > Reflectance": ("plot_theta", "plot_order"),
}  # fmt: skip

#: Of Blender's own, not ours.
_FOREIGN = {
    "rna_type",
    "filepath",
    "check_existing",
    "filter_glob",
    "hide_props_region",
    "remove_name",
    "remove_active",
}


def register():
    """The add-on of this checkout, registered."""
    if "diffraction_shader" not in sys.modules:
        spec = importlib.util.spec_from_file_location(
            "diffraction_shader", ROOT / "__init__.py", submodule_search_locations=[str(ROOT)]
        )
        module = importlib.util.module_from_spec(spec)
        sys.modules["diffraction_shader"] = module
        spec.loader.exec_module(module)
    sys.modules["diffraction_shader"].register()


def page(bpy):
    """The whole page as text; the add-on is registered."""
    from diffraction_shader.addon import operators, paint_properties
    from diffraction_shader.addon.viewport import operator as viewport_operator
    from diffraction_shader.precompute.presets import PRESETS, look_of

    scene = bpy.context.scene
    parts = [HEAD]
    for panel, names in PANELS.items():
        if panel == "Evaluate":
            known = scene.diffraction_viewport.bl_rna.properties
            parts.append("## Viewport\n\n`bpy.context.scene.diffraction_viewport`\n\n" + table(
                p for p in known if p.identifier not in ("rna_type", "name")
            ))  # fmt: skip
        known = scene.diffraction.bl_rna.properties
        parts.append(f"## {panel}\n\n" + table(known[name] for name in names))
    parts.append("## Structures\n\nEach is an item of `preset`; sources of the dimensions: [presets](../presets.md).\n")
    for preset in PRESETS.values():
        group = getattr(scene.diffraction.presets, preset.name).bl_rna.properties
        rows = table(group[p.name] for p in preset.parameters) if preset.parameters else "No parameters.\n"
        parts.append(
            f"### `{preset.name}`: {preset.label}\n\n{preset.description} {preset.size_um:g} um,"
            f" {preset.pixels} pixels a side. Look: {look_of(preset.name).summary()}.\n\n{rows}"
        )
    parts.append("## Operators\n\nEach is `bpy.ops.NAME(...)`.\n")
    for cls in (*operators.CLASSES, *viewport_operator.CLASSES):
        if "_OT_" not in cls.__name__ or cls.__name__.endswith("_preset_add"):
            continue
        namespace, _, name = cls.bl_idname.partition(".")
        rna = getattr(getattr(bpy.ops, namespace), name).get_rna_type()
        rows = [p for p in rna.properties if p.identifier not in _FOREIGN and p.type not in {"POINTER", "COLLECTION"}]
        rows = [p for p in rows if not p.is_hidden]
        if cls.__name__ == "DIFFRACTION_OT_paint":
            rows = [p for p in rows if p.identifier in paint_properties.COMMON]
        if cls.__name__ == "DIFFRACTION_OT_make_preset":
            rows = [p for p in rows if p.identifier in ("preset", "size_um", "pixels")]
        text = f"### `{cls.bl_idname}`: {cls.bl_label}\n\n{rna.description}.\n\n"
        parts.append(text + (table(rows) if rows else "No parameters.\n"))
        if cls.__name__ == "DIFFRACTION_OT_make_preset":
            parts.append("And the parameters of the structure, listed above.\n")
        if cls.__name__ == "DIFFRACTION_OT_paint":
            parts.append("And the settings of the recipe, as `python -m precompute paint --help` lists them.\n")
    return "\n".join(parts)


def table(properties):
    """Rows for some RNA properties."""
    lines = ["| name | in the panel | default | values | meaning |", "|---|---|---|---|---|"]
    for prop in properties:
        meaning = (prop.description or prop.name).replace("|", "/")
        lines.append(f"| `{prop.identifier}` | {prop.name} | {default(prop)} | {values(prop)} | {meaning} |")
    return "\n".join(lines) + "\n"


def default(prop):
    """As a script writes it."""
    if prop.type == "ENUM":
        return f"`{prop.default!r}`" if prop.default else ""
    if getattr(prop, "is_array", False):
        return f"`{tuple(number(x) for x in prop.default_array)}`"
    if prop.type == "FLOAT":
        return f"`{number(prop.default)}`"
    return f"`{prop.default!r}`"


def values(prop):
    """Choices or range."""
    if prop.type == "ENUM":
        items = prop.enum_items
        shown = ", ".join(f"`{item.identifier}`" for item in items[:16])
        return shown or "channels of the file"
    if prop.type in {"FLOAT", "INT"}:
        low, high = number(prop.hard_min), number(prop.hard_max)
        unit = " rad" if prop.subtype == "ANGLE" else ""
        low = "" if low <= -1e9 else f"{low}"
        high = "" if high >= 1e9 else f"{high}"
        if low and high:
            return f"{low} to {high}{unit}"
        return f"at least {low}{unit}" if low else (f"at most {high}{unit}" if high else unit.strip())
    return {"BOOLEAN": "`True`, `False`", "STRING": "text"}.get(prop.type, "")


def number(value):
    """A 32-bit number in as few digits as name it."""
    if isinstance(value, int):
        return value
    value = float(f"{value:.7g}")
    return int(value) if value == int(value) and abs(value) < 1e9 else value


def main():
    import bpy

    register()
    PAGE.parent.mkdir(parents=True, exist_ok=True)
    PAGE.write_text(page(bpy), encoding="utf-8")
    print(PAGE.relative_to(ROOT))


if __name__ == "__main__":
    main()
