"""The AXI slaves (rtl/axi) under random traffic on all channels, against plain models of engine and memories; and slaves that
are wrong in one place, which the same traffic must notice (V5)."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

from orbsoc.rtl.digest import program_digest
from tests.rtl.engine_sources import RTL, build
from tests.rtl.verilator import require_verilator

WORDS = {"ENGINE_WORD": 0x01010184, "SIZES_WORD": 0x12345678, "IDENTITY_WORD": 0x23456789}
"""What the harness (rtl/harness/axi_traffic.cpp) expects of the wrapper's constant registers."""
F64 = {"FP": 64, "ADDRESS_BITS": 6, "CODE_BITS": 3, "CODE_WIDTH": 100} | WORDS
F32 = {"FP": 32, "ADDRESS_BITS": 6, "WORDS": 50, "CODE_BITS": 3, "CODE_WIDTH": 150} | WORDS
"""Small memories, so that bursts meet their ends; five pieces of a line leave three of padding."""
CLOCKS = 100_000
SEEDS = range(1, 6)
COUNT = re.compile(r"^([\w' ]+) (\d+)$", re.MULTILINE)
KINDS = (
    "register writes", "register writes with strobes missing", "writes to RESET", "register reads", "reads of the wrapper's registers",
    "write bursts", "write bursts with an error within", "write bursts refused by a running engine", "refused write bursts",
    "read bursts", "read bursts refused by a running engine", "refused read bursts",
    "writes to LIMIT", "launches stopped by their limit", "words of storage written", "words of storage read", "lines of microcode written", "templates written",
)  # fmt: skip


def traffic(
    harness: Path, seed: int, clocks: int = CLOCKS, *options: str
) -> subprocess.CompletedProcess[str]:
    command = [harness, str(seed), str(clocks), *options]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("shape", [F64, F32], ids=["binary64", "binary32"])
def test_random_traffic_meets_the_plain_models_and_the_rules_of_axi(shape: dict[str, int]) -> None:
    require_verilator()
    harness = build("axi_slaves", **shape)
    for seed in SEEDS:
        done = traffic(harness, seed)
        assert done.returncode == 0, done.stdout
        counts = {what: int(count) for what, count in COUNT.findall(done.stdout)}
        assert [kind for kind in KINDS if counts.get(kind, 0) < 40] == []


def test_bursts_of_sixteen_beats_take_the_clocks_of_the_documentation() -> None:
    require_verilator()
    found = {}
    for name, shape in (("f64", F64), ("f32", F32)):
        done = subprocess.run(
            [build("axi_slaves", **shape), "timing"], capture_output=True, text=True, check=True
        )
        clocks = re.findall(r"^clocks (.+) (\d+)$", done.stdout, re.MULTILINE)
        found |= {f"{what}, {name}": int(count) for what, count in clocks}
    documented = re.findall(
        r"^\| 16 beats: (.+?) \| (\d+) \|$", (RTL.parent / "docs" / "driver.md").read_text(), re.MULTILINE
    )
    assert found == {what: int(count) for what, count in documented}


@pytest.mark.parametrize(
    ("shape", "pieces", "stride"), [(F64, 4, 4), (F32, 5, 8)], ids=["binary64", "binary32"]
)
def test_the_digest_is_that_of_the_words_whatever_the_size_of_a_beat(
    shape: dict[str, int], pieces: int, stride: int
) -> None:
    require_verilator()
    done = subprocess.run(
        [build("axi_slaves", **shape), "timing"], capture_output=True, text=True, check=True
    )
    found = {what: int(word) for what, word in re.findall(r"^digest (.+) (\d+)$", done.stdout, re.MULTILINE)}
    written = {  # beat i holds i: as two pieces, or as one in the half that its address names
        "microcode written by 8 bytes": [word for beat in range(16) for word in (beat, 0)],
        "microcode written by 4 bytes": [beat if beat % 2 == 0 else 0 for beat in range(16)],
    }
    for what, words in written.items():
        lines = [words[at : at + pieces] for at in range(0, len(words), stride)]
        assert found[what] == program_digest([], lines), what


