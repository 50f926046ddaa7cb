"""A task that begins again computes only the parts that its journal lacks."""

from __future__ import annotations

import os
import pickle
import zlib
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orbsoc.missions.reachable_domain.search.continuation import wavefront
from orbsoc.missions.reachable_domain.search.continuation.attempts import attempt
from orbsoc.missions.reachable_domain.search.continuation.domain import Domain
from orbsoc.missions.reachable_domain.search.continuation.tasks import grid_shards, solve_grid_shard
from orbsoc.sweep.journal import HEAD, Journal
from tests.missions.reachable_domain.cases import kick_stage

PACKAGE = "orbsoc.missions.reachable_domain"


def counted(journal: Journal, values: list[int]) -> int:
    """How many of the parts were computed."""
    calls: list[int] = []

    def square(value: int) -> np.ndarray:
        calls.append(value)
        return np.array([value**2, value])

    with closing(journal):
        for value in values:
            np.testing.assert_array_equal(journal.part(partial(square, value)), [value**2, value])
    return len(calls)


def test_parts_are_computed_once_and_a_torn_one_again(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "journal"
    assert counted(Journal(path, "one", PACKAGE), [3, 4, 5]) == 3
    assert counted(Journal(path, "one", PACKAGE), [3, 4, 5, 6]) == 1
    with path.open("r+b") as stream:  # killed while the last part was written
        stream.truncate(path.stat().st_size - 5)
    assert counted(Journal(path, "one", PACKAGE), [3, 4, 5, 6, 7]) == 2
    assert counted(Journal(path, "another task", PACKAGE), [3, 4]) == 2


def test_a_journal_from_elsewhere_runs_no_code(tmp_path: Path) -> None:
    class Evil:
        def __reduce__(self) -> tuple[object, ...]:
            return os.mkdir, (str(tmp_path / "made"),)

    path = tmp_path / "journal"
    with path.open("wb") as stream:
        for value in ("one", Evil()):
            data = pickle.dumps(value, protocol=4)
            stream.write(HEAD.pack(len(data), zlib.crc32(data)) + data)
    assert counted(Journal(path, "one", PACKAGE), [1]) == 1
    assert not (tmp_path / "made").exists()


def test_a_shard_that_was_killed_goes_on_where_it_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    [(_rows, payload)] = grid_shards(Domain.of(kick_stage()))
    whole = solve_grid_shard(payload)
    payload["journal"] = str(tmp_path / "journal")
    monkeypatch.setattr(wavefront, "ROWS_PER_PART", 1)
    attempts, kill_at = list[int](), 3

    def killed(*arguments: Any) -> Any:
        attempts.append(len(attempts))
        if len(attempts) == kill_at:
            raise KeyboardInterrupt
        return attempt(*arguments)

    monkeypatch.setattr(wavefront, "attempt", killed)
    with pytest.raises(KeyboardInterrupt):
        solve_grid_shard(payload)
    again = solve_grid_shard(payload)
    resumed = len(attempts) - kill_at
    attempts.clear()
    kill_at = 0
    solve_grid_shard({name: value for name, value in payload.items() if name != "journal"})
    assert resumed == len(attempts) - 2 > 0
    assert (again["status"] == whole["status"]).all()
    np.testing.assert_allclose(again["a_km"], whole["a_km"], rtol=1e-9)
