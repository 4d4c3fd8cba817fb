#!/usr/bin/env bash
# Configures build/PRESET unless it is configured.
#   configure.sh PRESET [--python | --has-python]
# --python switches the Python module on, for Debian's python3, where it is off. Later runs without
# the option leave it on. --has-python only tells by the exit code whether it is on.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

preset=$1
option=${2:-}

has_python() {
  grep --quiet --ignore-case --extended-regexp '^TAGCAL_BUILD_PYTHON:.*=(ON|1|TRUE|YES)$' \
    "build/$preset/CMakeCache.txt" 2>/dev/null
}

if [ "$option" = --has-python ]; then
  has_python
elif [ "$option" = --python ] && ! has_python; then
  cmake --preset "$preset" -D TAGCAL_BUILD_PYTHON=ON -D Python_EXECUTABLE=/usr/bin/python3
elif [ ! -f "build/$preset/build.ninja" ]; then
  cmake --preset "$preset"
fi
