# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of docs/gallery.md: one module a picture, each with `build(out)` that sets the scene up."""
