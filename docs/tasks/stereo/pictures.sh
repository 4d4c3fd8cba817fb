#!/bin/sh
# The pictures of docs/tasks/stereo.md. Run in the root of the project, after tools/setup.sh, with
# python3-opencv:
#   docs/tasks/stereo/pictures.sh
set -eu
tagcal=$(realpath "${TAGCAL:-build/release/tools/tagcal}")
root=$PWD
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"$tagcal" render "$root/data-synthetic/scenes/stereo.yaml" --out stereo
"$tagcal" rig stereo --out rig.yaml
"$tagcal" reproject stereo/left/images stereo/right/images --camera rig.yaml --rectify flat
sed -n '/^```python$/,/^```$/p' "$root/docs/tasks/stereo.md" | grep -v '^```' >depth.py
/usr/bin/python3 depth.py
/usr/bin/python3 -c '
import cv2
lines = cv2.imread("flat/lines/000.png")
cv2.imwrite("lines.png", cv2.resize(lines, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA))'
cp lines.png depth.png "$root/docs/tasks/stereo/"
