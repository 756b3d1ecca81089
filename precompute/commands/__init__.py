# SPDX-License-Identifier: GPL-3.0-or-later
"""Subcommands of ``python -m precompute``, a module each.

The module's name is the subcommand's. It has ``add_arguments(parser)``, ``run(args) -> dict`` (ready for JSON) and,
where a plain listing of that dict does not do, ``describe(result) -> str``. It is imported when it is asked for.
"""

#: Subcommand -> the first line of its module's docstring, which is its line in the help.
COMMANDS = {
    "info": "Say what a scan or a table holds: shape, size, heights, channel; terms, energy.",
    "check": "Say which tables are missing, damaged or of another release; exit code 1 where any is.",
    "bake": "Bake a scan into a spectral table.",
    "eval": "Evaluate the BRDF of a table for one pair of directions.",
    "direct": "Evaluate the BRDF of a scan without a table: by direct summation, the reference, or by another method.",
    "map": "Draw the BRDF of a table towards all view directions as a PNG or EXR picture.",
    "mirror": "Say what colour a flat mirror of some material, films on it or a lacquer over it has.",
    "preset": "Write the heightfield of a preset structure as a .gsf file.",
    "paint": "Turn a recipe or a picture into maps of period, depth and direction that paint a surface.",
    "reflectance": "Compare the peak of a diffraction order with the grating equation and estimate the period.",
    "sweep": "Bake many scans with many parameters, on one machine or several.",
}
