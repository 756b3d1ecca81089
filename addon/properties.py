# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene remembers of its scan, its bake and the material's options."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import bpy
import numpy as np
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    IntVectorProperty,
    PointerProperty,
    StringProperty,
)

from ..precompute.errors import DiffractionError
from ..precompute.parameters import ENSEMBLES, ILLUMINANTS, LEVELS, SERIES
from . import paint_properties, preset_properties
from .tables import light_file, stack_preview

_LABELS = {
    "average": ("Average", "The mean over all places of the coherence window: what a pixel that covers many sees"),
    "single": ("Single", "One coherence window in the middle of the patch: speckled, a larger table"),
    "periodic": ("Periodic", "The scan is one period: all its copies are lit coherently (gratings, discs)"),
    "nodes": ("Nodes", "One transform at each node of kappa; the fastest"),
    "chebyshev": ("Chebyshev", "Jacobi-Anger series"),
    "taylor": ("Taylor", "The series of the thesis; needs the most terms"),
    "none": ("None", "Heights as they are"),
    "plane": ("Plane", "Take out the tilt"),
    "poly2": ("Polynomial", "Take out tilt and bow (second order)"),
    "D65": ("D65", "Daylight"),
    "D50": ("D50", "Horizon light"),
    "A": ("A", "Incandescent lamp"),
    "E": ("E", "Equal energy"),
    "FL11": ("FL11", "Narrow-band fluorescent lamp"),
}


def _items(names: tuple[str, ...]) -> list[tuple[str, str, str]]:
    return [(name, *_LABELS.get(name, (name, ""))) for name in names]


ENSEMBLE_ITEMS, SERIES_ITEMS, LEVEL_ITEMS, ILLUMINANT_ITEMS = map(_items, (ENSEMBLES, SERIES, LEVELS, ILLUMINANTS))
ILLUMINANT_ITEMS.append((light_file.FILE, "File", "A measured spectrum from a text file"))

# Files keep numbers, which count up from the first.
FRESNEL_ITEMS = [
    ("DIELECTRIC", "Dielectric", "Reflectance by the index of refraction (skin, horn, lacquer), exact"),
    ("CONDUCTOR", "Conductor", "Reflectance by n and k (aluminium: discs), exact"),
    ("NONE", "None", "Reflects everything"),
    ("SCHLICK", "Schlick", "Schlick's approximation for a dielectric, as the thesis has it and version 0.1.0 had"),
]

# Numbers, because files keep those: version 0.1.0 had OSL as 0.
IMPLEMENTATION_ITEMS = [
    ("AUTO", "Automatic", "OSL where this Blender, the scene's engine and its device render it, else Nodes", 0, 2),
    ("OSL", "OSL", "Cycles on the CPU and OptiX: lamps of any size, world, emitters and bounce light", 0, 0),
    (
        "NODES",
        "Nodes",
        "Cycles on any device, with the same light, and EEVEE, with four lamps; packed into the file",
        0,
        1,
    ),
]

ORIENTATION_ITEMS = [
    ("UV", "UV Map", "The scan's x runs along u"),
    ("ATTRIBUTE", "Attribute", "The scan's x runs along a vector attribute of the mesh"),
    ("RADIAL", "Radial", "The scan's x points away from the object's z axis: discs"),
    ("TEXTURE", "Angle Image", "UV map, turned by an image: white is a whole turn"),
]


def sigma_s() -> Any:
    """Standard deviation of the coherence window."""
    return FloatProperty(
        name="Coherence (um)",
        description="Standard deviation of the coherence window in micrometres; 0 takes the ensemble's default",
        default=0.0, min=0.0, soft_max=50.0, precision=2,
    )  # fmt: skip


def ensemble() -> Any:
    """How windows are averaged."""
    return EnumProperty(name="Ensemble", description="How coherence windows are averaged", items=ENSEMBLE_ITEMS)


def replicas() -> Any:
    """Copies of a period."""
    return IntVectorProperty(
        name="Copies", description="Copies of the scan along x and y, for the ensemble Periodic",
        size=2, default=(8, 8), min=1, soft_max=100,
    )  # fmt: skip


def series() -> Any:
    """How the phase is transformed."""
    return EnumProperty(name="Series", description="How the phase is transformed", items=SERIES_ITEMS)


