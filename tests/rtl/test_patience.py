"""A run without an end is a failure within the session's patience, not a job that hangs."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from orbsoc.ps.registers import Control, Register
from orbsoc.rtl.session import PATIENCE_S, RtlPort, RtlSession
from orbsoc.rtl.validation import RtlError

ENDLESS = """#!/bin/sh
while read command rest; do
  case $command in wait) while :; do :; done ;; esac
  echo ok
done
"""
BUSY = """#!/bin/sh
while read command rest; do
  case $command in wait) echo 0 7 ;; *) echo ok ;; esac
done
"""


def harness(folder: Path, text: str) -> Path:
    path = folder / "harness"
    path.write_text(text)
    path.chmod(0o755)
    return path


def test_the_patience_is_a_minute() -> None:
    assert PATIENCE_S <= 60.0


def test_an_answer_that_does_not_come_ends_the_session(tmp_path: Path) -> None:
    began = time.monotonic()
    with RtlSession(harness(tmp_path, ENDLESS), patience_s=0.5) as session:
        assert session.ask("reset") == "ok"
        with pytest.raises(RtlError, match=r"gave no answer to 'wait 1000000' within 0\.5 s"):
            session.wait(1_000_000)
    assert time.monotonic() - began < 20.0


def test_a_launch_that_does_not_end_is_an_error_though_every_command_is_answered(tmp_path: Path) -> None:
    with RtlSession(harness(tmp_path, BUSY), patience_s=0.5) as session:
        port = RtlPort(session)
        port.write(Register.CONTROL, Control.ATTEMPT)
        with pytest.raises(RtlError, match=r"has not ended what it was launched for within 0\.5 s"):
            poll(port)


def poll(port: RtlPort) -> None:
    for _ in range(1_000_000):
        port.tick()


def test_a_session_that_is_not_asked_lives_on(tmp_path: Path) -> None:
    with RtlSession(harness(tmp_path, BUSY), patience_s=0.3) as session:
        assert session.wait(1) == (False, 7)
        time.sleep(1.0)
        assert session.wait(1) == (False, 7)
