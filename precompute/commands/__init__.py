# SPDX-License-Identifier: GPL-3.0-or-later
"""Subcommands of ``python -m precompute``, a module each.

The module's name is the subcommand's, the first line of its docstring the help. It has ``add_arguments(parser)``,
``run(args) -> dict`` (ready for JSON) and, where a plain listing of that dict does not do, ``describe(result) -> str``.
"""

from . import bake, direct, eval, info, map, preset, reflectance, sweep

COMMANDS = (info, bake, eval, direct, map, preset, reflectance, sweep)
