# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/pictures/house.png: the wings of both halves on their floors, by tools/house.py and what each says of itself."""

import ast
import io
import json
import sys
import textwrap
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # a script: its folder alone is on the path

from tools import house

#: Of each half the colours of a folder and of a file, and what stands beside it.
LOOKS = {
    "addon": ("#cfe3f6", "#edf4fb", "addon/\nimports Blender"),
    "precompute": ("#fbe3bd", "#fdf4e3", "precompute/\nnumbers alone"),
}
WIDTH, ROW, GAP = 10.0, 0.52, 0.07
LEFT = 0.95


def floors():
    """The floors as text."""
    return json.dumps(house.FLOORS)


def caption(path, characters, lines=2):
    """What a wing's docstring says first, wrapped; what does not fit is left away at a colon or with an ellipsis."""
    sentence = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))).split("\n\n")[0]
    sentence = " ".join(sentence.split()).replace("``", "").rstrip(".")
    for text in (sentence, sentence.partition(":")[0]):
        wrapped = textwrap.wrap(text, characters)
        if len(wrapped) <= lines:
            return "\n".join(wrapped)
    return "\n".join(textwrap.wrap(text, characters, max_lines=lines, placeholder=" …"))


def draw_half(axes, half, bottom):
    """Draw a half's floors upwards from a height; returns the height above them."""
    from matplotlib.patches import FancyBboxPatch

    folder, file, label = LOOKS[half]
    names = house.modules(half)
    for number, floor in enumerate(house.FLOORS[half]):
        y = bottom + number * (ROW + GAP)
        axes.text(LEFT - 0.12, y + ROW / 2, str(number + 1), ha="right", va="center", fontsize=9, color="#888888")
        width = (WIDTH - LEFT - 0.05 - (len(floor) - 1) * GAP) / len(floor)
        for place, wing in enumerate(floor):
            x = LEFT + place * (width + GAP)
            path = names.get(f"{half}.{wing}", house.ROOT / half / "__init__.py")
            is_folder = path.name == "__init__.py" and wing != "__init__"
            axes.add_patch(
                FancyBboxPatch(
                    (x, y), width, ROW, boxstyle="round,pad=0,rounding_size=0.05",
                    facecolor=folder if is_folder else file, edgecolor="#9aa3ab", linewidth=0.7,
                )
            )  # fmt: skip
            title = f"{wing}/" if is_folder else f"{wing}.py"
            axes.text(
                x + width / 2,
                y + ROW - 0.06,
                title,
                ha="center",
                va="top",
                fontsize=8.5,
                weight="bold",
                color="#222222",
            )
            axes.text(
                x + width / 2, y + 0.185, caption(path, int(width * 17)), ha="center", va="center", fontsize=6.6,
                linespacing=1.05, color="#444444",
            )  # fmt: skip
    top = bottom + len(house.FLOORS[half]) * (ROW + GAP)
    axes.text(0.32, (bottom + top) / 2, label, rotation=90, ha="center", va="center", fontsize=11, color="#333333")
    return top


def draw(path):
    """Draw both halves, the add-on above the core that it stands on; the picture says inside which floors it shows."""
    from matplotlib.figure import Figure
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    rows = sum(map(len, house.FLOORS.values()))
    height = rows * (ROW + GAP) + 1.05
    figure = Figure(figsize=(WIDTH, height), dpi=130, facecolor="white")
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_xlim(0, WIDTH)
    axes.set_ylim(0, height)
    axes.axis("off")
    middle = draw_half(axes, "precompute", 0.1)
    draw_half(axes, "addon", middle + 0.5)
    arrow = {"arrowstyle": "-|>", "linewidth": 1.6, "color": "#666666"}
    axes.annotate("", (WIDTH / 2, middle + 0.02), (WIDTH / 2, middle + 0.46), arrowprops=arrow)
    axes.text(WIDTH / 2 + 0.15, middle + 0.22, "imports", va="center", fontsize=9, color="#444444")
    axes.text(
        LEFT, height - 0.24, "A wing imports what stands on a lower floor, never its neighbours or what is above it",
        fontsize=9, color="#444444",
    )  # fmt: skip
    drawn = io.BytesIO()
    figure.savefig(drawn)
    told = PngInfo()
    told.add_text("Floors", floors())
    Image.open(drawn).convert("RGB").quantize(128).save(path, pnginfo=told, optimize=True)


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else house.ROOT / "docs" / "pictures" / "house.png"
    draw(target)
    print(target)
