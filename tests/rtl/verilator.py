"""Tools for tests of the RTL: found, or the test is skipped, or fails where it is required.

Used as `verilator = require_verilator()` at the start of a test. `ORBSOC_REQUIRE_RTL=1` says that the tools must
be here, as `.ci/run` does after installing them; the skip then becomes a failure.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest


def require_verilator() -> Path:
    """The Verilator executable; skips the calling test without it, or fails it under ORBSOC_REQUIRE_RTL=1."""
    return _require("verilator", "Verilator")


def require_yosys() -> Path:
    """The same of yosys."""
    return _require("yosys", "yosys")


def _require(tool: str, name: str) -> Path:
    found = shutil.which(tool)
    if found:
        return Path(found)
    missing = f"{name} is not installed (Debian: apt install {tool})"
    if os.environ.get("ORBSOC_REQUIRE_RTL") == "1":
        pytest.fail(f"ORBSOC_REQUIRE_RTL=1, but {missing}")
    pytest.skip(missing)
