"""Validation cases for the RTL harness (docs/pl-machine.md, Validation cases), and its answers."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

from tests.rtl.engine_sources import RTL, build
from tests.rtl.machine import Machine

_RUN = re.compile(r"run (\S+) cycles (\d+) expected (\d+) different (\d+) asserted (\d+)((?:\n(?!run ).*)*)")


@dataclass
class Case:
    """Microcode of several runs, one after the other, and what each must give."""

    machine: Machine
    form: str = "flat"
    code: list[int] = field(default_factory=list)
    templates: list[int] = field(default_factory=list)
    runs: list[str] = field(default_factory=list)

    def add(
        self,
        name: str,
        code: list[int],
        cycles: int,
        memory: dict[int, int],
        expect: dict[int, int],
        gaps: tuple[int, int] | None = None,
    ) -> None:
        """One run; `gaps` is (seed, level) for the in-order sequencer."""
        lines = [f"run {name} start {len(self.code)} words {len(code)} cycles {cycles}"]
        lines += [f"gaps seed {gaps[0]} level {gaps[1]}"] if gaps else []
        for key, words in (("memory", memory), ("expect", expect)):
            lines += [f"{key} {len(words)}", *(f"{at:x} {word:x}" for at, word in words.items())]
        self.runs.append("\n".join([*lines, "end"]))
        self.code += code

    def text(self) -> str:
        m = self.machine
        units = f"config fp {m.fp} lanes {m.lanes} dividers {m.dividers}"
        config = f"{units} banks {m.banks} clusters {m.clusters} address_bits {m.address_bits}"
        lines = ["orbsoc-pl-case 1", config, f"format {self.form}"]
        if self.form == "compressed":
            lines += [f"templates {len(self.templates)}", *(f"{template:x}" for template in self.templates)]
        lines += [f"microcode {len(self.code)}", *(f"{word:x}" for word in self.code)]
        return "\n".join([*lines, *self.runs, ""])


@dataclass(frozen=True)
class Answer:
    """What the RTL did in one run."""

    cycles: int
    expected: int
    different: int
    violated: tuple[str, ...]
    signals: tuple[str, ...] = ()
    """What counter, status or interrupt said that they must not."""

    @property
    def good(self) -> bool:
        equal = self.cycles == self.expected and not self.different
        return equal and not self.violated and not self.signals


def run_case(case: Case, folder: Path, rtl: Path = RTL) -> dict[str, Answer]:
    """Every run of the case on the RTL, by name. Its exit status must agree with its lines."""
    executable = build("engine", rtl=rtl, **case.machine.build_options(case.form))
    path = folder / "case.txt"
    path.write_text(case.text())
    done = subprocess.run([executable, path], capture_output=True, text=True, check=False)
    assert done.returncode in (0, 1), done.stderr
    answers = {
        name: Answer(
            int(cycles),
            int(expected),
            int(different),
            tuple(re.findall(r"assert (\w+)", rest)),
            tuple(re.findall(r"^(?:counter|status) .*", rest, re.MULTILINE)),
        )
        for name, cycles, expected, different, _, rest in _RUN.findall(done.stdout)
    }
    assert len(answers) == len(case.runs), done.stdout
    assert (done.returncode == 0) == all(answer.good for answer in answers.values()), done.stdout
    return answers
