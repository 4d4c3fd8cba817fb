#!/usr/bin/env bash
# Runs the main steps on data of its own: render, detect, calibrate, validate. A step whose result is
# newer than the program and the scene is skipped. `--program FILE` takes a program that is there
# instead of building one.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/usage.sh

if [ $# -eq 0 ]; then
  tagcal=build/release/tools/tagcal
  ./tools/setup.sh
elif [ $# -eq 2 ] && [ "$1" = --program ]; then
  tagcal=$2
else
  echo "demo.sh: $*: unknown options (known: --program FILE)" >&2
  exit 2
fi
scene=data-synthetic/scenes/desk.yaml
out=data-synthetic/out/desk
mkdir -p "$(dirname "$out")"
times=()

# step NAME RESULT INPUT -- COMMAND...: makes RESULT unless it is newer than INPUT and the program.
step() {
  local name=$1 result=$2 input=$3 before after
  shift 4
  if [ "$result" -nt "$input" ] && [ "$result" -nt "$tagcal" ]; then
    times+=("$name done before")
    return
  fi
  echo "tagcal $*" >&2
  before=${EPOCHREALTIME/[.,]/}
  if ! "$tagcal" "$@" >"$out.log"; then
    cat "$out.log"
    exit 1
  fi
  after=${EPOCHREALTIME/[.,]/}
  if [ ! "$result" -nt "$input" ]; then mv "$out.log" "$result"; fi  # the result was on stdout
  times+=("$(printf '%s %d.%02d s' "$name" $(((after - before) / 1000000)) \
    $(((after - before) % 1000000 / 10000)))")
}

step render "$out/dataset.yaml" "$scene" -- render "$scene" --force --out "$out"
step detect "$out/corners.csv" "$out/dataset.yaml" -- detect "$out" --out "$out/corners.csv"
step calibrate "$out/camera.yaml" "$out/corners.csv" -- \
  calibrate "$out" --observations "$out/corners.csv" --out "$out/camera.yaml"
step validate "$out/validation.txt" "$out/camera.yaml" -- \
  validate "$out/camera.yaml" --dataset "$out" --observations "$out/corners.csv"
rm -f "$out.log"

echo
echo "$scene"
cat "$out/validation.txt"
printf 'time       %s\n' "$(IFS=,; echo "${times[*]}" | sed 's/,/, /g')"
