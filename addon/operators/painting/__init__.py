# SPDX-License-Identifier: GPL-3.0-or-later
"""Paint of the active material: maps that drive its sockets."""
