# SPDX-License-Identifier: GPL-3.0-or-later
"""Options that several subcommands share, and what they mean in SI units."""

from __future__ import annotations

import argparse
import math
import os
import sys
from typing import TYPE_CHECKING, Any

import numpy as np

from ..constants import CACHE_LIMIT_BYTES
from ..errors import ParameterError
from ..evaluate.directions import from_angles
from ..light.illuminant import ILLUMINANTS, Illuminant, illuminant_of, read_spectrum
from ..parameters import ENERGY, ENSEMBLES, LEVELS, ROW_AXES, SERIES, TILINGS, BakeParameters
from ..scan.heightfield import HeightField

if TYPE_CHECKING:
    from ..table.cache import TableCache
    from ..table.table import SpectralTable


def number(text: str) -> float:
    """A finite number, for argparse."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is no number") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"'{text}' is not finite")
    return value


def light(text: str) -> Illuminant:
    """A name of an illuminant or the spectrum in a file, for argparse."""
    try:
        return illuminant_of(text) if text in ILLUMINANTS or not os.path.exists(text) else read_spectrum(text)
    except ParameterError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def add_scan(parser: argparse.ArgumentParser, several: bool = False) -> None:
    """FILE (or several) and what a file may fail to say about itself."""
    if several:
        parser.add_argument("file", nargs="+", metavar="FILE", help="the scans")
    else:
        parser.add_argument("file", metavar="FILE", help="the scan")
    parser.add_argument("--size-um", nargs=2, type=number, metavar=("X", "Y"), help="side lengths in micrometres")
    parser.add_argument("--height-nm", type=number, metavar="H", help="height range in nanometres")
    parser.add_argument("--channel", help="name or number of the channel; the height channel by default")
    parser.add_argument(
        "--trust-units",
        action="store_true",
        help="take sides above 10 mm and heights above 1 mm from the file without a question",
    )


def scan_reading(args: argparse.Namespace) -> dict[str, Any]:
    """Keyword arguments of `precompute.readers.read_scan`."""
    return {
        **({"trust_units": True} if args.trust_units else {}),
        "size_m": None if args.size_um is None else tuple(x * 1e-6 for x in args.size_um),
        "height_m": None if args.height_nm is None else args.height_nm * 1e-9,
        "channel": args.channel,
    }


def read(args: argparse.Namespace) -> HeightField:
    """The scan that `add_scan` names."""
    from ..readers import read_scan_or_part

    return read_scan_or_part(args.file, crop(args), **scan_reading(args))


def crop(args: argparse.Namespace) -> tuple[float, float, float, float] | None:
    """--crop-um in metres, where the subcommand has it."""
    given = getattr(args, "crop_um", None)
    if given is None:
        return None
    left, right, bottom, top = (x * 1e-6 for x in given)
    return left, right, bottom, top


def add_crop(parser: argparse.ArgumentParser) -> None:
    """--crop-um."""
    parser.add_argument(
        "--crop-um", nargs=4, type=number, metavar=("LEFT", "RIGHT", "BOTTOM", "TOP"), help="keep this rectangle"
    )


def add_parameters(parser: argparse.ArgumentParser, several: bool = False) -> None:
    """What decides a bake; the defaults are those of `BakeParameters`. ``several`` lets each take many values."""
    default = BakeParameters()
    many: dict[str, Any] = {"nargs": "+"} if several else {}
    parser.add_argument(
        "--sigma-s-um",
        type=number,
        metavar="S",
        help="coherence width; by default a tenth of the shorter side (average), or 16.25 and at most a quarter of it"
        " (single)",
        **many,
    )
    parser.add_argument("--ensemble", choices=ENSEMBLES, default=default.ensemble, **many)
    parser.add_argument("--series", choices=SERIES, default=default.series, **many)
    parser.add_argument(
        "--tolerance",
        type=number,
        metavar="E",
        default=default.tolerance,
        help="largest error of the expansion in kappa, before any table; --error is that of lookups in it",
        **many,
    )
    parser.add_argument("--level", choices=LEVELS, default=default.level, **many)
    parser.add_argument("--clip", type=number, metavar="P", help="keep the middle P percent of heights", **many)
    parser.add_argument(
        "--align-rows", choices=ROW_AXES, default=default.align_rows, help="subtract the lines' medians", **many
    )
    parser.add_argument("--smooth-nm", type=number, metavar="S", default=0.0, help="smooth the heights", **many)
    if not several:
        add_crop(parser)
    parser.add_argument("--tile", choices=TILINGS, default=default.tile, help="make opposite edges fit", **many)
    parser.add_argument(
        "--illuminant",
        type=light,
        default=default.illuminant,
        metavar="NAME|FILE",
        help=f"{', '.join(ILLUMINANTS)}, or a text file of two columns: wavelength in nm, relative power",
        **many,
    )


def add_stack(parser: argparse.ArgumentParser) -> None:
    """--substrate and --film."""
    parser.add_argument(
        "--substrate",
        metavar="MATERIAL",
        help="what the surface is made of: a name such as Au or keratin, an index, n,k or a file; its reflectance goes"
        " into the table",
    )
    add_film(parser)


def add_film(parser: argparse.ArgumentParser) -> None:
    """--film."""
    parser.add_argument(
        "--film",
        action="append",
        default=[],
        metavar="MATERIAL:NM",
        help="a film on it and its thickness; repeat it, outermost first; '(chitin:100,melanin:80)x12' repeats a group",
    )


def add_stuff(parser: argparse.ArgumentParser) -> None:
    """`add_stack`, --lacquer and --energy."""
    add_stack(parser)
    add_lacquer(parser)
    parser.add_argument(
        "--energy",
        choices=ENERGY,
        default=BakeParameters().energy,
        help="'capped' cuts each wavelength by its own excess inside the table; by default renderers divide",
    )


def add_lacquer(parser: argparse.ArgumentParser) -> None:
    """--lacquer."""
    parser.add_argument("--lacquer", metavar="MATERIAL", help="a clear layer over the relief")


def stuff(args: argparse.Namespace) -> dict[str, Any]:
    """Keyword arguments of `BakeParameters` that `add_stack` or `add_stuff` collected; none where it was not asked."""
    if "substrate" not in args:
        return {}
    from ..stack import material_of, parse_stack

    found: dict[str, Any] = {"stack": parse_stack(args.substrate, args.film)}
    if "lacquer" in args:
        found |= {"lacquer": None if args.lacquer is None else material_of(args.lacquer), "energy": args.energy}
    return found


def said_stuff(parameters: BakeParameters) -> dict[str, Any]:
    """The same as `SpectralTable.stuff`, before there is a table."""
    said: dict[str, Any] = {}
    if parameters.stack is not None:
        said = {"stack": str(parameters.stack), "notes": list(parameters.stack.notes)}
    if parameters.lacquer is not None:
        said["lacquer"] = {"material": parameters.lacquer.to_json(), "n": parameters.index}
    return said


def stuff_lines(result: dict[str, Any]) -> list[str]:
    """What `SpectralTable.stuff` says, in words."""
    lines = [f"R of {result['stack']} is inside"] if "stack" in result else []
    if "lacquer" in result:
        lines.append(f"under a lacquer of n = {result['lacquer']['n']:.4f}")
    return lines


def add_headroom(parser: argparse.ArgumentParser) -> None:
    """--scale-headroom and --depth-headroom."""
    for what in ("scale", "depth"):
        parser.add_argument(
            f"--{what}-headroom",
            type=number,
            default=1.0,
            metavar="X",
            help=f"largest {what} of a painted surface that the table is to hold; more than 1 makes it larger",
        )


def add_replicas(parser: argparse.ArgumentParser) -> None:
    """--replicas, for the ensemble ``periodic``."""
    parser.add_argument(
        "--replicas", nargs=2, type=int, metavar=("NX", "NY"), default=BakeParameters().replicas,
        help="copies of the scan, which is one period, for the ensemble 'periodic'",
    )  # fmt: skip


def bake_parameters(args: argparse.Namespace, **more: Any) -> BakeParameters:
    """The parameters that `add_parameters` collected, in SI units."""
    if "replicas" in args and args.ensemble == "periodic":
        more.setdefault("replicas", tuple(args.replicas))
    for name in ("scale_headroom", "depth_headroom"):
        if name in args:
            more.setdefault(name, getattr(args, name))
    fields = {name: _si(args, key, factor) for name, key, factor in _FIELDS}
    return BakeParameters(**fields, crop_m=crop(args), **stuff(args), **more)


def parameter_values(args: argparse.Namespace) -> dict[str, list[Any]]:
    """All values that `add_parameters` with ``several`` (and ``--detail``) collected, in SI units."""
    values = {}
    for name, key, factor in (*_FIELDS, ("detail", "detail", 1.0), ("error", "error", 0.01)):
        value = _si(args, key, factor)
        values[name] = value if isinstance(value, list) else [value]
    return values


#: Field of `BakeParameters`, option, and its unit in SI (None for words).
_FIELDS = (
    ("sigma_s_m", "sigma_s_um", 1e-6),
    ("ensemble", "ensemble", None),
    ("series", "series", None),
    ("tolerance", "tolerance", 1.0),
    ("level", "level", None),
    ("clip_percent", "clip", 1.0),
    ("align_rows", "align_rows", None),
    ("smooth_m", "smooth_nm", 1e-9),
    ("tile", "tile", None),
    ("illuminant", "illuminant", None),
)


def _si(args: argparse.Namespace, key: str, factor: float | None) -> Any:
    value = getattr(args, key)
    if value is None or factor is None:
        return value
    return [x * factor for x in value] if isinstance(value, list) else value * factor


def add_cache(parser: argparse.ArgumentParser) -> None:
    """--cache and its limit. Without them nothing is kept: no file appears outside the folders the user names."""
    parser.add_argument(
        "--cache",
        metavar="DIR",
        default=os.environ.get("DIFFRACTION_CACHE_DIR") or "none",
        help="keep tables in this folder and take them from it; 'none' (the default unless the environment variable"
        " DIFFRACTION_CACHE_DIR names a folder) keeps none",
    )
    parser.add_argument(
        "--cache-limit-mb",
        type=number,
        default=CACHE_LIMIT_BYTES / 1e6,
        metavar="MB",
        help="the tables used longest ago go when the cache is larger than this",
    )


def cache(args: argparse.Namespace) -> TableCache | None:
    """The cache that `add_cache` names."""
    from ..table.cache import TableCache

    return None if args.cache == "none" else TableCache(args.cache, int(args.cache_limit_mb * 1e6))


def add_directions(parser: argparse.ArgumentParser) -> None:
    """--wi and --wr in degrees."""
    for name, target in (("wi", "light"), ("wr", "viewer")):
        parser.add_argument(
            f"--{name}",
            nargs=2,
            type=number,
            required=True,
            metavar=("THETA", "PHI"),
            help=f"direction towards the {target}: polar angle and azimuth in degrees",
        )


def add_scaling(parser: argparse.ArgumentParser) -> None:
    """--scale, --depth and --rotation of a painted surface."""
    parser.add_argument("--scale", type=number, default=1.0, metavar="S", help="period over the one baked")
    parser.add_argument("--depth", type=number, default=1.0, metavar="Q", help="depth over the one baked")
    parser.add_argument("--rotation", type=number, default=0.0, metavar="A", help="degrees, from tangent to bitangent")


def scaled(args: argparse.Namespace, table: SpectralTable) -> tuple[Any, dict[str, Any]]:
    """The table as `add_scaling` says, and what the result must say about it."""
    if (args.scale, args.depth, args.rotation) == (1.0, 1.0, 0.0):
        return table, {}
    from ..evaluate.scaled import ScaledTable

    changed = ScaledTable(table, args.scale, args.depth, math.radians(args.rotation))
    note: dict[str, Any] = {"scale": args.scale, "depth": args.depth, "rotation_deg": args.rotation}
    notes = []
    if changed.beyond:
        most = " and ".join(f"{value:g}" for value in table.headroom)
        notes.append(
            f"A scale or depth above {most} passes the rim of the table, whose last values are taken there; bake with"
            " --scale-headroom or --depth-headroom for more."
        )
    if changed.approximate:
        notes.append(
            "The stack's reflectance at the scaled coordinates is corrected in X, Y and Z alone, which is approximate."
        )
    if notes:
        note["note"] = " ".join(notes)
    return changed, note


def direction(angles_deg: list[float]) -> np.ndarray:
    """``(3,)`` unit vector of polar angle and azimuth in degrees."""
    return from_angles(*np.radians(angles_deg))


class Progress:
    """Prints the stage and the percentage on standard error: in place on a terminal, a line a stage elsewhere."""

    def __init__(self) -> None:
        self._terminal = sys.stderr.isatty()
        self._stage = ""

    def __call__(self, stage: str, fraction: float) -> None:
        if self._terminal:
            print(f"\r\033[K{100 * fraction:3.0f} %  {stage}", end="", file=sys.stderr, flush=True)
        elif stage != self._stage:
            print(f"{100 * fraction:3.0f} %  {stage}", file=sys.stderr, flush=True)
        self._stage = stage

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._terminal and self._stage:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
