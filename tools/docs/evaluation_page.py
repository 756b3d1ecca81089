# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/evaluation.md: fill its tables and draw its pictures. `evaluation_page.py [CHAPTER ...]` makes a part of it."""

import importlib
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from precompute.files.atomic import atomic_path  # noqa: E402
from tools.docs.fill_page import fill  # noqa: E402

PAGE = ROOT / "docs" / "evaluation.md"
PICTURES = ROOT / "docs" / "pictures"
CHAPTERS = ("reflectance", "terms", "coherence", "methods", "maps", "gamut")

#: Chapters of other pages.
PAGES = {"gamut": ROOT / "docs" / "lighting.md"}


#: Largest picture of a page, bytes.
LIMIT = 300_000


def shrink(path):
    """Give a picture that is too large a palette of 256 colours: a third of the bytes for some fine gradients."""
    from PIL import Image

    if path.stat().st_size <= LIMIT:
        return
    with Image.open(path) as image:
        small = image.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    with atomic_path(path) as temporary:
        small.save(temporary, format="PNG", optimize=True)


def main(chapters):
    PICTURES.mkdir(parents=True, exist_ok=True)
    for name in chapters:
        fill(PAGES.get(name, PAGE), importlib.import_module(f"tools.docs.evaluation.{name}").run(PICTURES))
    for path in PICTURES.glob("evaluation_*.png"):
        shrink(path)


if __name__ == "__main__":
    main(sys.argv[1:] or CHAPTERS)
