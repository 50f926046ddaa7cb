"""An output folder is complete or absent, and never replaces what orbsoc did not write."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from orbsoc.files.output_folder import OutputFolderError, check_replaceable, write_manifest, written_at_once


def write(folder: Path, content: str, names: tuple[str, ...] = ("a.txt",)) -> None:
    with written_at_once(folder) as place:
        for name in names:
            (place / name).write_text(content)
        write_manifest(place, {"content": content})


def test_folder_appears_with_a_manifest_of_its_files(tmp_path: Path) -> None:
    folder = tmp_path / "deep" / "out"
    write(folder, "one", ("b.txt", "a.txt"))
    document = json.loads((folder / "plan.json").read_text())
    assert document["schema"] == "orbsoc.plan/1"
    assert document["files"] == ["a.txt", "b.txt", "plan.json"]
    assert [path.name for path in folder.parent.iterdir()] == ["out"]


def test_earlier_output_is_replaced_whole(tmp_path: Path) -> None:
    write(tmp_path / "out", "one", ("a.txt", "only_in_one.txt"))
    write(tmp_path / "out", "two")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["a.txt", "plan.json"]
    assert (tmp_path / "out" / "a.txt").read_text() == "two"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError("boom"), MemoryError])
@pytest.mark.parametrize("exists", [False, True])
def test_nothing_is_left_after_an_error_or_ctrl_c(
    tmp_path: Path, error: type[BaseException] | BaseException, exists: bool
) -> None:
    folder = tmp_path / "out"
    if exists:
        write(folder, "one")

    def fail() -> None:
        with written_at_once(folder) as place:
            (place / "a.txt").write_text("half")
            write_manifest(place, {})
            raise error

    with pytest.raises(error if isinstance(error, type) else type(error)):
        fail()
    assert [path.name for path in tmp_path.iterdir()] == (["out"] if exists else [])
    if exists:
        assert (folder / "a.txt").read_text() == "one"


def test_foreign_files_folders_and_links_are_refused(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    write(folder, "one")
    (folder / "notes.md").write_text("mine")
    with pytest.raises(OutputFolderError, match=r"holds notes\.md, which orbsoc did not write"):
        write(folder, "two")
    assert (folder / "a.txt").read_text() == "one"

    other = tmp_path / "other"
    other.mkdir()
    (other / "plan.json").write_text('{"schema": "something/1", "files": ["plan.json"]}')
    with pytest.raises(OutputFolderError, match=r"holds plan\.json"):
        check_replaceable(other)

    file = tmp_path / "file"
    file.write_text("")
    with pytest.raises(OutputFolderError, match="not a folder"):
        check_replaceable(file)
    link = tmp_path / "link"
    link.symlink_to(folder)
    with pytest.raises(OutputFolderError, match="not a folder"):
        check_replaceable(link)


def test_empty_folder_is_replaced_and_a_path_through_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    write(tmp_path / "out", "one")
    assert (tmp_path / "out" / "a.txt").read_text() == "one"
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputFolderError, match="cannot be written"):
        write(tmp_path / "file" / "out", "one")


def test_file_that_arrives_while_writing_is_not_lost(tmp_path: Path) -> None:
    folder = tmp_path / "out"

    def late() -> None:
        with written_at_once(folder) as place:
            write_manifest(place, {})
            folder.mkdir()
            (folder / "mine.txt").write_text("mine")

    with pytest.raises(OutputFolderError, match=r"mine\.txt"):
        late()
    assert (folder / "mine.txt").read_text() == "mine"


def test_document_with_nan_is_refused_before_it_is_in_place(tmp_path: Path) -> None:
    def nan() -> None:
        with written_at_once(tmp_path / "out") as place:
            write_manifest(place, {"x": float("nan")})

    with pytest.raises(ValueError, match="not JSON compliant"):
        nan()
    assert list(tmp_path.iterdir()) == []
