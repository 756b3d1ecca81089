# SPDX-License-Identifier: GPL-3.0-or-later
"""The material: its node in OSL and in shader nodes, the lamps it follows, the frame it shades in, its travels."""
