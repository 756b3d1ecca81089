# SPDX-License-Identifier: GPL-3.0-or-later
"""What the viewport keeps between two drawings, for the handlers that draw and the settings that change it."""

from .drawing import Renderer

renderer = Renderer()
