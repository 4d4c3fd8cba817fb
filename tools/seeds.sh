#!/usr/bin/env bash
# Compares the whole chain with the truth: renders a scene with many seeds, detects, calibrates and
# validates each, and prints per parameter the mean of ((estimate - truth) / sd)^2, which is 1 where
# the standard deviations are right, with the largest error of fx and the worst projection
# difference to OpenCV.
#   tools/seeds.sh [SEEDS=50] [SCENE=data-synthetic/scenes/desk.yaml]
set -euo pipefail
cd "$(dirname "$0")/.."
source tools/usage.sh
seeds=${1:-50}
scene=${2:-data-synthetic/scenes/desk.yaml}
tagcal=build/release/tools/tagcal
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

one_seed() {
  local folder=$work/$1
  "$tagcal" render "$scene" --out "$folder" --seed "$1" --threads 1 >/dev/null 2>&1
  "$tagcal" detect "$folder" --out "$folder/observations.csv" --threads 1 2>/dev/null
  "$tagcal" calibrate "$folder" --observations "$folder/observations.csv" \
    --out "$folder/calibration.yaml" >/dev/null
  "$tagcal" validate "$folder/calibration.yaml" --dataset "$folder" \
    --observations "$folder/observations.csv" >"$work/$1.txt"
  rm -r "$folder"
}
export -f one_seed
export work scene tagcal
seq "$seeds" | xargs -P "$(nproc)" -I{} bash -c 'one_seed {}'

cat "$work"/*.txt | awk '
  $6 == "sd" { sum[$1] += $5 * $5; count[$1]++; if (!($1 in seen)) { seen[$1] = 1; order[++n] = $1 }
               if ($1 == "fx") { e = ($2 - $4) / $4; if (e < 0) e = -e; if (e > worst) worst = e } }
  /projections of/ { if ($8 + 0 > differs) differs = $8 + 0 }
  /^OpenCV agrees/ { passed++ }
  END { for (i = 1; i <= n; i++) if (sum[order[i]] > 0)
          printf "%-4s mean normalised squared error %.2f over %d seeds\n", order[i], sum[order[i]] / count[order[i]], count[order[i]]
        printf "fx   off by %.5f %% at most\nlargest difference to cv::projectPoints %.2g px; %d agree\n", 100 * worst, differs, passed }'
