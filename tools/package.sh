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

setup=(./tools/setup.sh)
check=
for option in "$@"; do
  case "$option" in
    --python) setup+=(--python) ;;
    --check) check=demo ;;
    --check-library) check=library ;;
    --help | -h)
      sed -n '2,/^[^#]/s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *)
      echo "package.sh: $option: unknown option (known: --python, --check, --check-library, --help)" >&2
      exit 2
      ;;
  esac
done

skip() {
  echo "package.sh: check skipped: $1" >&2
  exit 0
}

# What the check needs, below a folder: the package, the demo and its scene.
copy_for_check() {
  mkdir -p "$1/tools" "$1/data-synthetic/scenes" "$1/consumer"
  cp "$deb" "$1/tagcal.deb"
  cp tools/demo.sh tools/package_check.sh "$1/tools"
  cp data-synthetic/scenes/desk.yaml "$1/data-synthetic/scenes"
  cp tests/consumer/tag_pose.cpp "$1/consumer"
  chmod -R a+rX "$1"
}

# The lists of Debian packages of this machine, so that its mirror is used; none: mmdebstrap's own.
package_lists() {
  local list
  for list in /etc/apt/sources.list.d/debian.sources /etc/apt/sources.list; do
    if grep --quiet --extended-regexp "^[^#]*\b$VERSION_CODENAME\b" "$list" 2>/dev/null; then echo "$list"; fi
  done
}

check_in_clean_debian() {
  local work lists
  # shellcheck source=/dev/null
  source /etc/os-release
  if [ "${ID:-}" != debian ]; then
    skip "the package is for ${PRETTY_NAME:-this system}, on which it was made, not for Debian"
  fi
  if ! command -v mmdebstrap >/dev/null && ! ./tools/setup.sh --package; then
    skip "mmdebstrap is not installed, and cannot be installed by this user (apt-get install mmdebstrap)"
  fi
  work=$(mktemp --directory)
  # shellcheck disable=SC2064
  trap "rm -rf '$work'" EXIT
  copy_for_check "$work/check"
  chmod a+rx "$work"  # without root, mmdebstrap's root is another user
  mapfile -t lists < <(package_lists)
  echo "package.sh: checking the package in a clean $PRETTY_NAME (log: build/package/check.log)" >&2
  if ! LC_ALL=C.UTF-8 mmdebstrap --variant=apt --format=null \
    --customize-hook='echo made >&4' \
    --customize-hook="copy-in '$work/check' /opt" \
    --customize-hook="chroot \"\$1\" /opt/check/tools/package_check.sh $check >&3" \
    "$VERSION_CODENAME" /dev/null "${lists[@]}" 3>&1 4>"$work/made" \
    >build/package/check.log 2>&1; then
    if [ ! -s "$work/made" ]; then
      skip "no clean Debian could be made here, which needs root or user namespaces, and a mirror (mmdebstrap: $(
        sed -n 's/^E: //p' build/package/check.log | head -n 1
      ))"
    fi
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
