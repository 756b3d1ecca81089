# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake: from a patch of surface to its spectral table."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ScanError, SizeLimitError
from ..files.atomic import remove_stale
from ..light.colour import ADAPTED, adaptation, spectral_weights, white_xyz
from ..light.illuminant import to_json
from ..parameters import BakeParameters
from ..readers import read_scan_or_part
from ..scan.heightfield import HeightField
from ..scan.preparation import prepare
from ..stack import Material, Stack, fresnel_exact
from ..stack import to_json as stack_to_json
from ..table import scaled_bound
from ..table.albedo import SECTORS, albedo_map
from ..table.cache import TableCache, origin, table_key
from ..table.facts import lost_share
from ..table.layout import TableLayout, put_guard
from ..table.rivals import Rivals
from ..table.table import SpectralTable
from .balance import balance
from .budget import check_bake, check_scan, fits_memory
from .energy import Energy, energy, sector_shares
from .intensity import PolarIntensity
from .plan import plan_layout
from .refinement import refine, sentence
from .scaled_energy import scaled_bounds
from .series import chebyshev_nodes, check_single_precision, node_count
from .spectral_sum import Reflectance, SpectralSum
from .transforms import workers
from .window import Coherence, coherence

#: Called with the stage's name and the fraction of the whole that is done; may raise Cancelled.
Progress = Callable[[str, float], None]

#: Does what `PolarIntensity.coefficients` does on another device: gets it, the kappas and a progress (a fraction).
Transforms = Callable[[PolarIntensity, np.ndarray, Callable[[float], None]], np.ndarray]

#: Angles that go from the transforms to the spectral sum at a time, at most, with their opposites; bounds the memory in
#: between.
ANGLES_A_BLOCK = 72

#: Polar angles of the row that holds the reflectance of the surface's stuff.
N_REFLECTANCE = 91

#: Step of the wavelengths at which slices, radii and angles are chosen.
_COARSE_STEP_M = 2e-9

#: Texels are scaled to this largest value, well inside half floats (65504).
_LARGEST_TEXEL = 30000.0


@dataclass
class BakeReport:
    """What a bake made and what it cost.

    Parameters
    ----------
    path
        The table's EXR.
    table
        The table itself.
    seconds
        Wall time a stage, and ``total``.
    cache
        ``none``, ``hit`` (nothing was computed), ``stored`` or ``not stored`` (no room or no permission).
    notes
        What was chosen, assumed or filled in on the way, one sentence each.
    rival
        The note on another process that baked the same name meanwhile; empty where none did.
    """

    path: Path
    table: SpectralTable
    seconds: dict[str, float] = field(default_factory=dict)
    cache: str = "none"
    notes: tuple[str, ...] = ()
    rival: str = ""


class _Stages:
    """Times the stages of a bake and reports progress."""

    def __init__(self, progress: Progress | None) -> None:
        self.seconds: dict[str, float] = {}
        self._progress = progress
        self._start = self._last = time.perf_counter()

    def done(self, name: str) -> None:
        now = time.perf_counter()
        self.seconds[name] = self.seconds.get(name, 0.0) + now - self._last
        self._last = now
        self.seconds["total"] = now - self._start

    def report(self, stage: str, fraction: float) -> None:
        if self._progress is not None:
            self._progress(stage, fraction)


def resolve_sigma_s(patch: HeightField, parameters: BakeParameters) -> float:
    """The coherence window in force (metres): the given one, else the ensemble's default."""
    return window_of(patch, parameters).sigma_s_m


def window_of(patch: HeightField, parameters: BakeParameters) -> Coherence:
    """The coherence window in force, and what limits it."""
    return coherence(patch, parameters.ensemble, parameters.sigma_s_m)


def estimate(patch: HeightField, parameters: BakeParameters) -> TableLayout:
    """The layout (and so the size) that a bake of a prepared patch will have, checked against the limit.

    Raises
    ------
    SizeLimitError
        If the table would be larger than ``parameters.limit_bytes``.
    """
    half_range = 0.5 * float(np.ptp(patch.heights))
    layout = plan_layout(
        resolve_sigma_s(patch, parameters),
        parameters.ensemble,
        half_range,
        parameters.detail,
        parameters.index,
        0 if parameters.stack is None and parameters.lacquer is None else N_REFLECTANCE,
        (parameters.scale_headroom, parameters.depth_headroom),
        parameters.error_goal,
    )
    if layout.texel_bytes > parameters.limit_bytes:
        raise SizeLimitError(
            f"The table would need {layout.texel_bytes / 1e6:.0f} MB of texels ({layout.n_r} radii x {layout.n_phi}"
            f" angles x {layout.n_w} slices), more than the limit of {parameters.limit_bytes / 1e6:.0f} MB; choose a"
            " smaller sigma_s, the ensemble 'average' or a lower detail, or raise the limit."
        )
    return layout