def tolerance() -> Any:
    """Error that the series may leave."""
    return FloatProperty(
        name="Tolerance", description="Largest error of the expansion in kappa, before any table",
        default=1e-4, min=1e-8, max=0.1, precision=6,
    )  # fmt: skip


def level() -> Any:
    """Levelling."""
    return EnumProperty(
        name="Levelling", description="What to take out of the heights", items=LEVEL_ITEMS, default="poly2"
    )


def use_crop() -> Any:
    """Whether only a rectangle is kept."""
    return BoolProperty(name="Crop", description="Keep only a rectangle of the scan", default=False)


def crop_um() -> Any:
    """The rectangle."""
    return FloatVectorProperty(
        name="Rectangle (um)",
        description="Left, right, bottom and top in micrometres, counted from the left and the bottom",
        size=4, default=(0.0, 10.0, 0.0, 10.0), min=0.0, precision=3,
    )  # fmt: skip


def align_rows() -> Any:
    """Row alignment."""
    return EnumProperty(
        name="Align Rows",
        description="Subtract the median of each scan line. Erases a structure that runs along the lines",
        items=[
            ("none", "Off", "Leave the lines as they are"),
            ("x", "Along X", "Scan lines are rows (fast axis x)"),
            ("y", "Along Y", "Scan lines are columns (fast axis y)"),
        ],
    )


def smooth_nm() -> Any:
    """Smoothing."""
    return FloatProperty(
        name="Smooth (nm)", description="Standard deviation of a Gaussian over the heights in nanometres; 0: none",
        default=0.0, min=0.0, soft_max=500.0, precision=1,
    )  # fmt: skip


def tile() -> Any:
    """Opposite edges."""
    return EnumProperty(
        name="Tileable",
        description="Make opposite edges of the patch fit",
        items=[
            ("none", "Off", "Leave the edges as they are"),
            ("blend", "Blend", "Fade a band at one edge into the other edge"),
            ("period", "Whole Periods", "Crop to whole periods of the lattice that is found"),
        ],
    )


def clip_percent() -> Any:
    """Dust clip."""
    return FloatProperty(
        name="Keep (%)", description="Middle percent of the heights to keep (99.9 clips dust); 0 keeps all",
        default=0.0, min=0.0, max=100.0, precision=2,
    )  # fmt: skip


def detail() -> Any:
    """Resolution of the table."""
    return FloatProperty(
        name="Detail", description="Resolution of the table; its texels grow with the cube of it",
        default=1.0, min=0.1, max=8.0, soft_min=0.5, soft_max=2.0, precision=2,
    )  # fmt: skip


def error_percent() -> Any:
    """Largest error of lookups."""
    return FloatProperty(
        name="Error (%)",
        description="Slices, radii and angles of the table are chosen until its values are off by no more than this, "
        "wherever they are above a thousandth of the largest in their plane of incidence",
        default=2.0, min=0.1, max=100.0, soft_min=0.5, soft_max=20.0, precision=1,
    )  # fmt: skip


def headroom(what: str) -> Any:
    """Largest Scale or Depth of a painted surface."""
    return FloatProperty(
        name=f"{what} Headroom", description=f"Largest {what} of a painted surface that the table holds for every"
        " direction; above 1 the table grows", default=1.0, min=1.0, max=8.0, soft_max=2.0, precision=2,
    )  # fmt: skip


def illuminant() -> Any:
    """Light whose spectrum is baked in."""
    return EnumProperty(name="Illuminant", description="Spectrum of the light", items=ILLUMINANT_ITEMS)


def illuminant_file() -> Any:
    """A measured light."""
    return StringProperty(
        name="Light File",
        description="Spectrum of the illuminant FILE: text of two columns, wavelength in nm and relative power",
        subtype="FILE_PATH", options={"PATH_SUPPORTS_BLEND_RELATIVE"},
    )  # fmt: skip


def illuminant_data() -> Any:
    """What the file held when it was baked."""
    return StringProperty(
        name="Values of the Light File", description="Its spectrum as JSON, kept with a bake", options={"HIDDEN"}
    )


def substrate() -> Any:
    """What the surface is made of."""
    return StringProperty(
        name="Substrate",
        description="What the surface is made of: a material by name (Au, Al, Ti, keratin ...), a refractive index, n,k"
        " or a file. Its reflectance goes into the table; empty leaves it to the material's Fresnel",
    )


