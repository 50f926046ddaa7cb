"""Every command that a guide gives in full runs to its end and exits as the page says: an hour and more, so only by `make long`.

 Tutorials and how-to pages are run in each suite (test_pages.py); that the command line takes
all others is tested there, too (test_guides.py). The commands of a page run in order, in one folder: some go on from those before.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from .test_guides import CASES, ROOT, is_complete
from .test_pages import PAGES as RUN_IN_EACH_SUITE

LONGEST_S = 1800.0
UNKNOWN = re.compile(r"(?:^|=)[A-Z]$|^\[|…|HOST|^[A-Z]+(?:\.\w+)?$")
"""A word that stands for what the reader has."""
_REC1 = "orbsoc fly scenarios/rec1.toml --set guidance.period_s=14.0"
EXIT_CODES: dict[str, int] = {
    f"{_REC1} --runs 2000 --seed 1 --workers 2 --deadline-ms 50": 1,
    f"{_REC1} --runs 10000 --seed 1 --workers 2 --deadline-ms 50 --no-report --out out/rec1-10000": 1,
}
"""Those other than 0 that a page shows."""
ELSEWHERE = {
    "orbsoc hw validate": "tests/integration/test_cli_hw_validate.py, in parts",
}
"""Commands that have a test of their own."""


def is_given_in_full(command: str) -> bool:
    return is_complete(command) and not any(map(UNKNOWN.search, shlex.split(command)))


FULL = {
    page: commands
    for page in dict.fromkeys(page for page, _ in CASES if page not in RUN_IN_EACH_SUITE)
    if (
        commands := [
            each for at, each in CASES if at == page and is_given_in_full(each) and each not in ELSEWHERE
        ]
    )
}


def prepare(command: str, folder: Path) -> None:
    """What a page takes as given: a list of impulses, a problem, a table of times."""
    words = shlex.split(command)
    if "mine.csv" in words:
        run(shlex.join([*words[:3], "--device", "none", "--no-report", "--out", "mine"]), folder)
        shutil.copyfile(folder / "mine" / "impulses.csv", folder / "mine.csv")
    if "times.csv" in words:
        (folder / "times.csv").write_text(
            "stage,runs,microseconds\nfactorize,45,15180.0\nstatistics,45,1271.0\n"
        )
    for name in ("problem.json", "failure.json"):
        if name in words:
            shutil.copyfile(ROOT / "scenarios" / "rendezvous_lp.json", folder / name)


def run(command: str, folder: Path) -> tuple[int, str]:
    done = subprocess.run(
        [sys.executable, "-m", *shlex.split(command)], cwd=folder, capture_output=True, text=True, timeout=LONGEST_S,
        env=os.environ | {"COLUMNS": "160", "TERM": "dumb"}, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize("page", FULL, ids=lambda page: str(page.relative_to(ROOT)))
def test_the_commands_of_a_page_end_as_it_says(page: Path, tmp_path: Path) -> None:
    for name in ("scenarios", "rtl"):
        (tmp_path / name).symlink_to(ROOT / name)
    ends = {}
    for command in FULL[page]:
        prepare(command, tmp_path)
        code, printed = run(command, tmp_path)
        if code != EXIT_CODES.get(command, 0):
            ends[command] = (code, printed[-2000:])
    assert not ends


def test_most_commands_are_given_in_full() -> None:
    assert sum(map(len, FULL.values())) > 60
