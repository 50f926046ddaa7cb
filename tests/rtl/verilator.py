"""Verilator for tests of the RTL: found, or the test is skipped, or fails where it is required.

Used as `verilator = require_verilator()` at the start of a test. `ORBSOC_REQUIRE_RTL=1` says that Verilator must
be here, as `.ci/run` does after installing it; the skip then becomes a failure.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

MISSING = "Verilator is not installed (Debian: apt install verilator)"


def require_verilator() -> Path:
    """The Verilator executable; skips the calling test without it, or fails it under ORBSOC_REQUIRE_RTL=1."""
    found = shutil.which("verilator")
    if found:
        return Path(found)
    if os.environ.get("ORBSOC_REQUIRE_RTL") == "1":
        pytest.fail(f"ORBSOC_REQUIRE_RTL=1, but {MISSING}")
    pytest.skip(MISSING)
