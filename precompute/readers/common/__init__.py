# SPDX-License-Identifier: GPL-3.0-or-later
"""What readers share: channels and their choice, units, limits, binary heads, pages and tags of TIFF."""
