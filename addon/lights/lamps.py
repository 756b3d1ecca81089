# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamp objects of a scene: which ones there are, and how each enters the list."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import bpy
from mathutils import Matrix, Vector

from . import chains
from .slots import KINDS, SLOTS
from .source import Drive, Entry, Source, Variable, follow

#: Area shapes by kind and the property that holds the extent along y.
_AREA_SHAPES = {
    "SQUARE": ("RECTANGLE", "size"),
    "RECTANGLE": ("RECTANGLE", "size_y"),
    "DISK": ("ELLIPSE", "size"),
    "ELLIPSE": ("ELLIPSE", "size_y"),
}


@dataclass(frozen=True)
class Lamp:
    """A lamp in world space with its light, for those who shade by themselves (the viewport).

    Parameters
    ----------
    name
        Of the object.
    kind
        A key of `slots.KINDS`.
    place
        Direction *to* a sun (any length), position of any other lamp in metres.
    axis_u, axis_v
        Axes of an area lamp, scaled as its object is.
    size
        Sun: (angle in radians, 0). Ball: (radius, 0). Area: extents along the axes. Metres.
    colour, energy
        As the light data say; W/m^2 for a sun, W for the others.
    type
        ``SUN``, ``POINT``, ``SPOT`` or ``AREA``.
    spot_angle, spot_blend, direction
        Full cone angle in radians, softness 0..1 and the unit vector along which a spot or area lamp shines.
    """

    name: str
    kind: str
    place: tuple[float, float, float]
    axis_u: tuple[float, float, float]
    axis_v: tuple[float, float, float]
    size: tuple[float, float]
    colour: tuple[float, float, float]
    energy: float
    type: str
    spot_angle: float
    spot_blend: float
    direction: tuple[float, float, float]


class InstancedLamp:
    """A lamp within collections that empties show (often linked from a library); used like an object.

    Parameters
    ----------
    lamp
        The object in the innermost collection.
    chain
        The empties, from the scene inwards.
    """

    def __init__(self, lamp: bpy.types.Object, chain: chains.Chain) -> None:
        self.lamp, self.chain = lamp, chain
        self.data, self.library = lamp.data, lamp.library
        self.name = ": ".join(each.name for each in (*chain, lamp))
        self.name_full = ": ".join(each.name_full for each in (*chain, lamp))

    @property
    def instancer(self) -> bpy.types.Object:
        """The empty of the scene's own."""
        return self.chain[0]

    def as_pointer(self) -> tuple[int, ...]:
        """Identity."""
        return tuple(each.as_pointer() for each in (*self.chain, self.lamp))

    @property
    def matrix_world(self) -> Matrix:
        """Where the instance stands."""
        return chains.world(self.chain, self.lamp)

    def evaluated_get(self, depsgraph: bpy.types.Depsgraph) -> InstancedLamp:
        """The same at the depsgraph's frame."""
        chain = tuple(each.evaluated_get(depsgraph) for each in self.chain)
        return InstancedLamp(self.lamp.evaluated_get(depsgraph), chain)


#: What `lamp_objects` gives.
LampObject = bpy.types.Object | InstancedLamp


def lamp_kind(light: bpy.types.Light) -> str:
    """The kind of a light's data."""
    if light.type == "AREA":
        return _AREA_SHAPES[light.shape][0]
    return "SUN" if light.type == "SUN" else "BALL"


def _size_paths(light: bpy.types.Light) -> tuple[str, ...]:
    if light.type == "AREA":
        return ("size", _AREA_SHAPES[light.shape][1])
    return ("angle",) if light.type == "SUN" else ("shadow_soft_size",)


def sizes(light: bpy.types.Light) -> tuple[float, ...]:
    """Sun: its angle. Ball: its radius. Area: its extents along x and y."""
    return tuple(getattr(light, path) for path in _size_paths(light))


