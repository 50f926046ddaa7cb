"""Every model of the RTL begins with random bits in its registers and memories (rtl/harness/start.hpp), of another seed each day."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from datetime import date

import pytest

SEED = "ORBSOC_RTL_SEED"


@pytest.fixture(scope="module", autouse=True)
def start_of_models() -> Iterator[str]:
    """The seed, for all models of a module's tests: that of the environment, if there is one."""
    seed = os.environ.get(SEED, str(1 + date.today().toordinal() % 1000))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SEED, seed)
        yield seed


@pytest.fixture(autouse=True)
def told_start(start_of_models: str) -> None:
    """A test that fails tells the seed by which it can be repeated."""
    sys.stdout.write(f"{SEED}={start_of_models}\n")
