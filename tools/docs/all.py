# SPDX-License-Identifier: GPL-3.0-or-later
"""Make every picture of docs/ anew, in docs/pictures/, and the numbers of the pages that hold measurements.

The BRDF map comes from the demo, so it shows what the installed extension does. Pictures of Blender's own
window (window.png, panel_*.png) are the only ones that need a display; tests/window/test_guide.py takes them.
"""

import shutil
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # a script: its folder alone is on the path


from tools.build.fetch_wheels import ROOT

PICTURES = ROOT / "docs" / "pictures"


def demo_pictures():
    """The snake's BRDF map, by tools/demo.py."""
    out = ROOT / "out" / "docs"
    subprocess.run([sys.executable, ROOT / "tools" / "demo.py", "--out", out], check=True)
    shutil.copy(out / "brdf_map.png", PICTURES)


def preset_pictures():
    """Heights and BRDF maps of all presets."""
    subprocess.run(
        [sys.executable, ROOT / "tools" / "docs" / "preset_pictures.py", PICTURES / "presets.png"], check=True
    )


def house_picture():
    """The wings on their floors."""
    subprocess.run([sys.executable, ROOT / "tools" / "docs" / "house_picture.py"], check=True)


def preset_thumbnails():
    """The small pictures of the panel's menu, which ship with the extension."""
    subprocess.run([sys.executable, ROOT / "tools" / "docs" / "preset_thumbnails.py"], check=True)


def paint_picture():
    """Recipes of grating paint."""
    subprocess.run([sys.executable, ROOT / "tools" / "docs" / "paint_pictures.py"], check=True)


def viewport_picture():
    """Cycles, the viewport and FLSS side by side."""
    subprocess.run([sys.executable, ROOT / "tools" / "docs" / "viewport_pictures.py", "--out", PICTURES], check=True)


def gallery():
    """The large pictures; the longest part."""
    subprocess.run([sys.executable, ROOT / "tools" / "docs" / "gallery_page.py"], check=True)


def looks():
    """The contact sheet of the asset library, and the loop of the README."""
    for name in ("looks_sheet.py", "motion.py"):
        subprocess.run([sys.executable, ROOT / "tools" / "docs" / name], check=True)


def implementation_picture():
    """OSL, Nodes in Cycles and Nodes in EEVEE side by side."""
    subprocess.run(
        [sys.executable, ROOT / "tools" / "docs" / "implementation_pictures.py", "--out", PICTURES], check=True
    )


def pages_with_numbers():
    """The pages whose tables are filled by scripts."""
    for name in ("rcwa_page.py", "evaluation_page.py"):
        subprocess.run([sys.executable, ROOT / "tools" / "docs" / name], check=True)


def guide():
    """The guide's pictures and its reference of parameters."""
    subprocess.run([sys.executable, ROOT / "tools" / "docs" / "guide_pictures.py", PICTURES], check=True)
    subprocess.run([sys.executable, ROOT / "tools" / "docs" / "reference.py"], check=True)


def main():
    PICTURES.mkdir(parents=True, exist_ok=True)
    house_picture()
    demo_pictures()
    preset_pictures()
    preset_thumbnails()
    paint_picture()
    guide()
    gallery()
    looks()
    viewport_picture()
    implementation_picture()
    pages_with_numbers()
    for path in sorted(PICTURES.iterdir()):
        print(path.relative_to(ROOT), f"{path.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
