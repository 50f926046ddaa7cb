"""`orbsoc reach` for what the paper's scenario does not ask: every such run ends with its files, and says what it found."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.missions.reachable_domain.cases import small_scenario
from tests.processes import started

COMMAND = [sys.executable, "-m", "orbsoc", "reach"]

VARIANTS = {
    "perigee at its bound": {"condition": 'condition = "equal"'},
    "perigee direction that nothing has": {"condition": 'condition = "at_least"\nargp_deg = 30.0'},
    "burn too short for anything": {"duration_s": "duration_s = 60.0"},
    "altitude, perigee at its bound": {
        "duration_s": "duration_s = 1200.0\nminimum_altitude_km = 120.0",
        "condition": 'condition = "equal"',
    },
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_what_else_a_scenario_may_ask_ends_with_files_and_words(tmp_path: Path, variant: str) -> None:
    scenario = small_scenario(tmp_path, **VARIANTS[variant])
    done = subprocess.run(
        [*COMMAND, str(scenario), "--out", str(tmp_path / "out"), "--threads", "1"],
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    document = json.loads((tmp_path / "out" / "summary.json").read_text())
    reached = document["status"].get("reached", 0)
    assert sum(document["status"].values()) == 60
    assert (reached > 0) == ("at its bound" in variant)
    assert (
        f"{reached} reached" in done.stdout if reached else "not reached after these attempts" in done.stdout
    )
    assert all((tmp_path / "out" / name).stat().st_size > 0 for name in document["files"])


def test_workers_end_when_their_parent_is_killed(tmp_path: Path) -> None:
    """kill -9 gives the parent no moment to end them."""
    command = [*COMMAND, str(small_scenario(tmp_path)), "--out", str(tmp_path / "out"), "--threads", "2"]
    children: list[int] = []
    deadline = time.monotonic() + 60.0
    with started(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as parent:
        while len(children) < 2 and time.monotonic() < deadline:
            children = _workers_of(parent.pid)
            time.sleep(0.02)
        assert len(children) >= 2
        parent.send_signal(signal.SIGKILL)
        parent.wait()
        deadline = time.monotonic() + 60.0
        while any(_runs(child) for child in children) and time.monotonic() < deadline:
            time.sleep(0.1)
        assert not any(_runs(child) for child in children)


def _workers_of(parent: int) -> list[int]:
    listed = Path(f"/proc/{parent}/task/{parent}/children")
    return [int(word) for word in listed.read_text().split()] if listed.exists() else []


def _runs(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):  # ended before it was opened, or read
        return False
    return state != "Z"
