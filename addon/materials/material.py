# SPDX-License-Identifier: GPL-3.0-or-later
"""The material: node trees that render a spectral table."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeGuard

import bpy

from ...precompute.errors import ParameterError, TableError
from ...precompute.light.colour import table_light, xyz_to_rgb_matrix
from ...precompute.light.illuminant import to_json
from ...precompute.table import importance
from ...precompute.table.layout import TableLayout
from ...precompute.table.table import SpectralTable, read_sidecar
from .. import colour_spaces, paths
from ..colour_spaces import working_space
from ..versions import give_nodes, tells_mirrored_uv
from . import frame, lights, nodes_twin, osl, script_node, setup, travel

#: Name of the node that holds a material's diffraction.
NODE = "Diffraction"

#: Custom property of a material of ours: path of its table.
TABLE_KEY = "diffraction_table"

#: Name of the second output node of materials without OSL.
EEVEE_OUTPUT = "EEVEE Output"

#: Sockets that an artist turns while looking.
LIVE_SOCKETS = ("Brightness", "IOR", "Rotation", "Environment", "DiffuseLimit", "Cone")

#: Pigment under a material that had no shader of its own: the colours show over a dark ground only.
DARK = (0.012, 0.010, 0.009, 1.0)


@dataclass(frozen=True)
class Settings:
    """What an artist chooses for a material.

    Parameters
    ----------
    implementation
        ``OSL`` (Cycles on CPU and OptiX; lamps and environment) or ``NODES`` (Cycles on any device and
        EEVEE; up to 8 lamps by their middle, no environment; packed into the .blend).
    fresnel
        ``NONE`` (R = 1), ``DIELECTRIC`` (Schlick) or ``CONDUCTOR``.
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
    return material is not None and TABLE_KEY in material


def any_ours() -> bool:
    """Whether the file holds a material of ours; cheap enough for every update."""
    return any(TABLE_KEY in material for material in bpy.data.materials)


def shader_node(material: bpy.types.Material) -> Any:
    """The node of a material that holds the sockets of the diffraction; None where there is none."""
    return material.node_tree.nodes.get(NODE) if material.node_tree else None


def table_path(material: bpy.types.Material) -> Path:
    """Absolute path of a material's table."""
    return paths.absolute(material[TABLE_KEY], material.library)


def atlas_image(path: Path) -> bpy.types.Image:
    """The image data-block of a table's atlas.

    OSL reads the file by name; the data-block makes it known to Blender's path tools and to farm
    packers, and the fake user keeps it.
    """
    for image in bpy.data.images:
        if image.library is None and paths.absolute(image.filepath) == path:
            if image.packed_file is not None:
                image.unpack(method="REMOVE")  # a packed image would reload its old self
            image.reload()
            break
        if image.library is None and image.packed_file is not None and travel.unpacked_place(image) == path:
            return image  # its file is a copy made from it
    else:
        image = bpy.data.images.load(str(path), check_existing=False)
    image.name = path.stem
    colour_spaces.set_data(image)
    image.alpha_mode = "NONE"
    image.use_fake_user = True
    image.filepath = paths.relative(path)
    return image


def importance_image(path: Path, atlas_sha256: str) -> tuple[bpy.types.Image, float]:
    """The image that directs rays into the environment, beside the table, and the table's albedo-free cosine.

    Made anew for a new table, or where it is of an older version.
    """
    target = path.with_name(f"{path.stem}.importance.exr")
    origin = importance.read_origin(target)
    if origin is None or origin[0] != atlas_sha256:
        table = SpectralTable.load(path)
        origin = (atlas_sha256, importance.albedo_free_cosine(table))
        importance.save_importance(importance.importance(table).image(), target, *origin)
    return atlas_image(target), origin[1]


