# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of nodes that are animated, for drivers of the scene to follow without asking the nodes.

Blender's depsgraph relates what a node's sockets hold, but none of a node's own settings: a driver that reads one of
them is told so on the console each time that the depsgraph is built, and may come a frame late. So the scene gets a
copy of the setting's own curve or driver: a driver's curve maps what the driver gives, and one that gives the frame
brings any F-curve, its handles and modifiers, to where it is wanted.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from typing import Any

import bpy

from .source import Drive

#: Properties that Blender keeps itself.
_KEPT = {"rna_type", "is_valid", "control_points", "active", "select_control_point"}


@dataclass(frozen=True)
class Copied(Drive):
    """A number that moves as a setting does, by a copy of its F-curve or driver.

    Parameters
    ----------
    curve
        Of the setting; read when the copy is made, and not after.
    now
        What the setting is at this frame.
    """

    curve: Any = None
    now: float = 0.0

    def value(self) -> float:
        """As the setting is now."""
        return self.now

    def onto(self, made: bpy.types.FCurve) -> None:
        """Fill the curve of a new driver."""
        driver: Any = made.driver
        if self.curve.driver is None:
            driver.type, driver.expression = "SCRIPTED", "frame"
        else:
            _copy_driver(self.curve.driver, driver)
        made.keyframe_points.clear()
        for modifier in list(made.modifiers):
            made.modifiers.remove(modifier)
        made.keyframe_points.add(len(self.curve.keyframe_points))
        for old, new in zip(self.curve.keyframe_points, made.keyframe_points, strict=True):
            for name in ("handle_left_type", "handle_right_type"):
                setattr(new, name, getattr(old, name))
            for name in ("co", "handle_left", "handle_right", *_OF_KEYS):
                setattr(new, name, getattr(old, name))
        made.extrapolation, made.auto_smoothing = self.curve.extrapolation, self.curve.auto_smoothing
        for modifier in self.curve.modifiers:
            _copy_modifier(modifier, made.modifiers.new(modifier.type))
        made.update()


#: What a key has beside its place.
_OF_KEYS = ("interpolation", "easing", "back", "amplitude", "period")


def _settings(struct: Any) -> Iterator[tuple[str, Any]]:
    """Settings of a modifier, variable or target that can be set, in Blender's order."""
    for each in struct.bl_rna.properties:
        if not each.is_readonly and each.identifier not in _KEPT and each.type != "COLLECTION":
            value = getattr(struct, each.identifier)
            yield each.identifier, tuple(value) if getattr(each, "is_array", False) else value


def _copy_modifier(old: Any, new: Any) -> None:
    for name, value in _settings(old):
        setattr(new, name, value)
    for point in getattr(old, "control_points", ()):
        other = new.control_points.add(point.frame)
        other.min, other.max = point.min, point.max


def _copy_driver(old: Any, new: Any) -> None:
    new.type, new.use_self = old.type, old.use_self
    for each in old.variables:
        variable = new.variables.new()
        variable.name, variable.type = each.name, each.type
        for of_old, of_new in zip(each.targets, variable.targets, strict=True):
            found = dict(_settings(of_old))
            if each.type == "SINGLE_PROP":
                of_new.id_type = found["id_type"]
            for name, value in found.items():
                if name != "id_type":
                    setattr(of_new, name, value)
    new.expression = old.expression


def signature(curve: Any) -> Hashable:
    """All that decides the numbers of a curve or driver."""
    keys = tuple(
        (*key.co, *key.handle_left, *key.handle_right, *(getattr(key, name) for name in _OF_KEYS))
        for key in curve.keyframe_points
    )
    modifiers = tuple(
        (each.type, *_settings(each), *((p.frame, p.min, p.max) for p in getattr(each, "control_points", ())))
        for each in curve.modifiers
    )
    if curve.driver is None:
        return keys, curve.extrapolation, modifiers
    told: Any = curve.driver
    variables = tuple(
        (each.name, each.type, *((name, str(value)) for target in each.targets for name, value in _settings(target)))
        for each in told.variables
    )
    return keys, curve.extrapolation, modifiers, told.type, told.expression, told.use_self, variables


def curve_of(owner: Any, path: str) -> Any:
    """The F-curve or driver of a data-block's setting, None where it has none."""
    found = owner.animation_data
    if found is None:
        return None
    curves = [*found.drivers, *(curve for bag in bags(owner) for curve in bag.fcurves)]
    return next((curve for curve in curves if curve.data_path == path and not curve.mute), None)


def is_mixed(owner: Any) -> bool:
    """Whether strips or parts of an action move a data-block, which no single curve tells."""
    found = owner.animation_data
    if found is None:
        return False
    return bool(found.nla_tracks) or (
        found.action is not None and (found.action_influence != 1.0 or found.action_blend_type != "REPLACE")
    )


def bags(owner: Any) -> list[bpy.types.ActionChannelbag]:
    """Where an action holds the curves of a data-block."""
    animation = owner.animation_data
    if animation is None or animation.action is None or animation.action_slot is None:
        return []
    found = []
    for layer in animation.action.layers:
        for strip in layer.strips:
            bag = strip.channelbag(animation.action_slot) if isinstance(strip, bpy.types.ActionKeyframeStrip) else None
            if bag is not None:
                found.append(bag)
    return found
