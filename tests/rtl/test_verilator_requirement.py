"""What a test of the RTL does without Verilator."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.rtl.verilator import require_verilator


@pytest.fixture
def path_without_verilator(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("PATH", str(tmp_path))
    return tmp_path


@pytest.mark.usefixtures("path_without_verilator")
def test_without_verilator_a_test_is_skipped_with_the_package_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("ORBSOC_REQUIRE_RTL", raising=False)
    with pytest.raises(pytest.skip.Exception, match="apt install verilator"):
        require_verilator()


@pytest.mark.usefixtures("path_without_verilator")
def test_where_the_rtl_is_required_the_skip_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ORBSOC_REQUIRE_RTL", "1")
    with pytest.raises(pytest.fail.Exception, match="apt install verilator"):
        require_verilator()


def test_an_installed_verilator_is_used(path_without_verilator: Path) -> None:
    tool = path_without_verilator / "verilator"
    tool.write_text("#!/bin/sh\n")
    tool.chmod(0o755)
    assert require_verilator() == tool
