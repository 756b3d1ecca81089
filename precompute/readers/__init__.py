# SPDX-License-Identifier: GPL-3.0-or-later
"""Scans of any supported format as heightfields.

``read_scan`` finds the format by the first bytes and the extension; each format has a module of
its own that returns channels (``channel.Channel``), and its library is imported when a file of
that format is opened.
"""

from __future__ import annotations

import hashlib
import os
import struct
import warnings
import zlib
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from ..errors import DiffractionError, ScanError, SizeLimitError
from ..scan.heightfield import HeightField
from .common.channel import Channel, Samples, choose_channels
from .common.limits import LIMIT_FILE_BYTES, LIMIT_FILE_BYTES_CROPPED, check_shape, while_cropping
from .common.plausible import ImplausibleReliefError, check_relief, check_side
from .common.units import metres_per
from .common.window import part
from .formats import Format, find_format

__all__ = ["channel_names", "read_scan", "read_scan_or_part"]

#: Beyond it squares of heights overflow in single precision.
_LARGEST_HEIGHT_M = 1e12


def read_scan(
    path: str | os.PathLike[str],
    size_m: tuple[float, float] | None = None,
    height_m: float | None = None,
    channel: str | None = None,
    trust_units: bool = False,
    crop_m: tuple[float, float, float, float] | None = None,
) -> HeightField:
    """Read the heights of a scan file.

    Parameters
    ----------
    path
        The file.
    size_m
        Side lengths along x and y in metres; needed where the file carries none (images),
        otherwise it takes the place of the file's own size.
    height_m
        Height range in metres: for images the height of the full scale (255, 65535 or 1.0),
        for other files the distance from the lowest to the highest value. Needed where the
        heights carry no unit.
    channel
        Name or number of the channel; None chooses the height channel by unit and name.
    trust_units
        Take the file's own size and heights as they are, even sides above 10 mm and heights that
        span more than 1 mm, which no microscope scans and which are refused otherwise.
    crop_m
        Left, right, bottom and top in metres from the left and from the bottom: only this part is
        read, of a scan as large as it may be. ``metadata["cropped_m"]`` repeats it.

    Returns
    -------
    HeightField
        Heights in metres, row 0 at the bottom; missing points marked and NaN. ``metadata``
        holds ``name``, ``sha256``, ``format``, ``channel``, ``unit``, ``channels``, ``notes`` (one
        sentence each on what was chosen or assumed) and what else the file tells; ``processing``
        the user's scaling, if any.

    Raises
    ------
    ScanError
        If the file is missing, empty, damaged, of an unknown format, has no heights or size, or
        only such as come from a missing unit.
    SizeLimitError
        If it is larger than a reader may load.
    """
    path = Path(path)
    _check_user_scale(size_m, height_m)
    before = _check_file(path, LIMIT_FILE_BYTES if crop_m is None else LIMIT_FILE_BYTES_CROPPED)
    with _Sentences(path), while_cropping(crop_m is not None):
        digest = _sha256(path)
        form = find_format(path)
        if form.plain and (size_m is None or height_m is None):
            raise ScanError(
                "A plain image carries no units; give its size and height range, e.g. --size-um 65 65 --height-nm 800."
            )
        channels = form.read(path)
        field, chosen = _first_plausible(path, form, channels, channel, (size_m, height_m, trust_units), crop_m)
        after = path.stat()
        if (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns):
            raise ScanError("The file changed while it was read; open it again.")
    field.metadata["sha256"] = digest
    if channel is None and len(channels) > 1:
        field.metadata["notes"].insert(0, f"channel {chosen.name} was chosen of {len(channels)}")
    return field


def read_scan_or_part(
    path: str | os.PathLike[str], crop_m: tuple[float, float, float, float] | None, **reading: Any
) -> HeightField:
    """A scan as :func:`read_scan` gives it; of one too large to be read whole only the part that will be kept.

    Parameters
    ----------
    path, **reading
        See :func:`read_scan`.
    crop_m
        The part; None where all is wanted.

    Raises
    ------
    ScanError, SizeLimitError
        As :func:`read_scan`.
    """
    try:
        return read_scan(path, **reading)
    except SizeLimitError:
        if crop_m is None:
            raise
    return read_scan(path, crop_m=crop_m, **reading)


def channel_names(path: str | os.PathLike[str]) -> list[str]:
    """Names and units of all channels of a file, as a menu shows them.

    Raises
    ------
    ScanError
        As :func:`read_scan`.
    """
    path = Path(path)
    _check_file(path)
    with _Sentences(path):
        return [channel.label for channel in find_format(path).read(path)]


