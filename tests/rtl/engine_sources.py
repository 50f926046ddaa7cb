"""The RTL's sources as tests use them: numbers of the parameter files, and builds through `rtl/build.sh`."""

from __future__ import annotations

import re
import subprocess
from functools import cache
from pathlib import Path

RTL = Path(__file__).resolve().parents[2] / "rtl"
_PARAMETER = re.compile(r"^localparam int (\w+) = (\d+);", re.MULTILINE)


@cache
def parameters(rtl: Path = RTL) -> dict[str, int]:
    """Every number of `latency.svh` and `engine.svh`."""
    text = (rtl / "latency.svh").read_text() + (rtl / "engine.svh").read_text()
    return {name: int(value) for name, value in _PARAMETER.findall(text)}


def build(top: str, *, rtl: Path = RTL, **module_parameters: int) -> Path:
    """The executable of `top` with these module parameters, built if it is not in the cache.

    Raises AssertionError with the log if it does not build.
    """
    options = [f"-G{name}={value}" for name, value in module_parameters.items()]
    done = subprocess.run([rtl / "build.sh", top, *options], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return Path(done.stdout.strip())
