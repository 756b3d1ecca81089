# SPDX-License-Identifier: GPL-3.0-or-later
"""What a renderer without the extension needs."""
