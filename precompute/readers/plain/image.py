# SPDX-License-Identifier: GPL-3.0-or-later
"""Grey images as heights: 8- and 16-bit PNG (and other plain formats), TIFF and EXR.

An image knows neither its size nor its height range, so both come from the user: the full
scale of the pixel type (255, 65535, or 1.0 for floats) stands for the height range. Missing are NaN
among floats, the value in GDAL's nodata tag of a TIFF, and points that alpha makes wholly transparent.
"""

from __future__ import annotations

import os
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import ScanError
from ..common.channel import Channel, Samples
from ..common.limits import check_density, check_loaded, check_shape
from ..common.tiff_page import PLAIN_COMPRESSIONS, decoded, open_tiff
from . import png16

PNG_MAGIC = b"\x89PNG\r\n\x1a\n"
TIFF_MAGIC = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
EXR_MAGIC = b"\x76\x2f\x31\x01"

#: Further pages of a stack are not offered.
_MOST_PAGES = 256
_GDAL_NO_DATA = 42113

#: Red, green and blue of a grey picture may differ by this part of the full scale (JPEG's rounding).
_GREY_TOLERANCE = 0.02


def read_png(path: Path) -> list[Channel]:
    """The one channel of an 8- or 16-bit PNG, BMP or JPEG picture."""
    return [Channel("Grey", None, partial(_load_picture, path, 0))]


def _load_picture(path: Path, page: int) -> Samples:
    from PIL import Image, UnidentifiedImageError

    _check_chunks(path)
    found = png16.header(path)
    if found is not None and found[2] == 16 and found[3] in png16.SAMPLES:
        return _samples(png16.read_png16(path))
    try:
        with Image.open(path) as image:
            check_shape(image.height, image.width)
            check_loaded(image.height, image.width)
            if page:
                image.seek(page)
            if image.mode == "P":
                image = image.convert("RGB")
            elif image.mode == "1":
                image = image.convert("L")
            values = np.asarray(image)
    except UnidentifiedImageError:
        raise ScanError("The image cannot be read; save it again as 16-bit grey PNG.") from None
    return _samples(values)


def _check_chunks(path: Path) -> None:
    """Refuse a PNG one of whose pieces claims to be longer than the file: the library would make room for it."""
    end = os.path.getsize(path)
    with open(path, "rb") as file:
        start = file.read(33)
        if not start.startswith(PNG_MAGIC):
            return
        if len(start) == 33 and start[12:16] == b"IHDR":
            width, height, bits = (int.from_bytes(start[a:b], "big") for a, b in ((16, 20), (20, 24), (24, 25)))
            check_density(path, width * height * max(bits, 1))
        file.seek(len(PNG_MAGIC))
        while len(head := file.read(8)) == 8:
            file.seek(int.from_bytes(head[:4], "big") + 4, os.SEEK_CUR)
            if file.tell() > end:
                raise ScanError("The image ends early or is damaged; save it again as 16-bit grey PNG.")


def read_tiff(path: Path) -> list[Channel]:
    """The pages of a TIFF picture; thumbnails of another page are left out."""
    with open_tiff(path) as file:
        wanted = []
        for index in range(_MOST_PAGES):
            try:
                page = file.pages[index]
            except IndexError:
                break
            if index == 0 or not page.is_reduced:
                wanted.append(index)
    names = ["Grey"] if len(wanted) == 1 else [f"Page {number}" for number in range(1, len(wanted) + 1)]
    return [Channel(name, None, partial(_load_page, path, index)) for name, index in zip(names, wanted, strict=True)]


def _load_page(path: Path, index: int) -> Samples:
    with open_tiff(path) as file:
        page = file.pages[index]
        if not _decodable(page):
            if page.bitspersample > 8 and page.samplesperpixel > 1:
                raise ScanError(
                    "The TIFF is compressed in a way that needs the Python package 'imagecodecs', which is not"
                    " installed; save it uncompressed or with deflate."
                )
            return _load_picture(path, index)
        values = decoded(page, path)
        if page.planarconfig == 2 and values.ndim == 3:  # red, green and blue one after the other
            values = np.moveaxis(values, 0, -1)
        missing = _no_data(page, values)
        if page.photometric == 0:  # white is zero
            values = 1.0 - values if values.dtype.kind == "f" else np.iinfo(values.dtype).max - values
    if values.ndim == 3 and values.shape[-1] == 1:
        values = values[..., 0]
        missing = None if missing is None else missing[..., 0]
    return _samples(values, missing)