def films() -> Any:
    """Thin films on the substrate."""
    return StringProperty(
        name="Films",
        description="Thin films, outermost first, with blanks between: SiO2:250 is 250 nm of silica,"
        " (chitin:100,melanin:80)x12 repeats a group",
    )


def lacquer() -> Any:
    """A clear layer over the relief."""
    return StringProperty(
        name="Under Lacquer",
        description="A clear layer over the relief, by name or refractive index: polycarbonate of a disc, varnish on"
        " foil; empty is none",
    )


def energy() -> Any:
    """How energy is conserved."""
    return EnumProperty(
        name="Energy",
        description="How no direction sends out more light than came in",
        items=(
            ("raw", "Divide", "Renderers divide by albedos that hold at every wavelength"),
            ("capped", "Cap Each Wavelength", "Each wavelength is also cut by its own excess inside the table"),
        ),
    )


def limit_mb() -> Any:
    """Largest table."""
    return IntProperty(
        name="Limit (MB)",
        description="Largest table to bake, in megabytes of texels",
        default=1024,
        min=1,
        soft_max=8192,
    )


def ior() -> Any:
    """Index of refraction."""
    return FloatProperty(
        name="IOR", description="Index of refraction of the surface (keratin 1.55)", default=1.55, min=1.0, soft_max=3.0
    )


def preset_size() -> Any:
    """Side length of a preset's patch."""
    return FloatProperty(
        name="Size (um)", description="Side length in micrometres; 0 takes the preset's", default=0.0, min=0.0
    )


def preset_pixels() -> Any:
    """Pixels of a preset's patch."""
    return IntProperty(name="Pixels", description="Pixels along a side; 0 takes the preset's", default=0, min=0)


def map_theta() -> Any:
    """Polar angle of a map's light."""
    return FloatProperty(
        name="Theta", description="Angle between the light and the surface's normal", subtype="ANGLE",
        default=math.radians(30.0), min=0.0, max=math.radians(89.0),
    )  # fmt: skip


def map_phi() -> Any:
    """Azimuth of a map's light."""
    return FloatProperty(
        name="Phi", description="Azimuth of the light from the scan's x towards its y", subtype="ANGLE"
    )


def map_size() -> Any:
    """Pixels of a map."""
    return IntProperty(name="Pixels", description="Pixels along a side of the map", default=512, min=16, max=4096)


def plot_theta() -> Any:
    """Light of the reflectance plot."""
    return FloatProperty(
        name="Light", description="Angle between the light and the normal, in the plane of the scan's main period",
        subtype="ANGLE", default=0.0, min=math.radians(-85.0), max=math.radians(85.0),
    )  # fmt: skip


def plot_order() -> Any:
    """Order of the reflectance plot."""
    return IntProperty(name="Order", description="Diffraction order in view; not 0", default=1, min=-8, max=8)


def map_linear() -> Any:
    """Numbers or a picture."""
    return BoolProperty(
        name="Values",
        description="Linear Rec.709 values in 1/sr, unscaled, in place of a picture that shows 2 % at full brightness",
        default=False,
    )


DIFFRACTION_PG_presets = type(
    "DIFFRACTION_PG_presets",
    (bpy.types.PropertyGroup,),
    {
        "__annotations__": {name: PointerProperty(type=group) for name, group in preset_properties.GROUPS.items()},
        "__doc__": "Parameters of every preset structure.",
    },
)


def _seen_straight_on(self: Any) -> tuple[float, float, float]:
    """A function with a name: Blender keeps none of its own reference to it."""
    return _stack_colour(self.substrate, self.films, self.lacquer)


@lru_cache(maxsize=32)
def _stack_colour(substrate: str, films: str, lacquer: str) -> tuple[float, float, float]:
    from ..precompute.evaluate.stack_colour import stack_rgb
    from .tables.bake_settings import stuff

    try:
        made = stuff(substrate, films, lacquer)
    except DiffractionError:
        return 0.0, 0.0, 0.0
    if made["stack"] is None:
        return 1.0, 1.0, 1.0
    red, green, blue = stack_rgb(made["stack"], np.ones(()), outer=made["lacquer"])
    return float(red), float(green), float(blue)


