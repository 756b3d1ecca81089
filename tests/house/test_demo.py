# SPDX-License-Identifier: GPL-3.0-or-later
"""`make demo` with few samples: its pictures are there and show what they should."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """RGB of the demo's two pictures, 0 to 1, row 0 at the top, and what the demo printed."""
    import matplotlib.image

    out = tmp_path_factory.mktemp("demo")
    command = [sys.executable, ROOT / "tools" / "demo.py", "--out", out, "--samples", "4"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    names = ("snake.png", "brdf_map.png")
    assert all(str(out / name) in done.stdout for name in names)
    return [matplotlib.image.imread(out / name)[..., :3] for name in names]


def hues(image, chroma=0.15):
    """Share of the pixels whose largest component, of R, G and B, stands out by `chroma`, for each of the three."""
    strong = image.max(axis=-1) - image.min(axis=-1) > chroma
    return np.array([(strong & (image.argmax(axis=-1) == c)).mean() for c in range(3)])


@pytest.mark.slow
def test_the_snake_is_iridescent(pictures):
    """Red, green and blue all stand out somewhere: a pigment alone shows one hue, and this one is near black."""
    assert (hues(pictures[0]) > 1e-3).all(), hues(pictures[0])


@pytest.mark.slow
def test_the_map_is_a_disc_with_colours(pictures):
    image = pictures[1]
    rows, columns = np.mgrid[: image.shape[0], : image.shape[1]]
    radius = np.hypot(rows + 0.5 - image.shape[0] / 2, columns + 0.5 - image.shape[1] / 2) / (image.shape[0] / 2)
    assert image[radius > 1.02].max() < 0.05
    assert (hues(image) > 1e-3).all(), hues(image)
