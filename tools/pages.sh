#!/usr/bin/env bash
# Makes the numbers, charts and maps of the pages again that are older than the code that they
# measure, a piece after the other (tools/pages.txt). A piece takes less than an hour; an interrupted
# run goes on where it was.
#   tools/pages.sh [--list] [PIECE..]      --list: the pieces and their stamps, without running any
# Named pieces are made again in any case. Times in charts need a machine that is idle.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/usage.sh
if [ "${1:-}" != --list ]; then
  ./tools/configure.sh release >/dev/null
  cmake --build build/release --parallel "${JOBS:-$(nproc)}" --target tagcal_command tagcal_study_command >/dev/null
fi
exec python3 tools/pages.py "$@"
