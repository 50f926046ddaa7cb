#!/bin/sh
# Build a Verilator model with its harness and print the path of the executable.
# Usage: rtl/build.sh units -GEXP=11 -GMAN=52 -GADD_CYCLES=7 -GMUL_CYCLES=8 -GDIV_CYCLES=35 -GDIV_INTERVAL_CYCLES=4
#        rtl/build.sh engine -GFP=64 -GLANES=4 -GDIVIDERS=1 -GBANKS=16 -GADDRESS_BITS=14 -GSEQUENCER=0 -GCODE_BITS=17
#        rtl/build.sh engine_upsets -GFP=64 …             as engine, and any bit of it can be turned over
#        rtl/build.sh registers
#        rtl/build.sh axi_slaves -GFP=64 -GADDRESS_BITS=6 -GCODE_BITS=3 -GCODE_WIDTH=100
#        rtl/build.sh axi_engine -GFP=64 -GLANES=4 …      as engine, with the driver in C as its PS
#        ORBSOC_ROCKET=FOLDER rtl/build.sh soc -GFP=64 …  as engine, with a core; FOLDER is pythondata_cpu_rocket's `verilog`
#        ORBSOC_ROCKET=FOLDER rtl/build.sh soc_trace …    the same, which can write waveforms (FST)
#        ORBSOC_PICORV32=FOLDER rtl/build.sh board        the computer of board/; FOLDER is pythondata_cpu_picorv32's `verilog`
# SEQUENCER: 0 flat, 1 compressed, 2 in order. Parameters that are not given are the module's; the harness takes all from the model.
# The result is kept under $ORBSOC_RTL_CACHE (default ~/.cache/orbsoc/rtl) by the hash of sources, parameters and tools;
# so are the objects of Verilator's runtime, which is a third of a build and the same in all of them.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
top=$1
shift

module=$top
parallel=0
split=
traced=
open=
fast=-O1
case $top in
  units) sources="$here/harness/units.sv $here/harness/units.cpp" ;;
  engine) sources="$here/engine/*.sv $here/harness/engine.cpp" ;;
  engine_upsets)
    module=engine
    open=--public-flat-rw
    sources="$here/engine/*.sv $here/harness/upsets.cpp" ;;
  registers) sources="$here/engine/registers.sv $here/harness/registers.cpp" ;;
  axi_engine) sources="$here/engine/*.sv $here/axi/*.sv $here/harness/axi_engine.cpp" ;;
  axi_slaves) sources="$here/axi/axi_[!e]*.sv $here/harness/axi_traffic.cpp" ;;
  soc|soc_trace)
    module=soc
    core=${ORBSOC_ROCKET:?is not set: the folder of the generated core}
    rocket="$core/generated-src/freechips.rocketchip.system.LitexFullConfig"
    sources="$here/engine/*.sv $here/axi/*.sv $here/soc/soc_axi.sv $here/soc/soc.sv $here/soc/soc_[!a]*.sv $here/soc/rocket.vlt
      $rocket.v $rocket.behav_srams.v $core/vsrc/plusarg_reader.v $core/vsrc/AsyncResetReg.v $core/vsrc/EICG_wrapper.v $here/harness/soc.cpp"
    parallel=1
    fast=-O2
    split="--output-split 20000 --output-split-cfuncs 2000 -DPRINTF_COND=0 -DSTOP_COND=0"
    [ "$top" = soc ] || traced=--trace-fst ;;
  board)
    module=ulx3s
    core=${ORBSOC_PICORV32:?is not set: the folder of the core}
    fast=-O2
    split=-Wno-TIMESCALEMOD  # the core has one, for its test bench
    sources="$here/board/picorv32.vlt $here/engine/*.sv $here/axi/*.sv $here/board/*.sv $core/picorv32.v $here/harness/board.cpp" ;;
  *) echo "rtl/build.sh: no top '$top'; there are units, registers, engine, engine_upsets, axi_slaves, axi_engine, soc, soc_trace and board" >&2; exit 2 ;;
