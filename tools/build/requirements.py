# SPDX-License-Identifier: GPL-3.0-or-later
"""Print the pinned requirements of pyproject.toml for the Python that runs this: `requirements.py [EXTRA ...]`."""

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


#: Blenders that the extension is for by their Python: the first version, and the first that is too new, if any.
BLENDERS = {"3.11": ("4.5.0", "5.1.0"), "3.13": ("5.1.0", None)}
PYTHONS = tuple(BLENDERS)


def applies(marker, python):
    """Whether a marker, `python_version < '3.13'` or `python_version >= '3.13'`, holds for a Python such as "3.11".

    Raises
    ------
    SystemExit
        It is none of the two: pip could read it, this cannot.
    """
    found = re.fullmatch(r"\s*python_version\s*(<|>=)\s*'(\d+)\.(\d+)'\s*", marker)
    if found is None:
        sys.exit(f"pyproject.toml: write the marker '{marker.strip()}' as python_version < '3.N' or >= '3.N'.")
    older = tuple(map(int, python.split("."))) < (int(found[2]), int(found[3]))
    return older == (found[1] == "<")


def requirements(extras=(), python=None):
    """The run-time pins of pyproject.toml and those of the named extras.

    Parameters
    ----------
    extras : sequence of str
        Names below `[project.optional-dependencies]`.
    python : str
        Version of the Python that they are for, such as ``"3.11"``; by default of this one.

    Returns
    -------
    list of str
        Requirements such as ``"scipy==1.18.1"``, run-time ones first.
    """
    python = python or "{}.{}".format(*sys.version_info)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    pins = list(project["dependencies"])
    for extra in extras:
        pins += project["optional-dependencies"][extra]
    parts = [pin.partition(";") for pin in pins]
    return [pin.strip() for pin, _, marker in parts if not marker or applies(marker, python)]


if __name__ == "__main__":
    print("\n".join(requirements(sys.argv[1:])))
