# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene's light list: what shines, kept in custom properties of the scene for the materials to read."""