esac

texts=$(find "$here" ! -path "$here/*/program/*" \( -name '*.sv*' -o -name '*.[ch]pp' -o -name '*.[ch]' -o -name build.sh \) | LC_ALL=C sort | tr '\n' '\0' | xargs -0 cat)
tools=$(verilator --version; ${CXX:-c++} --version)
key=$(printf '%s\n' "$texts" "$tools" "$top" "$@" | sha256sum | cut -c 1-16)
cache=${ORBSOC_RTL_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/orbsoc/rtl}
for folder in "$here" "$cache"; do
  case $folder in
    *[[:space:]]*) echo "rtl/build.sh: '$folder': a path with a space breaks Verilator's makefiles; move it, or name a link to it" >&2; exit 2 ;;
  esac
done
built="$cache/$top-$key"
runtime="$cache/runtime-$(printf '%s\n' "$tools" "$(cat "$here/build.sh")" "$traced" | sha256sum | cut -c 1-16)"
if [ ! -x "$built" ]; then
  mkdir -p "$cache"
  work=$(mktemp -d "$cache/building.XXXXXX")
  trap 'rm -rf "$work"' EXIT
  # One translation unit for the model, but for the core's: in several, the headers cost more than the code.
  model() {
    # Unused: a parameter file included for one of its numbers; bits of an address that a unit does not have.
    # The driver is C, for its own compiler and the freestanding environment of a board; a harness has its accesses.
    objects=
    if [ "$top" = axi_engine ]; then
      objects="$work/orbsoc.o"
      "${CC:-cc}" -std=c11 -O1 -Wall -Wextra -Wpedantic -Werror -ffreestanding -DORBSOC_EXTERNAL_ACCESS -DORBSOC_BUS_ADDRESS -c "$here/driver/orbsoc.c" -o "$objects" || return 1
    fi
    # The numbers of latency.svh and engine.svh for the harness.
    cat "$here/latency.svh" "$here/engine.svh" | sed -n 's/^localparam int \([A-Z0-9_]*\) = \([0-9]*\);.*/constexpr int \1 = \2;/p' >"$work/contract.hpp"
    # shellcheck disable=SC2086  # the lists are meant to be split
    verilator --cc --exe -Wall -Wno-UNUSED -O3 --x-assign fast --x-initial unique --noassert -I"$here" $split $traced $open "$@" \
      --top-module "$module" -CFLAGS "-std=c++17 -I$here/harness -I$here/driver -I$work" --Mdir "$work/model" -o "$work/$top" \
      "$here/contract.sv" "$here"/fpu/*.sv $sources $objects &&
      { [ ! -d "$runtime" ] || cp "$runtime"/*.o "$work/model"; } &&
      { [ -z "$open" ] || verilator --xml-only --noassert -I"$here" "$@" --top-module "$module" --Mdir "$work/xml" \
        "$here/contract.sv" "$here"/fpu/*.sv "$here"/engine/*.sv; } &&
      make -C "$work/model" -f "V$module.mk" -j "$(getconf _NPROCESSORS_ONLN)" VM_PARALLEL_BUILDS=$parallel OPT_FAST="$fast" OPT_GLOBAL=-O1
  }
  if ! model "$@" >"$work/log" 2>&1; then
    cat "$work/log" >&2
    exit 1
  fi
  if [ ! -d "$runtime" ]; then
    mkdir "$work/runtime"
    mv "$work"/model/verilated*.o "$work/runtime"
    # A concurrent build may have finished first; its result is the same.
    if ! mv -T "$work/runtime" "$runtime" 2>"$work/log" && [ ! -d "$runtime" ]; then
      cat "$work/log" >&2
      exit 1
    fi
  fi
  [ -z "$open" ] || mv "$work/xml/V$module.xml" "$built.xml"
  mv "$work/$top" "$built"
fi
echo "$built"
