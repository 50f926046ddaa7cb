"""What `docs/flying.md` says of `rec1_dry` is what `orbsoc fly` prints of it; the flight whose target is out of reach takes longer."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from orbsoc.commands.app import app
from tests.printed import near
from tests.site.stated import text_of

SCENARIO = Path(__file__).resolve().parents[2] / "scenarios" / "rec1_dry.toml"
TEXT = text_of("flying.md")
LOST = ["event.at_s=35", "event.thrust_kept=0.25"]
NUMBER = r"(\d+(?:\.\d+)?)"


@pytest.mark.parametrize(
    ("settings", "pairs"),
    [
        ([], [("cut off at # s, not 56.6 s", "cut off at # s"), ("the decisions take # and", "the longest # of")]),
        (LOST, [("and the vehicle flies to # × # km", "perigee, # × # km"), ("the decisions take # and # ms", "the longest # ms")]),
    ],
    ids=["reached", "out of reach"],
)  # fmt: skip
def test_the_page_says_what_is_flown(
    settings: list[str], pairs: list[tuple[str, str]], tmp_path: Path
) -> None:
    options = [word for each in settings for word in ("--set", each)]
    result = CliRunner().invoke(app, ["fly", str(SCENARIO), *options, "--no-report", "--out", str(tmp_path / "out")])  # fmt: skip
    printed = " ".join(result.output.split())
    for stated, said in pairs:
        shown, found = (
            re.search(NUMBER.join(map(re.escape, words.split("#"))), text)
            for words, text in ((stated, TEXT), (said, printed))
        )
        assert shown, stated
        assert found, (said, printed)
        assert all(map(near, shown.groups()[-len(found.groups()) :], found.groups()))
