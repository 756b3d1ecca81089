# SPDX-License-Identifier: GPL-3.0-or-later
"""The formulas of ``shaders/*.osl`` as shader nodes, part by part; `nodes_twin` puts them together."""
