#!/bin/sh
# Build a Verilator model with its harness and print the path of the executable.
# Usage: rtl/build.sh units -GEXP=11 -GMAN=52 -GADD_CYCLES=6 -GMUL_CYCLES=7 -GDIV_CYCLES=32
#        rtl/build.sh engine -GFP=64 -GLANES=4 -GDIVIDERS=1 -GBANKS=16 -GADDRESS_BITS=14 -GSEQUENCER=0
#        rtl/build.sh registers
# The engine needs all six (SEQUENCER: 0 flat, 1 compressed, 2 in order); its harness knows them too, as PL_LANES ....
# The result is kept under $ORBSOC_RTL_CACHE (default ~/.cache/orbsoc/rtl) by the hash of sources, parameters and tool.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
top=$1
shift

case $top in
  units) sources="$here/harness/units.sv $here/harness/units.cpp" ;;
  engine) sources="$here/engine/*.sv $here/harness/engine.cpp" ;;
  registers) sources="$here/engine/registers.sv $here/harness/registers.cpp" ;;
  *) echo "rtl/build.sh: no top '$top'; there are units, registers and engine" >&2; exit 2 ;;
esac

texts=$(find "$here" -name '*.sv*' -o -name '*.[ch]pp' -o -name build.sh | LC_ALL=C sort | tr '\n' '\0' | xargs -0 cat)
key=$(printf '%s\n' "$texts" "$(verilator --version)" "$top" "$@" | sha256sum | cut -c 1-16)
cache=${ORBSOC_RTL_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/orbsoc/rtl}
built="$cache/$top-$key"
if [ ! -x "$built" ]; then
  mkdir -p "$cache"
  work=$(mktemp -d "$cache/building.XXXXXX")
  trap 'rm -rf "$work"' EXIT
  defines=$(printf '%s ' "$@" | sed 's/-G/-DPL_/g')
  # Unused: a parameter file included for one of its numbers; bits of an address that a unit does not have.
  # shellcheck disable=SC2086  # the lists are meant to be split
  if ! verilator --cc --exe --build -j "$(getconf _NPROCESSORS_ONLN)" -Wall -Wno-UNUSED -O3 --x-assign fast --x-initial fast --noassert -I"$here" "$@" --top-module "$top" \
    -CFLAGS "-std=c++17 -I$here/harness $defines" --Mdir "$work/model" -MAKEFLAGS "OPT_FAST=-O1 OPT_SLOW=-O0 OPT_GLOBAL=-O1" -o "$work/$top" "$here"/fpu/*.sv $sources >"$work/log" 2>&1
  then
    cat "$work/log" >&2
    exit 1
  fi
  mv "$work/$top" "$built"
fi
echo "$built"
