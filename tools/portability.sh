#!/usr/bin/env bash
# Builds this tree, with changes that are not committed, in a clean Debian 13 (trixie), as a new user
# would: by mmdebstrap in a temporary folder, with the packages of tools/setup.sh.
#   portability.sh              tools/demo.sh: the program, and the main job (20 minutes, 2 GB)
#   portability.sh --tests      the same, then tools/test.sh, all tests (an hour, 4 GB)
#   portability.sh --package    tools/package.sh --python --check; the package is then below build/portability
#   portability.sh --release R  another release, for example bookworm
# Where no clean Debian can be made it is skipped, with a line that says why.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/usage.sh
source tools/clean_debian.sh

release=trixie
command=./tools/demo.sh
hook=true
while [ $# -gt 0 ]; do
  case "$1" in
    --tests) command='./tools/demo.sh && ./tools/test.sh' ;;
    --package)
      command='./tools/package.sh --python --check'
      hook="copy-out /opt/tagcal/build/package '$PWD/build/portability'"
      ;;
    --release)
      release=${2:?portability.sh: --release: needs a name}
      shift
      ;;
    *)
      echo "portability.sh: $1: unknown option (known: --tests, --package, --release, --help)" >&2
      exit 2
      ;;
  esac
  shift
done

work=$(mktemp --directory)
# shellcheck disable=SC2064
trap "rm -rf '$work'" EXIT
chmod a+rx "$work"
mkdir -p build/portability "$work/tagcal"
git ls-files --cached --others --exclude-standard -z | tar --create --null --files-from=- |
  tar --extract --directory="$work/tagcal"
echo "portability.sh: building in a clean Debian $release (log: build/portability/log)" >&2
if ! in_clean_debian "$release" build/portability/log "$work/tagcal" "$command" "$hook"; then
  tail -n 30 build/portability/log >&2
  echo "portability.sh: fails in a clean Debian $release" >&2
  exit 1
fi
echo "portability.sh: works in a clean Debian $release" >&2