def bake(
    scan: HeightField,
    parameters: BakeParameters,
    progress: Progress | None = None,
    memory_bytes: int | None = None,
    transforms: Transforms | None = None,
) -> SpectralTable:
    """Bake the spectral table of a scan.

    Parameters
    ----------
    scan
        As read; it is prepared here as ``parameters`` ask.
    parameters
        What decides the table.
    progress
        Called with a stage's name and a fraction; an exception it raises (``Cancelled``) ends the bake.
    memory_bytes
        Most memory that the bake may take; None asks the system what is free.
    transforms
        Computes the transforms on another device; None computes them here. Only the series ``nodes`` uses it.

    Raises
    ------
    SizeLimitError, ParameterError, ScanError
        Before any long computation or large allocation.
    """
    return _bake(scan, parameters, _Stages(progress), memory_bytes, transforms)


def bake_file(
    path: str | Path,
    out_dir: str | Path,
    parameters: BakeParameters,
    progress: Progress | None = None,
    name: str | None = None,
    cache: TableCache | None = None,
    memory_bytes: int | None = None,
    transforms: Transforms | None = None,
    **reading: Any,
) -> BakeReport:
    """Read a scan, bake it and write ``<out_dir>/<name>.exr`` and ``.json``.

    Parameters
    ----------
    path
        The scan.
    out_dir
        Folder of the table; made if missing.
    parameters, progress, memory_bytes, transforms
        See :func:`bake`.
    name
        Name of the table; the scan's by default.
    cache
        Where the table is looked up before and stored after the computation; the files are the same either way.
    **reading
        Passed to :func:`precompute.readers.read_scan` (``size_m``, ``height_m``, ``channel``, ``trust_units``).

    Returns
    -------
    BakeReport
        Path, table, seconds a stage and what the cache did.
    """
    from ..files.output_folder import ensure_folder

    stages = _Stages(progress)
    stages.report("read", 0.0)
    scan = read_scan_or_part(path, parameters.crop_m, **reading)
    folder = ensure_folder(out_dir)
    remove_stale(folder)
    target = folder / f"{name or Path(path).stem}.exr"
    rivals = Rivals(target)
    stages.done("read")
    table, found = _cached_bake(scan, parameters, stages, cache, memory_bytes, transforms)
    stages.report("write", 0.97)
    if parameters.series != "nodes":
        from .terms import save_terms

        # Before the table: whoever finds the table and its key finds its terms.
        save_terms(prepare(scan, parameters), parameters, target, table.info["key"])
    written, rival = rivals.save(table)
    stages.done("write")
    stages.report("done", 1.0)
    notes = _notes(scan, table) + ((rival,) if rival else ())
    return BakeReport(written, table, stages.seconds, found, notes, rival)


def _notes(scan: HeightField, table: SpectralTable) -> tuple[str, ...]:
    """Of the reading and of the processing that the table's sidecar lists."""
    notes = list(scan.metadata.get("notes", ()))
    for step in table.info["source"].get("processing", []):
        if step.get("step") == "fill":
            notes.append(
                f"{step['count']} missing points ({100 * step['fraction']:.2g} %) were filled from around them"
            )
        if step.get("warning"):
            notes.append(str(step["warning"]).rstrip("."))
    if said := Coherence(**table.info["coherence"]).warning:
        notes.append(said)
    if said := sentence(table.info["error"]):
        notes.append(said)
    return tuple(notes)


def _cached_bake(
    scan: HeightField,
    parameters: BakeParameters,
    stages: _Stages,
    cache: TableCache | None,
    memory_bytes: int | None,
    transforms: Transforms | None,
) -> tuple[SpectralTable, str]:
    """The table, and what the cache did."""
    if cache is None:
        return _bake(scan, parameters, stages, memory_bytes, transforms), "none"
    key = table_key(scan, parameters)
    table = cache.get(key)
    stages.done("cache")
    if table is not None:
        table.info["source"].update(origin(scan))
        table.info["colour"]["illuminant"] = to_json(parameters.illuminant)  # of another name, perhaps
        return table, "hit"
    table = _bake(scan, parameters, stages, memory_bytes, transforms)
    stored = cache.put(key, table)
    stages.done("cache")
    return table, "stored" if stored else "not stored"


