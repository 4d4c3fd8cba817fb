#!/usr/bin/env bash
# Run by tools/package.sh --check inside a clean Debian, as root: installs the package that lies beside
# this script's folder, uses it as an ordinary user would, and removes it.
#   package_check.sh demo | library
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
what=$1
export DEBIAN_FRONTEND=noninteractive HOME=/tmp

as_user() {
  chroot --userspec=nobody:nogroup / /bin/sh -c "cd '$PWD' && $1"
}

install_package() {
  local options=(--no-install-recommends)
  if [ "$what" = library ]; then options=(--option APT::Install-Recommends=true); fi
  apt-get install --yes "${options[@]}" ./tagcal.deb
}

check_command() {
  as_user 'tagcal --version'
  as_user './tools/demo.sh --program /usr/bin/tagcal'
  as_user 'cd data-synthetic/out && tagcal pose desk --camera desk/camera.yaml --json >poses.json'
  as_user 'cd data-synthetic/out && tagcal report desk/camera.yaml --dataset desk --out report.html'
  as_user 'gzip --test /usr/share/man/man1/tagcal-calibrate.1.gz'
  as_user 'bash -n /usr/share/bash-completion/completions/tagcal'
}

check_python() {
  if [ ! -d /usr/lib/python3/dist-packages/tagcal ]; then
    echo "the package has no Python module"
    return
  fi
  as_user 'python3 - <<END
import tagcal
camera = tagcal.Camera.pinhole(100, 100, 9, 9, (20, 20))
assert camera.project([0, 0, 1]).tolist() == [9, 9]
print("import tagcal", tagcal.__version__)
END'
}

# The program of the README, by CMake and by pkg-config.
check_library() {
  apt-get install --yes --no-install-recommends g++ cmake make pkg-config >&2
  cat >consumer/CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.23)
project(tag_pose LANGUAGES CXX)
find_package(tagcal REQUIRED)
add_executable(tag_pose tag_pose.cpp)
target_link_libraries(tag_pose PRIVATE tagcal::tagcal)
END
  as_user 'cmake -S consumer -B consumer/build && cmake --build consumer/build' >&2
  as_user 'consumer/build/tag_pose'
  # shellcheck disable=SC2016
  as_user 'cd consumer && g++ -std=c++20 tag_pose.cpp -o by_pc $(pkg-config --cflags --libs tagcal)'
  as_user 'consumer/by_pc'
}

install_package >&2
chown -R nobody:nogroup .
check_command
check_python
if [ "$what" = library ]; then check_library; fi
apt-get purge --yes tagcal >&2
left=$(find /usr -path '*tagcal*')
if [ -n "$left" ]; then
  printf 'left behind by the package:\n%s\n' "$left" >&2
  exit 1
fi
