# SPDX-License-Identifier: GPL-3.0-or-later
"""CHANGELOG.md is as the convention has it, belongs to the manifest's version, and each fault in it is told."""

import pytest

from tools.build.changelog import read_changelog
from tools.build.check_manifest import changelog_problems, load_manifest

GOOD = """# Changelog

## [Unreleased]

### Added

* One thing,
  in two lines.
* Another.

## [0.2.0] - 2027-01-31

### Fixed

* A fault.

## [0.1.0] - 2026-11-22

The first.

### Added

* All.
"""


def test_the_changelog_is_right():
    manifest, _ = load_manifest()
    found = read_changelog()
    assert list(changelog_problems(manifest, found)) == []
    assert "0.1.0" in found.releases


def test_it_is_read_by_version_and_kind():
    found = read_changelog(GOOD)
    assert found.problems == []
    assert found.unreleased == {"Added": ["One thing, in two lines.", "Another."]}
    assert found.releases == {
        "0.2.0": ("2027-01-31", {"Fixed": ["A fault."]}),
        "0.1.0": ("2026-11-22", {"Added": ["All."]}),
    }


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("## [Unreleased]\n", "", "must begin"),
        ("### Fixed", "### Mended", "Mended"),
        ("* A fault.\n", "", "nothing stands under"),
        ("2027-01-31", "31.1.2027", "not of the form"),
        ("2027-01-31", "2027-01-32", "not of the form"),
        ("[0.2.0]", "0.2.0", "not of the form"),
        ("[0.2.0]", "[0.0.9]", "newest version first"),
        ("[0.2.0]", "[0.1.0]", "twice"),
    ],
)
def test_a_fault_is_told(old, new, word):
    assert old in GOOD
    assert any(word in sentence for sentence in read_changelog(GOOD.replace(old, new, 1)).problems)


def test_a_version_that_the_changelog_does_not_know_is_told():
    (sentence,) = changelog_problems({"version": "0.3.0"}, read_changelog(GOOD))
    assert "0.3.0" in sentence and "0.2.0" in sentence
    (sentence,) = changelog_problems({"version": "0.1.0"}, read_changelog("# Changelog\n\n## [Unreleased]\n"))
    assert "does not tell" in sentence
