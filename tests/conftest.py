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


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--long", action="store_true", help="only the tests that tests/long.py lists")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave the long tests, or all others, out."""
    from tests.long import LONG, pattern_of

    found = {item: pattern_of(item.nodeid) for item in items}
    if config.args == config.getini("testpaths"):
        listed = {(path, each) for path, patterns in LONG.items() for each in patterns}
        if missing := listed - set(found.values()):
            raise pytest.UsageError(f"tests/long.py lists what is not there: {sorted(missing)}")
    asked = config.getoption("--long")
    config.hook.pytest_deselected(items=[item for item in items if (found[item] is not None) != asked])
    items[:] = [item for item in items if (found[item] is not None) == asked]


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """A failure is told as it happens, once: a run that is ended before its summary has named it."""
    if report.failed and "PYTEST_XDIST_WORKER" not in os.environ:
        print(f"\n{report.nodeid}\n{report.longreprtext[-2000:]}", file=sys.__stderr__, flush=True)
