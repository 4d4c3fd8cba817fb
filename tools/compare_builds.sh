#!/usr/bin/env bash
# Builds the command with several presets and compares the answers: a table of the largest
# differences, corners, cameras and poses in their own standard deviations. Exit code 1 if one is
# beyond the tolerances of tests/same/answers.py.
#   tools/compare_builds.sh [PRESET, default release, clang and dev]..
# The first preset is what the others are compared with. A build takes about ten minutes on one core.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/usage.sh
presets=("$@")
[ ${#presets[@]} -gt 0 ] || presets=(release clang dev)

programs=()
for preset in "${presets[@]}"; do
  ./tools/configure.sh "$preset" >/dev/null
  nice -n 10 cmake --build "build/$preset" --target tagcal_command --parallel "${JOBS:-$(nproc)}" >/dev/null
  programs+=("$preset=build/$preset/tools/tagcal")
done
exec python3 tests/same/compare_programs.py "${programs[@]}"
