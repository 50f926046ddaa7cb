"""Where the numbers of each table of the guide come from, in tables.toml: a test that makes them anew, a record with its day and command,
or rules that no run makes. A table that is not listed, and an entry without a table, are errors."""

from __future__ import annotations

import importlib.util
import re
import shlex
import tomllib
from collections import Counter
from pathlib import Path

import pytest

from tests.site.test_guides import refusal

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
LEDGER: dict[str, dict[str, str]] = tomllib.loads(Path(__file__).with_name("tables.toml").read_text(encoding="utf-8"))  # fmt: skip
FEW = 3
"""Numbers of two digits or with a fraction up to which a table is taken for words."""
RECORD = re.compile(r"record of (\d{4}-\d\d-\d\d) by `(.+)`")
GONE = "code that is gone"


def tables_of(page: str) -> list[str]:
    """Section and place in it of each table with numbers: "Results", "Results 2"."""
    text = re.sub(r"```.*?```", "", (DOCS / page).read_text(encoding="utf-8"), flags=re.DOTALL)
    found: Counter[str] = Counter()
    names, heading = [], ""
    for block in re.split(r"\n\s*\n|(?=\n#+ )", text):
        if match := re.match(r"\s*#+ (.*)", block):
            heading = match[1]
        rows = re.search(r"^\|[-:| ]+\|\n((?:\|.*\n?)*)", block, re.MULTILINE)
        if rows and len(re.findall(r"\d+[.,]\d+|\d{2,}", rows[1])) > FEW:
            found[heading] += 1
            names.append(heading if found[heading] == 1 else f"{heading} {found[heading]}")
    return names


FILES = sorted([*DOCS.glob("*.md"), *DOCS.glob("tutorials/*.md"), *DOCS.glob("how-to/*.md")])
PAGES = [page for page in (str(file.relative_to(DOCS)) for file in FILES) if tables_of(page)]


def test_every_page_with_tables_is_listed() -> None:
    assert sorted(LEDGER) == PAGES


@pytest.mark.parametrize("page", PAGES)
def test_every_table_is_listed(page: str) -> None:
    listed = LEDGER[page]
    assert list(listed) == (["all"] if "all" in listed else tables_of(page))


def exists(test: str) -> bool:
    """Whether a file of tests has a function of that name."""
    file, _, name = test.partition("::")
    path = ROOT / "tests" / file
    return path.is_file() and f"def {name}(" in path.read_text(encoding="utf-8")


def is_command(words: str) -> bool:
    """Whether a command is one of ours: `orbsoc …`, a module of benchmarks or scripts, a program of the bench, a target of make."""
    program, *rest = shlex.split(words)
    if program == "make":
        return (
            re.search(rf"^{rest[0]}:", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
            is not None
        )
    if program == "python":
        return (
            importlib.util.find_spec(rest[1]) is not None if rest[0] == "-m" else (ROOT / rest[0]).is_file()
        )
    if program == "orbsoc-bench":
        return (ROOT / "rust" / "orbsoc-bench").is_dir()
    if program.startswith("rtl/"):
        return (ROOT / program).is_file()
    return program == "orbsoc" and refusal(words) == ""


@pytest.mark.parametrize(("table", "origin"), [(f"{page}, {name}", said) for page, of in LEDGER.items() for name, said in of.items()])  # fmt: skip
def test_where_it_comes_from_is_there(table: str, origin: str) -> None:
    if match := RECORD.fullmatch(origin):
        assert "2026-11-20" <= match[1] <= "2030"
        assert match[2] == GONE or is_command(match[2]), table
    else:
        assert origin == "rules" or exists(origin), (table, origin)


@pytest.mark.parametrize(
    "command", ["orbsoc hw frobnicate", "make nonesuch", "python -m benchmarks.nonesuch"]
)
def test_a_command_that_is_not_there_is_noticed(command: str) -> None:
    assert not is_command(command)
