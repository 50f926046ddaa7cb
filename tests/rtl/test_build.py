"""`rtl/build.sh`: what it refuses before it builds."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

from tests.rtl.engine_sources import RTL
from tests.rtl.verilator import require_verilator


def test_a_path_with_a_space_is_refused_by_its_name(tmp_path: Path) -> None:
    require_verilator()
    cache = tmp_path / "with a space"
    surroundings = os.environ | {"ORBSOC_RTL_CACHE": str(cache)}
    done = subprocess.run(
        [RTL / "build.sh", "registers"], env=surroundings, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert f"'{cache}': a path with a space" in done.stderr
    assert not cache.exists()
