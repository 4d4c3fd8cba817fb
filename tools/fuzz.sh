#!/usr/bin/env bash
# Searches for inputs that break a fuzz target (tests/fuzz/NAME_fuzz.cpp) with libFuzzer, under the
# address and undefined-behaviour sanitizers.
#   fuzz.sh NAME MINUTES [SEED]
# Begins with tests/fuzz/corpus/NAME and what earlier runs kept in build/fuzz/corpus/NAME, so that a
# long search may be run in pieces. What it finds is in build/fuzz/findings/NAME; it then ends with
# 1. Such a file becomes a test by copying it to tests/fuzz/corpus/NAME. Needs Clang:
# tools/setup.sh --checks.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

names=$(basename --suffix=_fuzz.cpp --multiple tests/fuzz/*_fuzz.cpp | tr '\n' ' ')
if [ $# -lt 2 ] || [ ! -f "tests/fuzz/$1_fuzz.cpp" ] || ! [[ $2 =~ ^[0-9]+$ ]]; then
  echo "fuzz.sh: usage: fuzz.sh NAME MINUTES [SEED], NAME one of: $names" >&2
  exit 2
fi
name=$1
minutes=$2
seed=${3:-0}

./tools/configure.sh fuzz
cmake --build --preset fuzz --target "fuzz_$name" --parallel "$(nproc)" >&2
found=build/fuzz/findings/$name
kept=build/fuzz/corpus/$name
mkdir -p "$found" "$kept"

# A reader may take a second and little memory for what is not work that was asked for; a
# calibration takes longer, above all under the sanitizers, which slow it down 20 to 50 times.
timeout=10
case "$name" in calibrate) timeout=120 ;; esac
export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1
export TMPDIR=${TMPDIR:-$(mktemp --directory)}
"build/fuzz/tests/fuzz/fuzz_$name" -max_total_time=$((60 * minutes)) -seed="$seed" \
  -timeout="$timeout" -rss_limit_mb=2048 -malloc_limit_mb=1024 -max_len=4096 -use_value_profile=1 \
  -print_final_stats=1 -artifact_prefix="$found/" "$kept" "tests/fuzz/corpus/$name" 2>&1 |
  grep --invert-match --extended-regexp '^#[0-9]+[[:space:]]+(NEW|REDUCE|pulse)' || true
status=${PIPESTATUS[0]}
exit "$((status == 0 ? 0 : 1))"
