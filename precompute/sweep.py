# SPDX-License-Identifier: GPL-3.0-or-later
"""Many bakes: scans times parameters, in this process or on the workers of a dask scheduler.

A task is a path and parameters, so almost nothing travels; workers read the scans and write the tables
themselves, and on several machines both folders must be shared. A task whose table exists already (the
sidecar's key says so, and its pixels match their hash) is skipped: the same call again resumes.
"""

from __future__ import annotations

import itertools
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from .errors import DiffractionError, ParameterError, TableError
from .files.atomic import atomic_path
from .files.output_folder import ensure_folder
from .light.illuminant import Spectrum
from .parameters import BakeParameters
from .table.cache import TableCache, table_key

#: The report of a sweep, in the folder of its tables.
REPORT = "sweep.json"

#: Short names of the swept parameters in the names of tables, and what their values are multiplied by.
_SHORT = {"sigma_s_m": ("s", 1e6), "clip_percent": ("clip", 1.0), "tolerance": ("tol", 1.0), "detail": ("detail", 1.0)}


@dataclass(frozen=True)
class Task:
    """One bake of a sweep.

    Parameters
    ----------
    path
        The scan, absolute.
    name
        Name of the table.
    parameters
        What decides it.
    reading
        Passed to :func:`precompute.readers.read_scan`.
    """

    path: str
    name: str
    parameters: BakeParameters
    reading: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    """What became of a task: ``baked``, ``cached``, ``skipped`` (it was there) or ``failed``."""

    name: str
    state: str
    table: str = ""
    error: str = ""
    seconds: float = 0.0


def make_tasks(
    paths: Sequence[str | os.PathLike[str]],
    base: BakeParameters,
    values: Mapping[str, Sequence[Any]],
    reading: dict[str, Any] | None = None,
) -> list[Task]:
    """All combinations of scans and parameter values.

    Parameters
    ----------
    paths
        The scans.
    base
        Parameters that all bakes share.
    values
        Values by field of ``BakeParameters``; a field with several takes part in the tables' names.
    reading
        How to read every scan.

    Raises
    ------
    ParameterError
        If two tables would have one name, or a value makes no sense.
    """
    tasks = []
    for path in paths:
        for combination in itertools.product(*values.values()):
            chosen = dict(zip(values, combination, strict=True))
            words = [_word(key, value) for key, value in chosen.items() if len(values[key]) > 1]
            name = "_".join([Path(path).stem, *words])
            tasks.append(Task(os.path.abspath(path), name, replace(base, **chosen), dict(reading or {})))
    seen: set[str] = set()
    for task in tasks:
        if task.name.casefold() in seen:
            raise ParameterError(
                f"Two tables of the sweep would be called '{task.name}'; give the scans different names and no value"
                " twice."
            )
        seen.add(task.name.casefold())
    return tasks


def _word(key: str, value: Any) -> str:
    short, factor = _SHORT.get(key, (key, 1.0))
    if isinstance(value, float):
        return f"{short}-{value * factor:.6g}"
    return str(value) if isinstance(value, (str, Spectrum)) else f"{short}-{value}"


def bake_task(task: Task, out_dir: str, cache_dir: str | None = None, cache_limit: int | None = None) -> Outcome:
    """Do one task; runs in a worker.

    A fault of the input comes back as an outcome, since no retry mends it; anything else is raised.
    """
    from .bake.baking import bake_file
    from .readers import read_scan

    try:
        target = Path(out_dir) / f"{task.name}.exr"
        if _finished(target, table_key(read_scan(task.path, **task.reading), task.parameters)):
            return Outcome(task.name, "skipped", str(target))
        limit = {} if cache_limit is None else {"limit_bytes": cache_limit}
        cache = None if cache_dir is None else TableCache(cache_dir, **limit)
        report = bake_file(task.path, out_dir, task.parameters, None, task.name, cache, **task.reading)
        state = "cached" if report.cache == "hit" else "baked"
        return Outcome(task.name, state, str(report.path), seconds=round(report.seconds["total"], 3))
    except DiffractionError as error:
        return Outcome(task.name, "failed", error=str(error))


def _finished(path: Path, key: str) -> bool:
    from .table.table import SpectralTable

    try:
        return SpectralTable.load(path).info.get("key") == key
    except TableError:
        return False


