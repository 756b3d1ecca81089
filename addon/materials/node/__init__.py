# SPDX-License-Identifier: GPL-3.0-or-later
"""The node *Diffraction*: its sockets, the groups behind it, what they read of the scene, files of version 0.1.0."""
