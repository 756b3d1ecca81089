# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of optical profilers and of surface metrology's standards."""