def _bake(
    scan: HeightField,
    parameters: BakeParameters,
    stages: _Stages,
    memory_bytes: int | None = None,
    transforms: Transforms | None = None,
) -> SpectralTable:
    from threadpoolctl import threadpool_limits

    stages.report("prepare", 0.01)
    check_scan(scan, resolve_sigma_s(scan, parameters), parameters, memory_bytes)
    patch = prepare(scan, parameters)
    sigma_s = resolve_sigma_s(patch, parameters)
    layout = estimate(patch, parameters)
    check_bake(patch, sigma_s, layout, parameters, ANGLES_A_BLOCK, memory_bytes)
    kappa_max, index, stack = parameters.kappa_max, parameters.index, parameters.stack
    x = kappa_max * 0.5 * float(np.ptp(patch.heights))
    check_single_precision(parameters.series, x, parameters.tolerance)
    stages.report(f"{layout.texel_bytes / 1e6:.0f} MB of texels", 0.04)
    stages.done("prepare")
    wavelengths, weights = spectral_weights(illuminant=parameters.illuminant)
    white = white_xyz(parameters.illuminant)
    polar = PolarIntensity(
        patch,
        sigma_s,
        parameters.ensemble,
        parameters.series,
        parameters.tolerance,
        kappa_max,
        parameters.frequency_max,
    )
    nodes = chebyshev_nodes(kappa_max, node_count(x, parameters.tolerance))
    compute = PolarIntensity.coefficients if transforms is None or parameters.series != "nodes" else transforms
    coefficients = compute(polar, nodes, lambda done: stages.report("transforms", 0.05 + 0.5 * done))
    stages.done("transforms")

    stuff = None if stack is None else Reflectance(stack, wavelengths, parameters.lacquer, index)
    with ThreadPoolExecutor(1) as beside, threadpool_limits(1, user_api="blas"):
        key = beside.submit(table_key, scan, parameters)  # the choice of nodes leaves a processor free
        layout, reached = refine(
            polar,
            coefficients,
            nodes,
            layout,
            spectral_weights(illuminant=parameters.illuminant, step_m=_COARSE_STEP_M),
            None if stuff is None else stuff.thinned(round(_COARSE_STEP_M / (wavelengths[1] - wavelengths[0]))),
            parameters.error_goal,
            lambda finer: (
                finer.texel_bytes <= parameters.refined_bytes
                and fits_memory(patch, sigma_s, finer, parameters, ANGLES_A_BLOCK, memory_bytes)
            ),
        )
    stages.report(f"{layout.texel_bytes / 1e6:.0f} MB of texels", 0.55)
    stages.done("refine")

    def spectral_sum(
        reflectance: Reflectance | None, gain: np.ndarray | None = None, coarse: int | None = None
    ) -> SpectralSum:
        return SpectralSum(
            polar.frequencies,
            nodes,
            kappa_max,
            layout.radii,
            layout.slices,
            wavelengths,
            weights,
            lambda done: stages.report("spectral sum", 0.55 + 0.04 * done),
            reflectance,
            gain,
            coarse,
        )

    def fewer(means: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Every second frequency, which the far radii use anyway."""
        return (total.grids[-1], means[-1]) if len(means) > 1 else (total.grids[0][::2], means[0][:, ::2])

    def energy_of(means: list[np.ndarray], gain: np.ndarray | None, albedo: np.ndarray | None, capped: bool) -> Energy:
        return energy(*fewer(means), nodes, kappa_max, layout, wavelengths, index, gain, albedo, capped)

    with threadpool_limits(1, user_api="blas"):  # the products are small and threads have one each
        total, gain = spectral_sum(stuff), None
        if parameters.energy == "capped":
            means = _integrate(polar, coefficients, total, layout, stages, None)
            gain = energy_of(means, None, None, True).gain
            total = spectral_sum(stuff, gain, total.coarse)
            stages.done("energy")
        transform = np.empty((layout.n_r, layout.n_w, 3, layout.n_phi), np.float32)
        means = _integrate(polar, coefficients, total, layout, stages, transform)
        del coefficients
        total.matrices.clear()  # the largest of what is held; of the sum its grids alone are looked at from here on
        stages.done("spectral sum")
    stages.report("balance", 0.85)
    texels = balance(transform, layout, lambda done: stages.report("balance", 0.85 + 0.02 * done))
    del transform
    stages.done("balance")
    stages.report("albedo", 0.88)
    # Energy is conserved by what the relief does to light: with R = 1.
    bare = texels
    with threadpool_limits(1, user_api="blas"):
        if stack is not None:
            bare = balance(spectral_sum(None, gain, total.coarse).apply(means), layout)
        albedo = albedo_map(bare, layout, white, lambda done: stages.report("albedo", 0.88 + 0.04 * done), index)
        stages.done("albedo")
        kept = energy_of(means, gain, albedo, False)
        stages.done("energy")
    del bare
    conserving = np.where(kept.bound > 1.0, np.maximum(albedo, kept.bound), albedo)
    stages.done("albedo")
    stages.report("atlas", 0.92)
    to_adapted = adaptation(parameters.illuminant)
    seen = None
    if layout.n_reflectance:
        seen = _seen_reflectance(stack, parameters.lacquer, index, wavelengths, weights)
        seen = seen if to_adapted is None else seen @ to_adapted.T
    layout, atlas = assemble(texels, layout, np.stack([albedo, conserving]), to_adapted, seen)
    del texels
    stages.done("atlas")
    spent: dict[str, object] = {
        "model": parameters.energy,
        "albedo_max_xyz": float(albedo.max()),
        "share_cut": kept.share_cut,
        "share_lost": lost_share(albedo),
    }
    info = {
        "key": key.result(),
        "parameters": {**parameters.to_dict(), "sigma_s_m": sigma_s},
        "source": {
            **origin(scan),
            "shape": list(patch.shape),
            "size_m": list(patch.size_m),
            "processing": [dict(step) for step in patch.processing],
        },
        "colour": {
            "illuminant": to_json(parameters.illuminant),
            "observer": "CIE 1931 2 degree",
            "adapted": None if to_adapted is None else ADAPTED,
            "white_xyz": [float(x) for x in (white if to_adapted is None else to_adapted @ white)],
            "wavelengths_m": [float(wavelengths[0]), float(wavelengths[-1])],
            "wavelength_step_m": float(wavelengths[1] - wavelengths[0]),
        },
        "terms": polar.series.terms or len(nodes),
        "albedo_max": float(conserving.max()),
        "energy": spent,
        "error": reached.to_json(),
        "coherence": window_of(patch, parameters).to_json(),
    }
    if stack is not None:
        info["stack"] = {**(stack_to_json(stack) or {}), "text": str(stack), "notes": list(stack.notes)}
    if seen is not None:  # every five degrees, for readers without the atlas
        info["reflectance_xyz"] = np.round(seen[:: (N_REFLECTANCE - 1) // 18], 6).tolist()
    if parameters.lacquer is not None:
        info["lacquer"] = {"material": parameters.lacquer.to_json(), "n": index}
    table = SpectralTable(layout, atlas, info)
    with threadpool_limits(1, user_api="blas"):
        bound = scaled_bounds(table, albedo, *fewer(means), nodes, kappa_max, wavelengths, gain)
    spent["scaled_bound"] = scaled_bound.pack(bound)
    stages.done("scaled energy")
    return table


def blocks_of_angles(count: int) -> list[slice]:
    """Even blocks of half a circle, six or a multiple where they are not too small: 2, 3 or 6 threads end together.

    They do not depend on the threads, so that the same bake gives the same bytes on one processor and on many.
    """
    size = max(24, math.ceil(count / (6 * math.ceil(count / (6 * ANGLES_A_BLOCK)))))
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]


def _integrate(
    polar: PolarIntensity,
    coefficients: np.ndarray,
    total: SpectralSum,
    layout: TableLayout,
    stages: _Stages,
    transform: np.ndarray | None,
) -> list[np.ndarray]:
    """T in XYZ into ``transform`` ``(n_r, n_w, 3, n_phi)``, unless it is None, block by block of angles.

    Returns means of S over sectors, ``(sectors, n_f, n)`` for each of the sum's grids.
    """
    half = layout.n_phi // 2
    blocks = blocks_of_angles(half)
    flat = None if transform is None else transform.reshape(layout.n_r, layout.n_w * 3, layout.n_phi)
    sectors = min(SECTORS, layout.n_phi)
    means = [np.zeros((sectors, len(each), total.n_nodes), np.float32) for each in total.grids]

    def integrate(block: slice) -> list[tuple[int, list[np.ndarray]]]:
        """Some angles, and those half a circle on; their shares of the sectors."""
        seen = [polar.polar(coefficients, layout.angles[block], each, opposite=True) for each in total.grids]
        both = [block, slice(block.start + half, block.stop + half)]
        if flat is not None:
            total.apply_into(seen, [flat[..., each] for each in both])
        found = []
        for each, first in zip(both, (0, len(seen[0]) // 2), strict=True):
            low, share = sector_shares(layout, each.start, each.stop)
            lines = [x[first : first + share.shape[1]] for x in seen]
            found.append((low, [(share @ x.reshape(len(x), -1)).reshape(-1, *x.shape[1:]) for x in lines]))
        return found

    with ThreadPoolExecutor(workers()) as pool:
        for done, found in enumerate(pool.map(integrate, blocks), 1):
            for low, parts in found:
                for mean, part in zip(means, parts, strict=True):
                    mean[low : low + len(part)] += part
            stages.report("spectral sum", 0.59 + 0.25 * done / len(blocks))
    return means


def _seen_reflectance(
    stack: Stack | None, lacquer: Material | None, index: float, wavelengths: np.ndarray, weights: np.ndarray
) -> np.ndarray:
    """``(N_REFLECTANCE, 3)`` in XYZ, 1 as white: what stack and lacquer keep from below, over a view's angle."""
    cosine = np.cos(np.linspace(0.0, 0.5 * np.pi, N_REFLECTANCE))
    outer = fresnel_exact(index, cosine) if lacquer is not None else np.zeros(N_REFLECTANCE)
    inside = np.sqrt(np.maximum(1.0 - (1.0 - cosine**2) / index**2, 0.0))
    below = np.zeros((len(wavelengths), N_REFLECTANCE))
    if stack is not None:
        below = stack.reflectance(wavelengths, inside, lacquer)
    return (1.0 - (1.0 - outer) * (1.0 - below)).T @ weights


def assemble(
    texels: np.ndarray,
    layout: TableLayout,
    albedo: np.ndarray,
    to_adapted: np.ndarray | None = None,
    reflectance: np.ndarray | None = None,
) -> tuple[TableLayout, np.ndarray]:
    """Put the table's nodes into the atlas as half floats.

    Parameters
    ----------
    texels
        ``(n_r, n_w, 3, n_phi)``, ``T / |w|^power`` in XYZ.
    layout
        Its scale is replaced.
    albedo
        ``(n_albedo_phi, n_theta)`` for all albedo tiles, or ``(n_albedo, ...)`` for each.
    to_adapted
        ``(3, 3)`` what the XYZ of the texels are multiplied by, see `precompute.light.colour.adaptation`. Saturated
        colours may leave it with a negative component, as they do any adaptation.
    reflectance
        ``(n_reflectance, 3)`` for the row of that name, adapted.

    Returns
    -------
    layout : TableLayout
        With the scale in force.
    atlas : ndarray
        ``(height, width, 3)`` float16, row 0 at the bottom.

    Raises
    ------
    ScanError
        If no light at all is diffracted into the table's domain.
    """
    turn = None if to_adapted is None or np.array_equal(to_adapted, np.eye(3)) else to_adapted.astype(np.float32)
    # No component of what is adapted is larger than this.
    gain = 1.0 if turn is None else max(1.0, float(np.abs(turn).sum(axis=1).max()))
    peak = float(texels.max()) * gain
    if not np.isfinite(peak) or peak <= 0.0:
        raise ScanError("The patch diffracts no light into the visible range; check the scan's size and heights.")
    layout = replace(layout, scale=peak / _LARGEST_TEXEL)
    factor = np.float32(1.0 / layout.scale)
    atlas = np.zeros((layout.height, layout.width, 3), np.float16)

    def put(index: int) -> None:
        x, y = layout.tile_origin(index)
        tile = atlas[y : y + layout.tile_height, x : x + layout.n_r]
        slice_texels = texels[:, index] if turn is None else np.matmul(turn, texels[:, index])
        tile[1:-1] = (slice_texels * factor).transpose(2, 0, 1)
        tile[0], tile[-1] = tile[-2], tile[1]

    with ThreadPoolExecutor(workers()) as pool:
        list(pool.map(put, range(layout.n_w)))
    for number, values in enumerate(np.broadcast_to(albedo, (layout.n_albedo, layout.n_albedo_phi, layout.n_theta))):
        y = layout.albedo_y + number * layout.albedo_height
        tile = atlas[y : y + layout.albedo_height, : layout.n_theta]
        tile[1:-1] = values[:, :, None]
        tile[0], tile[-1] = tile[-2], tile[1]
    if reflectance is not None:
        atlas[layout.reflectance_y - 1 : layout.reflectance_y + 2, : layout.n_reflectance] = reflectance
    put_guard(atlas, layout)
    return layout, atlas
