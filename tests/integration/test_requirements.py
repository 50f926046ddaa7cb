"""The lock files: exact, complete, and free of GPL code outside the benchmarks."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from orbsoc.files.extras import EXTRA_OF

ROOT = Path(__file__).resolve().parents[2]
MANIFEST = tomllib.loads((ROOT / "pyproject.toml").read_text())
EXTRAS = MANIFEST["project"]["optional-dependencies"]
WANTED = {
    "build": MANIFEST["build-system"]["requires"],
    "runtime": MANIFEST["project"]["dependencies"] + EXTRAS["missions"] + EXTRAS["hw"],
    "test": EXTRAS["test"] + EXTRAS["cvxpy"] + EXTRAS["reach"],  # what these bring is tested
    "bench": EXTRAS["bench"],
    "route": EXTRAS["route"],
    "docs": EXTRAS["docs"],
}


def normal(name: str) -> str:
    """A distribution's name as package indexes compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def pins(lock: str) -> dict[str, str]:
    """Name → version of one lock file, its own lines only."""
    lines = (ROOT / "requirements" / f"{lock}.txt").read_text().splitlines()
    entries = [line for line in lines if line and not line.startswith(("#", "-r "))]
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", entry) for entry in entries), entries
    return {normal(name): version for name, version in (entry.split("==") for entry in entries)}


@pytest.mark.parametrize("lock", WANTED)
def test_everything_wanted_is_pinned(lock: str) -> None:
    wanted = {normal(re.match(r"[\w.-]+", requirement)[0]) for requirement in WANTED[lock]}
    assert wanted <= set(pins(lock))


def test_every_lock_belongs_to_something_wanted() -> None:
    assert {path.stem for path in (ROOT / "requirements").glob("*.txt")} == set(WANTED)


def test_no_extra_is_forgotten() -> None:
    assert set(EXTRAS) == {"missions", "hw", "cvxpy", "reach", "all", "test", "bench", "docs", "route", "soc"}


def test_the_solver_alone_needs_three_packages() -> None:
    assert [re.match(r"[\w-]+", each)[0] for each in MANIFEST["project"]["dependencies"]] == [
        "numpy",
        "scipy",
        "clarabel",
    ]


def test_everything_is_all_that_commands_and_interfaces_need() -> None:
    assert EXTRAS["all"] == ["orbsoc[missions,hw,cvxpy,reach]"]


def test_an_extra_that_is_told_by_a_missing_package_asks_for_that_package() -> None:
    published = {"erfa": "pyerfa"}
    extra_of = {published.get(module, module): extra for module, extra in EXTRA_OF.items()}
    for package, extra in extra_of.items():
        assert package in [normal(re.match(r"[\w-]+", each)[0]) for each in EXTRAS[extra]]
    assert set(extra_of) == {
        normal(re.match(r"[\w-]+", each)[0])
        for extra in ("missions", "hw", "cvxpy", "reach")
        for each in EXTRAS[extra]
    }


def test_the_gpl_peer_is_in_the_benchmark_lock_only() -> None:
    assert [lock for lock in WANTED if "ecos" in pins(lock)] == ["bench"]


@pytest.mark.parametrize("lock", ["test", "bench", "docs", "route"])
def test_these_locks_build_on_the_runtime_lock(lock: str) -> None:
    text = (ROOT / "requirements" / f"{lock}.txt").read_text()
    assert "\n-r runtime.txt\n" in text
    assert not set(pins(lock)) & set(pins("runtime"))