def test_the_core_file_lists_all_of_the_rtl_and_the_list_elaborates() -> None:
    require_verilator()
    listed = re.findall(r"^      - ([\w/.]+)", (RTL / "orbsoc.core").read_text(), re.MULTILINE)
    folders = (RTL, RTL / "fpu", RTL / "engine", RTL / "axi")
    assert sorted(listed) == sorted(
        str(path.relative_to(RTL)) for folder in folders for path in folder.glob("*.sv*")
    )
    sources = [file for file in listed if file.endswith(".sv")]
    command = ["verilator", "--lint-only", "-Wall", "-Wno-UNUSED", "-I.", "--top-module", "axi_engine"]
    done = subprocess.run([*command, *sources], cwd=RTL, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@dataclass(frozen=True)
class Wrong:
    """One expression of one file of the slaves, and what is there instead; `before` it stands what makes the place unique."""

    file: str
    before: str
    right: str
    instead: str


MUTATIONS = {
    "B dropped": Wrong("burst_write", "state <= ", "ANSWER", "len[0] ? ANSWER : ADDRESS"),
    "a beat read twice": Wrong("burst_read", "if (", "completes", "completes && !(more == 8'd3 && rid[0])"),
    "a piece's address off by one": Wrong(
        "burst_write", "piece_address = {", "address[REGION_BITS+1:3]", "address[REGION_BITS+1:3] + (REGION_BITS - 1)'(last_beat && bid[0])"
    ),
    "no room kept for beats under way": Wrong("burst_read", "credit = ", "!under_way[DEPTH_BITS]", "1'b1"),
    "a register write twice on the bus": Wrong(
        "registers", "bus_write <= ", "take_write && !kept_address", "(take_write && !kept_address) || (bus_write && bus_value[4:0] == '1)"
    ),
    "a register write answered before it is done": Wrong("lite_slave", "answered = ", "write_done || (both && !whole)", "both"),
    "a register write that does not wait for storage": Wrong("registers", "idle && write_wanted && ", "quiet", "1'b1"),
    "a read that does not wait for the last write": Wrong("memory_port", "open && read_valid && ", "settling == '0", "1'b1"),
    "storage written while the engine runs": Wrong("memory_port", "piece_take = ", "piece_ready && !running", "piece_ready"),
    "a word of halves of different words": Wrong("word_pieces", "place == next && ", "this_word == begun", "1'b1"),
    "the upper half of a beat left out": Wrong("word_pieces", "pair && after == PLACE'(i)) word[32*i+:32] <= ", "upper", "value"),
    "a beat taken before the one it follows has ended": Wrong("burst_write", "upper || !halves[1] || ", "piece_pair", "1'b1"),
    "halves of two words taken as one": Wrong("burst_write", "piece_pair = ", "wide", "1'b1"),
    "a word begun before a run completed after it": Wrong("word_pieces", "if (reset || ", "drop", "1'b0"),
    "a write to the digest reaches the engine": Wrong("registers", "kept_address = reset_address || ", "write_address == DIGEST", "1'b0"),
    "a launch stopped a clock late": Wrong("limit", "limit != '0 && ", "next >= limit", "next > limit"),
    "the end of a launch behind an access overlooked": Wrong("limit", "is_status ? status_busy : was_busy && ", "!irq", "1'b1"),
    "a stopped engine reset for one clock": Wrong("limit", "hold = trip || ", "first", "1'b0"),
    "an access to an engine that is being stopped": Wrong("registers", "!reading && !resetting && !engine_reset && ", "!over", "1'b1"),
    "a limit that STATUS does not tell": Wrong("registers", "stopped && !own && ", "bus_address == STATUS", "1'b0"),
    "a limit that stays told after a reset": Wrong("limit", "if (", "restart", "1'b0"),
    "a write to the limit reaches the engine": Wrong("registers", " || ", "write_address == LIMIT", "1'b0"),
    "register reads that starve under writes": Wrong("registers", "!(read_wanted && ", "last_write", "1'b0"),
}  # fmt: skip


@pytest.fixture(scope="module")
def mutants(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One harness with every mutation in it, each of which `+mutant_N` turns on."""
    require_verilator()
    copy = tmp_path_factory.mktemp("mutants") / "rtl"
    shutil.copytree(RTL, copy)
    for number, wrong in enumerate(MUTATIONS.values()):
        path = copy / "axi" / f"axi_{wrong.file}.sv"
        text = path.read_text()
        assert text.count(wrong.before + wrong.right) == 1, wrong
        either = f'($test$plusargs("mutant_{number:02}") ? ({wrong.instead}) : ({wrong.right}))'
        path.write_text(text.replace(wrong.before + wrong.right, wrong.before + either))
    return build("axi_slaves", rtl=copy, **F64)


@pytest.mark.parametrize("name", MUTATIONS)
def test_a_mutation_of_the_slaves_is_caught(name: str, mutants: Path) -> None:
    option = f"+mutant_{list(MUTATIONS).index(name):02}"
    runs = (traffic(mutants, seed, CLOCKS, option) for seed in SEEDS)
    assert any(done.returncode == 1 and "fault " in done.stdout for done in runs)


def test_the_slaves_with_no_mutation_turned_on_pass_the_same_traffic(mutants: Path) -> None:
    assert traffic(mutants, 1, 20_000).returncode == 0
