# SPDX-License-Identifier: GPL-3.0-or-later
# Every target sets up what it needs in .venv; nothing outside this folder is touched.
.DEFAULT_GOAL := help
.PHONY: help setup setup-4.5 scan-files demo test test-slow test-thorough test-4.5 test-window fuzz bench gpu-check lint types docs build release clean

VENV := .venv
PY := $(VENV)/bin/python
READY := $(VENV)/ready
# Blender 4.5 LTS and its Python.
VENV45 := .venv-4.5
PY45 := $(VENV45)/bin/python
READY45 := $(VENV45)/ready
export PIP_DISABLE_PIP_VERSION_CHECK := 1
export PYTHONDONTWRITEBYTECODE := 1

help:
	@echo "make setup      .venv with Blender as a module and the tools"
	@echo "make demo       scan -> bake -> picture, written to out/ (SCAN=path takes your own)"
	@echo "make test       all tests but the slow ones; make test-slow: those too; make test-thorough: hours of them"
	@echo "make test-4.5   the smoke tests in Blender 4.5 LTS, set up in .venv-4.5 (needs Python 3.11)"
	@echo "make test-window  clicks in a Blender window: BLENDER=path, or WINDOW_RIG= and WINDOW_FOLDER= of a rig"
	@echo "make scan-files  scans of others and independent readers for the readers' tests, in out/scan-files (160 MB)"
	@echo "make fuzz       hostile files, kill -9, full disks: what tests/trust holds, slow ones too"
	@echo "make bench      times, memory and accuracy of a bake"
	@echo "make gpu-check  every device that Blender has here, pixel by pixel against the processor"
	@echo "make lint       ruff check and format; make types: mypy on precompute/ and addon/"
	@echo "make docs       the pictures of docs/"
	@echo "make build      the extension, one zip a platform and Python of Blender, in dist/"
	@echo "make release    the same, and the index that Blender's remote repositories read"

setup: $(READY)

$(READY): pyproject.toml .python-version tools/build/check_system.py tools/build/find_python.sh tools/build/requirements.py
	@sh tools/build/find_python.sh > /dev/null
	@test -x $(PY) && $(PY) -c "import sys; sys.exit('%d.%d' % sys.version_info[:2] != '$(shell cut -d. -f1,2 .python-version)')" 2> /dev/null \
		|| { rm -rf $(VENV); "$$(sh tools/build/find_python.sh)" -m venv $(VENV); }
	@$(PY) tools/build/check_system.py
	@$(PY) tools/build/requirements.py blender unbundled sweep test dev > $(VENV)/requirements.txt
	@echo "Installing Blender as a module and the tools into $(VENV) (about 500 MB, once) ..."
	@$(PY) -m pip install --quiet --requirement $(VENV)/requirements.txt
	@touch $(READY)

setup-4.5: $(READY45)

$(READY45): pyproject.toml tools/build/check_system.py tools/build/find_python.sh tools/build/requirements.py
	@sh tools/build/find_python.sh 3.11 > /dev/null
	@test -x $(PY45) || "$$(sh tools/build/find_python.sh 3.11)" -m venv $(VENV45)
	@$(PY45) tools/build/check_system.py
	@$(PY45) tools/build/requirements.py blender unbundled test > $(VENV45)/requirements.txt
	@echo "Installing Blender 4.5 LTS as a module into $(VENV45) (about 500 MB, once) ..."
	@$(PY45) -m pip install --quiet --requirement $(VENV45)/requirements.txt
	@touch $(READY45)

demo: $(READY)
	@$(PY) tools/demo.py $(if $(SCAN),--scan "$(SCAN)")

# Two processes, a file of tests at a time: most of a test's time is Blender's own, on one core.
test: $(READY)
	@OPENBLAS_NUM_THREADS=1 $(PY) -m pytest -m "not slow" --numprocesses 2 --dist loadfile $(PYTEST_ARGS)

test-slow: $(READY)
	@$(PY) -m pytest -m "not thorough" $(PYTEST_ARGS)

test-thorough: $(READY)
	@$(PY) -m pytest $(PYTEST_ARGS)

test-4.5: $(READY45)
	@$(PY45) -m pytest -m "smoke and not slow" $(PYTEST_ARGS)

# One process: the tests of a working day follow each other in one window.
test-window: $(READY)
	@$(PY) -m pytest tests/window -p no:xdist $(PYTEST_ARGS)

# An environment of its own: the independent readers bring 400 MB of libraries, which nothing here may lean on.
SCANS := out/scan-files
scan-files: $(READY)
	@mkdir -p $(SCANS)/sources
	@test -x $(SCANS)/venv/bin/python || $(PY) -m venv $(SCANS)/venv
	@$(SCANS)/venv/bin/python -m pip install --quiet --requirement tests/support/independent.txt
	@$(SCANS)/venv/bin/python -m pip install --quiet --no-deps AFMReader==0.0.7 nanosurf-core==2.0.7 nanosurf-utils==2.0.7 \
		spym==0.9.2 magic-afm==1.0.0b3
	@cd $(SCANS)/sources && ../venv/bin/python -m pip download --quiet --no-deps --no-binary :all: AFMReader==0.0.7 topostats==2.2.1 \
		&& for archive in *.tar.gz; do tar xzf $$archive; done
	@$(SCANS)/venv/bin/python tests/support/independent.py $(SCANS)/sources $(SCANS)/cases

fuzz: $(READY)
	@$(PY) -m pytest tests/trust $(PYTEST_ARGS)

bench: $(READY)
	@$(PY) tools/bench/bench_bake.py
	@$(PY) tools/bench/bench_stuff.py
	@$(PY) tools/bench/bench_commands.py
	@$(PY) tools/bench/bench_scene.py
	@$(PY) tools/bench/bench_cycles.py
	@$(PY) tools/bench/bench_lights.py
	@$(PY) tools/bench/bench_paint.py
	@$(PY) tools/bench/bench_viewport.py

gpu-check: $(READY)
	@$(PY) tools/gpu_check.py --out out/gpu_check.json

lint: $(READY)
	@$(PY) -m ruff check .
	@$(PY) -m ruff format --check .

types: $(READY)
	@$(PY) tools/build/check_types.py

docs: $(READY)
	@$(PY) tools/docs/all.py

build: $(READY)
	@$(PY) tools/build/build_extension.py --platform all

release: $(READY)
	@$(PY) tools/build/release.py

clean:
	rm -rf $(VENV) $(VENV45) out dist build wheels
