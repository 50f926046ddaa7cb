"""A plugin of pytest: a test that takes too long fails, and the first failure is written down."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Generator
from pathlib import Path
from types import FrameType

import pytest

LIMIT_S = "ORBSOC_MUTANT_LIMIT_S"
"""Seconds that a test may take; 0: as long as it wants."""
FOUND = "ORBSOC_MUTANT_FOUND"
"""Names the file that gets the first failure."""


class Endless(Exception):
    """A test that does not end in time."""


def _stop(_signal: int, _frame: FrameType | None) -> None:
    raise Endless(f"no end within {os.environ[LIMIT_S]} s")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol() -> Generator[None, object, object]:
    """The alarm is set anew for every test, its fixtures included."""
    signal.signal(signal.SIGALRM, _stop)
    signal.alarm(int(os.environ[LIMIT_S]))
    try:
        return (yield)
    finally:
        signal.alarm(0)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    path = Path(os.environ[FOUND])
    if report.failed and not path.exists():
        why = report.longreprtext.strip().splitlines()
        path.write_text(
            json.dumps({"test": report.nodeid, "endless": "Endless" in report.longreprtext, "why": why[-1:]})
        )
