# SPDX-License-Identifier: GPL-3.0-or-later
"""The node *Snake Scales*: a snake's scales on any mesh, in shader nodes alone, for the node *Diffraction* to shine on.

`lattice` is the mathematics of one sheet of scales, `group` lays such sheets onto a surface and paints them, `species`
holds what fits two snakes, `wire` connects the node to a material.
"""
