"""Mutants of the RTL shown to the tests of tests/rtl, one after the other, until one of these fails."""

from __future__ import annotations

import contextlib
import hashlib
import json
import multiprocessing
import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import hypothesis  # noqa: F401  loaded once, for all tests
import pytest

import orbsoc.rtl.solve  # noqa: F401
from scripts.mutation import time_limit
from scripts.mutation.places import Mutant
from scripts.mutation.schemata import VARIABLE, write_alone, write_schemata
from scripts.mutation.time_limit import FOUND, LIMIT_S

ROOT = Path(__file__).resolve().parents[2]
RTL = ROOT / "rtl"
ELABORATED = {"axi/axi_contract.sv", "engine/clusters.svh"}
"""Their functions are called by elaboration: a mutant of theirs is built alone."""
CHECKS = {
    "fpu": ("units", "engine"),
    "engine": ("rules", "registers", "attempt", "engine"),
    "axi": ("axi", "limit", "axi_solve"),
}
"""The tests that a mutant of a folder is shown to, in this order."""
LEFT_OUT = "not mutation and not mutant and not off_is_a_mismatch and not core_file"
"""Tests that have wrong sources of their own, and those of files as they are written."""
MOST_S = 1800
FORK = multiprocessing.get_context("fork")


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of a mutant. `test` is the first that failed."""

    number: int
    verdict: str
    """caught, time limit, or survived."""
    test: str
    why: str


def files() -> list[str]:
    """All that is mutated."""
    return [str(path.relative_to(RTL)) for folder in CHECKS for path in sorted((RTL / folder).glob("*.sv*"))]


def source() -> str:
    """A short hash of the RTL and of the tests."""
    paths = [*sorted(RTL.rglob("*.sv*")), *sorted(RTL.rglob("*pp"))]
    return hashlib.sha256(b"".join(path.read_bytes() for path in paths)).hexdigest()[:8]


def prepared(folder: Path, mutants: dict[int, Mutant], alone: int | None = None) -> Path:
    """A folder with tests and a mutated RTL: all mutants but the ELABORATED ones, or one `alone`."""
    tree = folder / ("all" if alone is None else f"alone-{alone}")
    if not tree.exists():
        scratch = Path(tempfile.mkdtemp(prefix="new-", dir=folder))
        if alone is None:
            write_schemata(
                RTL, scratch / "rtl", {n: m for n, m in mutants.items() if m.file not in ELABORATED}
            )
        else:
            write_alone(RTL, scratch / "rtl", mutants[alone])
        shutil.copytree(ROOT / "tests", scratch / "tests", ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "pyproject.toml", scratch)
        (scratch / "docs").symlink_to(ROOT / "docs")
        if not tree.exists():  # another campaign in this folder may have been first
            scratch.rename(tree)
    return tree


def shown(tree: Path, number: int, checks: tuple[str, ...], limit_s: int) -> Verdict:
    """The mutant of that number before these tests, each of which may take so long; 0 is the RTL as it is."""
    found, log = (tree / f"{checks[0]}-{number}.{suffix}" for suffix in ("json", "log"))
    found.unlink(missing_ok=True)
    variables = {VARIABLE: str(number), FOUND: str(found), LIMIT_S: str(limit_s), "ORBSOC_REQUIRE_RTL": "1"}
    process = FORK.Process(target=_test, args=(tree, checks, variables, log))
    process.start()
    try:
        process.join(MOST_S)
        ended = process.exitcode is not None
    finally:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)  # and the harnesses that it has left
    if not ended:
        return Verdict(number, "time limit", "", f"no end within {MOST_S} s")
    if process.exitcode == 0:
        return Verdict(number, "survived", "", "")
    if not found.exists():
        raise RuntimeError(f"mutant {number}: the tests did not run\n{log.read_text()[-2000:]}")
    failed = json.loads(found.read_text())
    verdict = "time limit" if failed["endless"] else "caught"
    return Verdict(number, verdict, failed["test"], " ".join(failed["why"]))


def _test(tree: Path, checks: tuple[str, ...], variables: dict[str, str], log: Path) -> None:
    """Run tests in this process, which was forked for it with all packages loaded, and end it."""
    os.setsid()
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    with log.open("w") as file:
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)
    os.chdir(tree)
    os.environ.update(variables)
    sys.path.insert(0, str(tree))
    sys.dont_write_bytecode = True
    names = [f"tests/rtl/test_{check}.py" for check in checks]
    options = [
        "-x",
        "-q",
        "-p",
        "no:cacheprovider",
        "--rootdir",
        str(tree),
        "-c",
        "pyproject.toml",
        "-W",
        "ignore:Module already imported",
    ]
    os._exit(pytest.main([*options, "-k", LEFT_OUT, *names], plugins=[time_limit]))


def verdicts(folder: Path, mutants: dict[int, Mutant], wanted: list[int]) -> Iterator[Verdict]:
    """Of each of these numbers. Raises RuntimeError if a test fails on the RTL as it is."""
    for group, checks in CHECKS.items():
        own = [number for number in wanted if mutants[number].file.startswith(f"{group}/")]
        if own:
            right = shown(prepared(folder, mutants), 0, checks, limit_s=0)  # it builds all models
            if right.verdict != "survived":
                raise RuntimeError(f"with no mutant on, {right.test} fails: {right.why}")
        for number in own:
            alone = mutants[number].file in ELABORATED
            tree = prepared(folder, mutants, number if alone else None)
            yield shown(tree, number, checks, limit_s=600 if alone else 60)
