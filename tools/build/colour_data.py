# SPDX-License-Identifier: GPL-3.0-or-later
"""Write precompute/light/colour_data.json, what every bake needs of colour-science: `colour_data.py`.

colour-science takes longer to import than a bake takes. Its observer, the illuminants by name, Bradford's matrix and
the primaries of the working spaces are a few hundred numbers, copied here as they are, within the range of the colour
integrals. A test holds the file equal to the installed colour-science; run this again where it fails.
"""

import json
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from precompute.constants import WAVELENGTH_MAX_M, WAVELENGTH_MIN_M  # noqa: E402  (a script: the path comes first)
from precompute.light.colour import OBSERVER, SPACES  # noqa: E402
from precompute.light.colour_data import PATH  # noqa: E402
from precompute.light.colour_library import load_colour  # noqa: E402
from precompute.light.illuminant import ILLUMINANTS  # noqa: E402


def collect():
    """Everything the file holds, as colour-science has it now.

    Returns
    -------
    dict
        ``observer``: ``wavelengths_nm`` and rows of xbar, ybar, zbar; ``illuminants``: by name, ``wavelengths_nm`` and
        ``power``; ``bradford``: the matrix of the cone responses; ``spaces``: by their names in colour-science,
        ``primaries`` and ``white`` as chromaticities xy.
    """
    colour = load_colour()

    def visible(distribution):
        nm = distribution.wavelengths
        return (nm >= 1e9 * WAVELENGTH_MIN_M - 1e-6) & (nm <= 1e9 * WAVELENGTH_MAX_M + 1e-6)

    def samples(distribution, key):
        kept = visible(distribution)
        return {"wavelengths_nm": distribution.wavelengths[kept].tolist(), key: distribution.values[kept].tolist()}

    spaces = {name: colour.RGB_COLOURSPACES[name] for name in SPACES.values()}
    return {
        "observer": samples(colour.MSDS_CMFS[OBSERVER], "xyz"),
        "illuminants": {name: samples(colour.SDS_ILLUMINANTS[name], "power") for name in ILLUMINANTS},
        "bradford": colour.adaptation.CHROMATIC_ADAPTATION_TRANSFORMS["Bradford"].tolist(),
        "spaces": {
            name: {"primaries": space.primaries.tolist(), "white": [float(x) for x in space.whitepoint]}
            for name, space in spaces.items()
        },
    }


def main():
    from precompute.files.atomic import atomic_path

    text = json.dumps(collect(), separators=(",", ":"))
    for at in ('"illuminants"', '"bradford"', '"spaces"'):
        text = text.replace(f",{at}", f",\n{at}")
    with atomic_path(PATH) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8", newline="\n")
    print(f"{PATH.relative_to(ROOT)}: {PATH.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
