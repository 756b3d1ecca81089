# SPDX-License-Identifier: GPL-3.0-or-later
"""The first picture of docs/architecture.md shows the floors that the tests keep."""

import re

from PIL import Image

from tools import house
from tools.docs import house_picture

PAGE = house.ROOT / "docs" / "architecture.md"


def test_the_page_begins_with_the_floors_as_they_are():
    first = re.search(r"!\[[^\]]*\]\(([^)]*)\)", PAGE.read_text(encoding="utf-8"))[1]
    with Image.open(PAGE.parent / first) as picture:
        shown = picture.text["Floors"]
    assert shown == house_picture.floors(), "run tools/docs/house_picture.py: the picture shows other floors"


def test_every_wing_has_a_caption_that_fits():
    for half, floors in house.FLOORS.items():
        names = house.modules(half)
        for wing in (wing for floor in floors for wing in floor):
            path = names.get(f"{half}.{wing}", house.ROOT / half / "__init__.py")
            text = house_picture.caption(path, 24)
            assert 0 < len(text) <= 2 * 25, (wing, text)
            assert max(map(len, text.split("\n"))) <= 24


def test_it_is_drawn(tmp_path):
    house_picture.draw(tmp_path / "house.png")
    with Image.open(tmp_path / "house.png") as picture:
        assert picture.width == 1300 and picture.height > 1000
        assert len(picture.convert("RGB").getcolors(1 << 20)) > 20
