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
from .common.channel import Channel
from .common.tiff_tags import first_tags

_HEAD_BYTES = 4096
_HDF = b"\x89HDF\r\n\x1a\n"


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
        Where its reader lives in this package (``family.module``); imported when needed.
    magic
        First bytes of a file; empty where the extension alone decides.
    claims
        A closer look for formats that share their first bytes: gets the path and the first 4 KiB.
    plain
        True for pictures, which carry neither size nor height range.
    """

    name: str
    extensions: tuple[str, ...]
    module: str
    function: str
    magic: tuple[bytes, ...] = ()
    claims: Callable[[Path, bytes], bool] | None = None
    plain: bool = False

    def read(self, path: Path) -> list[Channel]:
        """All channels of a file of this format."""
        module = importlib.import_module(f".{self.module}", __package__)
        return getattr(module, self.function)(path)

    def recognises(self, path: Path, head: bytes) -> bool:
        """Whether the content is this format's."""
        if self.magic and not head.startswith(self.magic):
            return False
        if self.claims is not None:
            return self.claims(path, head)
        return bool(self.magic)


def _is_park(path: Path, head: bytes) -> bool:
    return 50432 in first_tags(path)


def _is_jpk(path: Path, head: bytes) -> bool:
    return {0x8000, 0x8042} <= first_tags(path)


def _is_wsxm(path: Path, head: bytes) -> bool:
    return b"SxM Image file" in head[:200]


def _is_opd(path: Path, head: bytes) -> bool:
    return head[2:11] == b"Directory"


def _is_ardf(path: Path, head: bytes) -> bool:
    return head[8:12] == b"ARDF"


def _is_sm4(path: Path, head: bytes) -> bool:
    return head[2:18] == "STiMage ".encode("utf-16-le")


def _ends(extension: str) -> Callable[[Path, bytes], bool]:
    """For archives, whose first bytes tell nothing: the name decides."""
    return lambda path, head: path.suffix.lower() == extension


def _is_points(path: Path, head: bytes) -> bool:
    # The ending belongs to chemists' files too, so the content must be text at least.
    return path.suffix.lower() == ".xyz" and b"\0" not in head


#: Most specific first: a Park TIFF is also a plain TIFF.
FORMATS: tuple[Format, ...] = (
    Format("gsf", (".gsf",), "plain.gsf", "read_gsf", (b"Gwyddion Simple Field 1.0\n",)),
    Format("gwy", (".gwy",), "plain.gwy", "read_gwy", (b"GWYO", b"GWYP")),
    Format(
        "nanoscope",
        (".spm", ".di", ".001"),
        "probe.nanoscope",
        "read_nanoscope",
        (b"\\*File list", b"\\*EC File list", b"?*File list", b"\\*Force file list"),
    ),
    Format("igor", (".ibw",), "probe.igor", "read_ibw"),
    Format("x3p", (".x3p",), "optical.x3p", "read_x3p", (b"PK\x03\x04",), _ends(".x3p")),
    Format("plux", (".plux",), "optical.plux", "read_plux", (b"PK\x03\x04",), _ends(".plux")),
    Format("npz", (".npz",), "plain.npy", "read_npz", (b"PK\x03\x04",), _ends(".npz")),
    Format("npy", (".npy",), "plain.npy", "read_npy", (b"\x93NUMPY",)),
    Format("vk", (".vk3", ".vk4", ".vk6", ".vk7"), "optical.keyence", "read_vk", (b"VK3_", b"VK4_", b"VK6", b"VK7")),
    Format(
        "metropro",
        (),
        "optical.metropro",
        "read_dat",
        (b"\x88\x1b\x03\x6f", b"\x88\x1b\x03\x70", b"\x88\x1b\x03\x71"),
    ),
    Format("opdx", (".opdx",), "optical.opdx", "read_opdx", (b"VCA DATA\x01\0\0\x55",)),
    Format("datx", (".datx",), "optical.datx", "read_datx", (_HDF,), _ends(".datx")),
    Format("nhf", (".nhf",), "probe.nanosurf_hdf", "read_nhf", (_HDF,), _ends(".nhf")),
    Format("h5-jpk", (), "probe.jpk_hdf", "read_h5_jpk", (_HDF,), _ends(".h5-jpk")),
    Format("al3d", (".al3d",), "optical.al3d", "read_al3d", (b"AliconaImaging\0\r\n",)),
    Format("nms", (".nms",), "optical.nms", "read_nms"),
    Format("mi", (".mi",), "probe.mi", "read_mi", (b"fileType",)),
    Format("ardf", (".ardf",), "probe.ardf", "read_ardf", (), _is_ardf),
    Format("omicron", (), "probe.omicron_flat", "read_flat", (b"FLAT0100",)),
    Format("sm4", (".sm4",), "probe.sm4", "read_sm4", (), _is_sm4),
    Format("mdt", (".mdt",), "probe.mdt", "read_mdt", (b"\x01\xb0\x93\xff",)),
    Format("nanosurf", (".nid", ".ezd"), "probe.nanosurf", "read_nid", (b"[DataSet]",)),
    Format("park", (".tiff", ".tif"), "probe.park", "read_park", (b"II*\0", b"MM\0*"), _is_park),
    Format("jpk", (".jpk",), "probe.jpk", "read_jpk", (b"II*\0", b"MM\0*"), _is_jpk),
    Format("wsxm", (".stp", ".top", ".cur", ".tom"), "probe.wsxm", "read_wsxm", (b"WSxM file copyright",), _is_wsxm),
    Format("nanonis", (".sxm",), "probe.nanonis", "read_sxm", (b":NANONIS_VERSION:",)),
    Format("sur", (".sur", ".pro"), "optical.digital_surf", "read_sur", (b"DIGITAL SURF", b"DSCOMPRESSED")),
    Format(
        "sdf",
        (".sdf",),
        "optical.sdf",
        "read_sdf",
        tuple(f"{kind}{name}".encode() for kind in "abAB" for name in ("ISO-1.0", "ISO-2.0", "BCR-1.0")),
    ),
    Format("opd", (".opd",), "optical.opd", "read_opd", (), _is_opd),
    Format("plu", (".plu", ".apx"), "optical.plu", "read_plu"),
    Format("exr", (".exr",), "plain.image", "read_exr", (b"\x76\x2f\x31\x01",), plain=True),
    Format("png", (".png",), "plain.image", "read_png", (b"\x89PNG\r\n\x1a\n",), plain=True),
    Format("jpeg", (".jpg", ".jpeg"), "plain.image", "read_png", (b"\xff\xd8\xff",), plain=True),
    Format("bmp", (".bmp",), "plain.image", "read_png", (b"BM",), plain=True),
    Format("tiff", (".tif", ".tiff"), "plain.image", "read_tiff", (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"), plain=True),
    Format("text", (), "plain.text", "read_text", claims=_is_points),
    Format("text", (".txt", ".csv", ".tsv", ".dat", ".asc", ".ascii", ".text"), "plain.text", "read_text"),
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
        if form.recognises(path, head):
            return form
    extension = path.suffix.lower()
    for form in FORMATS:
        if extension in form.extensions:
            if form.magic or form.claims:
                raise ScanError(f"The name says {extension} but the content does not; check the file or its extension.")
            return form
    known = " ".join(sorted({extension[1:] for form in FORMATS for extension in form.extensions}))
    raise ScanError(f"The format is not known; supported are {known}; open the file in Gwyddion and export it as .gsf.")
