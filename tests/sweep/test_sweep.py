"""Shards: whole or absent, resumed without doing anything twice, lost workers replaced, folders never mixed up."""

from __future__ import annotations

import errno
import multiprocessing
import os
import signal
import threading
import time
from importlib import import_module
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orbsoc.sweep import (
    DaskCluster,
    Inline,
    Processes,
    Report,
    ShardStore,
    StoreError,
    Task,
    WorkersLost,
    run,
)
from orbsoc.sweep.worker import Work

TASKS = [Task("squares", k, 2, {"k": k, "marks": ""}) for k in range(5)]


def squares(payload: dict[str, Any]) -> dict[str, np.ndarray]:
    """Two rows, and a mark that this task was worked on."""
    k = payload["k"]
    if payload["marks"]:
        with Path(payload["marks"]).open("a", encoding="utf-8") as stream:
            stream.write(f"{k}\n")
    vectors = np.empty(2, dtype=object)
    vectors[:] = [np.array([1.0, k]), None]
    words = np.array(["a", "b"], dtype=object)
    return {
        "k": np.array([k, k]),
        "square": np.array([k**2, -(k**2)], float),
        "word": words,
        "vector": vectors,
    }


def dies_once(payload: dict[str, Any]) -> dict[str, np.ndarray]:
    """Kills its worker the first time task 2 is done."""
    flag = Path(payload["marks"])
    if payload["k"] == 2 and not flag.exists():
        flag.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return squares({**payload, "marks": ""})


def dies_always(payload: dict[str, Any]) -> dict[str, np.ndarray]:
    os.kill(os.getpid(), signal.SIGKILL)
    return {}


def told_to_end_once(payload: dict[str, Any]) -> dict[str, np.ndarray]:
    """Tells its worker to end the first time task 2 is done, as `kill` does."""
    flag = Path(payload["marks"])
    if payload["k"] == 2 and not flag.exists():
        flag.touch()
        os.kill(os.getpid(), signal.SIGTERM)
    return squares({**payload, "marks": ""})


def slow_but_for_the_first(payload: dict[str, Any]) -> dict[str, np.ndarray]:
    if payload["k"]:
        time.sleep(7200.0)  # longer than any test may take
    return squares(payload)


def large_but_for_the_first(payload: dict[str, Any]) -> dict[str, np.ndarray]:
    """Results that take a while to send: a worker is likely to be in the middle of one."""
    return {"x": np.ones(10_000_000 if payload["k"] else 1)}


def dies_while_sending_once(payload: dict[str, Any]) -> dict[str, np.ndarray]:
    """Kills its worker the first time task 2 is done, with half of the result sent."""

    def half(pipe: Connection, words: Any, _write: Any = None) -> None:
        os.write(pipe.fileno(), bytes(words)[: len(words) // 2])
        os.kill(os.getpid(), signal.SIGKILL)

    flag = Path(payload["marks"])
    if payload["k"] == 2 and not flag.exists():
        flag.touch()
        Connection._send = half  # type: ignore[attr-defined]
    return squares({**payload, "marks": ""})


def fails(payload: dict[str, Any]) -> dict[str, np.ndarray]:
    raise LookupError(f"nothing known of {payload['k']}")


class Unsendable(Exception):
    """Cannot be made again from its arguments, as exceptions of some packages cannot."""

    def __init__(self, one: str, other: str) -> None:
        super().__init__(f"{one} {other}")


def fails_in_its_own_way(_payload: dict[str, Any]) -> dict[str, np.ndarray]:
    raise Unsendable("neither", "nor")


def unwatched(_report: Report, _task: Task, _columns: Any) -> None:
    pass


def marked(folder: Path) -> list[Task]:
    return [Task(t.dataset, t.number, t.rows, {**t.payload, "marks": str(folder / "marks")}) for t in TASKS]


def table_of(store: ShardStore) -> list[tuple[Any, ...]]:
    columns = store.read("squares")
    vectors = [None if v is None else tuple(v) for v in columns["vector"]]
    return list(
        zip(columns["k"].tolist(), columns["square"].tolist(), columns["word"].tolist(), vectors, strict=True)
    )


def test_what_is_written_is_read_back_in_order(tmp_path: Path) -> None:
    store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    report = run(store, TASKS, squares, Inline(), unwatched)
    assert (report.shards_done, report.rows_done, report.rows_before) == (5, 10, 0)
    rows = table_of(store)
    assert rows[4:6] == [(2, 4.0, "a", (1.0, 2.0)), (2, -4.0, "b", None)]
    assert ShardStore.load(tmp_path / "out").document() == {"name": "x"}


@pytest.mark.parametrize("executor", [Inline(), Processes(2)], ids=["inline", "processes"])
def test_a_resumed_sweep_does_only_what_is_missing(tmp_path: Path, executor: Inline | Processes) -> None:
    store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    whole = ShardStore.open(tmp_path / "whole", {"name": "x"}, resume=False)
    run(whole, TASKS, squares, Inline(), unwatched)

    def stop_after_two(report: Report, _task: Task, _columns: Any) -> None:
        if report.shards_done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(store, TASKS, squares, executor, stop_after_two)
    finished = [task.number for task in TASKS if store.is_finished(task)]
    assert len(finished) == 2
    again = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=True)
    report = run(again, marked(tmp_path), squares, executor, unwatched)
    assert report.rows_before == 4
    done = sorted(int(line) for line in (tmp_path / "marks").read_text().split())
    assert done == sorted(set(range(5)) - set(finished))
    assert table_of(again) == table_of(whole)


def test_a_half_written_shard_counts_as_absent(tmp_path: Path) -> None:
    store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    place = tmp_path / "out" / TASKS[0].place
    place.mkdir(parents=True)
    (place / ".part.parquet.123").write_bytes(b"PAR1 and no more")  # what kill -9 leaves
    assert not store.is_finished(TASKS[0])
    run(store, TASKS, squares, Inline(), unwatched)
    assert len(table_of(store)) == 10


def test_a_lost_worker_is_replaced_and_its_shard_done_again(tmp_path: Path) -> None:
    store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    run(store, marked(tmp_path), dies_once, Processes(2), unwatched)
    assert (tmp_path / "marks").exists()
    assert [row[0] for row in table_of(store)] == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4]