def apply(
    material: bpy.types.Material, table: str | Path, settings: Settings, lamps: Sequence[lights.LampObject]
) -> bpy.types.Material:
    """Make a material diffract: a fresh one, one with a shader of its own (kept underneath), or one of ours.

    Parameters
    ----------
    material
        Edited in place.
    table
        Path of the table's EXR.
    settings
        The artist's choice.
    lamps
        Lamp objects to follow.

    Raises
    ------
    TableError
        If the table is missing or of another version.
    """
    path = paths.absolute(str(table)).with_suffix(".exr")
    sidecar = read_sidecar(path)
    if not path.is_file():
        raise TableError(f"The table's atlas {path} does not exist; bake the scan again.")
    layout = TableLayout.from_dict(sidecar["layout"])
    image = atlas_image(path)
    give_nodes(material)

    directions = None
    albedo_max = float(sidecar["albedo_max"])
    kind = "ShaderNodeScript" if settings.implementation == "OSL" else "ShaderNodeGroup"
    node = _place_node(material, kind)
    if settings.implementation == "OSL":
        directions, albedo_free = importance_image(path, sidecar["atlas"]["sha256"])
        script_node.fill(node, _source_text(path.stem, osl.source(layout, albedo_max, albedo_free=albedo_free)))
        node.inputs["Atlas"].default_value = image.filepath
        node.inputs["Importance"].default_value = directions.filepath
    else:
        image.pack()
        node.node_tree = nodes_twin.build(
            material.name, image, layout, albedo_max, settings.fresnel, settings.conserve_energy, lamps
        )
    node.label = f"Diffraction: {path.stem}"
    _connect(material, node, settings)
    set_settings(node, settings)
    for name in ("Fresnel", "IOR", "ConductorN", "ConductorK"):  # the table holds what they would say
        node.inputs[name].hide = layout.holds_reflectance
    node.inputs["LacquerRoughness"].hide = layout.index == 1.0
    light = table_light(sidecar["colour"])
    set_working_space(node, light)
    lights.bind(node, lamps)

    material[TABLE_KEY] = image.filepath
    travel.attach(material, image, directions, sidecar["atlas"]["sha256"])
    travel.sync(material)
    material["diffraction_illuminant"] = light if isinstance(light, str) else json.dumps(to_json(light))
    setup.prepare_material(material)
    return material


def set_settings(node: bpy.types.Node, settings: Settings) -> None:
    """Write the artist's choice into the sockets."""
    node.inputs["Fresnel"].default_value = osl.FRESNEL[settings.fresnel]
    node.inputs["IOR"].default_value = settings.ior
    node.inputs["ConserveEnergy"].default_value = int(settings.conserve_energy)
    node.inputs["Brightness"].default_value = settings.brightness
    node.inputs["Environment"].default_value = settings.environment


def set_working_space(node: bpy.types.Node, illuminant: Any) -> None:
    """Write the matrix from XYZ to the working space of the file into the sockets.

    ``illuminant`` is the sidecar's entry, or its JSON text.
    """
    matrix = xyz_to_rgb_matrix(working_space(), illuminant)
    for name, row in zip(("ToRed", "ToGreen", "ToBlue"), matrix, strict=True):
        node.inputs[name].default_value = [float(x) for x in row]


def settings_of(material: bpy.types.Material) -> Settings:
    """The artist's choice, read back from the sockets."""
    inputs = shader_node(material).inputs
    names = {value: name for name, value in osl.FRESNEL.items()}
    nodes = material.node_tree.nodes
    tangent, picture = nodes.get(frame.TANGENT), nodes.get(frame.ANGLE_IMAGE)
    attribute = nodes.get(frame.ATTRIBUTE)
    orientation, turn = "UV", inputs["Rotation"].default_value
    if attribute is not None:
        orientation = "ATTRIBUTE"
    elif tangent is not None and getattr(tangent, "direction_type", "") == "RADIAL":
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


def our_materials() -> list[bpy.types.Material]:
    """Materials of ours that can be edited and are whole."""
    return [m for m in bpy.data.materials if is_ours(m) and m.is_editable and shader_node(m) is not None]


def refresh_table(path: Path, scene: bpy.types.Scene) -> None:
    """Bring the materials of a table that was baked anew up to its layout."""
    for material in our_materials():
        if table_path(material) == path:
            apply(material, path, settings_of(material), lights.lamp_objects(scene))


def _source_text(stem: str, source: str) -> bpy.types.Text:
    name = f"diffraction {stem}.osl"
    text = bpy.data.texts.get(name) or bpy.data.texts.new(name)
    if text.as_string() != source:
        text.clear()
        text.write(source)
    return text


def follow_lamps(material: bpy.types.Material, scene: bpy.types.Scene) -> None:
    """Bind a material to the scene's lamps as they are now."""
    settings = settings_of(material)
    if settings.implementation == "NODES" and table_path(material).is_file():
        apply(material, table_path(material), settings, lights.lamp_objects(scene))
        return
    lights.bind(shader_node(material), lights.lamp_objects(scene))


def lamps_max(material: bpy.types.Material) -> int:
    """Lamps that a material can follow."""
    return osl.LAMPS_MAX if needs_osl(material) else nodes_twin.LAMPS_MAX


def needs_osl(material: bpy.types.Material) -> bool:
    """Whether a material is of the OSL implementation."""
    return shader_node(material).bl_idname == "ShaderNodeScript"


