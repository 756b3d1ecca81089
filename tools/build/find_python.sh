#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# find_python.sh [VERSION]: prints the path of an interpreter of a version (of .python-version where none is given) that
# can make a virtual environment, or says in one sentence what is missing. Looks on PATH, then among pyenv's.
wanted=${1:-$(cat "$(dirname "$0")/../.python-version" 2>/dev/null || echo 3.13)}
minor=$(echo "$wanted" | cut -d. -f1,2)

for candidate in ${PYTHON:+"$PYTHON"} "python$wanted" python "python$minor" python3 \
    "${PYENV_ROOT:-$HOME/.pyenv}"/versions/"$minor".*/bin/"python$minor"; do
    path=$("$candidate" -c "import sys
if '%d.%d' % sys.version_info[:2] == '$minor': print(sys.executable)" 2>/dev/null) || continue
    [ -n "$path" ] || continue
    if "$path" -c "import venv, ensurepip" 2>/dev/null; then
        echo "$path"
        exit 0
    fi
    echo "Python $minor at $path cannot make a virtual environment: install its venv module (Debian package python$minor-venv)." >&2
    exit 1
done
echo "Python $minor is missing: install it (Debian package python$minor and python$minor-venv, or 'pyenv install $minor')." >&2
exit 1
