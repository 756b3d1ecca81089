# SPDX-License-Identifier: GPL-3.0-or-later
"""GPU shaders from the files of ``shaders/``: what goes in, what comes out."""

from __future__ import annotations

from functools import cache
from typing import Any

from ....precompute.constants import LEAST_REFLECTANCE, LEAST_SCALE
from ....precompute.table import importance, scaled_albedo
from ...materials.osl import LAMP_KINDS, LAMPS_MAX
from ...shader_files import SHADERS

#: Uniform blocks, vec4 and mat4 only, so that every back end lays them out alike. Filled in `blocks`.
_TYPES = """
struct DiffractionLamp { vec4 place; vec4 half_u; vec4 half_v; vec4 normal; vec4 colour; vec4 extra; };
struct DiffractionFrame {
  mat4 view; mat4 projection; vec4 viewer; vec4 counts; vec4 display; vec4 ambient; vec4 clip[6];
  vec4 border; vec4 sky[4];
  DiffractionLamp lamps[LAMPS_MAX];
};
struct DiffractionSurface {
  vec4 radial; vec4 slices; vec4 value; vec4 texel; vec4 to_red; vec4 to_green; vec4 to_blue; vec4 fresnel;
  vec4 conductor_n; vec4 conductor_k; vec4 rotation; vec4 pigment;
  vec4 kept[KEPT];
};
struct DiffractionSeries { vec4 bins; vec4 window; vec4 loops; vec4 spectrum[WAVELENGTHS_MAX]; };
"""

#: Pixels by which EEVEE's depth may have been sampled elsewhere.
DEPTH_SLACK = 2.0

#: Wavelengths of the reference method: 380-780 nm in steps of 5 nm are 81.
WAVELENGTHS_MAX = 96

#: Numbers of the densities of directions.
_DENSITIES = {
    name: getattr(importance, name)
    for name in (
        *("N_VIEWS", "VIEW_END", "AZIMUTHS_STEP", "AZIMUTHS_MAX", "AZIMUTHS_SETS", "FIRST_VIEWS", "SET_VIEWS"),
        *("SET_COSINE", "CUTS", "WIDTH", "N_R", "N_PHI"),
    )
} | {"SETS": len(importance.DEPTHS), "DEPTH_STEP": importance.DEPTHS[0] - importance.DEPTHS[1]}

#: Numbers of the albedos of scaled surfaces, and what a scale that makes no sense counts as.
_SCALED = {
    "SCALED_STEPS": scaled_albedo.STEPS,
    "SCALED_N_SCALES": scaled_albedo.N_SCALES,
    "SCALED_N_THETA": scaled_albedo.N_THETA,
    "SCALED_N_PHI": scaled_albedo.N_PHI,
    **{f"SCALED_DEPTH_{i}": depth for i, depth in enumerate(scaled_albedo.DEPTHS)},
    "SCALE_LEAST": LEAST_SCALE,
    "REFLECTANCE_LEAST": LEAST_REFLECTANCE,
}

#: Side of the finest level of an image of the surroundings, and how many levels there are: the last has four texels.
SKY_SIDE = 512
SKY_LEVELS = 9

#: Side of the square that says what diffuse surfaces see, the same as of one of the levels, and where it begins with
#: its border in the image: column and row, beside the third level.
DIFFUSE_SIDE = 32
DIFFUSE_CORNER = SKY_SIDE + SKY_SIDE // 4 + 4, SKY_SIDE // 2 + 2

#: Angles of view, even steps from 0 to 90 degrees, at which a surface tells what it keeps from the pigment below.
KEPT = 19

METHODS = ("TABLE", "FLSS")

#: What a shader can be made to do besides; a variant has the code of those that it needs and no other: software
#: renderers, and GPUs where neighbours differ, run every branch. LAMPS_0 to LAMPS_16 say how many there are: loops of
#: known length. SKY_8 to SKY_32: directions in which an image of the surroundings is looked up.
FLAGS = (
    "LOOSE_DEPTH",  # the depth buffer's points lie elsewhere in their pixels
    "BOUNDED",  # by clipping planes or a border
    "DISPLAY",  # colours pass through the view transform
    "REPLACE",  # draws the pigment too
    "TURNED",  # an image of angles
    "MASKED",  # an image says where the structure is
    "CUTOUT",  # where it is not, there is no surface
    "PAINTED",  # an image of scale, depth, angle and mask
    "SCALED",  # a period or depth that is not the table's
    "CONSERVE",  # f is divided by the albedo where that passes 1
    "LINEAR_IN_W",  # of the table's factor |w|^power: the power is 1
    "DIELECTRIC",
    "SCHLICK",
    "CONDUCTOR",
    "INSIDE",  # the table holds the reflectance of its stuff
    "LACQUER",
    "SUN_APART",  # light that is missing in what EEVEE shows of the material, mirror of a lacquer there already
    "AMBIENT",  # a plain world
    "SKYLIT",  # an image surrounds the scene
    "GATHERS",  # writes the mean of its light and of what was gathered before
    "GATHERED",  # shows that mean
    "SUNS",
    "BALLS",
    "SPOTS",
    "AREAS",
    "WIDE",  # lamps of more than one point
)


def _text(*names: str) -> str:
    return "\n".join((SHADERS / name).read_text(encoding="utf-8") for name in names)


