"""Mutants of the RTL shown to the tests of tests/rtl, one after the other, until one of these fails."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from scripts.mutation.places import Mutant
from scripts.mutation.schemata import VARIABLE, write_alone, write_schemata
from scripts.mutation.time_limit import FOUND, LIMIT_S

ROOT = Path(__file__).resolve().parents[2]
RTL = ROOT / "rtl"
ELABORATED = {"axi/axi_contract.sv", "engine/clusters.svh"}
"""Their functions are called by elaboration: a mutant of theirs is built alone."""
CHECKS = {
    "fpu": ("units",),
    "engine": ("rules", "registers", "attempt", "engine"),
    "axi": ("axi", "limit", "axi_solve"),
}
"""The tests that a mutant of a folder is shown to, in this order."""
LEFT_OUT = "not mutation and not mutant and not off_is_a_mismatch and not core_file"
"""Tests that have wrong sources of their own, and those of files as they are written."""
MOST_S = 1800


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
    found = tree / f"found-{number}-{checks[0]}.json"
    found.unlink(missing_ok=True)
    path = os.pathsep.join([str(tree), *filter(None, [os.environ.get("PYTHONPATH")]), str(ROOT)])
    names = [f"tests/rtl/test_{check}.py" for check in checks]
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-p", "scripts.mutation.time_limit", "-k", LEFT_OUT, *names]  # fmt: skip
    variables = {VARIABLE: str(number), FOUND: str(found), LIMIT_S: str(limit_s), "PYTHONPATH": path, "ORBSOC_REQUIRE_RTL": "1", "PYTHONDONTWRITEBYTECODE": "1"}  # fmt: skip
    with subprocess.Popen(
        command, cwd=tree, env=os.environ | variables, start_new_session=True, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as process:  # fmt: skip
        try:
            text, _ = process.communicate(timeout=MOST_S)
        except subprocess.TimeoutExpired:
            return Verdict(number, "time limit", "", f"no end within {MOST_S} s")
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
    if process.returncode == 0:
        return Verdict(number, "survived", "", "")
    if not found.exists():
        raise RuntimeError(f"mutant {number}: the tests did not run\n{text[-2000:]}")
    failed = json.loads(found.read_text())
    return Verdict(
        number, "time limit" if failed["endless"] else "caught", failed["test"], " ".join(failed["why"])
    )


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
