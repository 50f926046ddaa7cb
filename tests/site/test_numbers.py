"""Numbers of a table that names its commands are those of a run: each that a row states is found in the plan of its command.

Those of lines that name none are held by `stated`.

A number is found where one of the plan's, in its record or its verdict, is within a unit of its last digit, in SI units, km or mm. The last
bits of a plan depend on the processor (tests/printed.py).
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import orbsoc
from orbsoc.commands.hw_options import parsed_settings

ROOT = Path(__file__).resolve().parents[2]
NUMBER = re.compile(r"(?<![\w.,])\d+(?:\.\d+)?(?![\w.])")
COMMAND = re.compile(r"orbsoc plan scenarios/(\w+)\.toml((?: --\w+ [\w.=]+)*)$")


def text(page: str) -> str:
    return (ROOT / "docs" / page).read_text(encoding="utf-8")


def numbers_of(value: Any) -> Iterator[float]:
    """Every number of a document, and those that its texts print."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list | tuple):
        for each in value:
            yield from numbers_of(each)
    elif isinstance(value, int | float):
        yield abs(float(value))
    elif isinstance(value, str):
        yield from (float(found) for found in re.findall(r"\d+(?:\.\d+)?", value))


def planned(command: str) -> list[float]:
    """The numbers of the plan that a command makes."""
    found = COMMAND.fullmatch(command)
    assert found, command
    words = shlex.split(found[2])
    settings = [f"problem={value}" if option == "--problem" else value for option, value in zip(words[::2], words[1::2], strict=True)]  # fmt: skip
    run = orbsoc.plan(
        ROOT / "scenarios" / f"{found[1]}.toml", settings=parsed_settings(settings), device="none"
    )
    assert run.plan.status.name == "VERIFIED"
    return list(numbers_of([run.to_dict(), str(run.verdict)]))


def missing(stated: str, found: list[float]) -> list[str]:
    """The numbers that a line states and none of `found` is near."""
    places = {number: len(number.partition(".")[2]) for number in NUMBER.findall(stated)}
    return [
        number
        for number, digits in places.items()
        if not any(
            abs(value * scale - float(number)) <= 1.001 * 10.0**-digits
            for value in found
            for scale in (1.0, 1e-3, 1e3)
        )
    ]


def rows(page: str, heading: str) -> list[list[str]]:
    """The cells of the table below a heading, its head left out."""
    section = re.search(rf"^## {heading}\n(.*?)(?=^## )", text(page), flags=re.DOTALL | re.MULTILINE)
    assert section
    table = [line for line in section[1].splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table[2:]]


BURNS = [
    (command.strip("`"), answer) for _, command, answer in rows("plan.md", "Missions") if "`orbsoc" in command
]


@pytest.mark.parametrize(("command", "stated"), BURNS)
def test_a_number_that_a_page_states_is_one_of_its_plan(command: str, stated: str) -> None:
    assert missing(stated, planned(command)) == []


def test_the_tables_are_read() -> None:
    assert len(BURNS) == 8


def test_a_number_that_is_not_there_is_missing() -> None:
    assert missing("56.570 s onto 152.76 × 201.84 km", [56.57001, 152763.0, 201.8]) == ["201.84"]