def test_a_worker_that_was_told_to_end_is_replaced(tmp_path: Path) -> None:
    store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    run(store, marked(tmp_path), told_to_end_once, Processes(2), unwatched)
    assert [row[0] for row in table_of(store)] == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4]


def test_a_worker_that_died_while_sending_is_replaced(tmp_path: Path) -> None:
    store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    run(store, marked(tmp_path), dies_while_sending_once, Processes(2), unwatched)
    assert [row[0] for row in table_of(store)] == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4]


def test_workers_are_kept_from_task_to_task(tmp_path: Path) -> None:
    started: list[Any] = []

    def count(_report: Report, _task: Task, _columns: Any) -> None:
        started.extend(process for process in multiprocessing.active_children() if process not in started)

    many = [Task("squares", k, 2, {"k": k, "marks": ""}) for k in range(40)]
    store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    assert run(store, many, squares, Processes(2), count).rows_done == 80
    assert len(started) == 2
    assert multiprocessing.active_children() == []


def test_what_a_task_raises_says_where(tmp_path: Path) -> None:
    store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    with pytest.raises(LookupError, match="nothing known of 0") as caught:
        run(store, TASKS, fails, Processes(1), unwatched)
    assert "test_sweep.py" in caught.value.__notes__[0]
    with pytest.raises(RuntimeError, match=r"Unsendable: neither nor[\s\S]*test_sweep\.py"):
        run(store, TASKS, fails_in_its_own_way, Processes(1), unwatched)
    assert multiprocessing.active_children() == []


@pytest.mark.parametrize(
    "work", [slow_but_for_the_first, large_but_for_the_first], ids=lambda work: work.__name__
)
def test_ctrl_c_ends_workers_whatever_they_do(tmp_path: Path, work: Work) -> None:
    store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    threads, reported = threading.enumerate(), []

    def interrupted(_report: Report, task: Task, _columns: Any) -> None:
        reported.append(task)
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        run(store, TASKS, work, Processes(2), interrupted)
    assert len(reported) == 1
    assert [task for task in TASKS if store.is_finished(task)] == reported
    assert multiprocessing.active_children() == []
    assert set(threading.enumerate()) <= set(threads)


def test_a_sweep_outside_the_main_thread_is_done_too(tmp_path: Path) -> None:
    store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    thread = threading.Thread(target=run, args=(store, TASKS, squares, Processes(2), unwatched))
    thread.start()
    run(
        ShardStore.open(tmp_path / "other", {"name": "x"}, resume=False),
        TASKS,
        squares,
        Processes(2),
        unwatched,
    )
    thread.join()
    assert [row[0] for row in table_of(store)] == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4]


def test_other_processes_of_the_caller_are_left_alone(tmp_path: Path) -> None:
    other = multiprocessing.get_context("spawn").Process(target=time.sleep, args=(7200.0,))
    other.start()
    try:
        store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
        with pytest.raises(WorkersLost):
            run(store, TASKS, dies_always, Processes(1), unwatched)
        assert other.is_alive()
    finally:
        other.kill()
        other.join()


