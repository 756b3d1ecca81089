# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures that people bring, as linear colours."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ..errors import ParameterError

#: Most pixels of a picture.
LIMIT_PIXELS = 64_000_000


def read_picture(path: str | os.PathLike[str]) -> np.ndarray:
    """A picture as linear Rec.709; transparent parts are black.

    8-bit files are taken as sRGB (IEC 61966-2-1); an EXR holds linear values.

    Returns
    -------
    ndarray
        ``(rows, cols, 3)`` float64, row 0 at the bottom.

    Raises
    ------
    ParameterError
        If the file cannot be read as a picture.
    """
    path = Path(path)
    try:
        values = _exr(path) if path.suffix.lower() == ".exr" else _encoded(path)
    except ParameterError:
        raise
    except FileNotFoundError as error:
        raise ParameterError(f"The picture {path} does not exist.") from error
    except Exception as error:  # either library raises exceptions of many kinds
        raise ParameterError(f"{path.name} cannot be read as a picture; save it as PNG, JPEG or EXR.") from error
    if not np.isfinite(values).all():
        raise ParameterError(f"{path.name} holds values that are no numbers.")
    return np.clip(values[..., :3] * values[..., 3:], 0.0, None)[::-1]


def _encoded(path: Path) -> np.ndarray:
    from PIL import Image

    with Image.open(path) as image:
        if image.width * image.height > LIMIT_PIXELS:
            raise ParameterError(f"{path.name} has {image.width} x {image.height} pixels; make it smaller.")
        values = np.asarray(image.convert("RGBA"), float) / 255.0
    colour = values[..., :3]
    linear = np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
    return np.concatenate([linear, values[..., 3:]], axis=-1)


def _exr(path: Path) -> np.ndarray:
    import OpenEXR

    with OpenEXR.File(os.fspath(path), separate_channels=True) as image:
        channels = {name: channel.pixels.astype(float) for name, channel in image.channels().items()}
    if "R" in channels:
        found = [channels.get(name) for name in "RGB"]
        if any(each is None for each in found):
            raise ParameterError(f"{path.name} has not all of the channels R, G and B.")
        rgb = np.stack(found, axis=-1)  # type: ignore[arg-type]
    elif "Y" in channels:
        rgb = np.repeat(channels["Y"][..., None], 3, axis=-1)
    else:
        raise ParameterError(f"{path.name} has neither channels R, G, B nor Y.")
    return np.concatenate([rgb, np.ones_like(rgb[..., :1])], axis=-1)  # EXR colours are premultiplied already
