# SPDX-License-Identifier: GPL-3.0-or-later
# Every target sets up what it needs in .venv; nothing outside this folder is touched.
.DEFAULT_GOAL := help
.PHONY: help setup demo test test-slow fuzz bench lint docs build clean

VENV := .venv
PY := $(VENV)/bin/python
READY := $(VENV)/ready
export PIP_DISABLE_PIP_VERSION_CHECK := 1
export PYTHONDONTWRITEBYTECODE := 1

help:
	@echo "make setup      .venv with Blender as a module and the tools"
	@echo "make demo       scan -> bake -> picture, written to out/ (SCAN=path takes your own)"
	@echo "make test       all tests but the slow ones; make test-slow: those too; make test-thorough: hours of them"
	@echo "make fuzz       hostile files, kill -9, full disks: what tests/trust holds, slow ones too"
	@echo "make bench      times, memory and accuracy of a bake"
	@echo "make lint       ruff check and format"
	@echo "make docs       the pictures of docs/"
	@echo "make build      the extension, one zip a platform, in dist/"

setup: $(READY)

$(READY): pyproject.toml .python-version tools/check_system.py tools/find_python.sh tools/requirements.py
	@sh tools/find_python.sh > /dev/null
	@test -x $(PY) && $(PY) -c "import sys; sys.exit('%d.%d' % sys.version_info[:2] != '$(shell cut -d. -f1,2 .python-version)')" 2> /dev/null \
		|| { rm -rf $(VENV); "$$(sh tools/find_python.sh)" -m venv $(VENV); }
	@$(PY) tools/check_system.py
	@$(PY) tools/requirements.py blender sweep test dev > $(VENV)/requirements.txt
	@echo "Installing Blender as a module and the tools into $(VENV) (about 500 MB, once) ..."
	@$(PY) -m pip install --quiet --requirement $(VENV)/requirements.txt
	@touch $(READY)

demo: $(READY)
	@$(PY) tools/demo.py $(if $(SCAN),--scan "$(SCAN)")

test: $(READY)
	@$(PY) -m pytest -m "not slow" $(PYTEST_ARGS)

test-slow: $(READY)
	@$(PY) -m pytest -m "not thorough" $(PYTEST_ARGS)

test-thorough: $(READY)
	@$(PY) -m pytest $(PYTEST_ARGS)

fuzz: $(READY)
	@$(PY) -m pytest tests/trust $(PYTEST_ARGS)

bench: $(READY)
	@$(PY) tools/bench_bake.py
	@$(PY) tools/bench_cycles.py
	@$(PY) tools/bench_viewport.py

lint: $(READY)
	@$(PY) -m ruff check .
	@$(PY) -m ruff format --check .

docs: $(READY)
	@$(PY) tools/docs.py

build: $(READY)
	@$(PY) tools/build_extension.py --platform all

clean:
	rm -rf $(VENV) out dist build wheels
