# SPDX-License-Identifier: GPL-3.0-or-later
"""Two small tables that are told apart by their keys."""

from tests.support.blender.tables import gentle, lobes, make_table


def tables(folder):
    """Tables with the keys ``first`` and ``second``; their files lie in a folder of their own."""
    found = []
    for name, transform in (("first", gentle), ("second", lobes)):
        table = make_table(folder / "made" / f"{name}.exr", transform, n_r=16, n_phi=12, n_w=4)
        table.info["key"] = name
        found.append(table)
    return found
