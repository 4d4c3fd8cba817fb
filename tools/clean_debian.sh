# shellcheck shell=bash
# Sourced by tools/package.sh and tools/portability.sh, at the top of the repository.

# The lists of Debian packages of this machine, for a release (bookworm, trixie), so that its mirror is
# used; none if it is not Debian: mmdebstrap's own.
package_lists() {
  local codename list
  # shellcheck source=/dev/null
  codename=$(source /etc/os-release && echo "${VERSION_CODENAME:-none}")
  for list in /etc/apt/sources.list.d/debian.sources /etc/apt/sources.list; do
    if grep --quiet --extended-regexp "^[^#]*\b$codename\b" "$list" 2>/dev/null; then
      sed "s/\b$codename\b/$1/g" "$list" >"$2/${list##*/}"
      echo "$2/${list##*/}"
    fi
  done
}

# in_clean_debian RELEASE LOG FOLDER COMMAND [HOOK]: makes a clean Debian in a temporary folder, copies
# FOLDER to its /opt, runs COMMAND there as root and HOOK of mmdebstrap after it. stdout is that of the
# command, at the end; the rest goes to LOG. False if the command fails; exit code 0 with a line that
# says why if no clean Debian can be made here.
in_clean_debian() {
  local release=$1 log=$2 folder=$3 command=$4 hook=${5:-true} name=${0##*/} work made lists status=0
  if ! command -v mmdebstrap >/dev/null && ! ./tools/setup.sh --package --no-build; then
    echo "$name: skipped: mmdebstrap is not installed, and cannot be installed by this user (apt-get install mmdebstrap)" >&2
    exit 0
  fi
  work=$(mktemp --directory)
  mapfile -t lists < <(package_lists "$release" "$work")
  chmod -R a+rX "$folder" "$work"  # without root, mmdebstrap's root is another user
  # Not by descriptors of our own: those of mmdebstrap 1.5 would then exceed 9, the most in dash.
  : >"$work/made" >"$work/stdout"
  chmod a+w "$work/made" "$work/stdout"
  LC_ALL=C.UTF-8 mmdebstrap --variant=apt --format=null \
    --customize-hook="echo made >'$work/made'" \
    --customize-hook="copy-in '$folder' /opt" \
    --customize-hook="chroot \"\$1\" /bin/sh -c 'cd /opt/${folder##*/} && $command' >'$work/stdout'" \
    --customize-hook="$hook" \
    "$release" /dev/null "${lists[@]}" >"$log" 2>&1 || status=$?
  cat "$work/stdout"
  made=$(<"$work/made")
  rm -rf "$work"
  if [ "$status" -ne 0 ] && [ -z "$made" ]; then
    echo "$name: skipped: no clean Debian could be made here, which needs root or user namespaces, and a mirror (mmdebstrap: $(
      sed -n 's/^E: //p' "$log" | head -n 1
    ))" >&2
    exit 0
  fi
  return "$status"
}
