#!/bin/sh
# Name every tool of the build that is missing, and what to install for it; silent when all are there.
# Usage: scripts/require_tools.sh [PYTHON]
set -u
python=${1:-python3}
missing=0

miss() {
    echo "missing: $1" >&2
    echo "         $2" >&2
    missing=1
}

# The oldest compiler the workspace states it builds with.
manifest=$(dirname "$0")/../Cargo.toml
oldest_rust=$(sed -n 's/^rust-version *= *"\([0-9.]*\)".*/\1/p' "$manifest")

if ! "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
    found=$("$python" --version 2>&1) || found="no $python here"
    miss "Python 3.11 or newer ($found)" \
         "Debian: apt install python3 python3-venv; another interpreter: make PYTHON=python3.12 …"
elif ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
    miss "Python's venv module" "Debian: apt install python3-venv"
fi

if ! command -v cc >/dev/null 2>&1; then
    miss "a C compiler (cc), which links the Rust extension" "Debian: apt install gcc libc6-dev"
fi

rust_found=$(rustc --version 2>/dev/null | cut -d' ' -f2)
if [ -z "$rust_found" ] || ! command -v cargo >/dev/null 2>&1; then
    miss "a Rust toolchain (cargo and rustc) $oldest_rust or newer" "rustup: see https://rustup.rs, then: rustup toolchain install stable"
elif [ "$(printf '%s\n%s\n' "$oldest_rust" "$rust_found" | sort -V | head -n 1)" != "$oldest_rust" ]; then
    miss "Rust $oldest_rust or newer (rustc is $rust_found)" "rustup update stable"
fi

exit "$missing"
