# SPDX-License-Identifier: GPL-3.0-or-later
"""Print the pinned requirements of pyproject.toml, one a line: `requirements.py [EXTRA ...]`, run-time ones first."""

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def requirements(extras=()):
    """The run-time pins of pyproject.toml and those of the named extras.

    Parameters
    ----------
    extras : sequence of str
        Names below `[project.optional-dependencies]`.

    Returns
    -------
    list of str
        Requirements such as ``"scipy==1.18.1"``.
    """
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    pins = list(project["dependencies"])
    for extra in extras:
        pins += project["optional-dependencies"][extra]
    return pins


if __name__ == "__main__":
    print("\n".join(requirements(sys.argv[1:])))
