# SPDX-License-Identifier: GPL-3.0-or-later
"""The material without OSL: the formulas of ``shaders/*.osl`` as shader nodes, for any device and for EEVEE.

Each lamp of the scene has its own nodes, so the group is built anew when lamps come or go; moves go through
drivers. Cycles takes the same aimed toon lobes as the OSL material. EEVEE has no toon closure: there a white GGX
lobe about the half vector is turned into the colour that it shows (Shader to RGB), which brings the lamp's light
and shadow, and that colour times f cos is emitted. A lobe of the colour f cos would go through EEVEE's buffers,
which hold colours in ten bits from 0 to 8 and one lobe of several at random. Lamps count by their middle, and there
is no environment.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import bpy

from ...precompute.table.layout import TableLayout
from . import lights, node_lookup
from .node_graph import Graph, Socket, Value, interface, new_group

#: Lamps that the nodes follow.
LAMPS_MAX = 8

#: Alpha (roughness squared) of EEVEE's lobe, for small lamps and at most: it is four times as wide as the lamp.
#: Narrower ones its tables of GGX do not hold, wider ones see more of the other lamps and of the world.
EEVEE_ALPHA, EEVEE_ALPHA_MAX = 0.04, 0.25

#: What EEVEE's tables make of the lobe's peak, measured: 0.995 to 0.997 at all angles for the smallest alpha.
EEVEE_PEAK = 0.9957

#: Radius of the disc with the same mean square as a lamp, over half the lamp's diagonal.
_ROUND = {"SUN": 1.0, "BALL": 1.0, "RECTANGLE": math.sqrt(2.0 / 3.0), "ELLIPSE": math.sqrt(0.5)}

_NUMBER, _VECTOR, _SHADER = "NodeSocketFloat", "NodeSocketVector", "NodeSocketShader"

_INPUTS: dict[str, tuple[str, object]] = {
    "Base": (_SHADER, None),
    "Normal": (_VECTOR, (0.0, 0.0, 0.0)),
    "Tangent": (_VECTOR, (0.0, 0.0, 0.0)),
    "Bitangent": (_VECTOR, (0.0, 0.0, 0.0)),
    "TangentIsDirection": ("NodeSocketInt", 0),
    "Rotation": (_NUMBER, 0.0),
    "Brightness": (_NUMBER, 1.0),
    "IOR": (_NUMBER, 1.5),
    "ConductorN": (_VECTOR, (1.35, 0.95, 0.61)),
    "ConductorK": (_VECTOR, (7.47, 6.54, 5.47)),
    "LacquerRoughness": (_NUMBER, 0.05),
    "DiffuseLimit": (_NUMBER, 1.0),
    "Cone": (_NUMBER, 0.1),
    # Built in rather than read; they stand here for whoever asks a material what it is.
    "Fresnel": ("NodeSocketInt", 1),
    "ConserveEnergy": ("NodeSocketInt", 1),
    "Environment": ("NodeSocketInt", 0),
    "ToRed": (_VECTOR, (3.2404542, -1.5371385, -0.4985314)),
    "ToGreen": (_VECTOR, (-0.969266, 1.8760108, 0.041556)),
    "ToBlue": (_VECTOR, (0.0556434, -0.2040259, 1.0572252)),
}


def build(
    name: str, image: bpy.types.Image, layout: TableLayout, albedo_max: float, fresnel: str, conserve: bool,
    lamps: Sequence[lights.LampObject],
) -> bpy.types.NodeTree:  # fmt: skip
    """Build (or rebuild in place) the group of a material.

    Parameters
    ----------
    name
        Of the material; the group is called after it.
    image
        The atlas.
    layout, albedo_max
        Of the table.
    fresnel, conserve
        As in `material.Settings`; they are built in.
    lamps
        At most `LAMPS_MAX` are taken.
    """
    stem = image.name
    texels = node_lookup.bilinear(image, layout)
    table = node_lookup.transform(stem, layout, texels)
    albedo = node_lookup.albedo(stem, layout, texels) if conserve and albedo_max > 1.0 else None

    tree = new_group(f"Diffraction {name}")
    lamps = lamps[:LAMPS_MAX]
    sockets = dict(_INPUTS)
    for number in range(1, len(lamps) + 1):
        sockets |= {f"Lamp{number}{each}": (_VECTOR, None) for each in ("Place", "AxisU", "AxisV", "Size")}
        sockets[f"Lamp{number}Kind"] = ("NodeSocketInt", 0)
    interface(tree, sockets, {"BSDF": _SHADER, "EEVEE": _SHADER})
    reflectance = node_lookup.reflectance(stem, layout, texels) if layout.holds_reflectance else None
    surface = _Surface(Graph(tree), table, albedo, fresnel, reflectance, layout.index)
    cycles, eevee = surface.base(), surface.base()
    seen: Value = (0.0, 0.0, 0.0)
    for number, lamp in enumerate(lamps, 1):
        toon, colour = surface.lobes(number, lights.lamp_kind(lamp.data))
        cycles, seen = surface.both(cycles, toon), surface.graph.vector("ADD", seen, colour)
    if lamps:
        eevee = surface.both(eevee, surface.emitted(seen))
    output = surface.graph.add("NodeGroupOutput")
    surface.graph.put(output.inputs["BSDF"], cycles)
    surface.graph.put(output.inputs["EEVEE"], eevee)
    return tree


class _Surface:
    """The nodes that all lamps share, and those of one lamp."""

    def __init__(
        self,
        graph: Graph,
        table: bpy.types.NodeTree,
        albedo: bpy.types.NodeTree | None,
        fresnel: str,
        reflectance: bpy.types.NodeTree | None = None,
        index: float = 1.0,
    ) -> None:
        self.graph, self._table, self._albedo = graph, table, albedo
        # What the table holds is not multiplied in once more.
        self._fresnel = fresnel if reflectance is None else "NONE"
        self._kept, self._index = reflectance, index
        self._in = graph.add("NodeGroupInput").outputs
        geometry = graph.add("ShaderNodeNewGeometry")
        self._viewer, self._position = geometry.outputs["Incoming"], geometry.outputs["Position"]
        given = self._in["Normal"]
        has_normal = graph.math("GREATER_THAN", graph.scalar("LENGTH", given), 0.0)
        self._n = graph.vector("NORMALIZE", graph.mix(has_normal, geometry.outputs["Normal"], given))
        self._t, self._b = self._frame()
        self._wr = self._local(self._viewer)
        self._wr_x, self._wr_y, self._cos_r = graph.split(self._wr)
        front = graph.math("GREATER_THAN", self._cos_r, 0.0)
        self._front = graph.product(front, graph.difference(1.0, geometry.outputs["Backfacing"]))
        self._albedo_r = self._albedo_of(self._wr)

    def _surface_direction(self, name: str) -> Socket:
        """Undo the transform of normals and apply that of directions, see ``shaders/diffraction.osl``.

        With M the object's matrix, a normal's transform is undone by its transpose: the components are the
        products with M's columns, the images of the axes. (Vector Transform itself treats normals as directions.)
        """
        graph, given = self.graph, self._in[name]
        total: Any = (0.0, 0.0, 0.0)
        for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
            turned = graph.add(
                "ShaderNodeVectorTransform", vector_type="VECTOR", convert_from="OBJECT", convert_to="WORLD"
            )
            graph.put(turned.inputs[0], axis)
            column = turned.outputs[0]
            total = graph.vector("ADD", total, graph.scaled(column, graph.scalar("DOT_PRODUCT", given, column)))
        return total

    def _frame(self) -> tuple[Socket, Socket]:
        graph, n = self.graph, self._n
        t, b = self._surface_direction("Tangent"), self._surface_direction("Bitangent")
        t = graph.mix(self._in["TangentIsDirection"], t, self._in["Tangent"])
        t = graph.vector("SUBTRACT", t, graph.scaled(n, graph.scalar("DOT_PRODUCT", t, n)))
        t = graph.vector("NORMALIZE", t)
        across = graph.vector("CROSS_PRODUCT", n, t)
        mirrored = graph.math("LESS_THAN", graph.scalar("DOT_PRODUCT", across, b), 0.0)
        across = graph.scaled(across, graph.fused(mirrored, -2.0, 1.0))
        cos, sin = graph.math("COSINE", self._in["Rotation"]), graph.math("SINE", self._in["Rotation"])
        turned_b = graph.vector("SUBTRACT", graph.scaled(across, cos), graph.scaled(t, sin))
        turned_t = graph.vector("ADD", graph.scaled(t, cos), graph.scaled(across, sin))
        return turned_t, turned_b

    def _local(self, direction: Socket) -> Socket:
        return self.graph.join(*(self.graph.scalar("DOT_PRODUCT", direction, a) for a in (self._t, self._b, self._n)))

    def _albedo_of(self, direction: Socket) -> Value:
        if self._albedo is None:
            return 1.0
        return self.graph.group(self._albedo, Direction=direction).outputs["Albedo"]

    def _reflectance(self, cos_half: Socket) -> Value:
        """R as a vector of red, green and blue, or a number."""
        graph = self.graph
        if self._fresnel == "DIELECTRIC":
            ior = self._in["IOR"]
            root = graph.quotient(graph.difference(ior, 1.0), graph.sum(ior, 1.0))
            r0 = graph.product(root, root)
            m = graph.math("POWER", graph.difference(1.0, graph.clamp(cos_half, 0.0, 1.0)), 5.0)
            return graph.fused(graph.difference(1.0, r0), m, r0)
        if self._fresnel == "CONDUCTOR":
            n, k = graph.split(self._in["ConductorN"]), graph.split(self._in["ConductorK"])
            return graph.join(*(self._conductor(n[i], k[i], cos_half) for i in range(3)))
        return 1.0

    def _conductor(self, n: Socket, k: Socket, cos_half: Socket) -> Socket:
        """As ``fresnel_conductor`` in ``shaders/brdf.osl``."""
        graph = self.graph
        c = graph.clamp(cos_half, 0.0, 1.0)
        c2 = graph.product(c, c)
        s2 = graph.difference(1.0, c2)
        d = graph.difference(graph.difference(graph.product(n, n), graph.product(k, k)), s2)
        nk = graph.product(n, k)
        a2b2 = graph.math("SQRT", graph.fused(d, d, graph.product(nk, nk, 4.0)))
        a = graph.math("SQRT", graph.product(graph.sum(a2b2, d), 0.5))
        twice = graph.product(c, a, 2.0)
        plain = graph.sum(a2b2, c2)
        rs = graph.quotient(graph.difference(plain, twice), graph.sum(plain, twice))
        p_plain, p_twice = graph.fused(c2, a2b2, graph.product(s2, s2)), graph.product(twice, s2)
        rp = graph.product(rs, graph.quotient(graph.difference(p_plain, p_twice), graph.sum(p_plain, p_twice)))
        return graph.product(graph.sum(rs, rp), 0.5)

    def base(self) -> Socket:
        """The pigment, weighted by 1 - R at the view angle, and the mirror of a lacquer's outer face."""
        reflectance: Value = self._reflectance(self._cos_r)
        if self._kept is not None:
            xyz = self.graph.group(self._kept, Cosine=self._cos_r).outputs["XYZ"]
            rows = [self.graph.scalar("DOT_PRODUCT", self._in[name], xyz) for name in ("ToRed", "ToGreen", "ToBlue")]
            rows = [self.graph.clamp(row, 0.0, 1.0) for row in rows]
            reflectance = self.graph.product(self.graph.sum(self.graph.sum(rows[0], rows[1]), rows[2]), 1.0 / 3.0)
        if isinstance(reflectance, bpy.types.NodeSocket) and reflectance.type == "VECTOR":
            reflectance = self.graph.product(self.graph.scalar("DOT_PRODUCT", reflectance, (1.0, 1.0, 1.0)), 1.0 / 3.0)
        node = self.graph.add("ShaderNodeMixShader")
        self.graph.put(node.inputs[0], reflectance)
        self.graph.put(node.inputs[1], self._in["Base"])
        if self._index == 1.0:
            return node.outputs[0]
        mirror = self.graph.add("ShaderNodeBsdfAnisotropic", distribution="GGX")
        face = self.graph.product(self._outer_face(self._cos_r), self._front)
        self.graph.put(mirror.inputs["Color"], self.graph.join(face, face, face))
        self.graph.put(mirror.inputs["Roughness"], self._in["LacquerRoughness"])
        self.graph.put(mirror.inputs["Normal"], self._n)
        return self.both(node.outputs[0], mirror.outputs[0])

    def _outer_face(self, cosine: Socket) -> Socket:
        """Exact reflectance of the lacquer's outer face, as ``fresnel_exact`` in ``shaders/brdf.osl``."""
        graph, n2 = self.graph, self._index**2
        c = graph.clamp(cosine, 1e-6, 1.0)
        inside = graph.math("SQRT", graph.fused(c, c, n2 - 1.0))
        s = graph.quotient(graph.difference(c, inside), graph.sum(c, inside))
        dense = graph.product(c, n2)
        p = graph.quotient(graph.difference(dense, inside), graph.sum(dense, inside))
        return graph.product(graph.fused(s, s, graph.product(p, p)), 0.5)

    def _inside(self, cosine: Socket) -> Socket:
        """Cosine of a direction behind the outer face."""
        graph, n2 = self.graph, self._index**2
        return graph.math("SQRT", graph.product(graph.fused(cosine, cosine, n2 - 1.0), 1.0 / n2))

    def both(self, a: Socket, b: Socket) -> Socket:
        """Two closures added."""
        node = self.graph.add("ShaderNodeAddShader")
        self.graph.put(node.inputs[0], a)
        self.graph.put(node.inputs[1], b)
        return node.outputs[0]

    def emitted(self, colour: Value) -> Socket:
        """A closure that shows a colour."""
        node = self.graph.add("ShaderNodeEmission")
        self.graph.put(node.inputs["Color"], colour)
        return node.outputs[0]

    def lobes(self, number: int, kind: str) -> tuple[Socket, Socket]:
        """A lamp's lobe for Cycles, and the colour that it gives in EEVEE."""
        graph = self.graph
        place, size = self._in[f"Lamp{number}Place"], self._in[f"Lamp{number}Size"]
        if kind == "SUN":
            to = graph.vector("NORMALIZE", place)
            radius = graph.product(graph.split(size)[0], 0.5)
        else:
            offset = graph.vector("SUBTRACT", place, self._position)
            to = graph.vector("NORMALIZE", offset)
            radius = graph.math(
                "ARCTANGENT", graph.quotient(self._half_extent(number, kind), graph.scalar("LENGTH", offset))
            )
        half = graph.vector("NORMALIZE", graph.vector("ADD", to, self._viewer))
        f_cos = self._f_cos(to, half)
        cone = graph.math("MAXIMUM", self._in["Cone"], graph.fused(radius, 1.02, 0.002))
        s = graph.math("SINE", graph.product(cone, 0.5))
        toon = graph.add("ShaderNodeBsdfToon", component="GLOSSY")
        graph.put(toon.inputs["Color"], graph.scaled(f_cos, graph.product(s, s, 4.0 * math.pi)))
        graph.put(toon.inputs["Size"], graph.product(cone, 2.0 / math.pi))
        graph.put(toon.inputs["Smooth"], 0.0)
        graph.put(toon.inputs["Normal"], half)

        radius = graph.product(radius, _ROUND[kind])
        alpha = graph.clamp(graph.product(radius, 2.0), EEVEE_ALPHA, EEVEE_ALPHA_MAX)
        alpha2 = graph.product(alpha, alpha)
        glossy = graph.add("ShaderNodeBsdfAnisotropic", distribution="GGX")
        graph.put(glossy.inputs["Color"], (1.0, 1.0, 1.0))
        graph.put(glossy.inputs["Roughness"], graph.math("SQRT", alpha))
        graph.put(glossy.inputs["Normal"], half)
        shown = graph.add("ShaderNodeShaderToRGB")
        graph.put(shown.inputs[0], glossy.outputs[0])
        c = graph.clamp(graph.scalar("DOT_PRODUCT", half, self._viewer), 1e-3, 1.0)
        # One over the lobe's peak is 4 c pi alpha^2 (1 + 2 Lambda(c)), with 1 + 2 Lambda = sqrt(1 + alpha^2 tan^2).
        tan2 = graph.difference(graph.math("POWER", c, -2.0), 1.0)
        gain = graph.product(c, alpha2, graph.math("SQRT", graph.fused(tan2, alpha2, 1.0)), 4.0 * math.pi / EEVEE_PEAK)
        # The mean of the lobe over the lamp lies below the peak: half vectors turn by half the lamp's radius in the
        # plane of incidence and by 1 / c as much across it, D falls as 1 - 2 (tan / alpha)^2.
        part = graph.quotient(graph.product(radius, 0.5), alpha)
        gain = graph.product(gain, graph.fused(graph.product(part, part, 0.5), graph.sum(tan2, 2.0), 1.0))
        return toon.outputs[0], graph.scaled(graph.vector("MULTIPLY", f_cos, shown.outputs[0]), gain)

    def _half_extent(self, number: int, kind: str) -> Socket:
        """Radius of a ball that holds the lamp."""
        graph = self.graph
        x, y, _ = graph.split(self._in[f"Lamp{number}Size"])
        if kind == "BALL":
            return x
        along = graph.product(x, graph.scalar("LENGTH", self._in[f"Lamp{number}AxisU"]))
        across = graph.product(y, graph.scalar("LENGTH", self._in[f"Lamp{number}AxisV"]))
        return graph.product(graph.math("SQRT", graph.fused(along, along, graph.product(across, across))), 0.5)

    def _f_cos(self, to: Socket, half: Socket) -> Socket:
        """f cos(theta_i) R as RGB, 0 where light or viewer is below the surface."""
        graph = self.graph
        wi = self._local(to)
        x, y, cos_i = graph.split(wi)
        lit = graph.product(graph.math("GREATER_THAN", cos_i, 0.0), self._front)
        w = graph.math("MAXIMUM", graph.sum(cos_i, self._cos_r), 1e-4)
        mirror = graph.sum(graph.scalar("DOT_PRODUCT", wi, self._wr), 1.0)
        factor = graph.quotient(graph.product(mirror, mirror), graph.product(self._cos_r, w, w))
        if self._index > 1.0:  # seen through a clear layer, see ``shaders/brdf.osl``
            inner_i, inner_r = self._inside(cos_i), self._inside(self._cos_r)
            plane = graph.fused(x, self._wr_x, graph.product(y, self._wr_y))
            inner = graph.fused(plane, self._index**-2, graph.fused(inner_i, inner_r, 1.0))
            steep = graph.sum(inner_i, inner_r)
            through = graph.product(
                graph.difference(1.0, self._outer_face(cos_i)), graph.difference(1.0, self._outer_face(self._cos_r))
            )
            lower = graph.product(graph.product(inner_i, inner_r), steep, steep)
            factor = graph.quotient(graph.product(through, graph.product(inner, inner), cos_i), lower)
            w = graph.product(steep, self._index)
        if self._albedo is not None:
            largest = graph.math("MAXIMUM", graph.math("MAXIMUM", self._albedo_of(wi), self._albedo_r), 1.0)
            factor = graph.quotient(factor, largest)
        u = graph.product(graph.sum(x, self._wr_x), -1.0)
        v = graph.product(graph.sum(y, self._wr_y), -1.0)
        xyz = graph.scaled(graph.group(self._table, U=u, V=v, W=w).outputs["XYZ"], factor)
        rgb = self._into_gamut(xyz)
        cos_half = graph.math("MAXIMUM", graph.scalar("DOT_PRODUCT", half, self._viewer), 0.0)
        reflectance = self._reflectance(cos_half)
        if isinstance(reflectance, bpy.types.NodeSocket) and reflectance.type == "VECTOR":
            rgb, reflectance = graph.vector("MULTIPLY", rgb, reflectance), 1.0
        gain = graph.product(lit, self._in["Brightness"], reflectance)
        rgb = graph.scaled(rgb, gain)
        # Seen by a diffuse bounce the specular peak makes fireflies.
        red, green, blue = graph.split(rgb)
        peak = graph.math("MAXIMUM", red, graph.math("MAXIMUM", green, blue))
        limit = self._in["DiffuseLimit"]
        limited = graph.quotient(limit, graph.math("MAXIMUM", peak, limit))
        diffuse = graph.add("ShaderNodeLightPath").outputs["Is Diffuse Ray"]
        return graph.scaled(rgb, graph.fused(diffuse, graph.difference(limited, 1.0), 1.0))

    def _into_gamut(self, xyz: Socket) -> Socket:
        graph = self.graph
        components = [graph.scalar("DOT_PRODUCT", self._in[name], xyz) for name in ("ToRed", "ToGreen", "ToBlue")]
        luminance = graph.math("MAXIMUM", graph.split(xyz)[1], 0.0)
        lowest = graph.math("MINIMUM", components[0], graph.math("MINIMUM", components[1], components[2]))
        below = graph.math("MINIMUM", lowest, 0.0)
        keep = graph.quotient(luminance, graph.difference(luminance, below))  # 1 inside the gamut
        grey = graph.join(luminance, luminance, luminance)
        away = graph.vector("SUBTRACT", graph.join(*components), grey)
        moved = graph.vector("ADD", grey, graph.scaled(away, keep))
        return graph.vector("MAXIMUM", moved, (0.0, 0.0, 0.0))
