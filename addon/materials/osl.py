# SPDX-License-Identifier: GPL-3.0-or-later
"""The OSL source of a material: the files of ``shaders/`` behind the numbers of one table."""

from __future__ import annotations

from ...precompute.constants import LEAST_REFLECTANCE, LEAST_SCALE
from ...precompute.table import importance, scaled_albedo
from ...precompute.table.layout import GUARD, GUARD_TOLERANCE, TableLayout
from ..lights import slots
from ..shader_files import SHADERS
from ..versions import texture_t_is_down

#: In the order in which they use each other.
PARTS = ("table.osl", "brdf.osl", "lamps.osl", "importance.osl", "diffraction.osl")

#: Lamps that the shader reads of the scene's list, see ``shaders/diffraction.osl``.
LAMPS_MAX = slots.SLOTS

#: Values of the socket ``Fresnel``. 1 was the one form of dielectrics in 0.1.0: files keep it.
FRESNEL = {"NONE": 0, "SCHLICK": 1, "CONDUCTOR": 2, "DIELECTRIC": 3}

#: Values of the sockets ``LampNKind``.
LAMP_KINDS = slots.KINDS


def source(layout: TableLayout, albedo_max: float, albedo_free: float = 2.0) -> str:
    """The complete source text for a table.

    The table's numbers come as constants, not as sockets, so that the compiler folds them and an
    albedo that never passes 1 costs no lookup.

    Parameters
    ----------
    layout
        Coordinates and atlas geometry of the table.
    albedo_max
        Largest directional albedo of the raw model.
    albedo_free
        Cosine above which no albedo passes 1 (`importance.albedo_free_cosine`); 2 looks up every one.
    """
    numbers = {f"TABLE_{name.upper()}": value for name, value in layout.to_dict().items()}
    numbers["TABLE_ALBEDO_Y"] = layout.conserving_y
    numbers["TABLE_HOLDS_REFLECTANCE"] = int(layout.holds_reflectance)
    numbers["TABLE_HAS_LACQUER"] = int(layout.index > 1.0)
    numbers["TABLE_INDEX"] = layout.index
    numbers["TABLE_HAS_ALBEDO"] = int(albedo_max > 1.0)
    numbers.setdefault("TABLE_GUARDED", layout.guarded)
    numbers.update(
        zip(("GUARD_HIGH", "GUARD_MIDDLE", "GUARD_LOW"), GUARD, strict=True), GUARD_TOLERANCE=GUARD_TOLERANCE
    )
    numbers["TEXTURE_T_DOWN"] = int(texture_t_is_down())
    numbers["LAMPS_MAX"] = LAMPS_MAX
    numbers["TABLE_ALBEDO_FREE"] = float(albedo_free)
    numbers["TABLE_SCALE_HEADROOM"], numbers["TABLE_DEPTH_HEADROOM"] = layout.headroom
    numbers["SCALE_LEAST"], numbers["REFLECTANCE_LEAST"] = LEAST_SCALE, LEAST_REFLECTANCE
    for name in ("N_SCALES", "STEPS", "N_THETA", "N_PHI"):
        numbers[f"SCALED_{name}"] = float(getattr(scaled_albedo, name))
    numbers.update({f"SCALED_DEPTH_{i}": value for i, value in enumerate(scaled_albedo.DEPTHS)})
    numbers["TABLE_FIRST_SHARE"] = layout.first_share
    numbers["TABLE_IS_LINEAR_IN_W"] = int(layout.power == 1.0)
    for name in (
        "N_VIEWS",
        "VIEW_END",
        "AZIMUTHS_STEP",
        "AZIMUTHS_MAX",
        "N_R",
        "N_PHI",
        "WIDTH",
        "HEIGHT",
        "VIEWS",
        "FIRST_VIEWS",
        "SET_VIEWS",
        "AZIMUTHS_SETS",
        "SET_COSINE",
        "CUTS",
        "GUARD_X",
        "GUARD_Y",
    ):
        numbers[f"IMPORTANCE_{name}"] = float(getattr(importance, name))
    numbers["IMPORTANCE_SETS"] = float(len(importance.DEPTHS))
    numbers["IMPORTANCE_DEPTH_STEP"] = importance.DEPTHS[0] - importance.DEPTHS[1]
    numbers.update({f"FRESNEL_{name}": value for name, value in FRESNEL.items()})
    numbers.update({f"LAMP_{name}": value for name, value in LAMP_KINDS.items()})
    defines = "".join(f"#define {name} {value!r}\n" for name, value in sorted(numbers.items()))
    return defines + "\n" + "\n".join((SHADERS / part).read_text(encoding="utf-8") for part in PARTS)
