"""The solver of docs/solver-in-the-page.md: the core crate compiled to WebAssembly, as text in a script, so that it works from `file://`."""

from __future__ import annotations

import base64
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
TARGET = "wasm32-unknown-unknown"
SCRIPT = ROOT / "docs" / "static" / "solver.js"


def lacking() -> str:
    """What is missing here to compile it; empty when nothing is."""
    if shutil.which("cargo") is None:
        return "no cargo: https://rustup.rs"
    asked = ["rustc", "--print", "target-libdir", "--target", TARGET]
    folder = subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
    return "" if Path(folder).is_dir() else f"no Rust library for the target: rustup target add {TARGET}"


def compiled() -> bytes:
    """The module of `rust/orbsoc-wasm`, compiled where its sources have changed. Raises RuntimeError with what is missing."""
    if reason := lacking():
        raise RuntimeError(reason)
    command = ["cargo", "build", "--quiet", "--locked", "--profile", "page", "--target", TARGET]
    subprocess.run([*command, "--package", "orbsoc-wasm"], cwd=ROOT, check=True)
    folder = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    return (folder / TARGET / "page" / "orbsoc_wasm.wasm").read_bytes()


def script(module: bytes) -> str:
    """The module as a constant of a script."""
    return f'const ORBSOC_WASM = "{base64.b64encode(module).decode()}";\n'


def write_script(app: Any) -> None:
    from generated import write_changed

    write_changed(SCRIPT, script(compiled()))


def setup(app: Any) -> dict[str, Any]:
    app.connect("builder-inited", write_script)
    return {"parallel_read_safe": True}
