"""Partitions: those that ship, and errors that say what is allowed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from hw_model.errors import PartitionError
from hw_model.platform.partition import load_partition, parse_partition, partition_names
from hw_model.vocabulary import PL_MODULES

ALLOWED = ", ".join(PL_MODULES)


def test_the_shipped_partitions() -> None:
    assert partition_names() == ["all_ps", "factor_only", "paper", "paper_streams", "resident"]
    sides = {name: load_partition(name).modules for name in partition_names()}
    assert sides["all_ps"] == dict.fromkeys(PL_MODULES, "ps")
    assert sides["paper"] == sides["paper_streams"] == dict.fromkeys(PL_MODULES, "pl") | {"statistics": "ps"}
    assert sides["resident"] == dict.fromkeys(PL_MODULES, "pl")
    programs = {
        name: (load_partition(name).control, load_partition(name).streams) for name in partition_names()
    }
    assert programs.pop("paper_streams") == ("ps", "iteration")
    assert programs.pop("resident") == ("pl", "iteration")
    assert set(programs.values()) == {("ps", "stage")}
    assert sides["factor_only"] == dict.fromkeys(PL_MODULES, "ps") | {"factorization": "pl"}


@pytest.mark.parametrize("name", partition_names())
def test_the_tasks_of_the_ps_stay_there(name: str) -> None:
    partition = load_partition(name)
    assert partition.name == name
    assert partition.side("ps") == "ps"
    assert partition.uses_pl == (name != "all_ps")


def sides(**changes: str) -> dict[str, Any]:
    return {"name": "mine", "modules": dict.fromkeys(PL_MODULES, "ps") | changes}


@pytest.mark.parametrize(
    ("raw", "says"),
    [
        (sides(fft="pl"), rf"`modules\.fft` = 'pl': no such module; allowed: {ALLOWED}"),
        (sides(ps="pl"), r"`modules\.ps` = 'pl': the PS's own tasks cannot be moved"),
        (sides(ps="ps"), r"`modules\.ps` = 'ps': the PS's own tasks cannot be moved"),
        (sides(cone_ops="gpu"), r"`modules\.cone_ops` = 'gpu': input should be 'ps' or 'pl'"),
        ({"name": "mine", "modules": {"cone_ops": "pl"}}, r"`modules` lacks matrix_update, matrix_scaling, "),
        ({"name": "mine"}, r"`modules` is missing; required here: name, description, modules"),
        ({"name": "mine", "modules": 3}, r"`modules` = 3"),
        (sides() | {"lanes": 4}, r"`lanes` = 4 is not a known key; allowed here: name, description, modules"),
        ({"modules": sides()["modules"]}, r"`name` is missing"),
        (
            sides() | {"control": "pl"},
            r'`control` = "pl": needs every module on the PL; on the PS is .*matrix_update, ',
        ),
        (sides() | {"streams": "solve"}, r"`streams` = 'solve': input should be 'stage' or 'iteration'"),
    ],
)
def test_a_bad_partition_is_refused_by_name(raw: dict[str, Any], says: str) -> None:
    with pytest.raises(PartitionError, match=says):
        parse_partition(raw)


def test_a_partition_file_is_read_and_named_in_errors(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    lines = "\n".join(f'{name} = "pl"' for name in PL_MODULES if name != "statistics")
    path.write_text(f'name = "mine"\n[modules]\n{lines}\n', encoding="utf-8")
    assert load_partition(path) == load_partition("paper").model_copy(
        update={"name": "mine", "description": ""}
    )
    path.write_text(f'name = "mine"\n[modules]\n{lines}\nfft = "pl"\n', encoding="utf-8")
    with pytest.raises(PartitionError, match=r"partition mine\.toml: `modules\.fft`"):
        load_partition(path)


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(
        PartitionError,
        match="partition 'papers' is not known; known: all_ps, factor_only, paper, paper_streams",
    ):
        load_partition("papers")
