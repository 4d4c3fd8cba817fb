#!/bin/sh
# Makes dist/ again from src/ (needs Node 18 or newer, npm and, for npm ci, a network). The build
# of tagcal needs none of this: it embeds the files of dist/, which stand in the repository.
# "build.sh --check" makes them in a temporary folder and fails if they differ from dist/.
set -eu
cd "$(dirname "$0")"
work=.
if [ "${1:-}" = --check ]; then
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
  cp -r package.json package-lock.json build.mjs src "$work"
fi
(cd "$work" && npm ci --silent --no-audit --no-fund && npm run --silent build)
if [ "$work" != . ]; then
  for file in report.js report.css LICENSES SHA256SUMS; do cmp "dist/$file" "$work/dist/$file"; done
  echo "dist is what src makes"
fi
wc -c dist/report.js dist/report.css
