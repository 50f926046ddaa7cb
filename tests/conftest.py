"""Lets test files import each other as `tests.…`; one fixed seed for generated data.

The root goes last on sys.path: `orbsoc` and `hw_model` stay those of the installed wheel.
"""

import os
import signal
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

sys.path.append(str(Path(__file__).resolve().parent.parent))

# A shell that starts us in the background has SIGINT ignored, and so would every child: the tests of Ctrl-C
# need it as a terminal leaves it.
signal.signal(signal.SIGINT, signal.default_int_handler)

# A busy machine makes examples slowly; no test may fail for that.
settings.register_profile(
    "fixed", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("fixed")


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """A failure is told as it happens, once: a run that is ended before its summary has named it."""
    if report.failed and "PYTEST_XDIST_WORKER" not in os.environ:
        print(f"\n{report.nodeid}\n{report.longreprtext[-2000:]}", file=sys.__stderr__, flush=True)
