# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import secrets
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import OutputError

#: How the names of temporary files begin; one is left behind where a process is killed.
TEMPORARY = ".tmp-"

#: Such a file goes after this time (seconds); no write takes as long.
STALE_AFTER = 3600.0


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary path in the folder of ``path`` that takes its place when the block ends well.

    The temporary file keeps the suffix of ``path``, since many writers choose their format by
    it. The folder is created when it does not exist. When the block raises, the temporary file
    goes away and whatever stood at ``path`` before stays as it was.

    Parameters
    ----------
    path
        The file to write.

    Yields
    ------
    Path
        The temporary file, existing and empty: write to it, do not rename it.

    Raises
    ------
    OutputError
        If the folder cannot be made or written, ``path`` is a folder, or the disk is full.

    Examples
    --------
    >>> with atomic_path("out/map.png") as temporary:  # doctest: +SKIP
    ...     write_png(temporary)
    """
    target = Path(path)
    try:
        if target.is_dir():
            raise OutputError(f"Cannot write '{target}': it is a folder; give the name of a file in it.")
        target.parent.mkdir(parents=True, exist_ok=True)
        # A short name of its own, so that long target names do not pass the limit of the file system.
        # Not by tempfile, whose files are private: this one gets the mode of an ordinary new file.
        temporary = target.parent / f"{TEMPORARY}{secrets.token_hex(8)}{target.suffix}"
        temporary.touch(exist_ok=False)
    except OSError as error:
        raise _cannot_write(target, error) from error
    try:
        try:
            yield temporary
            _flush(temporary)
            os.replace(temporary, target)
        except OSError as error:
            raise _cannot_write(target, error) from error
    finally:
        temporary.unlink(missing_ok=True)


def remove_stale(folder: str | os.PathLike[str]) -> None:
    """Remove temporary files that killed processes left in a folder long ago."""
    for path in Path(folder).glob(f"{TEMPORARY}*"):
        with suppress(OSError):  # removed meanwhile, or not ours to remove
            if path.is_file() and time.time() - path.stat().st_mtime > STALE_AFTER:
                path.unlink()


def _cannot_write(target: Path, error: OSError) -> OutputError:
    reason = (error.strerror or str(error) or type(error).__name__).rstrip(".")
    return OutputError(f"Cannot write '{target}' ({reason}); choose a folder that you may write to and that has space.")


def _flush(path: Path) -> None:
    """Bytes on the disk before the rename, so that a power cut cannot leave an empty file under the final name."""
    handle = os.open(path, os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
