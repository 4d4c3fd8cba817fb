#!/bin/sh
# Makes the pictures of docs/tasks/first_calibration.md: first_calibration/pictures.sh [TAGCAL=tagcal] [FOLDER=docs/tasks/first_calibration]
# That of the report needs chromium and is left as it is without it.
set -eu
root=$(cd "$(dirname "$0")/../../.." && pwd)
tagcal=${1:-tagcal}
out=${2:-$root/docs/tasks/first_calibration}
work=$(mktemp -d)
mkdir -p "$out"
trap 'rm -rf "$work"' EXIT

# small NAME EDITS NUMBER..: these views of the phone's scene, with these edits, in a fifth of its size.
small() {
  name=$1
  sed -e "$2" -e 's/image_size: \[1200, 900\]/image_size: [240, 180]/; s/f: 900/f: 180/; s/f: 927/f: 185.4/' \
    -e 's/cx: 604.6, cy: 446.2/cx: 120.5, cy: 88.8/; s/noise_levels: 3/noise_levels: 1/' \
    "$root/data-synthetic/scenes/phone.yaml" >"$work/$name.yaml"
  shift 2
  "$tagcal" render "$work/$name.yaml" --out "$work/$name" >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
  for number; do cp "$work/$name/images/$number.png" "$out/${name}_$number.png"; done
}
small good '' 003 010 006
small flat 's/elevation_deg: 40/elevation_deg: 89.5/; s/elevation_deg: 85/elevation_deg: 90/; s/target_m: 0.06/target_m: 0.003/' 003 010 006
small far 's/distance_m: 0.2/distance_m: 0.8/; s/distance_m: 0.32/distance_m: 0.9/; s/target_m: 0.06/target_m: 0.02/' 003 010 006
small focus 's/f: 900/f: 927/' 003

if command -v chromium >/dev/null; then
  cd "$work"
  "$tagcal" render "$root/data-synthetic/scenes/phone.yaml" --out phone 2>log || { cat log >&2; exit 1; }
  "$tagcal" calibrate phone --out camera.yaml --report report.html >log 2>&1 || { cat log >&2; exit 1; }
  chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --window-size=1100,1080 \
    --force-device-scale-factor=0.8 --screenshot="$out/report.png" "file://$work/report.html" >log 2>&1
fi
