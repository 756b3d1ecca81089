# SPDX-License-Identifier: GPL-3.0-or-later
"""Members of zip archives: by name inside the archive, bounded in size, nothing unpacked to disk; and their XML."""

from __future__ import annotations

import zipfile
from xml.etree import ElementTree

from ...errors import ScanError

LONGEST_XML = 4 << 20


def member(archive: zipfile.ZipFile, name: str, limit: int, kind: str) -> bytes:
    """A member of an archive, at most ``limit`` bytes of it and a little more.

    Parameters
    ----------
    archive, name
        Case and a leading ``./`` do not matter.
    limit
        What the header allows; a directory may lie, and reading on would unpack a bomb.
    kind
        The ending that messages name, such as ``.x3p``.

    Raises
    ------
    ScanError
        If it is missing or declares more.
    """
    names = {info.filename.lstrip("./").casefold(): info for info in archive.infolist()}
    info = names.get(name.strip().lstrip("./").casefold())
    if info is None:
        raise ScanError(f"The {kind} archive lacks '{name.strip()[:60]}'; copy or export it again.")
    if info.file_size > limit + 4096:
        name = info.filename[:60]
        raise ScanError(f"The {kind} archive declares {info.file_size} bytes for '{name}', more than fit.")
    with archive.open(info) as file:
        return file.read(limit + 4096)


def xml_root(raw: bytes, kind: str) -> ElementTree.Element:
    """The root of an XML text without a document type, the door to entity bombs.

    Raises
    ------
    ScanError
        If it declares one or is encoded unusually.
    """
    if b"<!DOCTYPE" in raw or b"<!ENTITY" in raw or b"\0" in raw:
        raise ScanError(
            f"The {kind} file's XML declares entities or an unusual encoding, which is refused; export it again."
        )
    return ElementTree.fromstring(raw)