def test_workers_that_always_die_end_the_sweep_with_a_reason(tmp_path: Path) -> None:
    store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    with pytest.raises(WorkersLost, match="died 3 times"):
        run(store, TASKS, dies_always, Processes(1), unwatched)


def test_a_full_disk_keeps_what_is_finished(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    sync, calls = os.fsync, []

    def full_at_the_third(descriptor: int) -> None:
        calls.append(descriptor)
        if len(calls) == 3:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", full_at_the_third)
    with pytest.raises(
        StoreError, match=r"shard=0002: cannot be written: No space left on device; finished shards"
    ):
        run(store, TASKS, squares, Inline(), unwatched)
    monkeypatch.undo()
    assert [store.is_finished(task) for task in TASKS] == [True, True, False, False, False]
    assert not list((tmp_path / "out").rglob(".part*"))
    assert run(store, TASKS, squares, Inline(), unwatched).rows_before == 4
    whole = ShardStore.open(tmp_path / "whole", {"name": "x"}, resume=False)
    run(whole, TASKS, squares, Inline(), unwatched)
    assert table_of(store) == table_of(whole)


def test_folders_are_never_mixed_up(tmp_path: Path) -> None:
    ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    with pytest.raises(StoreError, match=r"holds results of this scenario; add --resume"):
        ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    with pytest.raises(StoreError, match=r"another scenario \(x, .*nothing was overwritten"):
        ShardStore.open(tmp_path / "out", {"name": "y"}, resume=True)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("…")
    with pytest.raises(StoreError, match=r"holds files but no sweep\.json"):
        ShardStore.open(tmp_path / "mine", {"name": "x"}, resume=False)
    with pytest.raises(StoreError, match="is not a results folder"):
        ShardStore.load(tmp_path / "mine")
    with pytest.raises(StoreError, match="has no shard of `squares` yet"):
        ShardStore.load(tmp_path / "out").read("squares")


def test_an_address_without_a_scheduler_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("distributed", reason="the extra `reach` is not installed")
    store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    with pytest.raises(
        StoreError, match=r"--dask = tcp://127\.0\.0\.1:9: no scheduler answers within 0\.2 s"
    ):
        run(store, TASKS, squares, DaskCluster("tcp://127.0.0.1:9", timeout_s=0.2), unwatched)


@pytest.mark.filterwarnings("ignore")
def test_an_embedded_cluster_gives_the_same_table(tmp_path: Path) -> None:
    pytest.importorskip("distributed", reason="the extra `reach` is not installed")
    here = ShardStore.open(tmp_path / "here", {"name": "x"}, resume=False)
    there = ShardStore.open(tmp_path / "there", {"name": "x"}, resume=False)
    run(here, TASKS, squares, Inline(), unwatched)
    run(there, TASKS, squares, DaskCluster(None, workers=1), unwatched)
    assert table_of(there) == table_of(here)


@pytest.mark.filterwarnings("ignore")
def test_a_lost_dask_worker_is_replaced_and_its_shard_done_again(tmp_path: Path) -> None:
    """The worker is killed in the middle of a task without a request; the table is that of an undisturbed sweep.

    However long another one takes to start: Dask gives it 15 s, and would then wait for ever.
    """
    pytest.importorskip("distributed", reason="the extra `reach` is not installed")
    here = ShardStore.open(tmp_path / "here", {"name": "x"}, resume=False)
    there = ShardStore.open(tmp_path / "there", {"name": "x"}, resume=False)
    run(here, TASKS, squares, Inline(), unwatched)
    with import_module("dask.config").set({"distributed.deploy.lost-worker-timeout": "10 ms"}):
        report = run(there, marked(tmp_path), dies_once, DaskCluster(None, workers=1), unwatched)
    assert (tmp_path / "marks").exists()
    assert (report.shards_done, report.rows_done) == (5, 10)
    assert table_of(there) == table_of(here)


@pytest.mark.filterwarnings("ignore")
def test_dask_workers_that_always_die_end_the_sweep_with_a_reason(tmp_path: Path) -> None:
    pytest.importorskip("distributed", reason="the extra `reach` is not installed")
    store = ShardStore.open(tmp_path / "out", {"name": "x"}, resume=False)
    with pytest.raises(WorkersLost, match="Dask workers died again and again at one task"):
        run(store, TASKS[:1], dies_always, DaskCluster(None, workers=1), unwatched)
    assert not store.is_finished(TASKS[0])