def _um(sides: tuple[float, ...]) -> str:
    return " x ".join(f"{1e6 * side:.6g}" for side in sides) + " um"


def _check_user_scale(size_m: tuple[float, float] | None, height_m: float | None) -> None:
    if size_m is not None and (len(tuple(size_m)) != 2 or not all(np.isfinite(size) and size > 0 for size in size_m)):
        raise ScanError(f"The size {_um(size_m)} makes no sense; give two positive side lengths.")
    if height_m is not None and not (np.isfinite(height_m) and height_m > 0):
        raise ScanError(f"The height range of {1e9 * height_m:.6g} nm makes no sense; give a positive height.")


def _first_plausible(
    path: Path,
    form: Format,
    channels: list[Channel],
    wanted: str | None,
    said: tuple[tuple[float, float] | None, float | None, bool],
    crop_m: tuple[float, float, float, float] | None,
) -> tuple[HeightField, Channel]:
    """The heights of the channel that is wanted, else of the best one whose heights can be heights.

    A sensor that is not calibrated stores volts where its file says metres; the drive's heights are right then.
    """
    size_m, height_m, trust_units = said
    passed_over: list[tuple[Channel, ImplausibleReliefError]] = []
    for chosen in choose_channels(channels, wanted, height_m is not None):
        samples = chosen.load()
        scale = _Scale(size_m, height_m, trust_units or samples.trusted)
        try:
            field = _heightfield(path, form, channels, chosen, samples, scale, crop_m)
        except ImplausibleReliefError as error:
            passed_over.append((chosen, error))
            continue
        for other, implausible in passed_over:
            field.metadata["notes"].append(f"channel {other.name} was passed over: {implausible.what}")
        return field, chosen
    raise passed_over[0][1]


@dataclass(frozen=True)
class _Scale:
    """What the user says of size and heights; ``trusted`` where the file's own need no question."""

    size_m: tuple[float, float] | None
    height_m: float | None
    trusted: bool


def _check_file(path: Path, limit: int = LIMIT_FILE_BYTES) -> os.stat_result:
    try:
        if path.is_dir():
            raise ScanError(f"'{path}' is a folder; choose a scan file in it.")
        if not path.exists():
            raise ScanError(f"There is no file '{path}'; check its name and folder.")
        if not path.is_file():
            raise ScanError(f"'{path}' is no ordinary file; choose a scan file.")
        status = path.stat()
        with open(path, "rb"):
            pass
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ScanError(f"Cannot open '{path}' ({reason}); check its name and permissions.") from error
    if status.st_size == 0:
        raise ScanError(f"'{path.name}' is empty; copy or export it again.")
    if status.st_size > limit:
        raise SizeLimitError(
            f"'{path.name}' has {status.st_size >> 20} MB, above the limit of {limit >> 20} MB; "
            "read a part of it with --crop-um LEFT RIGHT BOTTOM TOP, or export the height channel alone."
        )
    return status


