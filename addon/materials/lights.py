# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene's lamps: which ones there are, where they stand, and the drivers that make a material follow them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
from mathutils import Matrix, Vector

from .osl import LAMP_KINDS, LAMPS_MAX

#: Area shapes by the lamp kind of the shader and the property that holds the extent along y.
_AREA_SHAPES = {
    "SQUARE": ("RECTANGLE", "size"),
    "RECTANGLE": ("RECTANGLE", "size_y"),
    "DISK": ("ELLIPSE", "size"),
    "ELLIPSE": ("ELLIPSE", "size_y"),
}


@dataclass(frozen=True)
class Lamp:
    """A lamp as the shaders see it, in world space.

    Parameters
    ----------
    name
        Of the object.
    kind
        A key of ``LAMP_KINDS``.
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


def lamp_kind(light: bpy.types.Light) -> str:
    """The kind of a light's data for the shaders."""
    if light.type == "AREA":
        return _AREA_SHAPES[light.shape][0]
    return "SUN" if light.type == "SUN" else "BALL"


def _size_paths(light: bpy.types.Light) -> tuple[str, ...]:
    if light.type == "AREA":
        return ("size", _AREA_SHAPES[light.shape][1])
    return ("angle",) if light.type == "SUN" else ("shadow_soft_size",)


def _shows(lamp: bpy.types.Object) -> bool:
    """Whether a lamp can light a render at some frame; an animated switch counts as on."""
    if not lamp.hide_render:
        return True
    animation = lamp.animation_data
    if animation is None:
        return False
    if any(curve.data_path == "hide_render" for curve in animation.drivers):
        return True
    return animation.action is not None


class InstancedLamp:
    """A lamp within a collection that an empty shows (often one linked from a library); used like an object.

    Parameters
    ----------
    lamp
        The object in the collection.
    instancer
        The empty.
    """

    def __init__(self, lamp: bpy.types.Object, instancer: bpy.types.Object) -> None:
        self.lamp, self.instancer = lamp, instancer
        self.data, self.library = lamp.data, lamp.library
        self.name, self.name_full = f"{instancer.name}: {lamp.name}", f"{instancer.name_full}: {lamp.name_full}"

    def as_pointer(self) -> tuple[int, int]:
        """Identity."""
        return self.lamp.as_pointer(), self.instancer.as_pointer()

    @property
    def matrix_world(self) -> Matrix:
        """Where the instance stands."""
        collection = self.instancer.instance_collection
        assert collection is not None  # `lamp_objects` found the lamp in it
        offset = Matrix.Translation(-Vector(collection.instance_offset))
        return self.instancer.matrix_world @ offset @ self.lamp.matrix_world

    def evaluated_get(self, depsgraph: bpy.types.Depsgraph) -> InstancedLamp:
        """The same at the depsgraph's frame."""
        return InstancedLamp(self.lamp.evaluated_get(depsgraph), self.instancer.evaluated_get(depsgraph))


#: A lamp, or one in a collection that an empty shows.
LampObject = bpy.types.Object | InstancedLamp


def lamp_objects(scene: bpy.types.Scene) -> list[LampObject]:
    """The lamps that may light a render of the scene, in a stable order (by name, local before linked).

    Those in collections that empties show count too, one level deep.
    """
    objects = {ob for layer in scene.view_layers for ob in layer.objects if _shows(ob)}
    lamps: list[LampObject] = [ob for ob in objects if ob.type == "LIGHT"]
    for ob in objects:
        if ob.instance_type == "COLLECTION" and ob.instance_collection is not None:
            inside = ob.instance_collection.all_objects
            lamps += [InstancedLamp(lamp, ob) for lamp in inside if lamp.type == "LIGHT" and _shows(lamp)]
    return sorted(lamps, key=lambda lamp: (lamp.library is not None, lamp.name_full))


def scene_lamps(depsgraph: bpy.types.Depsgraph) -> list[Lamp]:
    """The lamps of an evaluated scene, at most `LAMPS_MAX`, in the order of `lamp_objects`."""
    scene = depsgraph.scene.original if hasattr(depsgraph.scene, "original") else depsgraph.scene
    return [describe(lamp.evaluated_get(depsgraph)) for lamp in lamp_objects(scene)[:LAMPS_MAX]]


