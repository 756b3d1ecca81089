# SPDX-License-Identifier: GPL-3.0-or-later
"""CHANGELOG.md as https://keepachangelog.com/en/1.1.0/ has it: what is new in each version, newest first."""

import datetime
import re
from dataclasses import dataclass
from pathlib import Path

CHANGELOG = Path(__file__).resolve().parents[2] / "CHANGELOG.md"

#: Kinds of changes, in the order of the convention.
KINDS = ("Added", "Changed", "Deprecated", "Removed", "Fixed", "Security")


@dataclass(frozen=True)
class Changelog:
    """What the file says.

    Parameters
    ----------
    unreleased
        Of each kind of change the entries that no version holds yet.
    releases
        Of each version its date and its entries by kind, newest first.
    problems
        A sentence for each thing that is not as it should be.
    """

    unreleased: dict[str, list[str]]
    releases: dict[str, tuple[str, dict[str, list[str]]]]
    problems: list[str]


def _entries(text, where, problems):
    """The entries of a version by kind."""
    found = {}
    for part in re.split(r"^### ", text, flags=re.MULTILINE)[1:]:
        kind, _, body = part.partition("\n")
        if kind.strip() not in KINDS:
            problems.append(f"CHANGELOG.md, {where}: '{kind.strip()}' is none of {', '.join(KINDS)}.")
        entries = [" ".join(each.split()) for each in re.split(r"^\* ", body, flags=re.MULTILINE)[1:]]
        if not entries:
            problems.append(f"CHANGELOG.md, {where}: nothing stands under '{kind.strip()}'; entries begin with '* '.")
        found.setdefault(kind.strip(), []).extend(entries)
    return found


def read_changelog(text=None):
    """Read the file, or a text in its place.

    Returns
    -------
    Changelog
    """
    text = CHANGELOG.read_text(encoding="utf-8") if text is None else text
    problems, releases, unreleased = [], {}, {}
    heads = list(re.finditer(r"^## (.*)$", text, flags=re.MULTILINE))
    if not heads or heads[0][1] != "[Unreleased]":
        problems.append("CHANGELOG.md must begin with '## [Unreleased]', empty or not.")
    for head, end in zip(heads, [*(each.start() for each in heads[1:]), len(text)], strict=True):
        body = text[head.end() : end]
        if head[1] == "[Unreleased]":
            unreleased = _entries(body, "Unreleased", problems)
            continue
        named = re.fullmatch(r"\[(\d+\.\d+\.\d+)\] - (\d{4}-\d{2}-\d{2})", head[1])
        if named is None or not _is_date(named[2]):
            problems.append(f"CHANGELOG.md: '## {head[1]}' is not of the form '## [1.2.3] - 2026-12-31'.")
            continue
        if named[1] in releases:
            problems.append(f"CHANGELOG.md has {named[1]} twice.")
        releases[named[1]] = (named[2], _entries(body, named[1], problems))
    numbers = [tuple(map(int, version.split("."))) for version in releases]
    if numbers != sorted(numbers, reverse=True):
        problems.append("CHANGELOG.md must have the newest version first.")
    return Changelog(unreleased, releases, problems)


def _is_date(text):
    try:
        datetime.date.fromisoformat(text)
    except ValueError:
        return False
    return True
