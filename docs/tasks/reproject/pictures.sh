#!/bin/sh
# The pictures of docs/tasks/reproject.md. Run in the root of the project, after tools/setup.sh:
#   docs/tasks/reproject/pictures.sh
set -eu
tagcal=${TAGCAL:-build/release/tools/tagcal}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$tagcal" render data-synthetic/scenes/fisheye_room.yaml --out "$work/room"
reproject() {
  name=$1
  shift
  "$tagcal" reproject --camera "$work/room/truth.yaml" "$work/room/images/000.png" --out "$work/$name" "$@"
}
reproject pinhole --undistort 120
reproject panorama --panorama equirectangular
reproject cube --pinholes 5
reproject plane --plane --target "$work/room/target.yaml" --m-per-px 0.0025 --rectangle=-0.3,-0.2,0.96,0.86
cp "$work/room/images/000.png" docs/tasks/reproject/fisheye.png
for name in pinhole panorama plane; do cp "$work/$name/000.png" "docs/tasks/reproject/$name.png"; done
for face in left front; do cp "$work/cube/$face/000.png" "docs/tasks/reproject/$face.png"; done
