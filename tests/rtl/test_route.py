"""The record of place and route is of this RTL and of the pinned tools, and the presets' clocks are its own."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from hw_model.platform.platform import load_platform, platform_names
from scripts import record_route
from tests.rtl.verilator import require_route_tools

ROOT = Path(__file__).resolve().parents[2]
DOCUMENT = json.loads(record_route.RECORD.read_text())
ROWS: list[dict[str, Any]] = DOCUMENT["rows"]
OURS = [row for row in ROWS if row["module"] != "picorv32_axi"]


def test_every_row_is_of_the_rtl_as_it_is() -> None:
    old = {row["module"] for row in OURS if row["source"] != record_route.source_of(row["module"]).digest}
    assert not old, f"{old}: `make route` places and routes them again"


def test_every_row_is_made_by_the_pinned_tools() -> None:
    lock = (ROOT / "requirements" / "route.txt").read_text()
    pins = dict(re.findall(r"^([\w.-]+)==(\S+)$", lock, re.MULTILINE))
    for row in ROWS:
        assert row["tools"] == {tool: pins[tool] for tool in row["tools"]}


def test_the_page_shows_the_record() -> None:
    page = record_route.PAGE.read_text()
    assert record_route.with_table(page) == page


@pytest.mark.parametrize("unit", ["fp_add", "fp_mul"])
def test_a_unit_routed_anew_has_the_clock_on_record(unit: str) -> None:
    """To the cell and the tenth of a megahertz: the tools are the same machine code everywhere."""
    require_route_tools()
    key = ("ecp5_85_8", unit, "EXP=8 MAN=23", 1)
    (row,) = (row for row in ROWS if record_route.key_of(row) == key)
    made = record_route.routed(*key)
    assert made == {name: row[name] for name in made}


@pytest.mark.parametrize("device", record_route.PUBLISHED_MHZ)
def test_a_devices_clock_is_scaled_from_the_record(device: str) -> None:
    clock = load_platform(device).pl.clock_mhz
    assert clock.tag == "scaled"
    assert (clock.low, clock.value, clock.high) == record_route.scaled_clock_mhz(device, ROWS)


@pytest.mark.parametrize("device", platform_names())
def test_no_device_has_a_bare_clock(device: str) -> None:
    clock = load_platform(device).pl.clock_mhz
    assert clock.low is not None, device
    assert clock.high is not None, device


def test_a_devices_clock_lies_between_the_engines_own_and_what_a_small_core_gains() -> None:
    rows = [
        {"part": "ecp5_85_8", "module": module, "mhz": mhz}
        for module, mhz in (
            ("engine", 90.0),
            ("engine", 100.0),
            ("picorv32_axi", 178.5),
            ("picorv32_axi", 200.0),
        )
    ]
    assert record_route.scaled_clock_mhz("zu9eg", rows) == (90, 180, 360)


def test_clocks_are_written_into_the_devices_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for device in record_route.PUBLISHED_MHZ:
        shutil.copy(record_route.DEVICES / f"{device}.toml", tmp_path)
    monkeypatch.setattr(record_route, "DEVICES", tmp_path)
    rows = [
        {"part": "ecp5_85_8", "module": module, "mhz": mhz}
        for module, mhz in (("engine", 90.0), ("picorv32_axi", 178.5))
    ]
    for _ in range(2):  # again, over the first
        record_route.write_clocks(rows)
        clock = load_platform(tmp_path / "zu9eg.toml").pl.clock_mhz
        assert (clock.low, clock.value, clock.high, clock.tag) == (90.0, 180.0, 360.0, "scaled")
