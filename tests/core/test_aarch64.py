"""The solver on 64-bit Arm, cross-compiled and run under QEMU: the bits of x86-64."""

from __future__ import annotations

import os
import shutil
import subprocess
from functools import reduce
from pathlib import Path

import numpy as np
import pytest

import orbsoc
from benchmarks.guidance import quadrotor, rendezvous
from benchmarks.recorded import first_insertions
from benchmarks.statistics import portfolio, small_lp
from orbsoc.conic.problem import Problem
from orbsoc.conic.solution import Solution

ROOT = Path(__file__).resolve().parents[2]
TARGET = "aarch64-unknown-linux-gnu"
TOOLS = ("cargo", "aarch64-linux-gnu-gcc", "qemu-aarch64")


def lacking() -> str:
    """What is missing here for a cross build; empty when nothing is."""
    missing = [tool for tool in TOOLS if shutil.which(tool) is None]
    if missing:
        return f"no {', '.join(missing)}: apt-get install gcc-aarch64-linux-gnu qemu-user"
    sysroot = subprocess.run(
        ["rustc", "--print", "sysroot"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.strip()
    if not (Path(sysroot) / "lib" / "rustlib" / TARGET).is_dir():
        return f"no Rust library for the target: rustup target add {TARGET}"
    return ""


@pytest.fixture(scope="module")
def bench() -> Path:
    """`orbsoc-bench` for the target, linked statically; quick to compile, for bits do not depend on optimisation."""
    if reason := lacking():
        if "ORBSOC_REQUIRE_ARM" in os.environ:
            pytest.fail(reason)
        pytest.skip(reason)
    flags = {"CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUSTFLAGS": "-C target-feature=+crt-static"}
    folder = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    subprocess.run(
        ["cargo", "build", "--quiet", "--locked", "-p", "orbsoc-bench", "--target", TARGET],
        cwd=ROOT,
        env=os.environ | flags,
        check=True,
    )
    return folder / TARGET / "debug" / "orbsoc-bench"


def bits(solution: Solution) -> str:
    """FNV-1a over the bits of x, y, z and s."""
    words = np.concatenate([solution.x, solution.y, solution.z, solution.s]).view(np.uint64).tolist()
    return f"{reduce(lambda found, word: (found ^ word) * 0x100000001B3 % 2**64, words, 0xCBF29CE484222325):016x}"


PROBLEMS = {
    "insertion": lambda: first_insertions(12, 1)[0],
    "rendezvous": lambda: rendezvous(10, 0),
    "quadrotor": lambda: quadrotor(5, 0),
    "portfolio": lambda: portfolio(30, 0),
    "small_lp": lambda: small_lp(16, 0, rows=100),
}


def test_solves_on_aarch64_have_the_bits_of_x86_64(bench: Path, tmp_path: Path) -> None:
    """Tiles, condensed blocks, simplicial columns and cones: every loop that is written by hand for NEON."""
    problems: dict[str, Problem] = {name: make() for name, make in PROBLEMS.items()}
    for name, problem in problems.items():
        problem.save(tmp_path / f"{name}.json")
    done = subprocess.run(
        ["qemu-aarch64", bench, "--marks", tmp_path], capture_output=True, text=True, check=True
    )
    _, *lines = done.stdout.splitlines()
    found = {line.split()[0].rpartition("/")[2]: line.split()[-1] for line in lines}
    expected = {name: bits(orbsoc.solve(problem)) for name, problem in problems.items()}
    assert found == expected
