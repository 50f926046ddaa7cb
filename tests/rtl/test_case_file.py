"""Damaged case files: the harness refuses each by the token at fault, and runs nothing."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from tests.rtl.case_writer import Case
from tests.rtl.engine_sources import build
from tests.rtl.machine import Machine, busy_cycles, encode, evaluate, random_program, schedule
from tests.rtl.verilator import require_verilator

MACHINE = Machine(fp=32, lanes=1, banks=4, address_bits=10)
FLAT_BITS = 1 + (4 * 10 + 4) + (3 * 10 + 2)


@cache
def good(form: str = "flat") -> str:
    """Two runs of thirty operations, under a sequencer's name; the words are those of flat microcode."""
    case = Case(MACHINE, form)
    for seed in range(2):
        ops, memory = random_program(MACHINE, 30, seed)
        slots = schedule(MACHINE, ops)
        words = 1 + max(slot.time for slot in slots)
        code, cycles = encode(MACHINE, slots, words), busy_cycles(MACHINE, slots, words)
        gaps = (1, 0) if form == "in_order" else None
        case.add(f"random{seed}", code, cycles, memory, evaluate(MACHINE, ops, memory), gaps)
    return case.text()


def line(text: str, start: str, offset: int = 0) -> str:
    """The line that begins so, or one after it."""
    lines = text.splitlines()
    return lines[offset + next(k for k, found in enumerate(lines) if found.startswith(start))]


def run(text: str, folder: Path, form: str = "flat") -> subprocess.CompletedProcess[str]:
    harness = build("engine", **MACHINE.build_options(form))
    path = folder / "damaged.case"
    path.write_text(text)
    return subprocess.run([harness, path], capture_output=True, text=True, check=False, timeout=60)


def code_line(word: str) -> Callable[[str], str]:
    def damage(text: str) -> str:
        head = line(text, "microcode")
        return text.replace(f"{head}\n{line(text, 'microcode', 1)}\n", f"{head}\n{word}\n", 1)

    return damage


def first_word(of: str, damaged: str) -> Callable[[str], str]:
    """The first line of a list, with `address` and `word` of the line as it was to choose from."""

    def damage(text: str) -> str:
        head, found = line(text, of), line(text, of, 1)
        address, word = found.split()
        return text.replace(
            f"{head}\n{found}\n", f"{head}\n{damaged.format(address=address, word=word)}\n", 1
        )

    return damage


def field(name: str, change: int | str) -> Callable[[str], str]:
    """A number of the first run: another one, or so much more."""

    def damage(text: str) -> str:
        head = line(text, "run random0").split()
        at = head.index(name) + 1
        before = " ".join(head)
        head[at] = change if isinstance(change, str) else str(int(head[at]) + change)
        return text.replace(before, " ".join(head))

    return damage


DAMAGES = {
    "microcode too wide": (
        code_line(f"{1 << FLAT_BITS:x}"),
        f"'{1 << FLAT_BITS:x}' has {FLAT_BITS + 1} bits",
    ),
    "microcode no number": (code_line("12x4"), "'12x4' is not a number of base 16"),
    "microcode with a prefix": (code_line("0x12"), "'0x12' is not a number of base 16"),
    "expected beyond the storage": (
        first_word("expect", "400 {word}"),
        "address '400' is beyond the storage",
    ),
    "memory beyond the storage": (first_word("memory", "400 {word}"), "address '400' is beyond the storage"),
    "expected too wide": (first_word("expect", "{address} 100000000"), "'100000000' is wider than 32 bits"),
    "memory too wide": (first_word("memory", "{address} 100000000"), "'100000000' is wider than 32 bits"),
    "memory negative": (first_word("memory", "{address} -1"), "'-1' is not a number"),
    "memory beyond 64 bits": (first_word("memory", "{address} 10000000000000000"), "more than 64 bits"),
    "start beyond the microcode": (field("start", "100000"), "start '100000' is beyond the microcode"),
    "start within a run": (field("start", 1), "start '1' is where no run ends"),
    "a word fewer": (field("words", -1), "end where no run starts"),
    "a word more": (field("words", 1), "end where no run starts"),
    "no words": (field("words", "0"), "words '0': allowed is 1 to"),
    "words beyond the microcode": (field("words", "100000"), "words '100000': allowed is 1 to"),
    "cycles no number": (field("cycles", "12.5"), "'12.5' is not a number of base 10"),
    "cut short": (lambda text: text[: len(text) // 2].rsplit("\n", 1)[0], "the case ends too early"),
}


def test_the_case_as_it_is_passes(tmp_path: Path) -> None:
    require_verilator()
    done = run(good(), tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("name", DAMAGES)
def test_a_damaged_case_is_refused_by_its_token(name: str, tmp_path: Path) -> None:
    require_verilator()
    damage, said = DAMAGES[name]
    damaged = damage(good())
    assert damaged != good()
    done = run(damaged, tmp_path)
    assert done.returncode == 2, done.stdout
    assert said in done.stderr
    assert "run " not in done.stdout


@pytest.mark.parametrize(
    ("gaps", "said"),
    [("seed 0 level 0", "seed '0'"), ("seed 1 level 256", "level '256': allowed is 0 to 255")],
)
def test_gaps_without_end_are_refused(gaps: str, said: str, tmp_path: Path) -> None:
    require_verilator()
    done = run(good("in_order").replace("seed 1 level 0", gaps), tmp_path, "in_order")
    assert done.returncode == 2
    assert said in done.stderr


def test_a_word_that_no_run_expects_must_stay_as_it_was(tmp_path: Path) -> None:
    """Of a program that writes a word, the list of expected words forgets it."""
    require_verilator()
    text = good()
    changed = next(
        found
        for found in text.split("expect ", 1)[1].splitlines()[1:]
        if found not in text.split("memory ", 1)[1].split("expect ", 1)[0].splitlines()
    )
    count = int(line(text, "expect").split()[1])
    before, after = text.split("expect ", 1)
    rest = after.replace(f"{count}\n", f"{count - 1}\n", 1).replace(f"\n{changed}\n", "\n", 1)
    done = run(f"{before}expect {rest}", tmp_path)
    assert done.returncode == 1, done.stderr
    assert "different 1 asserted 0" in done.stdout
