# SPDX-License-Identifier: GPL-3.0-or-later
"""The thesis's own method (FLSS) as it stood at commit f889080, so that what it is compared with may change.

`recorded/` holds the text of its shaders; here are the blocks and rows that they read. 29 Taylor terms, 79 wavelengths
and 3 x 3 bins are what that commit measured.
"""

from pathlib import Path

import numpy as np

RECORDED = Path(__file__).with_name("recorded")

_TYPES = """
struct DiffractionLamp { vec4 place; vec4 half_u; vec4 half_v; vec4 normal; vec4 colour; vec4 extra; };
struct DiffractionFrame {
  mat4 view; mat4 projection; vec4 viewer; vec4 counts; vec4 display; vec4 ambient; DiffractionLamp lamps[16];
};
struct DiffractionSurface {
  vec4 radial; vec4 slices; vec4 value; vec4 texel; vec4 to_red; vec4 to_green; vec4 to_blue; vec4 fresnel;
  vec4 conductor_n; vec4 conductor_k; vec4 rotation; vec4 pigment;
};
struct DiffractionSeries { vec4 bins; vec4 window; vec4 loops; vec4 spectrum[96]; };
"""

_NUMBERS = {
    "METHOD_FLSS": 1, "FRESNEL_NONE": "0.0", "FRESNEL_DIELECTRIC": "1.0", "FRESNEL_CONDUCTOR": "2.0",
    "LAMP_NONE": "0.0", "LAMP_SUN": "1.0", "LAMP_BALL": "2.0", "LAMP_RECTANGLE": "3.0", "LAMP_ELLIPSE": "4.0",
}  # fmt: skip


def _begin():
    import gpu

    info = gpu.types.GPUShaderCreateInfo()
    for name, value in _NUMBERS.items():
        info.define(name, str(value))
    info.typedef_source(_TYPES)
    for slot, (kind, name) in enumerate(
        (("DiffractionFrame", "df_frame"), ("DiffractionSurface", "df_surface"), ("DiffractionSeries", "df_series"))
    ):
        info.uniform_buf(slot, kind, name)
    info.sampler(0, "FLOAT_2D_ARRAY", "df_table")
    info.sampler(1, "FLOAT_2D", "df_albedo")
    info.sampler(3, "FLOAT_2D_ARRAY", "df_terms")
    info.fragment_out(0, "VEC4", "out_colour")
    return info


def _text(name):
    return (RECORDED / name).read_text(encoding="utf-8")


def map_shader():
    """Fills the frame with f cos for one direction of light."""
    import gpu

    info = _begin()
    info.push_constant("VEC4", "df_light")
    info.push_constant("FLOAT", "df_reach")
    info.vertex_in(0, "VEC2", "pos")
    between = gpu.types.GPUStageInterfaceInfo("flss_map")
    between.smooth("VEC2", "place")
    info.vertex_out(between)
    info.vertex_source("void main() { place = df_reach * pos; gl_Position = vec4(pos, 0.0, 1.0); }")
    info.fragment_source(_text("flss_map.glsl"))
    return gpu.shader.create_from_info(info)


def surface_shader():
    """Draws meshes."""
    import gpu

    info = _begin()
    info.sampler(2, "FLOAT_3D", "df_display")
    info.sampler(4, "FLOAT_2D", "df_angle")
    info.push_constant("MAT4", "df_model")
    between = gpu.types.GPUStageInterfaceInfo("flss_surface")
    for slot, (kind, name, out, out_kind) in enumerate(
        (
            ("VEC3", "pos", "world_place", "VEC3"),
            ("VEC3", "nor", "world_normal", "VEC3"),
            ("VEC4", "tan", "world_tangent", "VEC4"),
            ("VEC2", "uv", "world_uv", "VEC2"),
        )
    ):
        info.vertex_in(slot, kind, name)
        between.smooth(out_kind, out)
    info.vertex_out(between)
    info.vertex_source(_text("flss_surface_vertex.glsl"))
    info.fragment_source(_text("flss_surface.glsl"))
    return gpu.shader.create_from_info(info)


def frame_rows(view, projection, lamps):
    """Rows of its frame: one point a lamp, no view transform, no world."""
    rows = np.zeros((12 + 6 * 16, 4), np.float32)
    rows[0:4], rows[4:8] = np.asarray(view).T, np.asarray(projection).T
    to_world = np.linalg.inv(view)
    perspective = projection[3, 3] == 0.0
    rows[8] = (*to_world[:3, 3], 1.0) if perspective else (*to_world[:3, 2], 0.0)
    rows[9] = len(lamps), 1.0, 0.0, 2.0
    if len(lamps):
        rows[12 : 12 + 6 * len(lamps)] = np.reshape(lamps, (-1, 4))
    return rows


def surface_rows(layout, to_rgb, conserve_energy, fresnel=0.0, ior=1.5):
    """Rows of its surface."""
    rows = np.zeros((12, 4), np.float32)
    rows[0] = layout.a_r, 1.0 / layout.r0, layout.n_r - 1, layout.n_phi
    rows[1] = layout.a_w, 1.0 / layout.w0, layout.s_w, layout.n_w - 1
    rows[2] = layout.scale, layout.power, layout.n_theta - 1, layout.n_albedo_phi
    rows[3] = 1.0 / layout.n_r, 1.0 / layout.tile_height, 1.0 / layout.n_theta, 1.0 / (layout.n_albedo_phi + 2)
    rows[4:7, :3] = to_rgb
    rows[7] = fresnel, ior, float(conserve_energy), 1.0
    rows[10] = 1.0, 0.0, 0.0, 0.0
    return rows


def albedo_texture(table):
    """The table's albedo tile as that commit kept it."""
    import gpu
    from diffraction_shader.addon.versions import smooth_lookups
    from diffraction_shader.addon.viewport.data.blocks import buffer

    layout = table.layout
    last = layout.albedo_y + layout.n_albedo_phi + 2
    tile = np.ascontiguousarray(table.atlas[layout.albedo_y : last, : layout.n_theta, 0], np.float32)
    texture = gpu.types.GPUTexture((layout.n_theta, layout.n_albedo_phi + 2), format="R32F", data=buffer(tile))
    smooth_lookups(texture)
    return texture
