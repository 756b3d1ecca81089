# SPDX-License-Identifier: GPL-3.0-or-later
"""The manifest is right, and each thing that can be wrong in it is told."""

import copy

import pytest


@pytest.fixture(scope="module")
def check():
    """tools/build/check_manifest.py as a module."""
    from tools.build import check_manifest

    return check_manifest


@pytest.fixture
def state(check):
    """Everything that `problems` takes, free to be changed."""
    manifest, project = check.load_manifest()
    return {
        "manifest": copy.deepcopy(manifest),
        "project": project,
        "pins": check.pins_by_python(),
        "lock": check.read_lock(),
        "tags": check.valid_tags(),
        "changelog": check.read_changelog(),
    }


def test_the_manifest_is_right(check, state):
    assert check.problems(**state) == []


@pytest.mark.parametrize(
    ("key", "value", "word"),
    [
        ("license", ["SPDX:GPL-9.0-or-never"], "license"),
        ("tags", ["Material", "Iridescence"], "Iridescence"),
        ("tags", [], "tags"),
        ("platforms", ["linux-x64", "amiga-m68k"], "amiga-m68k"),
        ("platforms", ["linux-x64"], "platforms"),
        ("tagline", "It ends with a full stop.", "tagline"),
        ("tagline", "x" * 65, "65"),
        ("tagline", "", "tagline"),
        ("permissions", {"files": "Reason with a stop."}, "files"),
        ("permissions", {"everything": "Because"}, "everything"),
        ("version", "9.9.9", "9.9.9"),
        ("id", "another", "id"),
        ("schema_version", "2.0.0", "schema_version"),
        ("blender_version_min", "4.2.0", "blender_version_min"),
    ],
)
def test_a_wrong_value_is_told(check, state, key, value, word):
    state["manifest"][key] = value
    assert any(word in sentence for sentence in check.problems(**state))


@pytest.mark.parametrize(
    "wheel",
    ["numpy-2.5.5-cp313-cp313-win_amd64.whl", "scipy-1.18.1-cp312-cp312-win_amd64.whl", "six-1.0-py3-none-any.whl"],
)
def test_a_wheel_that_does_not_belong_is_told(check, state, wheel):
    state["manifest"]["wheels"].append(f"./wheels/{wheel}")
    assert any(wheel in sentence for sentence in check.problems(**state))


def test_a_missing_wheel_is_told_with_its_platform(check, state):
    gone = next(path for path in state["manifest"]["wheels"] if "openexr" in path and "cp311-win_amd64" in path)
    state["manifest"]["wheels"].remove(gone)
    found = check.problems(**state)
    assert any("openexr" in s and "3.11" in s and "windows-x64" in s for s in found)


def test_two_versions_for_one_python_are_told(check, state):
    """Blender would unpack the newer of two pure wheels, whichever Python it has."""
    wheels = state["manifest"]["wheels"]
    place = next(i for i, path in enumerate(wheels) if "colour_science-0.4.7" in path)
    wheels[place] = "./wheels/colour_science-0.4.7-py3-none-any.whl"
    found = check.problems(**state)
    assert any("2 wheels of colour_science for Python 3.11" in sentence for sentence in found)


def test_numpy_is_never_pinned_for_the_bundle(state):
    assert not any(pin.lower().startswith("numpy") for pins in state["pins"].values() for pin in pins)


def test_all_versions_are_pinned(state):
    assert all(pin.count("==") == 1 for pins in state["pins"].values() for pin in pins)


@pytest.mark.parametrize(
    ("blenders", "word"),
    [
        ({"3.11": ("4.5.0", "5.0.0"), "3.13": ("5.1.0", None)}, "ends at 5.0.0"),
        ({"3.11": ("4.5.0", "5.2.0"), "3.13": ("5.1.0", None)}, "ends at 5.2.0"),
        ({"3.11": ("4.5.0", "5.1.0"), "3.13": ("5.1.0", "6.0.0")}, "ends at 6.0.0"),
        ({"3.13": ("5.1.0", None)}, "differs from 5.1.0"),
        ({"3.11": ("4.2.0", "5.1.0"), "3.13": ("5.1.0", None)}, "4.5.0 or later"),
    ],
)
def test_a_gap_between_the_zips_is_told(check, state, blenders, word):
    assert any(word in sentence for sentence in check.blender_problems(state["manifest"], blenders))


def test_an_end_of_all_blenders_is_told(check, state):
    state["manifest"]["blender_version_max"] = "6.0.0"
    assert any("blender_version_max" in sentence for sentence in check.problems(**state))
