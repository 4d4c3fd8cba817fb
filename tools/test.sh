#!/usr/bin/env bash
# Runs the set-up, then builds and tests everything, the Python module too. `--asan` does so under
# the address and undefined-behaviour sanitizers instead.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

preset=release
case "${1:-}" in
  "") ;;
  --asan) preset=asan ;;
  *)
    echo "test.sh: $1: unknown option (known: --asan)" >&2
    exit 2
    ;;
esac

./tools/setup.sh --python
./tools/configure.sh "$preset" --python
cmake --build --preset "$preset" --parallel "$(nproc)"
ctest --preset "$preset" --parallel "$(nproc)"