def shows(ob: bpy.types.Object) -> bool:
    """Whether an object can take part in a render at some frame; an animated switch counts as on."""
    if not ob.hide_render:
        return True
    animation = ob.animation_data
    if animation is None:
        return False
    if any(curve.data_path == "hide_render" for curve in animation.drivers):
        return True
    return animation.action is not None


def is_portal(light: bpy.types.Light) -> bool:
    """Whether an area lamp only leads Cycles to the world: it shines not, the world does."""
    return light.type == "AREA" and getattr(getattr(light, "cycles", None), "is_portal", False)


def with_sets(scene: bpy.types.Scene) -> Iterator[bpy.types.Scene]:
    """A scene and those that it shows behind itself."""
    seen: set[bpy.types.Scene] = set()
    each: bpy.types.Scene | None = scene
    while each is not None and each not in seen:
        seen.add(each)
        yield each
        each = each.background_set


def lamp_objects(scene: bpy.types.Scene) -> list[LampObject]:
    """The lamps that may light a render of the scene, in a stable order (by name, local before linked).

    Those of its set scenes count, and those in collections that empties show, at any depth.
    """
    lamps = [lamp for lamp in _all(scene) if _in_render(lamp)]
    return sorted(lamps, key=lambda lamp: (lamp.library is not None, lamp.name_full))


def switched_off(scene: bpy.types.Scene) -> list[LampObject]:
    """Lamps that do not show in renders now: a script may switch them on, so they get slots that are left."""
    lamps = [lamp for lamp in _all(scene) if not _in_render(lamp)]
    return sorted(lamps, key=lambda lamp: (lamp.library is not None, lamp.name_full))


def _in_render(lamp: LampObject) -> bool:
    return all(shows(ob) for ob in (*getattr(lamp, "chain", ()), getattr(lamp, "lamp", lamp)))


def _all(scene: bpy.types.Scene) -> Iterator[LampObject]:
    objects = {}
    for each in with_sets(scene):
        for layer in each.view_layers:
            for ob in layer.objects:
                if ob.type == "LIGHT" or (ob.type == "EMPTY" and ob.instance_type == "COLLECTION"):
                    objects[ob.as_pointer()] = ob
    for ob in objects.values():
        if ob.type == "LIGHT":
            if not is_portal(ob.data):
                yield ob
        else:
            yield from _shown_by((ob,))


def _shown_by(chain: chains.Chain) -> Iterator[InstancedLamp]:
    collection = chain[-1].instance_collection
    if collection is None:
        return
    for ob in collection.all_objects:
        if ob.type == "LIGHT" and not is_portal(ob.data):
            yield InstancedLamp(ob, chain)
        elif ob.type == "EMPTY" and ob.instance_type == "COLLECTION" and ob not in chain:
            yield from _shown_by((*chain, ob))


def scene_lamps(depsgraph: bpy.types.Depsgraph) -> list[Lamp]:
    """The lamps of an evaluated scene, at most `SLOTS`, in the order of `lamp_objects`."""
    scene = depsgraph.scene.original if hasattr(depsgraph.scene, "original") else depsgraph.scene
    return [describe(lamp.evaluated_get(depsgraph)) for lamp in lamp_objects(scene)[:SLOTS]]


def describe(lamp: LampObject) -> Lamp:
    """An evaluated lamp with its light."""
    light, world = lamp.data, lamp.matrix_world
    size = [getattr(light, path) for path in _size_paths(light)] + [0.0]
    spot = light.type == "SPOT"
    colour = tuple(light.color)
    if getattr(light, "use_temperature", False):
        colour = tuple(c * t for c, t in zip(colour, light.temperature_color, strict=True))
    return Lamp(
        name=lamp.name,
        kind=lamp_kind(light),
        place=tuple(world.col[2][:3]) if light.type == "SUN" else tuple(world.translation),
        axis_u=tuple(world.col[0][:3]),
        axis_v=tuple(world.col[1][:3]),
        size=(size[0], size[1]),
        colour=colour,
        energy=light.energy * 2.0 ** getattr(light, "exposure", 0.0),
        type=light.type,
        spot_angle=light.spot_size if spot else 0.0,
        spot_blend=light.spot_blend if spot else 0.0,
        direction=tuple(-world.col[2].xyz.normalized()),
    )


