# SPDX-License-Identifier: GPL-3.0-or-later
"""The registry: which module reads which file.

A new format is one more line in ``FORMATS`` and one function that returns channels.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..errors import ScanError
from .channel import Channel

_HEAD_BYTES = 4096


@dataclass(frozen=True)
class Format:
    """One file format.

    Parameters
    ----------
    name
        Short name as metadata and docs give it.
    extensions
        Lower-case, with the dot.
    module, function
        Where its reader lives in this package; imported when needed.
    magic
        First bytes of a file; empty where the extension alone decides.
    claims
        A closer look for formats that share their first bytes: gets the first 4 KiB.
    plain
        True for pictures, which carry neither size nor height range.
    """

    name: str
    extensions: tuple[str, ...]
    module: str
    function: str
    magic: tuple[bytes, ...] = ()
    claims: Callable[[bytes], bool] | None = None
    plain: bool = False

    def read(self, path: Path) -> list[Channel]:
        """All channels of a file of this format."""
        module = importlib.import_module(f".{self.module}", __package__)
        return getattr(module, self.function)(path)

    def matches_magic(self, head: bytes) -> bool:
        """Whether the first bytes are this format's."""
        if self.magic and not head.startswith(self.magic):
            return False
        if self.claims is not None:
            return self.claims(head)
        return bool(self.magic)


FORMATS: tuple[Format, ...] = (
    Format("gsf", (".gsf",), "gsf", "read_gsf", (b"Gwyddion Simple Field 1.0\n",)),
    Format("gwy", (".gwy",), "gwy", "read_gwy", (b"GWYO", b"GWYP")),
    Format("exr", (".exr",), "image", "read_exr", (b"\x76\x2f\x31\x01",), plain=True),
    Format("png", (".png",), "image", "read_png", (b"\x89PNG\r\n\x1a\n",), plain=True),
    Format("jpeg", (".jpg", ".jpeg"), "image", "read_png", (b"\xff\xd8\xff",), plain=True),
    Format("bmp", (".bmp",), "image", "read_png", (b"BM",), plain=True),
    Format("tiff", (".tif", ".tiff"), "image", "read_tiff", (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"), plain=True),
    Format("text", (".txt", ".csv", ".tsv", ".dat", ".asc", ".ascii", ".text"), "text", "read_text"),
)


def find_format(path: Path) -> Format:
    """The format of a file: by its first bytes, then by its extension.

    Raises
    ------
    ScanError
        If it is none of ``FORMATS``.
    """
    with open(path, "rb") as file:
        head = file.read(_HEAD_BYTES)
    for form in FORMATS:
        if form.matches_magic(head):
            return form
    extension = path.suffix.lower()
    for form in FORMATS:
        if extension in form.extensions:
            if form.magic:
                raise ScanError(f"The name says {extension} but the content does not; check the file or its extension.")
            return form
    known = " ".join(sorted({extension for form in FORMATS for extension in form.extensions}))
    raise ScanError(f"The format is not known; supported are {known}.")
