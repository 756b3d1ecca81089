# SPDX-License-Identifier: GPL-3.0-or-later
"""The material without OSL: the formulas of ``shaders/*.osl`` as shader nodes, for any device and for EEVEE.

Lamps are read from the scene's list, slot by slot (`node.lamp_nodes`). Cycles takes the same aimed toon lobes as the
OSL material; nodes of an empty slot stand behind a Mix Shader of factor 0, which Cycles steps over. EEVEE has no toon
closure: there a white GGX lobe about the half vector is turned into the colour that it shows (Shader to RGB), which
brings the lamp's light and shadow, and that colour times f cos is emitted. A lobe of the colour f cos would go through
EEVEE's buffers, which hold colours in ten bits from 0 to 8 and one lobe of several at random. Lamps count by their
middle, and there is no environment.
"""

from __future__ import annotations

import math
from typing import Any

import bpy

from ...precompute.table.layout import TableLayout
from ..lights import slots
from . import frame, node_lookup
from .node import interface, lamp_nodes
from .node_graph import Graph, Socket, Value

#: Slots that the nodes read in EEVEE, where each one costs whether a lamp is in it or not.
EEVEE_LAMPS_MAX = 8

#: Alpha (roughness squared) of EEVEE's lobe, for small lamps and at most: it is four times as wide as the lamp.
#: Narrower ones its tables of GGX do not hold, wider ones see more of the other lamps and of the world.
EEVEE_ALPHA, EEVEE_ALPHA_MAX = 0.04, 0.25

#: What EEVEE's tables make of the lobe's peak, measured: 0.995 to 0.997 at all angles for the smallest alpha.
EEVEE_PEAK = 0.9957


def build(
    tree: bpy.types.NodeTree, stem: str, image: bpy.types.Image, layout: TableLayout, albedo_max: float, fresnel: str,
    conserve: bool, own: Any,
) -> None:  # fmt: skip
    """Fill (or fill anew) the group of a table.

    Parameters
    ----------
    tree
        A group with the sockets of `node.interface`.
    stem
        Name of the table.
    image
        The atlas.
    layout, albedo_max
        Of the table.
    fresnel, conserve
        As in `material.Settings`; they are built in.
    own
        Illuminant of a matrix of its own, None for the scene's, see `node.lamp_nodes.matrix`.
    """
    texels = node_lookup.bilinear(image, layout)
    table = node_lookup.transform(stem, layout, texels)
    albedo = node_lookup.albedo(stem, layout, texels) if conserve and albedo_max > 1.0 else None
    reflectance = node_lookup.reflectance(stem, layout, texels) if layout.holds_reflectance else None
    tree.nodes.clear()
    surface = _Surface(Graph(tree), table, albedo, fresnel, own, reflectance, layout.index)
    cycles, eevee = surface.base(), surface.base()
    seen: Value = (0.0, 0.0, 0.0)
    for slot in range(1, slots.SLOTS + 1):
        toon, colour = surface.lobes(slot, for_eevee=slot <= EEVEE_LAMPS_MAX)
        cycles = surface.both(cycles, toon)
        if colour is not None:
            seen = surface.graph.vector("ADD", seen, colour)
    eevee = surface.both(eevee, surface.emitted(seen))
    output = surface.graph.add("NodeGroupOutput")
    surface.graph.put(output.inputs[interface.OUTPUT], by_engine(surface.graph, cycles, eevee))


def by_engine(graph: Graph, cycles: Socket, eevee: Socket) -> Socket:
    """One closure in Cycles, another in EEVEE.

    EEVEE alone turns shaders into colours: the factor is 1 there. Cycles does not know that node, takes the factor's
    own value 0 and drops the branch with its images.
    """
    white, engine = graph.add("ShaderNodeEmission"), graph.add("ShaderNodeShaderToRGB", label="1 in EEVEE")
    choice = graph.add("ShaderNodeMixShader", label="Cycles or EEVEE")
    choice.inputs[0].default_value = 0.0
    graph.put(engine.inputs[0], white.outputs[0])
    for socket, value in zip(choice.inputs, (engine.outputs[0], cycles, eevee), strict=True):
        graph.put(socket, value)
    return choice.outputs[0]


