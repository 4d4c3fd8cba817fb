#!/usr/bin/env bash
# Compares the interface of the shared library with that of an earlier version: its symbols, and the
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

# install SOURCE FOLDER: the library and its headers, into FOLDER/prefix.
install() {
  cmake -S "$1" -B "$2" -G Ninja -D CMAKE_BUILD_TYPE=Debug -D CMAKE_CXX_FLAGS_DEBUG=-O0 \
    -D CMAKE_UNITY_BUILD=ON -D TAGCAL_BUILD_TOOLS=OFF -D TAGCAL_BUILD_TESTS=OFF >&2
  cmake --build "$2" --parallel "$(nproc)" >&2
  cmake --install "$2" --prefix "$2/prefix" >/dev/null
}

# The symbols that a program takes from the library. Weak ones are inline: the program has its own.
symbols() {
  nm --dynamic --defined-only "$1" | awk '$2 ~ /^[TDBR]$/ {print $3}' | sort
}

# types PREFIX OUT: a library with the types of all headers. The debug information of libtagcal itself,
# with all that it instantiates, takes abidiff more than 15 GB.
types() {
  local eigen
  read -ra eigen <<<"$(pkg-config --cflags eigen3)"
  find "$1/include" -name '*.hpp' -printf '#include <%P>\n' | sort |
    c++ -std=c++20 -g -O0 -fno-eliminate-unused-debug-types -fPIC -shared -I "$1/include" \
      "${eigen[@]}" -x c++ - -o "$2"
}

commit=$(git rev-parse --verify "$earlier^{commit}")
before=build/abi/$commit now=build/abi/now
if [ ! -d "$before/prefix" ]; then
  mkdir -p "$before/source"
  git archive "$commit" | tar --extract --directory="$before/source"
  install "$before/source" "$before"
fi
install . "$now"

sonames=()
for folder in "$before" "$now"; do
  library=$(find "$folder/prefix" -name libtagcal.so)
  if [ -z "$library" ]; then
    echo "abi.sh: $earlier has no shared library" >&2
    exit 2
  fi
  sonames+=("$(readelf -d "$library" | sed -n 's/.*SONAME.*\[\(.*\)\]/\1/p')")
  symbols "$library" >"$folder/symbols"
  types "$folder/prefix" "$folder/types.so"
done

status=0
gone=$(comm -23 "$before/symbols" "$now/symbols" | c++filt)
if [ -n "$gone" ]; then
  printf 'symbols that are gone:\n%s\n' "$gone"
  status=1
fi
printf '[suppress_type]\n  name_not_regexp = ^tagcal::\n' >build/abi/suppressions
changes=0
abidiff --non-reachable-types --suppressions build/abi/suppressions --headers-dir1 "$before/prefix/include" \
  --headers-dir2 "$now/prefix/include" "$before/types.so" "$now/types.so" || changes=$?
if ((changes & 3)); then exit 2; fi           # abidiff itself failed
if ((changes & 8)); then status=1; fi         # incompatible; 4: additions
if [ "${sonames[0]}" != "${sonames[1]}" ]; then
  echo "abi.sh: ${sonames[0]} became ${sonames[1]}: the interface may change" >&2
  exit 0
fi
[ "$status" -eq 0 ] && echo "abi.sh: the interface of $earlier holds" >&2
exit "$status"
