#!/usr/bin/env bash
# Compares the interface of the shared library with that of an earlier version: its functions, and the
# types of the installed headers (abidiff, of Debian's abigail-tools).
#   abi.sh [COMMIT]   default: the newest tag
# Exit code 1 if a program that was built with the earlier library may not run with this one, although
# both have the same SONAME. Both libraries are built without optimisation in build/abi (five minutes
# each on one core); the earlier one is kept.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/usage.sh

earlier=${1:-$(git describe --tags --abbrev=0 2>/dev/null || true)}
if [ -z "$earlier" ]; then
  echo "abi.sh: there is no tag: name the commit to compare with" >&2
  exit 2
fi
if ! command -v abidiff >/dev/null; then
  echo "abi.sh: abidiff is missing (apt-get install abigail-tools)" >&2
  exit 2
fi

# install SOURCE FOLDER: the library with debug information, and its headers.
install() {
  cmake -S "$1" -B "$2" -G Ninja -D CMAKE_BUILD_TYPE=Debug -D CMAKE_CXX_FLAGS_DEBUG='-O0 -g' \
    -D CMAKE_UNITY_BUILD=ON -D TAGCAL_BUILD_TOOLS=OFF -D TAGCAL_BUILD_TESTS=OFF >&2
  cmake --build "$2" --parallel "$(nproc)" >&2
  cmake --install "$2" --prefix "$2/prefix" >/dev/null
}

commit=$(git rev-parse --verify "$earlier^{commit}")
before=build/abi/$commit
if [ ! -d "$before/prefix" ]; then
  mkdir -p "$before/source"
  git archive "$commit" | tar --extract --directory="$before/source"
  install "$before/source" "$before"
fi
install . build/abi/now

libraries=() headers=() sonames=()
for folder in "$before" build/abi/now; do
  library=$(find "$folder/prefix" -name libtagcal.so)
  if [ -z "$library" ]; then
    echo "abi.sh: $earlier has no shared library" >&2
    exit 2
  fi
  libraries+=("$library")
  headers+=("$folder/prefix/include")
  sonames+=("$(readelf -d "$library" | sed -n 's/.*SONAME.*\[\(.*\)\]/\1/p')")
done
status=0
abidiff --no-added-syms --drop-private-types --headers-dir1 "${headers[0]}" --headers-dir2 "${headers[1]}" \
  "${libraries[@]}" || status=1
if [ "${sonames[0]}" != "${sonames[1]}" ]; then
  echo "abi.sh: ${sonames[0]} became ${sonames[1]}: the interface may change" >&2
  exit 0
fi
[ "$status" -eq 0 ] && echo "abi.sh: the interface of $earlier holds" >&2
exit "$status"
