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

# Three faults: each picture of the right camera from two instants later; the right camera turned by
# three degrees after the calibration; fisheyes as pinholes that show all that they see.
mkdir late
i=0
for picture in stereo/right/images/*.png; do
  later=$(printf 'stereo/right/images/%03d.png' $(((i + 2) % 30)))
  cp "$later" "late/$(basename "$picture")"
  i=$((i + 1))
done
"$tagcal" reproject stereo/left/images late --camera rig.yaml --cameras left,right --rectify flat_late
sed 's/roll_pitch_yaw_deg: \[0.6, -0.4/roll_pitch_yaw_deg: [3.6, -0.4/' "$root/data-synthetic/scenes/stereo.yaml" >turned.yaml
"$tagcal" render turned.yaml --out turned
"$tagcal" reproject turned/left/images turned/right/images --camera rig.yaml --rectify flat_turned
sed 's/model: opencv5, fx: [0-9.]*, fy: [0-9.]*, \(cx: [0-9.]*, cy: [0-9.]*\), distortion: .*]}/model: fisheye4, fx: 230, fy: 230, \1, distortion: [0, 0, 0, 0]}/' \
  "$root/data-synthetic/scenes/stereo.yaml" >wide.yaml
"$tagcal" render wide.yaml --out wide
"$tagcal" rig wide --out wide_rig.yaml
"$tagcal" reproject wide/left/images wide/right/images --camera wide_rig.yaml --alpha 1 --rectify flat_wide

/usr/bin/python3 -c '
import cv2
def small(name, picture, scale):
    cv2.imwrite(name, cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA),
                [cv2.IMWRITE_JPEG_QUALITY, 80])
small("lines.png", cv2.imread("flat/lines/000.png"), 0.5)
for fault in "late", "turned", "wide":
    small(f"{fault}.jpg", cv2.imread(f"flat_{fault}/lines/000.png"), 0.4)'
cp lines.png depth.png late.jpg turned.jpg wide.jpg "$root/docs/tasks/stereo/"
