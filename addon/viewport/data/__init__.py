# SPDX-License-Identifier: GPL-3.0-or-later
"""What the viewport keeps on the GPU: meshes, tables, shader sources, blocks of numbers."""
