# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/evaluation.md and docs/rcwa.md: whole, filled by scripts, light; and how pages are filled."""

import re

import pytest

from tools.docs.fill_page import block, fill, table

PAGES = ("evaluation.md", "rcwa.md")


@pytest.mark.parametrize("page", PAGES)
def test_every_block_is_filled_and_every_picture_is_there_and_small(root_dir, page):
    text = (root_dir / "docs" / page).read_text(encoding="utf-8")
    names = re.findall(r"<!-- begin (.+?) -->", text)
    assert names
    assert len(set(names)) == len(names)
    for name in names:
        lines = block(text, name).splitlines()
        assert len(lines) >= 3, name
        # A table: as many cells in each line as in its head.
        assert len({line.count("|") for line in lines}) == 1, name
        assert "nan" not in block(text, name)
    pictures = re.findall(r"!\[[^\]]+\]\((.+?)\)", text)
    assert pictures
    for picture in pictures:
        path = root_dir / "docs" / picture
        assert path.is_file(), picture
        assert path.stat().st_size <= 300_000, picture


def test_differences_on_the_page_are_below_what_is_seen(root_dir):
    """What the page says of the methods that must agree: a median below 1."""
    text = (root_dir / "docs" / "evaluation.md").read_text(encoding="utf-8")
    rows = {line.split("|")[1].strip(): line.split("|") for line in block(text, "methods").splitlines()[2:]}
    for name in ("windowed, Chebyshev", "windowed, Taylor", "table, nodes", "table, Chebyshev", "table, Taylor"):
        assert float(rows[name][4]) < 1.0, name


def test_gamut_on_the_lighting_page(root_dir):
    """Nearly a third of the scan's colours lies outside Rec.709, hardly any outside the two wide spaces."""
    text = (root_dir / "docs" / "lighting.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in block(text, "gamut").splitlines()[2:]]
    off_the_peak = {(row[0].partition(",")[0], row[1]): float(row[3].rstrip("% ")) for row in rows}
    assert 25 <= off_the_peak["Xenopeltis", "Linear Rec.709"] <= 36
    assert off_the_peak["Xenopeltis", "Linear Rec.2020"] < 3
    assert off_the_peak["Xenopeltis", "ACEScg"] < 3


def test_filling_touches_its_block_only(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("a\n<!-- begin x y -->\nold\n<!-- end x y -->\nb \\1\n<!-- begin z -->\n<!-- end z -->\n")
    fill(page, {"x y": table(["", "n"], [["one", 1]])})
    assert page.read_text() == (
        "a\n<!-- begin x y -->\n|  | n |\n| :-- | --: |\n| one | 1 |\n<!-- end x y -->\nb \\1\n"
        "<!-- begin z -->\n<!-- end z -->\n"
    )
    with pytest.raises(ValueError, match="no block 'missing'"):
        fill(page, {"missing": "text"})
