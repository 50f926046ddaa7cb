#!/bin/sh
# Build a Verilator model with its harness and print the path of the executable.
# Usage: rtl/build.sh TOP [-GNAME=VALUE ...]     TOP: units (floating-point units) or engine (the PL)
# The result is kept under $ORBSOC_RTL_CACHE (default ~/.cache/orbsoc/rtl) by the hash of sources, parameters and tool.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
top=$1
shift

case $top in
  units) sources="$here/harness/units.sv $here/harness/units.cpp" ;;
  engine) sources="$here/engine/*.sv $here/harness/engine.cpp" ;;
  *) echo "rtl/build.sh: no top '$top'; there are units and engine" >&2; exit 2 ;;
esac

texts=$(find "$here" -name '*.sv*' -o -name '*.[ch]pp' -o -name build.sh | LC_ALL=C sort | tr '\n' '\0' | xargs -0 cat)
key=$(printf '%s\n' "$texts" "$(verilator --version)" "$top" "$@" | sha256sum | cut -c 1-16)
cache=${ORBSOC_RTL_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/orbsoc/rtl}
built="$cache/$top-$key"
if [ ! -x "$built" ]; then
  mkdir -p "$cache"
  work=$(mktemp -d "$cache/building.XXXXXX")
  trap 'rm -rf "$work"' EXIT
  # shellcheck disable=SC2086  # the lists are meant to be split
  if ! verilator --cc --exe --build -Wall -O3 --x-assign fast --x-initial fast --noassert -I"$here" "$@" --top-module "$top" \
    -CFLAGS "-O2 -std=c++17 -I$here/harness" --Mdir "$work/model" -o "$work/$top" "$here"/fpu/*.sv $sources >"$work/log" 2>&1
  then
    cat "$work/log" >&2
    exit 1
  fi
  mv "$work/$top" "$built"
fi
echo "$built"
