#!/usr/bin/env bash
# Installs missing packages (Debian, by apt) and builds build/release/tools/tagcal. A second run has
# nothing left to do. `--python` also builds the Python module for Debian's python3, from then on
# with every run; another Python is chosen by configuring build/release with -D Python_EXECUTABLE.
# `--peers` also installs the programs of others that read our files in tests, `--browser` the
# browser that opens the pages of tagcal report in a test, `--engines` Slurm and Dask for the tests
# of fleets, `--package` what `tools/package.sh --check` needs, `--checks` what tools/fuzz.sh and the
# preset `clang` need. `--no-build` installs only.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/usage.sh

packages=(
  build-essential g++ cmake ninja-build ccache pkg-config file
  libeigen3-dev libceres-dev libapriltag-dev libopencv-dev
  libcli11-dev libfmt-dev libyaml-cpp-dev nlohmann-json3-dev libpng-dev libjpeg-dev
  libdeflate-dev libtiff-dev libwebp-dev libstb-dev libcairo2-dev libopencv-contrib-dev
  libavformat-dev libswscale-dev libheif-dev libbz2-dev liblz4-dev libzstd-dev libsqlite3-dev
  libgtest-dev librapidcheck-dev
)
python=(
  python3-dev pybind11-dev python3-numpy python3-pytest python3-opencv python3-matplotlib
  python3-setuptools python3-pip python3-venv mypy
)
peers=(
  ffmpeg zstd sqlite3 libheif-examples colmap python3-mrcal python3-camera-calibration-parsers python3-yaml
)
engines=(slurmctld slurmd slurm-client munge python3-distributed)
checks=(clang libclang-rt-dev llvm valgrind locales)
browser=(chromium chromium-driver python3-selenium python3-pytest)

configure=(./tools/configure.sh release)
build=yes
for option in "$@"; do
  case "$option" in
    --python)
      packages+=("${python[@]}")
      configure+=(--python)
      ;;
    --peers) packages+=("${peers[@]}") ;;
    --browser) packages+=("${browser[@]}") ;;
    --engines) packages+=("${engines[@]}") ;;
    --package) packages+=(mmdebstrap uidmap) ;;
    --checks) packages+=("${checks[@]}") ;;
    --no-build) build=no ;;
    *)
      echo "setup.sh: $option: unknown option (known: --python, --peers, --browser, --engines," \
        "--package, --checks, --no-build)" >&2
      exit 2
      ;;
  esac
done

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

[ "$build" = yes ] || exit 0
"${configure[@]}"
targets=(tagcal_command tagcal_shared)
if ./tools/configure.sh release --has-python; then targets+=(tagcal_python); fi
cmake --build --preset release --target "${targets[@]}" --parallel "$(nproc)"
if [ "${configure[-1]}" = --python ]; then
  echo "setup: import tagcal works after: export PYTHONPATH='$PWD/build/release/python'" >&2
fi