class _Surface:
    """The nodes that all lamps share, and those of one lamp."""

    def __init__(
        self,
        graph: Graph,
        table: bpy.types.NodeTree,
        albedo: bpy.types.NodeTree | None,
        fresnel: str,
        own: Any,
        reflectance: bpy.types.NodeTree | None = None,
        index: float = 1.0,
    ) -> None:
        self.graph, self._table, self._albedo = graph, table, albedo
        # What the table holds is not multiplied in once more.
        self._fresnel = fresnel if reflectance is None else "NONE"
        self._kept, self._index = reflectance, index
        self._in = graph.add("NodeGroupInput").outputs
        self._rows = lamp_nodes.matrix(graph, own)
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
        if index > 1.0:
            self._face_r, self._inner_r = self._outer_face(self._cos_r), self._inside(self._cos_r)

    def _surface_direction(self, given: Socket) -> Socket:
        """Undo the transform of normals and apply that of directions, see ``shaders/diffraction.osl``.

        With M the object's matrix, a normal's transform is undone by its transpose: the components are the
        products with M's columns, the images of the axes. (Vector Transform itself treats normals as directions.)
        """
        graph = self.graph
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
        is_given = graph.math("GREATER_THAN", graph.scalar("LENGTH", self._in["Tangent"]), 0.0)
        of_uv: Any = frame.uv_frame(graph.tree)  # where none is given
        for socket in of_uv:
            socket.node.hide = True
        tangent = graph.mix(is_given, of_uv[0], self._in["Tangent"])
        t, b = (self._surface_direction(x) for x in (tangent, graph.mix(is_given, of_uv[1], self._in["Bitangent"])))
        is_direction = graph.product(is_given, self._in["TangentIsDirection"])
        t = graph.mix(is_direction, t, tangent)
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
            rows = [self.graph.scalar("DOT_PRODUCT", row, xyz) for row in self._rows]
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
        face = self.graph.product(self._face_r, self._front)
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

    def lobes(self, slot: int, for_eevee: bool) -> tuple[Socket, Socket | None]:
        """A lamp's lobe for Cycles, and the colour that it gives in EEVEE."""
        graph = self.graph
        lamp = lamp_nodes.lamp(graph, slot).outputs
        kind, size = lamp["Kind"], lamp["Size"]
        is_on = graph.math("GREATER_THAN", kind, 0.5)
        is_sun, is_ball = (graph.math("COMPARE", kind, float(slots.KINDS[name]), 0.25) for name in ("SUN", "BALL"))
        offset = graph.vector("SUBTRACT", lamp["Place"], self._position)
        to = graph.vector("NORMALIZE", graph.mix(is_sun, offset, lamp["Place"]))
        # Of a ball that holds the lamp; the axes of one that is no area lamp are zero.
        along, across = (graph.scalar("DOT_PRODUCT", lamp[axis], lamp[axis]) for axis in "UV")
        extent = graph.fused(is_ball, size, graph.math("SQRT", graph.sum(along, across)))
        radius = graph.math("ARCTANGENT", graph.quotient(extent, graph.scalar("LENGTH", offset)))
        of_sun = graph.product(size, 0.5)
        radius = graph.fused(is_sun, graph.difference(of_sun, radius), radius)
        half = graph.vector("NORMALIZE", graph.vector("ADD", to, self._viewer))
        f_cos = self._f_cos(to, half)
        cone = graph.math("MAXIMUM", self._in["Cone"], graph.fused(radius, 1.02, 0.002))
        s = graph.math("SINE", graph.product(cone, 0.5))
        toon = graph.add("ShaderNodeBsdfToon", component="GLOSSY")
        graph.put(toon.inputs["Color"], graph.scaled(f_cos, graph.product(s, s, 4.0 * math.pi)))
        graph.put(toon.inputs["Size"], graph.product(cone, 2.0 / math.pi))
        graph.put(toon.inputs["Smooth"], 0.0)
        graph.put(toon.inputs["Normal"], half)
        lit = graph.add("ShaderNodeMixShader")
        graph.put(lit.inputs[0], is_on)
        graph.put(lit.inputs[2], toon.outputs[0])
        if not for_eevee:
            return lit.outputs[0], None

        # Of the disc with the same mean square as the lamp, over half the diagonal of a rectangle or an ellipse.
        is_area, is_round = graph.math("GREATER_THAN", kind, 2.5), graph.math("GREATER_THAN", kind, 3.5)
        square, disc = math.sqrt(2.0 / 3.0) - 1.0, math.sqrt(0.5) - math.sqrt(2.0 / 3.0)
        radius = graph.product(radius, graph.fused(is_area, square, graph.fused(is_round, disc, 1.0)))
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
        colour = graph.vector("MULTIPLY", f_cos, shown.outputs[0])
        return lit.outputs[0], graph.scaled(colour, graph.product(gain, is_on))

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
            inner_i, inner_r = self._inside(cos_i), self._inner_r
            plane = graph.fused(x, self._wr_x, graph.product(y, self._wr_y))
            inner = graph.fused(plane, self._index**-2, graph.fused(inner_i, inner_r, 1.0))
            steep = graph.sum(inner_i, inner_r)
            through = graph.product(graph.difference(1.0, self._outer_face(cos_i)), graph.difference(1.0, self._face_r))
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
        components = [graph.scalar("DOT_PRODUCT", row, xyz) for row in self._rows]
        luminance = graph.math("MAXIMUM", graph.split(xyz)[1], 0.0)
        lowest = graph.math("MINIMUM", components[0], graph.math("MINIMUM", components[1], components[2]))
        below = graph.math("MINIMUM", lowest, 0.0)
        keep = graph.quotient(luminance, graph.difference(luminance, below))  # 1 inside the gamut
        grey = graph.join(luminance, luminance, luminance)
        away = graph.vector("SUBTRACT", graph.join(*components), grey)
        moved = graph.vector("ADD", grey, graph.scaled(away, keep))
        return graph.vector("MAXIMUM", moved, (0.0, 0.0, 0.0))
