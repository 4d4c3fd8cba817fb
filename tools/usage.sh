# shellcheck shell=bash
# Sourced by the scripts beside it, at the top of the repository: --help prints their first comment.
if [[ ${1:-} == --help || ${1:-} == -h ]]; then
  sed --quiet '2,/^[^#]/s/^# \{0,1\}//p' "tools/$(basename "$0")"
  exit 0
fi