def _place_node(material: bpy.types.Material, kind: str) -> bpy.types.Node:
    """The node of the diffraction; one of the other implementation hands its pigment over and goes."""
    tree = material.node_tree
    node = tree.nodes.get(NODE)
    if node is not None and node.bl_idname == kind:
        return node
    pigment = None
    if node is not None:
        base = node.inputs.get("Base")
        pigment = base.links[0].from_socket if base is not None and base.links else None
        tree.nodes.remove(node)
    node = tree.nodes.new(kind)
    node.name = NODE
    node.width = 260.0
    if pigment is not None:
        tree.links.new(pigment, _surface_output(tree, "CYCLES").inputs["Surface"])  # found there by `_connect`
    return node


def _surface_output(tree: bpy.types.NodeTree, target: str) -> bpy.types.Node:
    """The output node of a renderer; one is made where there is none."""
    output = tree.get_output_node(target) or tree.get_output_node("ALL")
    return output if output is not None else tree.nodes.new("ShaderNodeOutputMaterial")


def _connect(material: bpy.types.Material, node: bpy.types.Node, settings: Settings) -> None:
    tree = material.node_tree
    output = _surface_output(tree, "CYCLES")
    surface = output.inputs["Surface"]
    base = surface.links[0].from_socket if surface.links else None
    if base is not None and base.node != node:
        node.location = (output.location.x - 20.0, output.location.y)
        output.location.x += 320.0
        tree.links.new(base, node.inputs["Base"])
    elif not node.inputs["Base"].links:
        pigment = tree.nodes.new("ShaderNodeBsdfDiffuse")
        pigment.name = pigment.label = "Pigment"
        pigment.inputs["Color"].default_value = DARK
        pigment.location = (-300.0, 200.0)
        node.location = (0.0, 200.0)
        output.location = (340.0, 200.0)
        tree.links.new(pigment.outputs["BSDF"], node.inputs["Base"])
    _take_over_normal(tree, node)
    _orient(tree, node, settings)
    tree.links.new(node.outputs["BSDF"], surface)
    for_eevee = tree.nodes.get(EEVEE_OUTPUT)
    if "EEVEE" in node.outputs:
        output.target = "CYCLES"
        if for_eevee is None:
            for_eevee = tree.nodes.new("ShaderNodeOutputMaterial")
            for_eevee.name, for_eevee.label, for_eevee.target = EEVEE_OUTPUT, "EEVEE", "EEVEE"
            for_eevee.location = (output.location.x, output.location.y - 180.0)
        tree.links.new(node.outputs["EEVEE"], for_eevee.inputs["Surface"])
    elif for_eevee is not None:
        tree.nodes.remove(for_eevee)
        output.target = "ALL"


def _take_over_normal(tree: bpy.types.NodeTree, node: bpy.types.Node) -> None:
    """Bump and normal maps of the pigment count for the diffraction too."""
    if node.inputs["Normal"].links or not node.inputs["Base"].links:
        return
    normal = node.inputs["Base"].links[0].from_node.inputs.get("Normal")
    if normal is not None and normal.links:
        tree.links.new(normal.links[0].from_socket, node.inputs["Normal"])


def _orient(tree: bpy.types.NodeTree, node: bpy.types.Node, settings: Settings) -> None:
    """Nodes that say how the scan lies on the surface; those of an earlier choice go."""
    for old in [n for n in tree.nodes if n.name.startswith("Diffraction ")]:
        tree.nodes.remove(old)
    at = (node.location.x - 280.0, node.location.y - 200.0)
    turn = settings.rotation
    bitangent = handedness = None
    if settings.orientation == "ATTRIBUTE":
        tangent, _ = frame.attribute_frame(tree, settings.attribute, at)
    elif settings.orientation == "RADIAL":
        tangent, _ = frame.radial_frame(tree, at)
        turn += frame.RADIAL_TURN
    elif "Handedness" in node.inputs and tells_mirrored_uv():
        tangent, handedness = frame.uv_directions(tree, settings.uv_map, at)
    else:
        tangent, bitangent = frame.uv_frame(tree, settings.uv_map, at)
    tree.links.new(tangent, node.inputs["Tangent"])
    if bitangent is not None:
        tree.links.new(bitangent, node.inputs["Bitangent"])
    if handedness is not None:
        tree.links.new(handedness, node.inputs["Handedness"])
    is_direction = settings.orientation == "ATTRIBUTE" or handedness is not None
    node.inputs["TangentIsDirection"].default_value = int(is_direction)
    node.inputs["Rotation"].default_value = turn
    if settings.orientation == "TEXTURE":
        image = bpy.data.images.get(settings.angle_image)
        if image is None:
            raise ParameterError(f"There is no image '{settings.angle_image}'; load the image of the angles first.")
        angle = frame.angle_image(tree, image, turn, (at[0], at[1] - 400.0))
        tree.links.new(angle, node.inputs["Rotation"])
