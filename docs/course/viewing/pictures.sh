#!/bin/sh
# Makes the pictures of docs/course/viewing.md: docs/course/viewing/pictures.sh [TAGCAL=tagcal] [FOLDER=docs/course/viewing]
set -eu
root=$(cd "$(dirname "$0")/../../.." && pwd)
tagcal=${1:-tagcal}
out=${2:-$root/docs/course/viewing}
scenes=$root/data-synthetic/scenes/viewing
work=$(mktemp -d)
mkdir -p "$out"
trap 'rm -rf "$work"' EXIT

# take NAME SCENE.yaml NUMBER: the picture of this number becomes NAME.png.
take() {
  "$tagcal" render "$2" --out "$work/$1" >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
  cp "$work/$1/images/$3.png" "$out/$1.png"
}

# house NAME CAMERA PATH: the house by another camera, from another place.
house() {
  sed -e "s/^camera: .*/camera: {image_size: [320, 240], $2}/" -e "s/^path: .*/path: {$3, target_m: [0, 0, 0.15]}/" \
    "$scenes/house.yaml" >"$work/$1.yaml"
  take "$1" "$work/$1.yaml" 000
}
parallel='model: parallel, scale_px_per_m: 250'
house perspective 'model: f, f: 400' 'type: look_at, eye_m: [0.64, -0.96, 0.87]'
house plan "$parallel" 'type: drawn, view: plan'
house front "$parallel" 'type: drawn, view: front_elevation'
house side "$parallel" 'type: drawn, view: side_elevation'
house isometric "$parallel" 'type: drawn, view: isometric'
house cavalier "$parallel, projection: cavalier" 'type: drawn, view: front_elevation'
house cabinet "$parallel, projection: cabinet" 'type: drawn, view: front_elevation'

take turned "$scenes/turned.yaml" 000
take wheel "$scenes/wheel.yaml" 002
take aircraft "$scenes/aircraft.yaml" 000
take tower "$scenes/tower.yaml" 000
take window "$scenes/window.yaml" 001
take wall "$scenes/wall.yaml" 000
