"""The files of a plan."""

import json
from pathlib import Path

import orbsoc

from .cases import SCENARIOS


def test_a_plan_has_its_files_and_its_page(tmp_path: Path) -> None:
    run = orbsoc.plan_file(SCENARIOS / "paper003_socp.toml", out=tmp_path / "out", device="none")
    assert run.succeeded
    folder = tmp_path / "out"
    for name in (
        "space.png",
        "approach.png",
        "distance.png",
        "front.png",
        "surprise.png",
        "primer.png",
        "impulses.csv",
        "chaser.oem",
        "chaser.opm",
    ):
        assert (folder / name).stat().st_size > 200, name
    document = json.loads((folder / "plan.json").read_text(encoding="utf-8"))
    keys = {
        "delta_v_m_s",
        "cost",
        "impulses",
        "terminal_error",
        "constraints",
        "certificates",
        "subproblems",
        "paper",
    }
    assert keys <= document.keys()
    assert document["certificates"]["optimum"]["gap"] < 1e-5
    page = (folder / "report.html").read_text(encoding="utf-8")
    for words in ("Another drag than planned", "Finite burns", "With errors", "385.34"):
        assert words in page, words
    assert (folder / "chaser.opm").read_text(encoding="utf-8").count("MAN_EPOCH_IGNITION") == 4
