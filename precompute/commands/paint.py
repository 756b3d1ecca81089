# SPDX-License-Identifier: GPL-3.0-or-later
"""Turn a recipe or a picture into maps of period, depth and direction that paint a surface."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..paint.recipe import Setting
from ..paint.recipes import RECIPES
from . import options


def _settings() -> dict[str, list[tuple[str, Setting]]]:
    """All recipes' settings by name, with the recipes that have them."""
    found: dict[str, list[tuple[str, Setting]]] = {}
    for recipe in RECIPES.values():
        for setting in recipe.settings:
            found.setdefault(setting.name, []).append((recipe.name, setting))
    return found


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """RECIPE, --out, the table's period and each recipe's own settings."""
    parser.add_argument("recipe", metavar="RECIPE", help=", ".join(RECIPES))
    parser.add_argument("--out", required=True, metavar="FILE", help="one .exr: R scale, G depth, B rotation, A mask")
    parser.add_argument("--table", metavar="FILE", help="the table to paint with: its period, window and headroom hold")
    parser.add_argument(
        "--period-um", type=options.number, metavar="P", help="period of the table's grating, where it does not say so"
    )
    parser.add_argument(
        "--picture", nargs="+", default=[], metavar="FILE", help="picture(s): picture, stereo (left, right), dots"
    )
    parser.add_argument("--pixels", type=int, default=1024, metavar="N", help="pixels along the longer side")
    parser.add_argument(
        "--size-mm", type=options.number, default=50.0, metavar="S", help="what the longer side measures (lens)"
    )
    for name, users in _settings().items():
        text = f"{users[0][1].help} ({', '.join(recipe for recipe, _ in users)})".replace("%", "%%")
        parser.add_argument(f"--{name.replace('_', '-')}", dest=name, type=options.number, metavar="X", help=text)


def run(args: argparse.Namespace) -> dict[str, Any]:
    """Make and write it."""
    from ..errors import ParameterError
    from ..files.pictures import read_picture
    from ..paint.maps import save_paint
    from ..paint.of_table import paint_of_table
    from ..paint.recipes import make_paint
    from ..table.table import read_sidecar

    given = {name: getattr(args, name) for name in _settings() if getattr(args, name) is not None}
    period_m = None if args.period_um is None else args.period_um * 1e-6
    if args.table is None and period_m is None:
        raise ParameterError("Give --table or --period-um: nothing else says what Scale 1 means.")
    sizes: Any = {"pixels": args.pixels, "size_m": args.size_mm * 1e-3, **given}
    sizes["pictures"] = [read_picture(path) for path in args.picture]
    if args.table is None:
        assert period_m is not None
        paint = make_paint(args.recipe, period_m, **sizes)
    else:
        paint = paint_of_table(args.recipe, read_sidecar(Path(args.table)), period_m=period_m, **sizes)
    save_paint(paint, args.out)
    scale, depth = paint.most
    return {"out": args.out, "shape": list(paint.shape), "scale_max": scale, "depth_max": depth, **paint.info}