def describe(lamp: LampObject) -> Lamp:
    """A lamp object as the shaders see it."""
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


def signature(scene: bpy.types.Scene) -> tuple:
    """What decides the sockets and drivers of `bind`; where it stays the same, nothing need be done."""
    return tuple((lamp.as_pointer(), lamp.name_full, *_shape_of(lamp.data)) for lamp in lamp_objects(scene))


def _shape_of(light: bpy.types.Light) -> tuple:
    return light.name_full, light.type, getattr(light, "shape", "")


def too_many(lamps: Sequence[LampObject], limit: int = LAMPS_MAX) -> str:
    """The warning for more lamps than a material can follow."""
    left_out = ", ".join(lamp.name for lamp in lamps[limit:][:3])
    return f"{len(lamps)} lamps, but a material follows {limit}: {left_out} and further ones are not diffracted"


def bind(node: bpy.types.Node, lamps: Sequence[LampObject]) -> None:
    """Make the lamp sockets of a shader node or group follow the lamps.

    Drivers copy single values (type SUM, no expression) or use a simple expression, so that they run
    with scripts switched off and without this add-on.

    Parameters
    ----------
    node
        A node with the sockets ``Lamp1Kind`` ... of ``shaders/diffraction.osl``.
    lamps
        As many are taken as the node has sockets for.
    """
    for number in range(1, LAMPS_MAX + 1):
        prefix = f"Lamp{number}"
        if prefix + "Kind" not in node.inputs:
            break
        for name in ("Place", "AxisU", "AxisV", "Size"):
            node.inputs[prefix + name].driver_remove("default_value")
        if number > len(lamps):
            node.inputs[prefix + "Kind"].default_value = LAMP_KINDS["NONE"]
            continue
        lamp = lamps[number - 1]
        node.inputs[prefix + "Kind"].default_value = LAMP_KINDS[lamp_kind(lamp.data)]
        sun = lamp.data.type == "SUN"
        columns = {"Place": 2 if sun else 3}
        if lamp.data.type == "AREA":
            columns |= {"AxisU": 0, "AxisV": 1}
        for name, column in columns.items():
            for axis in range(3):
                _follow(node.inputs[prefix + name], axis, lamp, column)
        node.inputs[prefix + "Size"].default_value = (0.0, 0.0, 0.0)
        for axis, path in enumerate(_size_paths(lamp.data)):
            _copy(node.inputs[prefix + "Size"], axis, lamp.data, path)


def _follow(socket: bpy.types.NodeSocket, axis: int, lamp: LampObject, column: int) -> None:
    """One component of a column of a lamp's world matrix."""
    if not isinstance(lamp, InstancedLamp):
        _copy(socket, axis, lamp, f"matrix_world[{column}][{axis}]")
        return
    # A row of the empty's matrix times the column of the lamp's: an expression simple enough to run without Python.
    driver = socket.driver_add("default_value", axis).driver
    driver.type = "SCRIPTED"
    collection = lamp.instancer.instance_collection
    offset = collection.instance_offset if column == 3 and collection is not None else (0.0, 0.0, 0.0)
    terms = []
    for k, shift in enumerate(offset):
        _variable(driver, lamp.instancer, f"matrix_world[{k}][{axis}]", f"e{k}")
        _variable(driver, lamp.lamp, f"matrix_world[{column}][{k}]", f"m{k}")
        terms.append(f"e{k}*(m{k}-({shift:.7g}))")
    if column == 3:
        _variable(driver, lamp.instancer, f"matrix_world[3][{axis}]", "e3")
        terms.append("e3")
    driver.expression = "+".join(terms)


def _copy(socket: bpy.types.NodeSocket, index: int, owner: bpy.types.ID, path: str) -> None:
    driver = socket.driver_add("default_value", index).driver
    driver.type = "SUM"
    _variable(driver, owner, path, "value")


def _variable(driver: bpy.types.Driver, owner: bpy.types.ID, path: str, name: str) -> None:
    variable = driver.variables.new()
    variable.name = name
    variable.type = "SINGLE_PROP"
    target = variable.targets[0]
    if isinstance(owner, bpy.types.Light):
        target.id_type = "LIGHT"
    target.id = owner
    target.data_path = path
