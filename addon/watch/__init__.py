# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands between a scene and its colours: said in the panels, and on the console before a render.

Each module knows one kind of trouble and gives sentences without a full stop; `sentences` puts them together.
"""