def _begin(method: str, flags: frozenset[str]) -> Any:
    import gpu

    info = gpu.types.GPUShaderCreateInfo()
    for name in sorted(flags):
        if name.startswith(("LAMPS_", "SKY_")):
            info.define(*name.split("_"))
        else:
            info.define(name, "1")
    info.define("LAMPS_MAX", str(LAMPS_MAX))
    info.define("WAVELENGTHS_MAX", str(WAVELENGTHS_MAX))
    info.define("KEPT", str(KEPT))
    for name, value in LAMP_KINDS.items():
        info.define(f"LAMP_{name}", f"{value}.0")
    info.define(f"METHOD_{method}", "1")
    info.typedef_source(_TYPES)
    info.uniform_buf(0, "DiffractionFrame", "df_frame")
    info.uniform_buf(1, "DiffractionSurface", "df_surface")
    info.sampler(0, "FLOAT_2D_ARRAY", "df_table")
    if flags & {"CONSERVE", "AMBIENT"}:
        info.sampler(1, "FLOAT_2D", "df_tiles" if "SCALED" in flags else "df_albedo")
    for name, number in _SCALED.items():
        info.define(name, f"{float(number)}")
    if method == "FLSS":
        info.uniform_buf(2, "DiffractionSeries", "df_series")
        info.sampler(3, "FLOAT_2D_ARRAY", "df_terms")
    info.fragment_out(0, "VEC4", "out_colour")
    return info


_BRDF = {"TABLE": ("table.glsl", "brdf.glsl"), "FLSS": ("table.glsl", "flss.glsl", "brdf.glsl")}


@cache
def surface(method: str, flags: frozenset[str]) -> Any:
    """The shader that draws meshes, by one of `METHODS`, with some of `FLAGS` and a number of lamps."""
    import gpu

    info = _begin(method, flags)
    if "LOOSE_DEPTH" in flags:
        info.depth_write("ANY")
        info.define("DEPTH_SLACK", str(DEPTH_SLACK))
    if "DISPLAY" in flags:
        info.sampler(2, "FLOAT_3D", "df_display")
    if "TURNED" in flags:
        info.sampler(4, "FLOAT_2D", "df_angle")
    if "PAINTED" in flags:
        info.sampler(4, "FLOAT_2D", "df_paint")
    if "MASKED" in flags:
        info.sampler(7, "FLOAT_2D", "df_mask")
    has_uv = bool(flags & {"TURNED", "PAINTED", "MASKED"})
    if has_uv:
        info.define("PICTURED", "1")
    if "SKYLIT" in flags:
        info.sampler(5, "FLOAT_2D", "df_sky")
        info.define("SKY_SIDE", f"{SKY_SIDE}.0")
        info.define("SKY_LEVELS", f"{SKY_LEVELS}.0")
        info.define("SKY_DIFFUSE", "vec3({}.0, {}.0, {}.0)".format(*DIFFUSE_CORNER, DIFFUSE_SIDE))
    if any(name.startswith("SKY_") for name in flags):
        _add_densities(info)
    info.push_constant("MAT4", "df_model")
    if flags & {"GATHERS", "GATHERED"}:  # in the slots of what these do not read
        info.sampler(2 if "GATHERS" in flags else 6, "FLOAT_2D", "df_gathered")
        info.push_constant("VEC4", "df_gathering")
    for slot, (kind, name) in enumerate((("VEC3", "pos"), ("VEC3", "nor"), ("VEC4", "tan"), ("VEC2", "uv"))):
        if name != "uv" or has_uv:
            info.vertex_in(slot, kind, name)
    between = gpu.types.GPUStageInterfaceInfo("diffraction_surface")
    between.smooth("VEC3", "world_place")
    between.smooth("VEC3", "world_normal")
    between.smooth("VEC4", "world_tangent")
    if has_uv:
        between.smooth("VEC2", "world_uv")
    info.vertex_out(between)
    info.vertex_source(_text("surface_vertex.glsl"))
    info.fragment_source(_text(*_BRDF[method], "lamps.glsl", "sky.glsl", "display.glsl", "surface_fragment.glsl"))
    return _made(info)


@cache
def map_of_directions(method: str, flags: frozenset[str] = frozenset(), text: str = "") -> Any:
    """The shader that fills the frame with f cos for one light direction: every pixel is a direction to the viewer.

    Parameters
    ----------
    text
        Of another fragment shader, to measure against.
    """
    import gpu

    info = _begin(method, flags)
    info.push_constant("VEC4", "df_light")
    info.push_constant("FLOAT", "df_reach")
    info.vertex_in(0, "VEC2", "pos")
    between = gpu.types.GPUStageInterfaceInfo("diffraction_map")
    between.smooth("VEC2", "place")
    info.vertex_out(between)
    info.vertex_source(_text("map_vertex.glsl"))
    info.fragment_source(text or _text(*_BRDF[method], "map_fragment.glsl"))
    return _made(info)


def _made(info: Any) -> Any:
    """A new shader, and another one in force.

    Blender binds a shader only where the one in force is another, by its address: a new one that lies where a freed one
    lay would draw with the freed one's program.
    """
    import gpu

    shader = gpu.shader.create_from_info(info)
    gpu.shader.from_builtin("UNIFORM_COLOR").bind()
    return shader


def _add_densities(info: Any) -> None:
    info.sampler(6, "FLOAT_2D", "df_importance")
    for name, value in _DENSITIES.items():
        info.define(f"IMPORTANCE_{name}", f"{float(value)}")


def free() -> None:
    """Let go of the compiled shaders."""
    surface.cache_clear()
    map_of_directions.cache_clear()
