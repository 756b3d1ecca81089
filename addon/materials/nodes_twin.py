# SPDX-License-Identifier: GPL-3.0-or-later
"""The material without OSL: the formulas of ``shaders/*.osl`` as shader nodes, for any device and for EEVEE.

Lamps are read from the scene's list, slot by slot; Cycles takes the list's numbers as constants and drops what is not
in use. What Cycles draws from the environment by a mirror EEVEE reads from its probe of the world
(`twin.lamps.mirror`).
"""

from __future__ import annotations

from typing import Any

import bpy

from ...precompute.table import importance
from ...precompute.table.layout import TableLayout
from ..lights import slots
from .node import interface, lamp_nodes
from .node_graph import Graph, Socket, Value
from .twin import aimed, environment, lamps, lookup, seen
from .twin import value as values
from .twin.surface import Parts, Surface, shared

#: Changes with the nodes: a group that another version made is built anew.
VERSION = 21


def build(
    tree: bpy.types.NodeTree, stem: str, images: tuple[bpy.types.Image, bpy.types.Image | None], layout: TableLayout,
    albedo_max: float, fresnel: str, conserve: bool, own: Any, albedo_free: float = 2.0,
) -> None:  # fmt: skip
    """Fill (or fill anew) the group of a table.

    Parameters
    ----------
    tree
        A group with the sockets of `node.interface`.
    stem
        Name of the table.
    images
        The atlas and the image of directions.
    layout, albedo_max
        Of the table.
    fresnel, conserve
        As in `material.Settings`; they are built in.
    own
        Illuminant of a matrix of its own, None for the scene's, see `node.lamp_nodes.matrix`.
    albedo_free
        Cosine above which no albedo passes 1 (`importance.albedo_free_cosine`).
    """
    atlas, directions = images
    assert directions is not None, "a material of the kind Nodes draws directions"
    if layout.holds_reflectance:
        fresnel = "NONE"  # what the table holds is not multiplied in once more
    built_in = f"{fresnel.lower()}{'' if conserve else ' raw'}"
    albedos = (importance.WIDTH, importance.HEIGHT)

    def parts(engine: str, at_random: bool = False) -> Parts:
        name, texels = f"{stem} {engine}".rstrip(), lookup.texels(atlas, (layout.width, layout.height), engine)
        kept = lookup.reflectance(name, layout, texels) if layout.holds_reflectance else None
        return Parts(
            name=f"{name} {built_in}", layout=layout,
            value=values.value(name, layout, lookup.transform(name, layout, texels, at_random), fresnel, kept),
            albedo=lookup.albedo(name, lookup.texels(directions, albedos, engine), engine == "EEVEE")
            if conserve else None,
            albedo_free=albedo_free,
            kept=kept,
            fresnel=fresnel, conserve=conserve,
        )  # fmt: skip

    both = parts("", at_random=True)
    lobe, for_eevee = lamps.in_cycles(parts("Cycles")), lamps.in_eevee(parts("EEVEE"))
    draw = environment.draw(both, directions)
    tree.nodes.clear()
    graph = Graph(tree)
    given = graph.add("NodeGroupInput").outputs
    in_eevee = graph.in_eevee()
    knows_directions = lookup.guard(
        graph, directions, importance.GUARD_X, importance.GUARD_Y, importance.WIDTH, importance.HEIGHT, in_eevee
    )
    surface = Surface(graph, both, shared(graph, given, both, lamp_nodes.matrix(graph, own), knows_directions))
    random = environment.random_numbers(graph)
    drawn = surface.group(draw, Random=random).outputs
    again = surface.group(draw, Random=environment.other_numbers(graph, random)).outputs if conserve else None
    enabled = graph.product(graph.clamp(given["Environment"], 0.0, 1.0), knows_directions)
    closure, shown = _lamps(surface, lobe, for_eevee, random, (drawn, again), enabled)
    cycles = surface.both(surface.base(given["Base"], given["LacquerRoughness"]), closure)
    eevee = surface.both(surface.base(given["Base"], given["LacquerRoughness"]), surface.emitted(shown))
    shaded = surface.mixed(surface["EEVEE"], cycles, eevee)
    shows = _on_a_surface(graph)
    if layout.guarded:
        intact = lookup.guard(graph, atlas, layout.guard_x, layout.guard_y, layout.width, layout.height, in_eevee)
        shows = graph.product(shows, intact)
    out = graph.add("NodeGroupOutput").inputs
    for name, shader in ((interface.OUTPUT, shaded), (interface.EEVEE, eevee)):
        structured = surface.mixed(shows, given["Base"], shader)
        graph.put(out[name], surface.mixed(given["Mask"], given["Base"], structured))


