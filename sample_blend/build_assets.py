# SPDX-License-Identifier: GPL-3.0-or-later
"""The asset library by a script; in Blender's window the button *Make Asset Library* does the same.

``blender -b -P sample_blend/build_assets.py -- assets/materials.blend`` (the extension enabled) bakes each structure,
sets its material up and renders its preview. Give Blender the folder under *Preferences > File Paths > Asset
Libraries*; a material dragged from it finds its table wherever the library lies.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path


def _library():
    """The extension's own module, under whatever name it is enabled."""
    for name in list(sys.modules):
        if name.rpartition(".")[2] == "diffraction_shader":
            return importlib.import_module(f"{name}.addon.assets.library")
    raise SystemExit("The extension Diffraction Shader is not enabled; enable it in Blender's preferences.")


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    _library().build_assets(Path(arguments[0] if arguments else "assets/materials.blend"))
else:
    ASSETS, build_assets = _library().ASSETS, _library().build_assets
