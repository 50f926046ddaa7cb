#!/bin/sh
# Build the wheel into a folder, without this machine's paths in it.
# Usage: scripts/build_wheel.sh PYTHON FOLDER [TARGET]
#   PYTHON: an interpreter with maturin beside it; TARGET: another machine's triple, aarch64-unknown-linux-gnu
set -eu
python=$1
folder=$2
target=${3:-}

# Panic messages of a dependency hold the path it was compiled at; let them start at cargo's folder. The environment's
# flags replace those of .cargo/config.toml, so those of the target's processor are said again.
processor=${target:-$(rustc -vV | sed -n 's/^host: //p')}
configured=$("$python" - "${processor%%-*}" <<'END'
import sys, tomllib
targets = tomllib.load(open(".cargo/config.toml", "rb"))["target"]
print(*targets.get(f'cfg(target_arch = "{sys.argv[1]}")', {}).get("rustflags", []))
END
)
RUSTFLAGS="${RUSTFLAGS:-} $configured --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=cargo"
export RUSTFLAGS

exec "$(dirname "$python")/maturin" build --release --locked --interpreter "$python" --out "$folder" \
    ${target:+--target "$target"}