def source(scene: bpy.types.Scene, lamp: LampObject) -> Source:
    """A lamp as an entry of the scene's list."""
    chain, light = getattr(lamp, "chain", ()), lamp.data
    ob = lamp.lamp if isinstance(lamp, InstancedLamp) else lamp
    kind, uneven = lamp_kind(light), is_uneven(light)
    sizes = [Variable("s", light, path) for path in _size_paths(light)]
    place = chains.column_of(scene, chain, ob, 2 if kind == "SUN" else 3)
    u: tuple[Entry, ...] = (0.0, 0.0, 0.0)
    v: tuple[Entry, ...] = (0.0, 0.0, 0.0)
    size: Entry = follow(light, _size_paths(light)[0])
    if light.type == "AREA":
        u, v = (chains.column_of(scene, chain, ob, column, sizes[column]) for column in (0, 1))
        size = follow(light, "spread")
    hidden = [Variable(f"h{i}", each, "hide_render") for i, each in enumerate((*chain, ob))]
    switch = Drive(tuple(hidden), "*".join([str(KINDS[kind]), *(f"(1-{each.name})" for each in hidden)]))
    shape = light.name_full, light.type, getattr(light, "shape", ""), uneven
    moved = tuple(tuple(chains.offset(each)) for each in chain)
    return Source(
        key=(lamp.as_pointer(), lamp.name_full, moved, *shape),
        name=lamp.name,
        kind=kind,
        entries=(*place, switch, *u, size, *v, float(uneven)),
        frames=chains.frames(scene, chain),
    )


def is_uneven(light: bpy.types.Light) -> bool:
    """Whether a light's nodes make it shine unevenly: anything linked to colour or strength may."""
    tree = light.node_tree if bpy.app.version >= (5, 0) or light.use_nodes else None
    if tree is None:
        return False
    output = tree.get_output_node("ALL") if hasattr(tree, "get_output_node") else None
    links = output.inputs["Surface"].links if output is not None else ()
    if not links:
        return False
    node = links[0].from_node
    return node.bl_idname != "ShaderNodeEmission" or any(socket.links for socket in node.inputs)


def power_at(light: bpy.types.Light, world: Matrix) -> float:
    """Irradiance at the origin by a lamp that the depsgraph made, as `irradiance` gives it for objects."""
    power = light.energy * 2.0 ** getattr(light, "exposure", 0.0) * sum(light.color[i] for i in range(3)) / 3.0
    if light.type == "SUN":
        return power
    sphere = 1.0 if light.type == "AREA" else 4.0 * math.pi
    return power / (math.pi * sphere * max(world.translation.length_squared, 1e-6))


def irradiance(lamp: LampObject, point: Vector) -> float:
    """About what a lamp sheds on a place, W/m^2 (luminance of its colour, shadows left out)."""
    seen = describe(lamp)
    power = seen.energy * (0.2126 * seen.colour[0] + 0.7152 * seen.colour[1] + 0.0722 * seen.colour[2])
    if seen.kind == "SUN":
        return power
    to = point - lamp.matrix_world.translation
    distance2 = max(to.length_squared, 1e-6)
    cosine = to.normalized().dot(lamp.matrix_world.col[2].xyz.normalized()) * -1.0
    if seen.type == "AREA":
        return power * max(cosine, 0.0) / (math.pi * distance2)
    if seen.type == "SPOT" and cosine < math.cos(0.5 * seen.spot_angle):
        return 0.0
    return power / (4.0 * math.pi**2 * distance2)
