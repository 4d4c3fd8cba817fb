#!/usr/bin/env bash
# Installs missing packages (Debian, by apt) and builds build/release/tools/tagcal. A second run has
# nothing left to do. `--peers` also installs the programs of others that read our files in tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

packages=(
  build-essential g++ cmake ninja-build ccache pkg-config
  libeigen3-dev libceres-dev libapriltag-dev libopencv-dev
  libcli11-dev libfmt-dev libyaml-cpp-dev nlohmann-json3-dev libpng-dev libjpeg-dev
  libdeflate-dev libtiff-dev libwebp-dev libstb-dev libcairo2-dev libopencv-contrib-dev
  libgtest-dev librapidcheck-dev gnuplot-nox
)
peers=(colmap python3-mrcal python3-camera-calibration-parsers python3-yaml)

case "${1:-}" in
  "") ;;
  --peers) packages+=("${peers[@]}") ;;
  *)
    echo "setup.sh: $1: unknown option (known: --peers)" >&2
    exit 2
    ;;
esac

missing_packages() {
  local installed package
  installed=$(dpkg-query --show --showformat='${Package} ${db:Status-Status}\n' "${packages[@]}" \
    2>/dev/null || true)
  for package in "${packages[@]}"; do
    grep --quiet --line-regexp --fixed-strings "$package installed" <<<"$installed" || echo "$package"
  done
}

as_root() {
  if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

install_packages() {
  echo "setup: installing $*" >&2
  as_root env DEBIAN_FRONTEND=noninteractive apt-get update --quiet
  as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get install --quiet --yes --no-install-recommends "$@" </dev/null
}

mapfile -t missing < <(missing_packages)
if [ "${#missing[@]}" -gt 0 ]; then install_packages "${missing[@]}"; fi

[ -f build/release/build.ninja ] || cmake --preset release
cmake --build --preset release --target tagcal_command --parallel "$(nproc)"