def sweep(
    tasks: Sequence[Task],
    out_dir: str | os.PathLike[str],
    scheduler: str | None = None,
    workers: int = 2,
    retries: int = 3,
    cache_dir: str | os.PathLike[str] | None = None,
    cache_limit: int | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> list[Outcome]:
    """Bake all tasks and write ``sweep.json`` beside the tables.

    Parameters
    ----------
    tasks
        See :func:`make_tasks`.
    out_dir
        Folder of the tables; on several machines one that all of them see.
    scheduler
        Address of a running dask scheduler; None starts a cluster of ``workers`` processes on this machine.
    workers
        Processes of the local cluster; 0 bakes one after the other in this process, without dask.
    retries
        How often a task is tried again after a worker died or an unexpected error.
    cache_dir, cache_limit
        See :class:`precompute.table.cache.TableCache`.
    progress
        Called with the last task's name and the fraction done.

    Returns
    -------
    list of Outcome
        In the order of ``tasks``.

    Raises
    ------
    ParameterError
        If dask is not installed or no scheduler answers.
    OutputError
        If the folder cannot be written.
    """
    folder = ensure_folder(os.path.abspath(out_dir))
    rest = (str(folder), None if cache_dir is None else os.path.abspath(cache_dir), cache_limit)
    outcomes: dict[str, Outcome] = {}
    stream = (
        _here(tasks, rest)
        if scheduler is None and workers == 0
        else _on_dask(tasks, rest, scheduler, workers, retries, folder)
    )
    for outcome in stream:
        outcomes[outcome.name] = outcome
        if progress is not None:
            progress(f"{len(outcomes)} of {len(tasks)}: {outcome.name} {outcome.state}", len(outcomes) / len(tasks))
    ordered = [outcomes[task.name] for task in tasks]
    _write_report(folder / REPORT, tasks, ordered)
    return ordered


def _here(tasks: Sequence[Task], rest: tuple) -> Iterator[Outcome]:
    for task in tasks:
        yield bake_task(task, *rest)


def _on_dask(
    tasks: Sequence[Task], rest: tuple, scheduler: str | None, workers: int, retries: int, folder: Path
) -> Iterator[Outcome]:
    try:
        import dask
        from distributed import Client, LocalCluster, as_completed
    except ImportError as error:
        raise ParameterError(
            f"A sweep over several processes needs the Python package '{error.name}', which is not installed: install"
            " 'distributed' (it brings dask), or bake in this process with --workers 0."
        ) from error
    import logging
    import tempfile
    from contextlib import ExitStack

    with ExitStack() as stack:
        # Each worker that dies under a task counts; dask gives up after this many.
        stack.enter_context(dask.config.set({"distributed.scheduler.allowed-failures": retries}))
        if scheduler is None:
            # Workers keep their files in the chosen folder, listen on this machine only and show no web page.
            space = stack.enter_context(tempfile.TemporaryDirectory(prefix=".tmp-sweep-", dir=folder))
            cluster = stack.enter_context(
                LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    processes=True,
                    dashboard_address=None,
                    local_directory=space,
                    silence_logs=logging.CRITICAL,
                )
            )
            client = stack.enter_context(Client(cluster))
        else:
            try:
                client = stack.enter_context(Client(scheduler, timeout="15s"))
            except (OSError, ValueError) as error:
                raise ParameterError(
                    f"No dask scheduler answers at '{scheduler}'; start one with 'dask scheduler', or leave"
                    " --scheduler out to bake on this machine."
                ) from error
        names = {}
        for task in tasks:
            future = client.submit(bake_task, task, *rest, retries=retries, pure=False, key=f"bake-{task.name}")
            names[future] = task.name
        for future in as_completed(names):
            failure = future.exception()
            yield future.result() if failure is None else Outcome(names[future], "failed", error=_sentence(failure))


def _sentence(error: BaseException) -> str:
    if type(error).__name__ == "KilledWorker":
        return "Its worker died each time it was tried, perhaps for want of memory; bake this scan alone."
    return " ".join(f"{type(error).__name__}: {error}".split())[:300]


def _write_report(path: Path, tasks: Sequence[Task], outcomes: Sequence[Outcome]) -> None:
    """What was asked for and what became of it; no times, so that the same tables give the same report."""
    entries = [
        {
            "name": task.name,
            "scan": task.path,
            "parameters": task.parameters.to_dict(),
            "table": Path(outcome.table).name,
            "error": outcome.error,
        }
        for task, outcome in zip(tasks, outcomes, strict=True)
    ]
    with atomic_path(path) as temporary:
        temporary.write_text(json.dumps(entries, indent=1, sort_keys=True) + "\n", encoding="utf-8")