def _on_a_surface(graph: Graph) -> Socket:
    """0 on strands and points, which have no place for a scan, as in ``shaders/diffraction.osl``; else 1."""
    strand = graph.add("ShaderNodeHairInfo").outputs["Is Strand"]
    radius = graph.add("ShaderNodePointInfo").outputs["Radius"]
    return graph.math("LESS_THAN", graph.math("MAXIMUM", strand, radius), 1e-30)


def _lamps(
    surface: Surface, lobe: bpy.types.NodeTree, for_eevee: bpy.types.NodeTree, random: Socket,
    directions: tuple[Any, Any], enabled: Socket,
) -> tuple[Socket, Socket]:  # fmt: skip
    """The closure of all lamps and of the mirror into the environment for Cycles, and their colour in EEVEE.

    Cycles knows the scene's list when it compiles: an empty slot leaves no nodes behind.
    """
    graph, (drawn, again) = surface.graph, directions
    closure: Any = None
    shown: Any = None
    drawn_grey = [environment.grey_of_plain(graph, one) for one in directions if one is not None]
    far: Value = 1.0  # where the drawn direction passes by all lamps
    outside: list[Value] = [1.0, 1.0]
    outside_in_eevee = enabled
    f_cos = graph.product(lamps.grey_of(graph, drawn["RGB"]), drawn["Finished"])
    f_cos = graph.quotient(f_cos, drawn["Solid"])
    listed = [lamp_nodes.lamp(graph, slot).outputs for slot in range(1, slots.SLOTS + 1)]
    lobes, taken = _aimed(surface, listed, random, directions, enabled)
    sent = graph.product(lamps.grey_of(graph, drawn["RGB"]), drawn["Weight"])
    chance = graph.product(graph.split(random)[2], lamps.WEIGHT_MIN)
    for slot, (lamp, one) in enumerate(zip(listed, lobes, strict=True), 1):
        given = {name: one[name] for name in ("To", "Aim", "Width", "Weight", "Narrow", "On", *aimed.SLENDER)}
        lit = surface.group(lobe, **given, Hits=taken[f"Hits {slot}"], Chance=chance, Sent=sent).outputs
        # A lobe about a part of a lamp leaves all beside the lamp.
        of_lobe = graph.product(lit["Grey"], one["Gain"], graph.difference(1.0, lit["Slender"]))
        closure = lit["Lobe"] if closure is None else surface.both(closure, lit["Lobe"])
        for number, name in enumerate(("", " Again")[: len(drawn_grey)]):
            places = one[f"Outside{name}"], one[f"Around{name}"]
            part = environment.left(graph, *places, of_lobe, drawn_grey[number])
            outside[number] = graph.product(outside[number], part)
        far = graph.product(far, one["Outside"])
        if slot <= lamps.EEVEE_LAMPS_MAX:
            sockets: dict[str, Any] = {name: lamp[name] for name in lamp_nodes.OUTPUTS}
            by_eevee = surface.group(for_eevee, **sockets, To=drawn["To"], Drawn=f_cos).outputs
            shown = by_eevee["Colour"] if shown is None else graph.vector("ADD", shown, by_eevee["Colour"])
            outside_in_eevee = graph.product(outside_in_eevee, by_eevee["Outside"])
    plain = _mirrors(surface, drawn, far, outside[0])
    if again is not None:
        xi = graph.split(random)[2]
        chosen, factor = environment.one_of_two(graph, drawn, again, (outside[0], outside[1]), xi)
        is_stretched = graph.math("LESS_THAN", surface["Scale"], environment.RESAMPLED_BELOW)
        plain = surface.mixed(is_stretched, plain, _mirror(surface, chosen, factor))
    closure = surface.both(closure, surface.mixed(enabled, None, plain))
    world = lamps.mirror(graph, graph.vector("NORMALIZE", drawn["Half"]), 0.0)
    world = graph.vector("MINIMUM", world, lamps.most_of_world(graph))
    by_world = graph.scaled(
        graph.vector("MULTIPLY", drawn["RGB"], world), graph.product(drawn["Finished"], outside_in_eevee)
    )
    return closure, graph.vector("ADD", shown, by_world)


