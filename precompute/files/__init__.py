# SPDX-License-Identifier: GPL-3.0-or-later
"""Files and memory: EXR images, pictures, writing that leaves nothing half-done, what the machine has free.

Everything that is written goes through `atomic_path`: a temporary file, then a rename.
"""

from .atomic import atomic_path
from .images import check_image_path, write_exr, write_png
from .memory import available_bytes, peak_rss_bytes
from .output_folder import ensure_folder

__all__ = [
    "atomic_path",
    "available_bytes",
    "check_image_path",
    "ensure_folder",
    "peak_rss_bytes",
    "write_exr",
    "write_png",
]