def _sha256(path: Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _heightfield(
    path: Path,
    form: Format,
    channels: list[Channel],
    chosen: Channel,
    samples: Samples,
    scale: _Scale,
    crop_m: tuple[float, float, float, float] | None,
) -> HeightField:
    shape = samples.values.shape
    if samples.values.ndim != 2 or min(shape) < 2:
        raise ScanError(f"The scan has the shape {shape}; a heightfield needs at least 2 x 2 pixels.")
    notes = list(samples.notes)
    steps = []
    size_m = scale.size_m
    if size_m is not None:
        if samples.size_m is not None:
            steps.append({"step": "set size", "size_m": [float(s) for s in size_m], "before_m": list(samples.size_m)})
    elif samples.size_m is not None:
        size_m = samples.size_m
        if not all(np.isfinite(size) and size > 0 for size in size_m):
            raise ScanError(f"The file gives the size {size_m[0]:g} m x {size_m[1]:g} m; give it with --size-um X Y.")
        if not scale.trusted:
            check_side(size_m)
    else:
        raise ScanError("The file carries no size; give its side lengths, e.g. --size-um 65 65.")
    values, missing, crop_steps = _wanted(samples, size_m, crop_m)
    if missing.all():
        raise ScanError("The scan holds no valid height at all; choose another channel or file.")
    if not np.isfinite(values[~missing]).all():
        raise ScanError("The scan holds infinite or undefined heights; export it again with them marked as missing.")

    factor = _metres_per_value(chosen, samples, values, missing, scale.height_m, steps)
    with np.errstate(over="ignore"):
        values *= factor
    valid = values[~missing]
    relief = float(valid.max()) - float(valid.min())
    if scale.height_m is None and not scale.trusted:
        check_relief(relief)
    if not np.isfinite(relief) or max(abs(float(valid.max())), abs(float(valid.min()))) > _LARGEST_HEIGHT_M:
        raise ScanError("The heights are too large to be computed with; check their unit and export the scan again.")
    values[missing] = np.nan
    metadata = {
        **samples.metadata,
        "name": path.name,
        "format": form.name,
        "channel": chosen.name,
        "unit": chosen.unit,
        "channels": [channel.label for channel in channels],
        "notes": notes,
    }
    if crop_m is not None:
        metadata["cropped_m"] = [float(side) for side in crop_m]
    earlier = metadata.pop("stored_processing", [])
    if isinstance(earlier, list):
        steps = [step for step in earlier if isinstance(step, dict)] + steps
    return HeightField(
        values,
        float(size_m[0]) / shape[1],
        float(size_m[1]) / shape[0],
        missing,
        metadata,
        (*steps, *crop_steps),
    )


def _wanted(
    samples: Samples, size_m: tuple[float, float], crop_m: tuple[float, float, float, float] | None
) -> tuple[np.ndarray, np.ndarray, list[dict]]:
    """Values and missing points of the part that is wanted, as arrays of their own, and its step."""
    raw, marked, steps = samples.values, samples.missing, []
    if crop_m is not None:
        index, step = part(crop_m, raw.shape, size_m)
        raw, marked, steps = raw[index], None if marked is None else marked[index], [step]
        with while_cropping(False):
            check_shape(*raw.shape)
    values = np.array(raw if samples.decode is None else samples.decode(np.asarray(raw)), dtype=np.float64)
    missing = np.zeros(values.shape, bool) if marked is None else np.array(marked, bool)
    if samples.decode is not None:
        missing |= np.isnan(values)
    return values, missing, steps


def _metres_per_value(
    chosen: Channel,
    samples: Samples,
    values: np.ndarray,
    missing: np.ndarray,
    height_m: float | None,
    steps: list[dict],
) -> float:
    if height_m is None:
        factor = metres_per(chosen.unit)
        if factor is not None:
            return factor
        if chosen.unit:
            raise ScanError(f"Channel {chosen.name} is in {chosen.unit}, not a height; choose a height channel.")
        raise ScanError(f"The heights of {chosen.name} carry no unit; give the height range, e.g. --height-nm 800.")
    if samples.full_scale is not None:
        steps.append({"step": "set height", "height_m": float(height_m), "full_scale": samples.full_scale})
        return height_m / samples.full_scale
    valid = values[~missing]
    low, high = float(valid.min()), float(valid.max())
    if not high > low:
        return 1.0 if low == 0 else 0.0
    if not np.isfinite(high - low):
        raise ScanError("The heights are too large to be computed with; export the scan again.")
    steps.append({"step": "set height", "height_m": float(height_m), "range_before": [low, high]})
    return height_m / (high - low)


class _Sentences:
    """Turns whatever a library raises on a damaged file into one sentence, and keeps its warnings quiet."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._warnings = warnings.catch_warnings()

    def __enter__(self) -> None:
        self._warnings.__enter__()
        warnings.simplefilter("ignore")

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._warnings.__exit__(kind, error, trace)
        if error is None or not isinstance(error, Exception):
            return
        if isinstance(error, DiffractionError):
            # The reader does not know the name; the user with ten files wants it.
            kind = ScanError if isinstance(error, ScanError) else type(error)
            raise kind(_printable(f"{self._path.name}: {error}")) from error
        if isinstance(error, ImportError):
            missing = error.name or "a library"
            raise ScanError(
                f"{self._path.name}: this format needs the Python package '{missing}', which is not installed; install "
                "it, or export the heights as .gsf."
            ) from error
        if isinstance(error, OSError) and error.errno is not None:
            raise ScanError(_printable(f"{self._path.name}: cannot be read ({error.strerror}).")) from error
        raise ScanError(
            _printable(
                f"{self._path.name}: the file is damaged or of an unknown variant ({_clause(error)}); export it again."
            )
        ) from error


def _printable(sentence: str) -> str:
    """On one line and without the control characters that a damaged header may bring into a terminal."""
    return " ".join("".join(letter if letter.isprintable() else " " for letter in sentence).split())


def _clause(error: Exception) -> str:
    """A short clause that names what a library complained about."""
    text = " ".join(str(error).split())
    if not text or isinstance(error, (struct.error, zlib.error, IndexError, KeyError)):
        text = f"{type(error).__name__} {text}".strip()
    return text[:100].rstrip(" .;,")
