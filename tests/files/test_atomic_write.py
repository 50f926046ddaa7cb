"""A file is written whole or not at all; links, modes and pipes stay what they are."""

from __future__ import annotations

import os
import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from orbsoc.files.atomic_write import write_atomically
from orbsoc.files.json_fields import write_json


def test_a_link_stays_a_link_and_a_file_keeps_its_mode(tmp_path: Path) -> None:
    target, link = tmp_path / "a.txt", tmp_path / "link.txt"
    write_atomically(target, "before")
    target.chmod(0o600)
    link.symlink_to(target)
    write_atomically(link, "after", durable=True)
    assert link.is_symlink()
    assert target.read_text() == "after"
    assert target.stat().st_mode & 0o777 == 0o600


def test_a_pipe_is_written_to_not_replaced(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with ThreadPoolExecutor(1) as pool:
        read = pool.submit(pipe.read_bytes)
        write_atomically(pipe, b"content")
        assert read.result(timeout=10) == b"content"
    assert pipe.is_fifo()


def test_threads_may_write_one_file(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    text = "é" * 10_000
    with ThreadPoolExecutor(4) as pool:
        for done in [pool.submit(write_atomically, path, text) for _ in range(200)]:
            done.result()
    assert path.read_text(encoding="utf-8") == text
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.txt"]


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    write_json({"x": 1}, path)
    before = path.read_bytes()
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json({"x": float("nan")}, path)
    with pytest.raises(OSError, match=re.escape(str(tmp_path))):
        write_json({"x": 1}, tmp_path)
    with pytest.raises(OSError, match="No such file"):
        write_atomically(tmp_path / "absent" / "a.txt", "text")
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.json"]
