"""What registers hold before the first reset (rtl/harness/start.hpp): random bits of a seed, and what it takes to begin right."""

from __future__ import annotations

import os
import subprocess

import pytest

from tests.rtl.conftest import SEED
from tests.rtl.engine_sources import build
from tests.rtl.verilator import require_verilator

DATA_VALID = ("read 20", "read 24")
"""Flags of buffers, which nothing but a reset and segments sets."""


def answers(seed: str | None, *script: str) -> list[int]:
    """What the register file answers to each line."""
    require_verilator()
    surroundings = {name: value for name, value in os.environ.items() if name != SEED}
    done = subprocess.run(
        [build("registers")],
        input="\n".join(script),
        env=surroundings | ({} if seed is None else {SEED: seed}),
        capture_output=True,
        text=True,
        check=True,
    )
    return [int(line.split()[0], 16) for line in done.stdout.splitlines()]


@pytest.mark.parametrize("seed", ["1", "2", "77"])
def test_registers_begin_with_the_random_bits_of_a_seed(seed: str) -> None:
    found = answers(seed, *DATA_VALID)
    assert all(8 < word.bit_count() < 24 for word in found)
    assert found == answers(seed, *DATA_VALID)
    assert found != answers(str(int(seed) + 1), *DATA_VALID)


def test_seed_0_begins_with_zeros_and_no_seed_is_seed_1() -> None:
    assert answers("0", *DATA_VALID) == [0, 0]
    assert answers(None, *DATA_VALID) == answers("1", *DATA_VALID)


@pytest.mark.parametrize("seed", ["1", "2", "77"])
def test_one_clock_of_reset_clears_what_the_random_bits_were(seed: str) -> None:
    assert answers(seed, "reset", *DATA_VALID) == [0, 0, 0]


def test_a_seed_that_is_no_number_names_what_is_allowed() -> None:
    require_verilator()
    surroundings = os.environ | {SEED: "1e3"}
    done = subprocess.run([build("registers")], env=surroundings, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == f"{SEED} = '1e3': allowed is a whole number from 0 to 1000000000\n"