def _decodable(page: Any) -> bool:
    """Whether tifffile decodes the page here.

    Raises
    ------
    ScanError
        If neither it nor Pillow can: floats whose bytes were predicted need imagecodecs.
    """
    if page.predictor == 3 and find_spec("imagecodecs") is None:
        raise ScanError(
            "The TIFF stores floats with predictor 3, which needs the Python package 'imagecodecs', which is not"
            " installed; save it without a predictor."
        )
    return page.compression in PLAIN_COMPRESSIONS or find_spec("imagecodecs") is not None


def _no_data(page: Any, values: np.ndarray) -> np.ndarray | None:
    """Points that GDAL's tag marks as without data."""
    tag = page.tags.get(_GDAL_NO_DATA)
    if tag is None or values.ndim != 2:
        return None
    try:
        mark = float(str(tag.value).split("\0")[0])
    except ValueError:
        return None
    if values.dtype.kind == "f":
        with np.errstate(over="ignore"):
            mark = float(values.dtype.type(mark))  # -3.4e38 in decimal digits is the least float32
    return values == mark


def read_exr(path: Path) -> list[Channel]:
    """One channel for each layer of an EXR picture."""
    import OpenEXR

    with OpenEXR.File(os.fspath(path), header_only=True) as file:
        header = file.header()  # emptied when the file closes
        low, high = (np.array(corner, np.int64) for corner in header["dataWindow"])
        names = [channel.name for channel in header["channels"]]
    check_shape(int(high[1] - low[1] + 1), int(high[0] - low[0] + 1))
    if {"R", "G", "B"} <= set(names):
        names = ["Grey", *(name for name in names if name != "A")]
    else:
        names = [name for name in names if name != "A"] or names
        names.sort(key=lambda name: name not in ("Y", "Z"))

    def load(name: str) -> Samples:
        with OpenEXR.File(os.fspath(path), separate_channels=True) as file:
            channels = file.channels()
            if name == "Grey":
                values = np.stack([channels[c].pixels for c in "RGB"], axis=-1)
            else:
                values = np.array(channels[name].pixels)
        return _samples(values)

    return [Channel(name, None, partial(load, name)) for name in names]


def _samples(values: np.ndarray, missing: np.ndarray | None = None) -> Samples:
    """Heights of a picture, top row first; NaN and what is wholly transparent are missing."""
    if values.dtype == np.bool_:
        values = values.astype(np.uint8) * 255
    if values.dtype.kind == "u" and values.dtype.itemsize <= 2:
        full_scale = float(np.iinfo(values.dtype).max)
    elif values.dtype.kind == "f":
        full_scale = 1.0
    elif values.dtype == np.int32 and values.size and values.min() >= 0 and values.max() <= 65535:
        full_scale = 65535.0  # how 16-bit grey PNGs arrive from some versions of the library
    else:
        raise ScanError(f"The image holds {values.dtype} pixels; save it as 8- or 16-bit grey, or as floats.")
    notes: tuple[str, ...] = ()
    if values.ndim == 3 and values.shape[-1] in (2, 4):
        clear = values[..., -1] == 0
        if clear.any() and not clear.all():
            missing = clear if missing is None else missing | clear
            notes = ("wholly transparent points are missing",)
    if values.ndim == 3:
        values = _grey(values, full_scale)
    if values.ndim != 2:
        raise ScanError(f"The image has the shape {values.shape}; save it as one grey picture.")
    if values.dtype.kind == "f":
        undefined = np.isnan(values)
        missing = undefined if missing is None else missing | undefined
    return Samples(values[::-1], None, None if missing is None else missing[::-1], full_scale, notes=notes)


def _grey(values: np.ndarray, full_scale: float) -> np.ndarray:
    """One channel of a grey picture stored in colour; a really coloured one is refused."""
    if values.shape[-1] in (1, 2):  # grey, with or without alpha
        return values[..., 0]
    if values.shape[-1] not in (3, 4):
        raise ScanError(f"The image has {values.shape[-1]} channels; save it as one grey picture.")
    # Two channels at a time: the largest pictures fill a good part of a gigabyte.
    for one, other in ((0, 1), (1, 2), (2, 0)):
        difference = np.subtract(values[..., one], values[..., other], dtype=np.float32)
        if np.nanmax(np.abs(difference, out=difference), initial=0.0) > _GREY_TOLERANCE * full_scale:
            raise ScanError("The image is coloured, so it tells no heights; export the heights in grey.")
    return values[..., :3].mean(axis=-1, dtype=np.float64)
