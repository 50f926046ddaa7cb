"""Rows and sentences of the guides whose numbers a plan has: data, one file a page, `PAGE.toml`.

Each `[[plan]]` names a scenario of `scenarios/` or of OWN, its `settings`, and `lines` of the page. A number of a line stands in braces as its place in
the plan's record: `{cost}`, `{audits.1.half_m}`, `{front.pulses=14.cost}` of the entry that has 14 there, `{max audits.*.half_m}` (or `min`, `sum`,
`len`) over a list, `{cost * 1000}` in another unit, `{'at # instants'}` at # of the verdict. `…` stands for anything within the line. A plan is VERIFIED unless `status` says otherwise.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import orbsoc
from orbsoc.commands.hw_options import parsed_settings
from orbsoc.guidance.scenario_file import read_toml
from tests.missions.approach.test_plan import PROXOPS
from tests.missions.reachable_insertion import test_bounded_search, test_coast
from tests.printed import NUMBER, near

ROOT = Path(__file__).resolve().parents[3]


def shipped(name: str) -> dict[str, Any]:
    return read_toml(ROOT / "scenarios" / f"{name}.toml")


OWN: dict[str, Callable[[], dict[str, Any]]] = {
    "plane change": lambda: test_bounded_search.PLANE,
    "perigee and plane": lambda: test_bounded_search.FREE,
    "wait for the node": lambda: test_coast.scenario().model_dump(),
    "public proxops": lambda: PROXOPS,
    "public proxops, held": lambda: (
        PROXOPS | {"engine": {"thrust": "held", "largest_m_s2": 0.1, "limit": "axes"}}
    ),
    "impulses at the held instants": lambda: shipped("station_held") | {"engine": {"largest_m_s": 1.0}},
}
"""Scenarios of the tests that a page tells of."""
PLACE = re.compile(r"\{(?:(min|max|sum|len) )?([\w.=*-]+|'[^'#]*#[^'#]*')(?: \* ([\d.e-]+))?\}")
FUNCTIONS: dict[str, Callable[[list[Any]], Any]] = {"min": min, "max": max, "sum": sum, "len": len}
WORDS = "words of the verdict"
RELATIVE = 1e-9
"""Beside a unit of the last digit, which the last bits of a plan may move."""


@dataclass(frozen=True)
class Stated:
    """A plan, and the lines of a page that tell of it."""

    page: str
    scenario: str
    settings: tuple[str, ...]
    lines: tuple[str, ...]
    status: str

    def __str__(self) -> str:
        return f"{self.page}: {' '.join((self.scenario, *self.settings))}"

    def record(self) -> dict[str, Any]:
        """The plan's record, made now, with the verdict's words."""
        named = OWN.get(self.scenario)
        source = ROOT / "scenarios" / f"{self.scenario}.toml" if named is None else named()
        run = orbsoc.plan(source, settings=parsed_settings(self.settings), device="none")
        assert run.plan.status.name == self.status
        return run.to_dict() | {WORDS: " ".join(str(run.verdict).split())}


def read() -> Iterator[Stated]:
    for path in sorted(Path(__file__).parent.glob("*.toml")):
        for each in tomllib.loads(path.read_text(encoding="utf-8"))["plan"]:
            settings = tuple(each.get("settings", ()))
            status = each.get("status", "VERIFIED")
            yield Stated(f"{path.stem}.md", each["scenario"], settings, tuple(each["lines"]), status)


def text_of(page: str) -> str:
    """A page, each paragraph and each item on one line."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    return re.sub(r"(?<=[^\n|])\n(?!\n|\||#|```|\s*(?:-|\d+\.) )\s*", " ", text)


def numbers_at(line: str, text: str) -> list[str]:
    """The numbers of a page where `line` has its braces; the page must have it once."""
    parts = [re.escape(part).replace("…", r"[^\n]*?") for part in re.split(r"\{[^}]*\}", line)]
    begins = "^" if line.startswith("|") else r"(?<!\w)"
    found = re.findall(begins + f"({NUMBER.pattern})".join(parts), text, flags=re.MULTILINE)
    assert len(found) == 1, (line, len(found))
    return [found[0]] if isinstance(found[0], str) else list(found[0])


def places_of(line: str) -> list[tuple[str, str, str]]:
    """Function, path and factor of each number of a line."""
    found = PLACE.findall(line)
    assert len(found) == line.count("{") > 0, line
    return found


def at(value: Any, path: str) -> Any:
    """What a record has at a path; of `*` the list of all; of words with a # the number there."""
    if path.startswith("'"):
        before, after = map(re.escape, path.strip("'").split("#"))
        found = re.search(f"{before}({NUMBER.pattern}){after}", value[WORDS])
        assert found, (path, value[WORDS])
        return float(found[1]) if "." in found[1] else int(found[1])
    for k, step in enumerate(steps := path.split(".")):
        if step == "*":
            return [at(each, ".".join(steps[k + 1 :])) for each in value]
        if "=" in step:
            key, wanted = step.split("=")
            [value] = [each for each in value if str(each[key]) == wanted]
        elif step:
            value = value[int(step)] if isinstance(value, list) else value[step]
    return value


def differing(line: str, text: str, record: dict[str, Any]) -> list[str]:
    """What the page states otherwise than the record."""
    found = []
    for shown, (function, path, factor) in zip(numbers_at(line, text), places_of(line), strict=True):
        value = at(record, path)
        value = FUNCTIONS[function](value) if function else value
        value = abs(value) if not factor else abs(value) * float(factor)
        if not near(shown, f"{value:.12g}", RELATIVE):
            found.append(f"{path}: {shown} is stated, {value:.12g} planned")
    return found
