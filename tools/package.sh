#!/usr/bin/env bash
# Makes a Debian package of tagcal from build/release, and prints its path.
#
#   tools/package.sh [--python] [--check | --check-library]
#
# --python         the package has the Python module too (without it: if build/release has it)
# --check          installs the package into a clean Debian, in a temporary folder by mmdebstrap, runs
#                  the demo there as an ordinary user, and removes the package again (3 minutes, 200 MB
#                  from the Debian mirror of this machine). Where that is not allowed it is skipped,
#                  with a line that says why.
# --check-library  the same with the recommended packages, by which a C++ program is compiled against
#                  the library there (400 MB)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/usage.sh
source tools/clean_debian.sh

setup=(./tools/setup.sh)
check=
for option in "$@"; do
  case "$option" in
    --python) setup+=(--python) ;;
    --check) check=demo ;;
    --check-library) check=library ;;
    *)
      echo "package.sh: $option: unknown option (known: --python, --check, --check-library, --help)" >&2
      exit 2
      ;;
  esac
done

# What the check needs, below a folder: the package, the demo and its scene.
copy_for_check() {
  mkdir -p "$1/tools" "$1/data-synthetic/scenes" "$1/consumer"
  cp "$deb" "$1/tagcal.deb"
  cp tools/demo.sh tools/package_check.sh "$1/tools"
  cp data-synthetic/scenes/desk.yaml "$1/data-synthetic/scenes"
  cp tests/consumer/tag_pose.cpp "$1/consumer"
}

check_in_clean_debian() {
  local work
  # shellcheck source=/dev/null
  source /etc/os-release
  if [ "${ID:-}" != debian ]; then
    echo "package.sh: skipped: the package is for ${PRETTY_NAME:-this system}, on which it was made, not for Debian" >&2
    exit 0
  fi
  work=$(mktemp --directory)
  # shellcheck disable=SC2064
  trap "rm -rf '$work'" EXIT
  chmod a+rx "$work"
  copy_for_check "$work/check"
  echo "package.sh: checking the package in a clean $PRETTY_NAME (log: build/package/check.log)" >&2
  if ! in_clean_debian "$VERSION_CODENAME" build/package/check.log "$work/check" "./tools/package_check.sh $check"; then
    tail -n 8 build/package/check.log >&2
    echo "package.sh: the package does not work in a clean $PRETTY_NAME" >&2
    exit 1
  fi
  echo "package.sh: the package works in a clean $PRETTY_NAME" >&2
}

"${setup[@]}" >&2
mkdir -p build/package
rm -f build/package/*.deb
cpack --config build/release/CPackConfig.cmake -B build/package >build/package/cpack.log 2>&1 || {
  cat build/package/cpack.log >&2
  exit 1
}
rm -rf build/package/_CPack_Packages
deb=$(ls build/package/*.deb)
echo "$deb"
if [ -n "$check" ]; then check_in_clean_debian; fi
