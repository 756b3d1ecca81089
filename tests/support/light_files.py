# SPDX-License-Identifier: GPL-3.0-or-later
"""Spectra of lights, and files of them as spectrometers write them."""

import numpy as np


def cie(name="D65"):
    """Wavelengths in nm and values that colour-science holds."""
    import colour

    found = colour.SDS_ILLUMINANTS[name]
    return np.asarray(found.wavelengths), np.asarray(found.values)


def light_file(path, nm, power, separator=",", header=""):
    """A file as spectrometers write it."""
    rows = [f"{a:.10g}{separator}{b:.10g}" for a, b in zip(nm, power, strict=True)]
    path.write_text(header + "\n".join(rows) + "\n", encoding="utf-8")
    return path
