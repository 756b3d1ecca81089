# SPDX-License-Identifier: GPL-3.0-or-later
"""The guide as pages that ship with the extension: what *Online Manual* opens, without a network."""

import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

#: Pages of docs/guide/ that ship.
PAGES = ("user", "parameters", "scripting")

#: Larger pictures stay in the checkout: they would weigh more than the pages.
LARGEST_PICTURE = 150_000

_FRAME = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title} - Diffraction Shader</title><style>
body {{ font: 16px/1.5 sans-serif; max-width: 52rem; margin: 2rem auto; padding: 0 1rem; color: #222; }}
img {{ max-width: 100%; }} table {{ border-collapse: collapse; }}
td, th {{ border: 1px solid #bbb; padding: .3em .6em; }}
code, pre {{ background: #f2f2f2; }} pre {{ padding: .6em; overflow-x: auto; }} nav a {{ margin-right: 1.5em; }}
</style></head><body><nav>{links}</nav>
{body}
</body></html>
"""


def write(folder):
    """Write the pages, and the pictures they show, into a folder.

    Parameters
    ----------
    folder : pathlib.Path
        Made where it does not exist.
    """
    import markdown

    (folder / "pictures").mkdir(parents=True, exist_ok=True)
    links = "".join(f'<a href="{name}.html">{name.title()} guide</a>' for name in PAGES)
    for name in PAGES:
        text = (ROOT / "docs" / "guide" / f"{name}.md").read_text(encoding="utf-8")
        body = markdown.markdown(text, extensions=["tables", "fenced_code", "toc", "sane_lists"])
        body = re.sub(
            r'<img alt="([^"]*)" src="\.\./pictures/([^"]+)" ?/?>', lambda m: _picture(folder, *m.groups()), body
        )
        body = re.sub(r'<a href="([^"]+)">(.*?)</a>', _link, body, flags=re.DOTALL)
        title = re.search(r"<h1[^>]*>(.*?)</h1>", body).group(1)
        page = _FRAME.format(title=title, links=links, body=body)
        (folder / f"{name}.html").write_text(page, encoding="utf-8", newline="\n")


def _picture(folder, alt, name):
    source = ROOT / "docs" / "pictures" / name
    if source.stat().st_size > LARGEST_PICTURE:
        return f"<em>({alt})</em>"
    shutil.copyfile(source, folder / "pictures" / name)
    return f'<img alt="{alt}" src="pictures/{name}">'


def _link(found):
    """Links between the pages and within one stay; what does not ship becomes plain text."""
    target, words = found.groups()
    page, _, place = target.partition("#")
    stem = page.removesuffix(".md")
    if not page or target.startswith("http"):
        return found.group(0)
    if stem in PAGES:
        return f'<a href="{stem}.html{"#" + place if place else ""}">{words}</a>'
    return words


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "out" / "manual")
