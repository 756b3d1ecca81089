# SPDX-License-Identifier: GPL-3.0-or-later
"""The transforms of a bake as compute shaders on the GPU that Blender draws with."""
