# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person reads on a machine that lacks something."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def tool(name):
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / "build" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def bare_checkout(tmp_path):
    """What `make setup` reads, and a PATH that holds the shell's tools but no Python at all."""
    shutil.copy(ROOT / "Makefile", tmp_path)
    shutil.copy(ROOT / ".python-version", tmp_path)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    shutil.copytree(ROOT / "tools", tmp_path / "tools", ignore=shutil.ignore_patterns("__pycache__"))
    programs = tmp_path / "bin"
    programs.mkdir()
    for name in ("sh", "make", "cat", "cut", "dirname", "test", "rm", "mkdir", "touch", "echo"):
        (programs / name).symlink_to(shutil.which(name))
    return tmp_path


def make(folder, target="setup"):
    environment = {"PATH": str(folder / "bin"), "HOME": str(folder)}
    return subprocess.run(
        [shutil.which("make"), target], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


def fake_python(folder, name, version, has_venv=True):
    """A program that answers as an interpreter of this version would, and cannot do anything else."""
    path = folder / "bin" / name
    path.write_text(
        "#!/bin/sh\n"
        'case "$2" in\n'
        f'  *sys.executable*) case "$2" in *{version}*) echo "$0";; esac;;\n'
        f"  *ensurepip*) exit {0 if has_venv else 1};;\n"
        "  *) exit 1;;\n"
        "esac\n",
        encoding="utf-8",
    )
    path.chmod(0o755)
    return path


@pytest.mark.parametrize("target", ["setup", "test", "demo"])
def test_make_names_the_missing_interpreter(bare_checkout, target):
    done = make(bare_checkout, target)
    assert done.returncode != 0
    sentences = [line for line in done.stderr.splitlines() if "make" not in line.partition(":")[0]]
    assert len(sentences) == 1
    assert "Python 3.13 is missing" in sentences[0]
    assert "python3.13" in sentences[0]


def test_make_names_the_missing_venv_module(bare_checkout):
    fake_python(bare_checkout, "python3.13", "3.13", has_venv=False)
    done = make(bare_checkout)
    assert done.returncode != 0
    assert "python3.13-venv" in done.stderr
    assert not (bare_checkout / ".venv").exists()


def test_an_interpreter_of_another_version_is_passed_over(bare_checkout):
    fake_python(bare_checkout, "python", "3.11")
    wanted = fake_python(bare_checkout, "python3.13", "3.13")
    done = subprocess.run(
        ["sh", "tools/build/find_python.sh"],
        cwd=bare_checkout,
        env={"PATH": str(bare_checkout / "bin")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(wanted)


def test_missing_libraries_are_named_with_their_packages():
    system = tool("check_system")
    absent = system.missing(present=lambda soname: soname not in {"libEGL.so.1", "libSM.so.6"})
    assert absent == {"libSM.so.6": "libsm6", "libEGL.so.1": "libegl1"}
    sentence = system.sentence(absent)
    assert sentence.count("\n") == 0
    assert "apt-get install libsm6 libegl1" in sentence


def test_any_driver_of_egl_will_do():
    system = tool("check_system")
    assert system.missing(present=lambda soname: soname != "libEGL_mesa.so.0") == {}
    neither = {"libEGL_mesa.so.0", "libEGL_nvidia.so.0"}
    assert list(system.missing(present=lambda soname: soname not in neither).values()) == ["libegl-mesa0"]


@pytest.mark.parametrize("python", ["3.11", "3.13"])
def test_requirements_hold_one_version_of_each_package(python):
    pins = tool("requirements").requirements(["blender", "test", "dev"], python)
    names = [pin.partition("==")[0] for pin in pins]
    assert len(names) == len(set(names))
    assert {"bpy", "numpy", "pytest", "ruff"} <= set(names)
    assert ("bpy==4.5.15" in pins) == ("colour-science==0.4.6" in pins) == (python == "3.11")


def test_a_marker_that_would_be_misread_is_refused():
    with pytest.raises(SystemExit, match="python_version"):
        tool("requirements").applies("sys_platform == 'linux'", "3.11")


def test_the_ci_script_is_sound():
    done = subprocess.run(["bash", "-n", ROOT / ".ci" / "run"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert os.access(ROOT / ".ci" / "run", os.X_OK)


@pytest.mark.parametrize("has_python", [True, False])
def test_the_ci_says_that_blender_4_5_was_skipped(bare_checkout, has_python):
    """Every step is a stand-in; the tests' reports hold what it writes."""
    shutil.copytree(ROOT / ".ci", bare_checkout / ".ci")
    for name in ("bash", "id", "timeout"):
        (bare_checkout / "bin" / name).symlink_to(shutil.which(name))
    (bare_checkout / ".venv" / "bin").mkdir(parents=True)
    python = bare_checkout / ".venv" / "bin" / "python"
    python.write_text(f'#!/bin/sh\n[ "$1" != - ] || exec {sys.executable} "$@"\n', encoding="utf-8")
    program = bare_checkout / "bin" / "make"
    program.unlink()
    program.write_text(
        "#!/bin/sh\n"
        'case "$2" in --version) exit 0;; PYTEST_ARGS=--junit-xml=*) report="${2#*xml=}";; *) exit 0;; esac\n'
        'echo \'<testsuites><testsuite tests="5" failures="0" errors="0" skipped="1"/></testsuites>\' > "$report"\n',
        encoding="utf-8",
    )
    for path in (python, program):
        path.chmod(0o755)
    fake_python(bare_checkout, "python3.13", "3.13")
    if has_python:
        fake_python(bare_checkout, "python3.11", "3.11")
    done = subprocess.run(
        [shutil.which("bash"), ".ci/run"],
        cwd=bare_checkout,
        env={"PATH": str(bare_checkout / "bin"), "HOME": str(bare_checkout)},
        capture_output=True,
        text=True,
        check=False,
    )
    lines = done.stdout.splitlines()
    assert done.returncode == 0, done.stdout + done.stderr
    if has_python:  # eight steps, and four of five tests in each Blender
        assert lines[-1] == "16 passed, 0 failed, 2 skipped"
        assert "skipped: no Python 3.11" not in lines
    else:
        assert lines[-3:-1] == ["skipped: no Python 3.11", "skipped: no Blender window"]
        assert lines[-1] == "10 passed, 0 failed, 1 skipped"


def test_an_interpreter_among_pyenvs_is_found(bare_checkout):
    folder = bare_checkout / ".pyenv" / "versions" / "3.11.7"
    (folder / "bin").mkdir(parents=True)
    wanted = fake_python(folder, "python3.11", "3.11")
    done = subprocess.run(
        ["sh", "tools/build/find_python.sh", "3.11"],
        cwd=bare_checkout,
        env={"PATH": str(bare_checkout / "bin"), "HOME": str(bare_checkout)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(wanted)
