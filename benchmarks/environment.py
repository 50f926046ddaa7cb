"""When, on what, and with what something was measured: the header of every result."""

from __future__ import annotations

import os
import platform
import subprocess
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from benchmarks.answer import Solver

ROOT = Path(__file__).resolve().parents[1]


def environment(solvers: Sequence[Solver], *, repeats: int, tol: float) -> dict[str, str]:
    """Keys and values, in order, of the header."""
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "machine": machine_class(),
        "commit": commit(),
        "solvers": ", ".join(f"{solver.name} {solver.version}" for solver in solvers),
        "python": f"{platform.python_version()}, NumPy {version('numpy')}, SciPy {version('scipy')}",
        "tolerance": f"{tol:g} by each solver's own criterion",
        "repeats": str(repeats),
        "load": f"{os.getloadavg()[0]:.1f} when the measurement began",
    }


def machine_class() -> str:
    """What the machine is, not which: number of cores, instruction set, widest vector registers."""
    architecture = platform.machine().replace("_", "-").lower()
    flags = _cpu_flags()
    vectors = "AVX-512" if "avx512f" in flags else "AVX2" if "avx2" in flags else ""
    shared = "shared " if "hypervisor" in flags else ""
    return f"{os.cpu_count()} {shared}{architecture} cores" + (f" ({vectors})" if vectors else "")


def commit() -> str:
    """The short hash of what is checked out; says so when files differ from it."""

    def git(*arguments: str) -> str:
        done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True)
        return done.stdout.strip()

    try:
        changed = git("status", "--porcelain", "--untracked-files=no", "--", "rust", "python")
        return git("rev-parse", "--short", "HEAD") + (" with uncommitted changes" if changed else "")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def _cpu_flags() -> set[str]:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return set()
    for line in lines:
        if line.startswith("flags"):
            return set(line.split())
    return set()
