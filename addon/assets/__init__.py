# SPDX-License-Identifier: GPL-3.0-or-later
"""Ready materials: what they are, the stage they are pictured on, and the library made of them."""
