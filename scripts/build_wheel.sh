#!/bin/sh
# Build the wheel into a folder, without this machine's paths in it.
# Usage: scripts/build_wheel.sh PYTHON FOLDER      (PYTHON: an interpreter with maturin beside it)
set -eu
python=$1
folder=$2

# Panic messages of a dependency hold the path it was compiled at; let them start at cargo's folder. The environment's
# flags replace those of .cargo/config.toml, so these are said again.
configured=$("$python" -c 'import tomllib; print(*tomllib.load(open(".cargo/config.toml", "rb"))["build"]["rustflags"])')
RUSTFLAGS="${RUSTFLAGS:-} $configured --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=cargo"
export RUSTFLAGS

exec "$(dirname "$python")/maturin" build --release --locked --interpreter "$python" --out "$folder"
