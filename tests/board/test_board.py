"""The computer for an FPGA in simulation: its parts, and a solve whose bits are the host's."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import pytest

from orbsoc import _core
from orbsoc.flight.export import default_settings
from orbsoc.soc.errors import SocError
from scripts.board import firmware, flow
from tests.board.computer import RTL, harness, printed

LIMIT = 20_000_000


@pytest.fixture(scope="module")
def image(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder with the program of the rendezvous."""
    harness()
    folder = tmp_path_factory.mktemp("image")
    firmware.firmware(firmware.rendezvous(), folder / "memory.hex")
    return folder


def test_memory_engine_and_serial_line_do_what_a_program_needs(tmp_path: Path) -> None:
    harness()
    here = Path(__file__).parent
    (tmp_path / "driver").symlink_to(RTL / "driver")
    firmware.compile_program(
        tmp_path, [here / "check.c", firmware.PROGRAM / "start.S"], tmp_path / "memory.hex", []
    )
    assert printed(tmp_path, 200_000, runs=2) == (0, ["PASS", "PASS"])


def test_the_engine_on_the_board_has_the_hosts_bits(image: Path) -> None:
    code, lines = printed(image, LIMIT)
    assert (code, lines[-1]) == (0, "PASS")
    text = "\n".join(lines)
    assert "SOLVED in 4 iterations: the recorded bits" in text
    assert f"answer {firmware.answer_hash(firmware.rendezvous())}" in lines
    assert text in (RTL.parent / "docs" / "board.md").read_text(encoding="utf-8")


def test_a_byte_begins_it_anew(image: Path) -> None:
    code, lines = printed(image, LIMIT, runs=2)
    half = len(lines) // 2
    assert (code, lines[-1], lines[:half]) == (0, "PASS", lines[half:])


def test_another_answer_than_the_hosts_is_told(image: Path, tmp_path: Path) -> None:
    """One bit of what the program expects is another."""
    problem = firmware.rendezvous()
    cold = _core.ExactEngine(problem, default_settings(32), 32).solve()
    low, high = struct.unpack("<2I", struct.pack("<d", cold.x[0]))
    text = (image / "memory.hex").read_text()
    wrong = text.replace(f"{low:08x}\n{high:08x}\n", f"{low:08x}\n{high ^ 1:08x}\n", 1)
    assert wrong != text
    (tmp_path / "memory.hex").write_text(wrong)
    code, lines = printed(tmp_path, LIMIT)
    assert (code, lines[-1]) == (1, "FAIL")
    assert "SOLVED in 4 iterations: OTHER BITS" in lines


def test_a_problem_that_the_microcode_has_no_room_for_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(firmware, "CODE_BITS", 12)
    with pytest.raises(SocError, match=r"takes \d+ lines of microcode: allowed is 4096"):
        firmware.firmware(firmware.rendezvous(), tmp_path / "memory.hex")


def ports() -> set[str]:
    """Of the top module, bit by bit."""
    header = re.search(r"\) \((.*?)\);", (RTL / "board" / "ulx3s.sv").read_text(), re.DOTALL)
    assert header
    found = set()
    for width, name in re.findall(r"(?:input|output) logic (?:\[(\d+):0\] )?(\w+)", header[1]):
        found |= {f"{name}[{bit}]" for bit in range(int(width) + 1)} if width else {name}
    return found


def test_every_port_has_a_pin_of_its_own_and_every_pin_a_port() -> None:
    pins = (RTL / "board" / "ulx3s.lpf").read_text()
    sites = dict(re.findall(r'^LOCATE COMP "(\S+)" SITE "(\S+)";', pins, re.MULTILINE))
    assert set(sites) == ports()
    assert len(set(sites.values())) == len(sites)
    assert set(re.findall(r'^IOBUF PORT "(\S+)" .*IO_TYPE=LVCMOS33\b', pins, re.MULTILINE)) == ports()
    assert re.findall(r"^FREQUENCY .*", pins, re.MULTILINE) == [
        f'FREQUENCY PORT "clk_25mhz" {flow.CLOCK_MHZ} MHZ;'
    ]


def test_the_sizes_of_the_computer_are_those_of_its_program_and_tools() -> None:
    text = (RTL / "board" / "board.sv").read_text()
    given = {name: int(value) for name, value in re.findall(r"parameter int (\w+) = (\d+)", text)}
    engine = firmware.ENGINE
    assert {name: given[name] for name in ("FP", "LANES", "BANKS", "ADDRESS_BITS", "CODE_BITS", "WORDS")} == {
        "FP": engine.fp,
        "LANES": engine.lanes,
        "BANKS": engine.banks,
        "ADDRESS_BITS": engine.address_bits,
        "CODE_BITS": firmware.CODE_BITS,
        "WORDS": flow.WORDS,
    }
    assert given["CLOCKS"] == round(flow.CLOCK_MHZ * 1e6 / 115200)
    script = (firmware.PROGRAM / "link.ld").read_text()
    assert f"LENGTH = {4 * flow.WORDS // 1024}K" in script


def test_a_step_that_is_none_is_told_in_one_line() -> None:
    with pytest.raises(SystemExit, match=r"takes netlist, routed or bitstream, not 'bits'"):
        flow.main(["bits"])
