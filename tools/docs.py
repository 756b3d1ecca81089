# SPDX-License-Identifier: GPL-3.0-or-later
"""Make every picture of docs/ anew, in docs/pictures/.

The snake and its BRDF map come from the demo, so they show what the installed extension does.
"""

import shutil
import subprocess
import sys

from fetch_wheels import ROOT

PICTURES = ROOT / "docs" / "pictures"


def demo_pictures():
    """The snake and its BRDF map, by tools/demo.py."""
    out = ROOT / "out" / "docs"
    subprocess.run([sys.executable, ROOT / "tools" / "demo.py", "--out", out], check=True)
    for name in ("snake.png", "brdf_map.png"):
        shutil.copy(out / name, PICTURES / name)


def preset_pictures():
    """Heights and BRDF maps of all presets."""
    subprocess.run([sys.executable, ROOT / "tools" / "preset_pictures.py", PICTURES / "presets.png"], check=True)


def main():
    PICTURES.mkdir(parents=True, exist_ok=True)
    demo_pictures()
    preset_pictures()
    for path in sorted(PICTURES.iterdir()):
        print(path.relative_to(ROOT), f"{path.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
