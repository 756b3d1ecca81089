# SPDX-License-Identifier: GPL-3.0-or-later
"""Custom properties of the groups *Diffraction*; materials of version 0.1.0 have the first five themselves."""

from __future__ import annotations

#: Path of the table.
TABLE = "diffraction_table"

#: The images of the table, and the hash of the atlas that the nodes were made for.
ATLAS, IMPORTANCE, SHA256 = "diffraction_atlas", "diffraction_importance", "diffraction_sha256"

#: Light of the table: a name, or a sidecar's entry as JSON.
ILLUMINANT = "diffraction_illuminant"

#: ``OSL`` or ``NODES``; what is built into the nodes; hash of all that the nodes were made from.
IMPLEMENTATION, VARIANT, STAMP = "diffraction_implementation", "diffraction_variant", "diffraction_stamp"
