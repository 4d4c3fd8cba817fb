#!/usr/bin/env bash
# Searches for inputs that break a fuzz target (tests/fuzz/NAME_fuzz.cpp) with libFuzzer, under the
# address and undefined-behaviour sanitizers.
#   fuzz.sh NAME MINUTES [SEED]   searches; NAME `all`: every target for that many minutes
#   fuzz.sh --table               what all pieces so far took and found
#   fuzz.sh --coverage            lines of lib/tagcal/io and detect that the inputs reach
# Begins with tests/fuzz/corpus/NAME and what earlier runs kept in build/fuzz/corpus/NAME, so that a
# long search may be run in pieces. What it finds is in build/fuzz/findings/NAME; it then ends with
# 1. Such a file becomes a test by copying it to tests/fuzz/corpus/NAME. Needs Clang:
# tools/setup.sh --checks.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/usage.sh

names=$(basename --suffix=_fuzz.cpp --multiple tests/fuzz/*_fuzz.cpp | tr '\n' ' ')
log=build/fuzz/pieces.tsv

# A reader may take a second and little memory for what is not work that was asked for. What
# estimates may take longer, above all under the sanitizers, which slow it down 20 to 50 times; and
# values of comparisons mean nothing there, where numbers are drawn.
limits() {
  case "$1" in
    calibrate) echo "-timeout=120 -report_slow_units=120" ;;
    pose) echo "-timeout=60 -report_slow_units=60" ;;
    rendered) echo "-timeout=60 -report_slow_units=60 -max_len=256" ;;
    *) echo "-timeout=10 -use_value_profile=1" ;;
  esac
}

# One piece. A line of $log: target, CPU seconds, inputs tried, findings (all, of all pieces).
search() {
  local name=$1 minutes=$2 seed=$3 found=build/fuzz/findings/$1 kept=build/fuzz/corpus/$1
  mkdir -p "$found" "$kept"
  local status=0 out times
  out=$(mktemp)
  # shellcheck disable=SC2046
  { TIMEFORMAT='%U %S'; time "build/fuzz/tests/fuzz/fuzz_$name" -max_len=4096 \
    -max_total_time=$((60 * minutes)) -seed="$seed" -rss_limit_mb=2048 -malloc_limit_mb=1024 \
    $(limits "$name") -print_final_stats=1 -artifact_prefix="$found/" "$kept" \
    "tests/fuzz/corpus/$name" >"$out" 2>&1; } 2>"$out.time" || status=$?
  grep --invert-match --extended-regexp '^#[0-9]+[[:space:]]+(NEW|REDUCE|pulse|RELOAD)' "$out" || true
  times=$(tail -1 "$out.time")
  awk -v name="$name" -v times="$times" -v found="$(find "$found" -type f | wc -l)" '
    /number_of_executed_units/ { tried = $2 }
    END { split(times, t, " "); printf "%s\t%.0f\t%d\t%d\n", name, t[1] + t[2], tried, found }
  ' "$out" >>"$log"
  rm -f "$out" "$out.time"
  return "$status"
}

table() {
  [ -f "$log" ] || { echo "fuzz.sh: no piece has run yet" >&2; exit 2; }
  echo "| target | CPU minutes | inputs tried | inputs kept | findings |"
  echo "|---|---|---|---|---|"
  for name in $names; do
    awk -F '\t' -v name="$name" -v kept="$(find "build/fuzz/corpus/$name" -type f 2>/dev/null | wc -l)" '
      $1 == name { cpu += $2; tried += $3; found = $4 }
      END { printf "| %s | %.0f | %d | %d | %d |\n", name, cpu / 60, tried, kept, found }' "$log"
  done
  awk -F '\t' '{ cpu += $2; tried += $3 }
    END { printf "| all | %.0f | %d | | |\n", cpu / 60, tried }' "$log"
}

# The files of the targets, in memory: they are synced, for which a disk takes longer than for all
# else.
own_scratch() {
  [ -z "${TMPDIR:-}" ] || return 0
  TMPDIR=$(mktemp --directory --tmpdir=/dev/shm || mktemp --directory)
  export TMPDIR
  trap 'rm -rf "$TMPDIR"' EXIT
}

# Replays both corpora. The programs count the lines that they reach.
coverage() {
  local profiles=build/fuzz/profiles report=build/fuzz/coverage.txt objects=() name room
  rm -rf "$profiles"
  mkdir -p "$profiles"
  for name in $names; do
    [ "$name" != calibrate ] && [ "$name" != pose ] || continue  # slow, and reach neither
    local program=build/fuzz/tests/fuzz/fuzz_$name kept=build/fuzz/corpus/$name
    mkdir -p "$kept"
    objects+=(--object "$program")
    LLVM_PROFILE_FILE="$profiles/$name.raw" "$program" -runs=0 "tests/fuzz/corpus/$name" "$kept" >&2
  done
  llvm-profdata merge -sparse "$profiles"/*.raw -o "$profiles/all"
  # The first program has no option. Names of files may be relative, so that awk chooses them.
  llvm-cov report "${objects[@]:1}" --instr-profile "$profiles/all" >"$report"
  for room in lib/tagcal/io lib/tagcal/detect; do
    awk -v room="$room" 'index($1, room "/") { functions += $5; unseen += $6; lines += $8; missed += $9 }
      END { printf "%s: %d of %d lines (%.1f %%), %d of %d functions\n", room, lines - missed, lines,
            100 * (1 - missed / lines), functions - unseen, functions }' "$report"
  done
  echo "by file: $report" >&2
}

build() {
  local programs=() name
  for name in "$@"; do programs+=("fuzz_$name"); done
  ./tools/configure.sh fuzz
  cmake --build --preset fuzz --target "${programs[@]}" --parallel "$(nproc)" >&2
}

case "${1:-}" in
  --table) table; exit 0 ;;
  --coverage)
    # shellcheck disable=SC2086
    build $names
    own_scratch
    coverage
    exit 0
    ;;
esac
if [ $# -lt 2 ] || ! [[ " all $names" == *" $1 "* && $2 =~ ^[0-9]+$ ]]; then
  echo "fuzz.sh: usage: fuzz.sh NAME MINUTES [SEED], NAME one of: ${names}or all" >&2
  exit 2
fi
chosen=$1
[ "$chosen" != all ] || chosen=$names

# shellcheck disable=SC2086
build $chosen
export LLVM_PROFILE_FILE=/dev/null  # a search counts no lines
export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1
own_scratch
failed=0
for name in $chosen; do search "$name" "$2" "${3:-0}" || failed=1; done
exit "$failed"
