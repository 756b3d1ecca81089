# SPDX-License-Identifier: GPL-3.0-or-later
"""The material: it has a node *Diffraction*, whose group (`node.group`) renders a spectral table."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeGuard

import bpy

from ...precompute.errors import ParameterError, TableError
from ...precompute.table import importance
from ...precompute.table.layout import TableLayout
from ...precompute.table.table import read_sidecar
from .. import paths
from ..tables import table_image
from ..versions import give_nodes, tells_mirrored_uv
from . import osl, pigment, setup, travel
from .node import eevee_output, frame, group, keys
from .node.group import NODE
from .scales.wire import wire as wire_scales

#: Sockets that an artist turns while looking.
LIVE_SOCKETS = ("Brightness", "IOR", "Rotation", "Scale", "Depth", "Environment", "DiffuseLimit", "Cone")

#: Pigment under a material that had no shader of its own: the colours show over a dark ground only.
DARK = (0.012, 0.010, 0.009, 1.0)


@dataclass(frozen=True)
class Settings:
    """What an artist chooses for a material.

    Parameters
    ----------
    implementation
        ``OSL`` (Cycles on CPU and OptiX; lamps and environment) or ``NODES`` (Cycles on any device and
        EEVEE, which shows four lamps by their middle; packed into the .blend).
    fresnel
        ``NONE`` (R = 1), ``DIELECTRIC`` (exact, by ``ior``), ``SCHLICK`` (its approximation, that of the thesis and of
        0.1.0) or ``CONDUCTOR`` (exact, by n and k of red, green and blue).
    ior
        Index of refraction of the dielectric.
    conserve_energy
        Divide f by the albedo where that passes 1.
    orientation
        Where the scan's x comes from: ``UV`` (tangent of a UV map), ``ATTRIBUTE`` (a vector attribute of
        the mesh, in object space), ``RADIAL`` (away from the object's z axis: discs) or ``TEXTURE``
        (UV tangent, turned by an image whose white is a whole turn).
    uv_map
        Name of the UV map; empty takes the active one.
    attribute
        Name of the vector attribute.
    angle_image
        Name of the image data-block of ``TEXTURE``.
    rotation
        Of the scan about the normal, radians.
    brightness
        Factor on the diffracted light.
    environment
        Random mirrors a sample that look into the environment; 0 leaves only lamps, more cost more and
        have less noise.
    """

    implementation: str = "OSL"
    fresnel: str = "DIELECTRIC"
    ior: float = 1.5
    conserve_energy: bool = True
    orientation: str = "UV"
    uv_map: str = ""
    attribute: str = ""
    angle_image: str = ""
    rotation: float = 0.0
    brightness: float = 1.0
    environment: int = 1


def is_ours(material: bpy.types.Material | None) -> TypeGuard[bpy.types.Material]:
    """Whether a material renders a table."""
    return material is not None and group.owner(material) is not None


def any_ours() -> bool:
    """Whether the file holds a material of ours; cheap enough for every update."""
    return any(keys.TABLE in tree for tree in bpy.data.node_groups) or any(keys.TABLE in m for m in bpy.data.materials)


def shader_node(material: bpy.types.Material) -> Any:
    """The node of a material that holds the sockets of the diffraction."""
    node = group.find(material.node_tree)
    if node is None and keys.TABLE in material and material.node_tree is not None:
        return material.node_tree.nodes.get(NODE)
    return node


def table_path(material: bpy.types.Material) -> Path:
    """Absolute path of a material's table."""
    known = group.owner(material)
    return paths.absolute(known[keys.TABLE], known.library)


def atlas_image(path: Path, content: str) -> bpy.types.Image:
    """The image data-block of a table's atlas, or of its image of directions.

    OSL reads the file by name; the data-block makes it known to Blender's path tools and to farm
    packers, and the fake user keeps it.

    Parameters
    ----------
    path
        The image's file.
    content
        Hash of the table.
    """
    for image in bpy.data.images:
        if image.library is None and paths.absolute(image.filepath) == path:
            table_image.bring_up_to_date(image, path, content)
            return image
        if image.library is None and image.packed_file is not None and travel.unpacked_place(image) == path:
            return image  # its file is a copy made from it
    return table_image.load(path, content)


def importance_image(path: Path, content: str) -> tuple[bpy.types.Image, float]:
    """The image that directs rays into the environment, beside the table, and the table's albedo-free cosine.

    A bake in Blender has made it; for tables from elsewhere it is made here.
    """
    target, albedo_free = importance.ensure_importance(path)
    return atlas_image(target, content), albedo_free


def apply(material: bpy.types.Material, table: str | Path, settings: Settings) -> bpy.types.Material:
    """Make a material diffract: a fresh one, one with a shader of its own (kept underneath), or one of ours.

    Of one of ours that has another table or implementation the node stays with its values, links, keys and drivers,
    and gets another group. Where the node's output is in use already, it stays wired as it is.

    Parameters
    ----------
    material
        Edited in place.
    table
        Path of the table's EXR.
    settings
        The artist's choice.

    Raises
    ------
    TableError
        If the table is missing or of another version.
    """
    tree = table_group(table, settings)
    give_nodes(material)
    node = shader_node(material)
    if node is None or node.bl_idname != "ShaderNodeGroup":
        node = material.node_tree.nodes.new("ShaderNodeGroup")
        node.name = node.label = NODE
        node.width = 200.0
    node.node_tree = tree
    _connect(node, settings)
    set_settings(node, settings)
    _hide_what_is_inside(node, table)
    setup.prepare_material(material)
    _colour_solid_view(material, node)
    return material


def _colour_solid_view(material: bpy.types.Material, node: bpy.types.Node) -> None:
    """Solid view shows the pigment, not Blender's light grey, over which no structural colour is seen; a colour that
    somebody chose stays."""
    colour = pigment.colour_of(node.inputs["Base"])
    if colour is not None and all(abs(c - 0.8) < 1e-6 for c in tuple(material.diffuse_color)[:3]):
        material.diffuse_color = (*colour, material.diffuse_color[3])


def table_group(table: str | Path, settings: Settings) -> bpy.types.NodeTree:
    """The node group of a table, for a node of one's own: ``node.node_tree = table_group(...)``.

    Parameters
    ----------
    table
        Path of the table's EXR.
    settings
        Of these the implementation, and for ``NODES`` Fresnel and conservation of energy, decide the group.

    Raises
    ------
    TableError
        If the table is missing or of another version.
    """
    steps = table_group_in_steps(table, settings)
    while True:
        try:
            next(steps)
        except StopIteration as end:
            made: bpy.types.NodeTree = end.value
            return made


def table_group_in_steps(table: str | Path, settings: Settings) -> Generator[None, None, bpy.types.NodeTree]:
    """`table_group` with rests, for a window that would stand still: a large table is packed, 1,800 nodes are made.

    What is there after a rest is whole; who stops there has only less of it.
    """
    path = paths.readable(paths.absolute(str(table)).with_suffix(".exr"))
    sidecar = read_sidecar(path)
    if not path.is_file():
        raise TableError(f"The table's atlas {path} does not exist; bake the scan again.")
    content, nodes = sidecar["atlas"]["sha256"], settings.implementation == "NODES"
    image = atlas_image(path, content)
    if nodes:
        _pack(image)
    yield
    directions, albedo_free = importance_image(path, content)
    if nodes:
        if directions.use_half_precision:
            directions.use_half_precision = False  # EEVEE would keep edges of a density in ten bits
        _pack(directions)
    yield
    tree = group.build(
        path.stem, settings.implementation, (image, directions), sidecar, settings.fresnel, settings.conserve_energy,
        albedo_free,
    )  # fmt: skip
    travel.note_scene_recipe(tree)
    travel.sync(tree)
    yield
    return tree


def _pack(image: bpy.types.Image) -> None:
    if image.packed_file is None:
        image.pack()


def set_table(material: bpy.types.Material, table: str | Path) -> None:
    """Let a material of ours render another table, or its own that was baked anew; all else stays as it is.

    Raises
    ------
    TableError
        If the table is missing or of another version.
    """
    tree = table_group(table, settings_of(material))
    shader_node(material).node_tree = tree
    _hide_what_is_inside(shader_node(material), table)


def _hide_what_is_inside(node: Any, table: str | Path) -> None:
    """Sockets that say what the table holds already (its stack, its lacquer), or what it has not, are not shown."""
    sidecar = read_sidecar(paths.absolute(str(table)).with_suffix(".exr"))
    layout = TableLayout.from_dict(sidecar["layout"])
    for name in ("Fresnel", "IOR", "ConductorN", "ConductorK"):
        node.inputs[name].hide = layout.holds_reflectance
    node.inputs["LacquerRoughness"].hide = layout.index == 1.0


def set_settings(node: bpy.types.Node, settings: Settings) -> None:
    """Write the artist's choice into the sockets."""
    node.inputs["Fresnel"].default_value = osl.FRESNEL[settings.fresnel]
    node.inputs["IOR"].default_value = settings.ior
    node.inputs["ConserveEnergy"].default_value = int(settings.conserve_energy)
    node.inputs["Brightness"].default_value = settings.brightness
    node.inputs["Environment"].default_value = settings.environment


def settings_of(material: bpy.types.Material) -> Settings:
    """The artist's choice, read back from the sockets."""
    inputs = shader_node(material).inputs
    names = {value: name for name, value in osl.FRESNEL.items()}
    nodes = shader_node(material).id_data.nodes
    tangent, picture = nodes.get(frame.TANGENT), nodes.get(frame.ANGLE_IMAGE)
    attribute = nodes.get(frame.ATTRIBUTE)
    orientation, turn = "UV", inputs["Rotation"].default_value
    if attribute is not None:
        orientation = "ATTRIBUTE"
    elif nodes.get(frame.AROUND) is not None or getattr(tangent, "direction_type", "") == "RADIAL":
        orientation, turn = "RADIAL", turn - frame.RADIAL_TURN
    elif picture is not None:
        orientation = "TEXTURE"
    return Settings(
        implementation="OSL" if needs_osl(material) else "NODES",
        fresnel=names.get(inputs["Fresnel"].default_value, "DIELECTRIC"),
        ior=inputs["IOR"].default_value,
        conserve_energy=bool(inputs["ConserveEnergy"].default_value),
        orientation=orientation,
        uv_map=getattr(tangent, "uv_map", ""),
        attribute=attribute.attribute_name if attribute is not None else "",
        angle_image=picture.image.name if picture is not None and picture.image is not None else "",
        rotation=turn,
        brightness=inputs["Brightness"].default_value,
        environment=inputs["Environment"].default_value,
    )


def of_file() -> list[bpy.types.Material]:
    """All materials of ours that are whole, linked ones too."""
    if not any_ours():
        return []
    return [m for m in bpy.data.materials if is_ours(m) and shader_node(m) is not None]


def our_materials() -> list[bpy.types.Material]:
    """Materials of ours that can be edited and are whole."""
    return [m for m in bpy.data.materials if m.is_editable and is_ours(m) and shader_node(m) is not None]


def needs_osl(material: bpy.types.Material) -> bool:
    """Whether a material is of the OSL implementation."""
    known = group.owner(material)
    if isinstance(known, bpy.types.Material):  # of version 0.1.0
        return shader_node(material).bl_idname == "ShaderNodeScript"
    return known[keys.IMPLEMENTATION] == "OSL"


def _surface_output(tree: bpy.types.NodeTree, target: str) -> bpy.types.Node:
    """The output node of a renderer; one is made where there is none."""
    output = tree.get_output_node(target) or tree.get_output_node("ALL")
    return output if output is not None else tree.nodes.new("ShaderNodeOutputMaterial")


def _connect(node: Any, settings: Settings) -> None:
    """Put the node between a shader that is there and the output; one that is in use stays where it is."""
    tree: Any = node.id_data
    if not node.outputs["BSDF"].links:
        output = _surface_output(tree, "CYCLES")
        surface = output.inputs["Surface"]
        base = surface.links[0].from_socket if surface.links else None
        if base is not None:
            node.location = (output.location.x - 20.0, output.location.y)
            output.location.x += 280.0
            tree.links.new(base, node.inputs["Base"])
        else:
            node.location, output.location = (0.0, 200.0), (280.0, 200.0)
        tree.links.new(node.outputs["BSDF"], surface)
    if not node.inputs["Base"].links:
        dark = tree.nodes.new("ShaderNodeBsdfDiffuse")
        dark.name = dark.label = "Pigment"
        dark.inputs["Color"].default_value = DARK
        dark.location = (node.location.x - 240.0, node.location.y)
        tree.links.new(dark.outputs["BSDF"], node.inputs["Base"])
    eevee_output.connect(tree, node, settings.implementation == "NODES")
    _take_over(tree, node)
    _orient(tree, node, settings)
    wire_scales(tree)


def _take_over(tree: bpy.types.NodeTree, node: bpy.types.Node) -> None:
    """Bump, normal maps and transparency of the pigment count for the diffraction too; what the user linked stays."""
    base, normal, mask = (node.inputs[name] for name in ("Base", "Normal", "Mask"))
    if not base.links:
        return
    if not normal.links:
        found = pigment.normal_of(base)
        if found is not None:
            tree.links.new(found, normal)
    if not mask.links or mask.links[0].from_node.get(pigment.OURS) == pigment.ALPHA:
        pigment.remove_alpha(tree)
        alpha = pigment.alpha_of(base)
        if isinstance(alpha, bpy.types.NodeSocket):
            tree.links.new(alpha, mask)
        elif alpha < 1.0:  # an opaque shader leaves the mask that the user set
            mask.default_value = alpha


def _orient(tree: bpy.types.NodeTree, node: bpy.types.Node, settings: Settings) -> None:
    """Nodes that say how the scan lies on the surface; those of an earlier choice go."""
    for old in [n for n in tree.nodes if n.name in frame.NAMES]:
        tree.nodes.remove(old)
    at = (node.location.x - 280.0, node.location.y - 200.0)
    turn = settings.rotation
    tangent = bitangent = handedness = None
    if settings.orientation == "ATTRIBUTE":
        tangent, _ = frame.attribute_frame(tree, settings.attribute, at)
    elif settings.orientation == "RADIAL":
        tangent, _ = frame.radial_frame(tree, at)
        turn += frame.RADIAL_TURN
    elif settings.uv_map and needs_handedness(node):
        tangent, handedness = frame.uv_directions(tree, settings.uv_map, at)
    elif settings.uv_map:
        tangent, bitangent = frame.uv_frame(tree, settings.uv_map, at)
    for socket, name in ((tangent, "Tangent"), (bitangent, "Bitangent"), (handedness, "Handedness")):
        if socket is not None:
            tree.links.new(socket, node.inputs[name])
    is_direction = settings.orientation in {"ATTRIBUTE", "RADIAL"} or handedness is not None
    node.inputs["TangentIsDirection"].default_value = int(is_direction)
    node.inputs["Rotation"].default_value = turn
    if settings.orientation == "TEXTURE":
        image = bpy.data.images.get(settings.angle_image)
        if image is None:
            raise ParameterError(f"There is no image '{settings.angle_image}'; load the image of the angles first.")
        angle = frame.angle_image(tree, image, turn, (at[0], at[1] - 400.0))
        tree.links.new(angle, node.inputs["Rotation"])


def needs_handedness(node: Any) -> bool:
    """Whether a node takes a direction and the sign of mirrored UV maps, rather than two vectors of normal maps."""
    return node.node_tree[keys.IMPLEMENTATION] == "OSL" and tells_mirrored_uv()
