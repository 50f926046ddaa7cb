"""Options of `orbsoc plan` do something or are refused, and what cannot be written is said before the work."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from orbsoc.commands.app import app
from orbsoc.files.output_folder import OutputFolderError, check_writable, written_at_once
from orbsoc.files.versions import __version__

REC1 = Path(__file__).resolve().parents[2] / "scenarios" / "rec1.toml"


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_version_is_printed() -> None:
    result = invoke("--version")
    assert result.exit_code == 0
    assert result.stdout.strip() == f"orbsoc {__version__}"


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (("--seed", 0), "--seed belongs to dispersed cases"),
        (("--resume",), "--resume belongs to dispersed cases"),
        (("--cases", 2, "--deadline-ms", 50, "--ps"), "--ps is for one plan"),
        (("--cases", 2, "--deadline-ms", 50, "--check", "clarabel"), "--check is for one plan"),
        (("--cases", 2, "--deadline-ms", 50, "--device", "none"), "--cases judges deadlines on a device"),
    ],
)
def test_an_option_that_would_do_nothing_is_refused(options: tuple[object, ...], complaint: str) -> None:
    result = invoke("plan", REC1, *options)
    assert result.exit_code == 2
    assert complaint in result.output


def test_cases_are_not_written_over_silently(tmp_path: Path) -> None:
    (tmp_path / "cases").mkdir()
    (tmp_path / "cases" / "case-0000.json.gz").write_bytes(b"kept")
    result = invoke("plan", REC1, "--cases", 1, "--deadline-ms", 50, "--out", tmp_path)
    assert result.exit_code == 2
    assert "holds cases already; --resume goes on with them" in result.output
    assert (tmp_path / "cases" / "case-0000.json.gz").read_bytes() == b"kept"


def test_a_place_that_cannot_be_written_is_refused_before_anything_is_solved(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    result = invoke("plan", REC1, "--device", "none", "--out", tmp_path / "file" / "out")
    assert result.exit_code == 2
    assert f"--out = {tmp_path / 'file' / 'out'}: cannot be written" in result.output
    assert "burn s" not in result.output


def test_trying_a_place_leaves_nothing_behind(tmp_path: Path) -> None:
    check_writable(tmp_path / "new" / "deep" / "out")
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_names_the_folder(tmp_path: Path) -> None:
    with (
        pytest.raises(OutputFolderError, match="out: cannot be written: No space left on device"),
        written_at_once(tmp_path / "out"),
    ):
        raise OSError(errno.ENOSPC, "No space left on device")
    assert list(tmp_path.iterdir()) == []


def test_without_a_report_there_are_the_plan_and_its_tables_alone(tmp_path: Path) -> None:
    result = invoke("plan", REC1, "--device", "none", "--no-report", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "plan.json", "attitude.csv", "orbit.oem", "orbit.opm",
    }  # fmt: skip
    idle = invoke("plan", REC1, "--cases", "2", "--no-report", "--out", tmp_path / "cases")
    assert idle.exit_code == 2
    assert "--no-report" in idle.output
