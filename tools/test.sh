#!/usr/bin/env bash
# Runs the set-up, then builds and tests everything, the Python module too.
#   test.sh                  the release
#   test.sh --asan           under the address and undefined-behaviour sanitizers; builds no release
#   test.sh --asan-inputs    so, but only the tests that read files, detect and run commands
#   test.sh --tsan           under the thread sanitizer, the tests of what runs in several threads
#   test.sh --valgrind       the tests that run commands, with each command under valgrind, which
#                            sees values that were never set; what it says is in build/valgrind
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/usage.sh

preset=release
build=release
python=--python
tests=()
case "${1:-}" in
  "") ;;
  --asan) preset=asan build=asan ;;
  --asan-inputs) preset=asan-inputs build=asan python= ;;
  --tsan) preset=tsan build=tsan python= ;;
  --valgrind)
    rm -rf build/valgrind
    mkdir -p build/valgrind
    export TAGCAL_TEST_UNDER="valgrind --quiet --error-exitcode=99 --log-file=$PWD/build/valgrind/%p"
    tests=(--label-regex '^cli$')
    ;;
  *)
    echo "test.sh: $1: unknown option (known: --asan, --asan-inputs, --tsan, --valgrind)" >&2
    exit 2
    ;;
esac

if [ "$preset" = release ]; then
  ./tools/setup.sh --python
else
  ./tools/setup.sh --python --no-build
fi
./tools/configure.sh "$build" $python
cmake --build --preset "$preset" --parallel "$(nproc)"
ctest --preset "$preset" --parallel "$(nproc)" "${tests[@]}"
