# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface's stuff: materials with dispersion, thin films on a substrate, and what such a stack reflects.

`material_of` knows materials by name, by numbers and from files, `Stack` holds films on a substrate, and its
`reflectance` is that of unpolarised light by the transfer matrix.
"""

from .material import Material
from .materials import MATERIALS, material_of
from .stack import Film, Group, Stack, parse_stack, split_films, stack_of, to_json
from .transfer import fresnel_conductor, fresnel_exact, reflectance

__all__ = [
    "MATERIALS",
    "Film",
    "Group",
    "Material",
    "Stack",
    "fresnel_conductor",
    "fresnel_exact",
    "material_of",
    "parse_stack",
    "reflectance",
    "split_films",
    "stack_of",
    "to_json",
]