def _aimed(
    surface: Surface, listed: list[Any], random: Socket, directions: tuple[Any, Any], enabled: Socket
) -> tuple[list[Any], Any]:  # fmt: skip
    """Outputs of `aimed.aimed` for each slot, and those of `seen.hits`."""
    graph, position, place, lobe = surface.graph, surface["Position"], seen.place(), aimed.aimed()
    each = [{name: lamp[name] for name in lamp_nodes.OUTPUTS} | {"Position": position} for lamp in listed]
    places = [graph.group(place, **one).outputs for one in each]
    named: dict[str, Any] = {f"Axis {slot}": one["Axis"] for slot, one in enumerate(places, 1)}
    edges: dict[str, Any] = {f"Edge {slot}": one["Edge"] for slot, one in enumerate(places, 1)}
    gaps = graph.group(seen.gaps(), **named, **edges).outputs
    lobes = []
    for slot, one in enumerate(each, 1):
        more: dict[str, Any] = {"Random": random, "Step": aimed.step(slot), "Sky": enabled}
        more |= {name: one["To"] for name, one in zip(("Drawn", "Drawn Again"), directions, strict=True) if one}
        lobes.append(graph.group(lobe, **one, **more, Cone=surface["Cone"], Gap=gaps[f"Gap {slot}"]).outputs)
    for slot, aim in enumerate(lobes, 1):
        named |= {f"Aim {slot}": aim["Aim"], f"Cosine {slot}": aim["Cosine"]}
    return lobes, graph.group(seen.hits(), **named).outputs


def _mirrors(surface: Surface, drawn: Any, far: Value, outside: Value) -> Socket:
    """The mirror into the drawn direction, which passes by all lamps or is left to them in part.

    What a lamp leaves is asked near one alone, the albedos where they count: Cycles steps over what only another branch
    of a Mix Shader needs, and computes beforehand what two of them do.
    """
    graph = surface.graph

    def by_way(name: str) -> Socket:
        near = _mirror(surface, drawn, graph.product(drawn[name], outside))
        return surface.mixed(graph.for_cycles(far), near, _mirror(surface, drawn, drawn[name]))

    if surface.parts.albedo is None:
        return by_way("Weight")
    is_plain = graph.for_cycles(graph.math("GREATER_THAN", far, drawn["Special"]))  # a factor above 1 is 1
    return surface.mixed(is_plain, by_way("Finished"), _mirror(surface, drawn, drawn["Weight"]))


def _mirror(surface: Surface, drawn: Any, weight: Socket) -> Socket:
    """A mirror that looks into the drawn direction."""
    graph = surface.graph
    node = graph.add("ShaderNodeBsdfAnisotropic", distribution="GGX")
    weight = graph.for_cycles(graph.product(weight, 0.01))
    graph.put(node.inputs["Color"], graph.scaled(drawn["RGB"], weight))
    graph.put(node.inputs["Roughness"], 0.0)
    graph.put(node.inputs["Normal"], drawn["Half"])
    return node.outputs[0]


def by_engine(graph: Graph, cycles: Socket, eevee: Socket) -> list[bpy.types.Node]:
    """One closure in Cycles, another in EEVEE: the nodes, of which the last gives it.

    Cycles knows the factor 0 when it compiles and drops the branch with its images.
    """
    flag: Any = graph.in_eevee().node
    choice = graph.add("ShaderNodeMixShader", label="Cycles or EEVEE")
    for socket, value in zip(choice.inputs, (flag.outputs[0], cycles, eevee), strict=True):
        graph.put(socket, value)
    engine = flag.inputs[0].links[0].from_node
    return [engine.inputs[0].links[0].from_node, engine, flag, choice]