class DIFFRACTION_PG_scene(bpy.types.PropertyGroup):
    """State of the panel, saved with the scene."""

    scan_path: StringProperty(name="Scan", description="The scan, stored as .gsf")
    source_path: StringProperty(name="Source", description="The file it was imported from")
    source_sha256: StringProperty()
    reading: StringProperty(description="How the source is read, as JSON")
    scan_info: StringProperty()
    table_path: StringProperty(
        name="Table", description="The baked table", subtype="FILE_PATH", options={"PATH_SUPPORTS_BLEND_RELATIVE"}
    )
    table_name: StringProperty(name="Name", description="Name of the next table; empty takes the scan's")
    table_recipe: StringProperty(description="How the table was made, as JSON")
    imported: StringProperty(description="Where the scan was imported from, as JSON")
    channels: StringProperty(description="Channels of the imported file, as JSON")
    message: StringProperty(description="What the last operation had to say", options={"SKIP_SAVE"})

    sigma_s_um: sigma_s()
    ensemble: ensemble()
    replicas: replicas()
    series: series()
    tolerance: tolerance()
    level: level()
    use_crop: use_crop()
    crop_um: crop_um()
    align_rows: align_rows()
    clip_percent: clip_percent()
    smooth_nm: smooth_nm()
    tile: tile()
    detail: detail()
    error_percent: error_percent()
    illuminant: illuminant()
    illuminant_file: illuminant_file()
    illuminant_data: illuminant_data()
    substrate: substrate()
    films: films()
    lacquer: lacquer()
    energy: energy()
    scale_headroom: headroom("Scale")
    depth_headroom: headroom("Depth")
    stack_colour: FloatVectorProperty(
        name="Seen Straight On",
        description="Colour of a flat mirror of these films in daylight",
        subtype="COLOR",
        size=3,
        get=_seen_straight_on,
    )
    limit_mb: limit_mb()

    implementation: EnumProperty(
        name="Implementation", description="What renders the material", items=IMPLEMENTATION_ITEMS, default="AUTO"
    )
    fresnel: EnumProperty(name="Fresnel", description="How much the surface reflects", items=FRESNEL_ITEMS)
    ior: ior()
    conserve_energy: BoolProperty(
        name="Conserve Energy",
        description="Keep the reflected light from passing the incoming light at grazing angles",
        default=True,
    )
    orientation: EnumProperty(
        name="Orientation", description="How the scan lies on the surface", items=ORIENTATION_ITEMS
    )
    uv_map: StringProperty(name="UV Map", description="Empty takes the active one")
    attribute: StringProperty(name="Attribute", description="Name of the vector attribute")
    angle_image: StringProperty(name="Image", description="Name of the image of the angles")
    environment: IntProperty(
        name="Environment", description="Random mirrors a sample for world, emitters and bounce light; 0: lamps only",
        default=1, min=0, max=8,
    )  # fmt: skip
    rotation: FloatProperty(
        name="Rotation", description="Turn of the scan on the surface", subtype="ANGLE", default=0.0,
        soft_min=-math.pi, soft_max=math.pi,
    )  # fmt: skip

    preset: EnumProperty(
        name="Preset", description="A structure that needs no microscope", items=preset_properties.ITEMS, default="cd"
    )
    preset_size_um: preset_size()
    preset_pixels: preset_pixels()
    presets: PointerProperty(type=DIFFRACTION_PG_presets)
    paint: PointerProperty(type=paint_properties.DIFFRACTION_PG_paint)

    map_theta: map_theta()
    map_phi: map_phi()
    map_size: map_size()
    map_linear: map_linear()
    plot_theta: plot_theta()
    plot_order: plot_order()
    plot_result: StringProperty(description="What the last reflectance plot found")
    map_image: StringProperty(description="Name of the last map's image")


CLASSES = (
    *preset_properties.GROUPS.values(),
    DIFFRACTION_PG_presets,
    *paint_properties.CLASSES,
    DIFFRACTION_PG_scene,
)


def prepare() -> None:
    """Before the classes are registered: presets and recipes get their pictures."""
    paint_properties.prepare()
    DIFFRACTION_PG_scene.__annotations__["preset"] = EnumProperty(
        name="Preset",
        description="A structure that needs no microscope",
        items=preset_properties.pictures.items(),
        default="cd",  # its colours are seen on any object under any lamp
    )


def register() -> None:
    """Attach the group to scenes."""
    bpy.types.Scene.diffraction = PointerProperty(type=DIFFRACTION_PG_scene)


def unregister() -> None:
    """Detach it; values stay in the files."""
    del bpy.types.Scene.diffraction
    preset_properties.pictures.drop()
    paint_properties.pictures.drop()
    stack_preview.drop()
