# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffraction of measured heightfields: the numerical core, free of Blender.

Importing this package loads nothing heavy; its modules import numpy, scipy,
colour-science and OpenEXR when they are first used.
"""

from .old_names import install as _install

_install(__name__)
