# SPDX-License-Identifier: GPL-3.0-or-later
"""Scans and tables of a scene: stored, baked, estimated, remembered, looked at."""
