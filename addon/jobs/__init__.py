# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that takes long: a job in a thread, its progress in the status bar, and Esc."""
