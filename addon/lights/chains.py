# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a lamp stands that collections bring, which empties show, at any depth: matrices, and drivers that follow."""

from __future__ import annotations

import zlib

import bpy
from mathutils import Matrix, Vector

from . import slots
from .source import Drive, Entry, Variable, follow

#: Empties that show collections, from the scene inwards.
Chain = tuple[bpy.types.Object, ...]


def offset(instancer: bpy.types.Object) -> Vector:
    """What an instance is moved by before its empty's matrix applies."""
    collection = instancer.instance_collection
    return -Vector(collection.instance_offset if collection is not None else (0.0, 0.0, 0.0))


def world(chain: Chain, ob: bpy.types.Object) -> Matrix:
    """World matrix of an object within a chain of empties."""
    matrix = Matrix.Identity(4)
    for instancer in chain:
        matrix = matrix @ instancer.matrix_world @ Matrix.Translation(offset(instancer))
    return matrix @ ob.matrix_world


def frame_name(chain: Chain) -> str:
    """The scene's property that holds the matrix of a chain's last empty."""
    text = "|".join(each.name_full for each in chain)
    return f"{slots.FRAME}{zlib.crc32(text.encode()):08x}"


def frames(scene: bpy.types.Scene, chain: Chain) -> dict[str, tuple[Entry, ...]]:
    """Entries of the properties that a chain needs: none for one empty, whose own matrix serves."""
    found: dict[str, tuple[Entry, ...]] = {}
    for length in range(2, len(chain) + 1):
        above, empty = chain[: length - 1], chain[length - 1]
        rows = [column_of(scene, above, empty, column) for column in range(4)]
        found[frame_name(chain[:length])] = tuple(rows[column][axis] for axis in range(3) for column in range(4))
    return found


def column_of(
    scene: bpy.types.Scene, chain: Chain, ob: bpy.types.Object, column: int, half: Variable | None = None
) -> tuple[Drive, ...]:
    """A column of an object's world matrix, within a chain of empties or free.

    Parameters
    ----------
    column
        0 to 2 an axis as long as it is scaled, 3 the place.
    half
        A number by half of which to multiply.
    """
    front, more = ("0.5*s*", (half,)) if half is not None else ("", ())
    if not chain:
        if half is None:
            return tuple(follow(ob, f"matrix_world[{column}][{axis}]") for axis in range(3))
        return tuple(
            Drive((*more, Variable("m", ob, f"matrix_world[{column}][{axis}]")), front + "m") for axis in range(3)
        )
    move = offset(chain[-1]) if column == 3 else Vector((0.0, 0.0, 0.0))
    drives = []
    for axis in range(3):
        variables, terms = list(more), []
        for k in range(3):
            variables.append(_outer(scene, chain, k, axis, f"e{k}"))
            variables.append(Variable(f"m{k}", ob, f"matrix_world[{column}][{k}]"))
            terms.append(f"e{k}*(m{k}+({move[k]:.7g}))" if column == 3 else f"e{k}*m{k}")
        if column == 3:
            variables.append(_outer(scene, chain, 3, axis, "e3"))
            terms.append("e3")
        drives.append(Drive(tuple(variables), front + "(" + "+".join(terms) + ")"))
    return tuple(drives)


def _outer(scene: bpy.types.Scene, chain: Chain, column: int, axis: int, name: str) -> Variable:
    """One number of the world matrix of a chain's last empty."""
    if len(chain) == 1:
        return Variable(name, chain[0], f"matrix_world[{column}][{axis}]")
    return Variable(name, scene, f'["{frame_name(chain)}"][{4 * axis + column}]')
