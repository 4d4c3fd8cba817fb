#!/usr/bin/env bash
# Plants the mistakes of tests/mutations.txt into a copy of the sources, one at a time, and says which
# no test notices. See tools/mutate.py for the options; `tools/mutate.sh --check` only tests the list.
set -euo pipefail
exec python3 -B "$(dirname "${BASH_SOURCE[0]}")/mutate.py" "$@"
