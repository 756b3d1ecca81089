# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure tables that hold a stack: their error against direct sums times R, and what the stack costs the bake.

`bench_stuff.py [--rounds N] [--directions N] [--page]`

Errors are those of Y, on bumps of 14 um, at polar angles of light and view uniform in 0-65 degrees. Costs are
processor time of this process on the preset snake, bare and coated in turn. Merged into out/bench.json under "stuff";
`--page` also fills the blocks of docs/materials.md.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from precompute.bake import bake  # noqa: E402
from precompute.evaluate.colour_difference import delta_e_2000  # noqa: E402
from precompute.evaluate.direct import direct_xyz  # noqa: E402
from precompute.evaluate.mirror import mirror_xyz, plate_table, seen_mirror_xyz  # noqa: E402
from precompute.evaluate.surface import brdf  # noqa: E402
from precompute.parameters import BakeParameters  # noqa: E402
from precompute.presets import make_preset  # noqa: E402
from precompute.scan.preparation import prepare  # noqa: E402
from precompute.stack import MATERIALS, parse_stack  # noqa: E402
from tools.bench.results import merge  # noqa: E402
from tools.docs.fill_page import fill, table  # noqa: E402

PAGE = ROOT / "docs" / "materials.md"

#: Substrate, films, lacquer.
STACKS = {
    "none (R = 1)": ("", (), None),
    "Au": ("Au", (), None),
    "250 nm of n = 2.35 on Au": ("Au", ("2.35:250",), None),
    "TiO2:150 on Ti": ("Ti", ("TiO2:150",), None),
    "1.47:400 on Fe": ("Fe", ("1.47:400",), None),
    "(chitin:60,1:140)x8 on melanin": ("melanin", ("(chitin:60,1:140)x8",), None),
    "(chitin:100,melanin:80)x12 on melanin": ("melanin", ("(chitin:100,melanin:80)x12",), None),
    "SiO2:2000 on Si": ("Si", ("SiO2:2000",), None),
    "Al under PMMA": ("Al", (), "PMMA"),
    "250 nm of n = 2.35 on Au, under PMMA": ("Au", ("2.35:250",), "PMMA"),
}

METALS = ("Al", "Ag", "Au", "Cu", "Ti", "Cr", "Ni", "Fe")


def parameters_of(stuff):
    """Bake parameters of an entry of `STACKS`."""
    substrate, films, lacquer = stuff
    return BakeParameters(stack=parse_stack(substrate, films), lacquer=lacquer)


def errors(stuff, directions):
    """Median and 95th percentile of the relative error of Y."""
    field, parameters = make_preset("stam_bumps", 14e-6, 144), parameters_of(stuff)
    baked = bake(field, parameters)
    rng = np.random.default_rng(2)
    theta, phi = np.radians(rng.uniform(0, 65, (2, directions))), rng.uniform(0, 2 * np.pi, (2, directions))
    wi, wr = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    sigma = baked.info["parameters"]["sigma_s_m"]
    truth = direct_xyz(
        prepare(field, parameters), sigma, "average", wi, wr, stack=parameters.stack, lacquer=parameters.lacquer
    )
    found = np.abs(brdf(baked, wi, wr)[:, 1] / truth[:, 1] - 1.0)
    return float(np.median(found)), float(np.percentile(found, 95))


def costs(rounds):
    """Processor time over that of the bare bake, and texels over its texels: medians over the rounds, by name."""
    field = make_preset("snake")
    seconds = {name: [] for name in STACKS}
    texels = {}
    for number in range(-1, rounds):  # the first round fills caches
        for name, stuff in STACKS.items():
            start = time.process_time()
            baked = bake(field, parameters_of(stuff))
            if number >= 0:
                seconds[name].append(time.process_time() - start)
            texels[name] = baked.layout.texel_bytes
            print(f"  round {number + 1}, {name}: {time.process_time() - start:.2f} s", flush=True)
    bare = next(iter(STACKS))
    ratios = {name: float(np.median(np.array(spent) / seconds[bare])) for name, spent in seconds.items()}
    return ratios, {name: size / texels[bare] for name, size in texels.items()}


def mirrors():
    """Delta E 2000 of a flat plate's table from the spectral integral, by metal and angle."""
    bare, rows = plate_table(None), {}
    for name in METALS:
        stack = parse_stack(name)
        baked = plate_table(stack)
        rows[name] = {
            degrees: float(
                delta_e_2000(
                    seen_mirror_xyz(baked, bare, np.radians(degrees)), mirror_xyz(stack, np.radians(degrees)), 1.0
                )
            )
            for degrees in (0, 30, 60)
        }
    return rows


def material_rows():
    """The named materials: range and source."""
    rows = []
    for name, material in MATERIALS.items():
        curve = material.n
        span = (curve.wavelengths_m[0], curve.wavelengths_m[-1]) if curve.kind == "table" else curve.range_m
        low, high = (1e9 * x for x in span)
        n = complex(material.index(np.array([550e-9]))[0])
        shown = f"{n.real:.3f}" + (f" + {n.imag:.3f}i" if n.imag else "")
        kind = "figures" if curve.kind == "table" else "formula"
        rows.append([f"`{name}`", shown, f"{kind}, {low:.4g}-{high:.4g} nm", material.source])
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3, help="after one that fills caches")
    parser.add_argument("--directions", type=int, default=40)
    parser.add_argument("--page", action="store_true", help="fill docs/materials.md")
    arguments = parser.parse_args()
    found = {name: errors(stuff, arguments.directions) for name, stuff in STACKS.items()}
    time_ratio, texel_ratio = costs(arguments.rounds)
    rows = []
    for name, (median, most) in found.items():
        rows.append([name, f"{median:.2%}", f"{most:.2%}", f"{time_ratio[name]:.2f}", f"{texel_ratio[name]:.2f}"])
        print(f"  {name:<40} median {median:.2%}, 95th percentile {most:.2%}, bake {time_ratio[name]:.2f}", flush=True)
    metals = mirrors()
    for name, each in metals.items():
        print(f"  mirror of {name}: Delta E " + ", ".join(f"{v:.2f} at {d} deg" for d, v in each.items()), flush=True)
    merge("stuff", {"errors": found, "time": time_ratio, "texels": texel_ratio, "mirrors": metals})
    if arguments.page:
        fill(PAGE, {
            "materials": table(["name", "n + ik at 550 nm", "range", "source"], material_rows()),
            "tables": table(["stack", "error, median", "95th percentile", "bake's time", "texels"], rows),
            "mirrors": table(
                ["Delta E 2000", *[f"{d} deg" for d in (0, 30, 60)]],
                [[name, *[f"{v:.2f}" for v in each.values()]] for name, each in metals.items()],
            ),
        })  # fmt: skip


if __name__ == "__main__":
    main()
