# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages of docs/ are written by hand; their numbers are not: scripts fill what stands between two marks.

<!-- begin NAME -->
...
<!-- end NAME -->
"""

import re


def table(head, rows):
    """A table of Markdown: first column to the left, all others to the right."""
    lines = [head, [":--", *["--:"] * (len(head) - 1)], *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def block(text, name):
    """What stands between the marks of ``name``, without the blank lines round it."""
    found = re.search(_marks(name), text, re.DOTALL)
    if found is None:
        raise ValueError(f"The page has no block '{name}'.")
    return found.group(2).strip("\n")


def fill(path, blocks):
    """Replace blocks of a page; names and texts in ``blocks``."""
    text = path.read_text(encoding="utf-8")
    for name, content in blocks.items():
        block(text, name)
        text = re.sub(
            _marks(name), lambda found, new=content: f"{found.group(1)}\n{new}\n{found.group(3)}", text, flags=re.DOTALL
        )
    path.write_text(text, encoding="utf-8")


def _marks(name):
    return rf"(<!-- begin {re.escape(name)} -->)\n(.*?)(<!-- end {re.escape(name)} -->)"
