"""`export_c`: what it writes builds, runs on other machines, keeps its bounds, and refuses bad input before it writes."""

from __future__ import annotations

import re
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

import orbsoc
from benchmarks.guidance import rendezvous
from benchmarks.recorded import first_insertions
from orbsoc import _core
from orbsoc.commands.app import app
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.flight import FlightError
from orbsoc.flight.bounds import STACK_BYTES, TEXT_BYTES
from orbsoc.flight.instructions import (
    COMPILER,
    EMULATOR,
    WORST_ITERATIONS,
    counted,
    solve_instructions,
    used_instructions,
    varied,
)
from tests.flight.c_library import FLIGHT, ROOT, STRICT, need, sources

SMALL = Problem(c=[1.0, 1.0], G=[[0.0, 0.0], [-1.0, 0.0], [0.0, -1.0]], h=[1.0, 0.0, 0.0], cones=Cones(q=[3]))
TARGETS = {
    "aarch64": (("aarch64-linux-gnu-gcc",), ("qemu-aarch64",)),
    "cortex-a9": (
        ("arm-linux-gnueabihf-gcc", "-mcpu=cortex-a9", "-mfpu=vfpv3", "-mfloat-abi=hard", "-marm"),
        ("qemu-arm", "-cpu", "cortex-a9"),
    ),
    "riscv64": (("riscv64-linux-gnu-gcc",), ("qemu-riscv64",)),
}


@pytest.fixture(scope="module", params=[64, 32])
def exported(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program of rec1's first subproblem."""
    folder = tmp_path_factory.mktemp("export") / "program"
    orbsoc.export_c(first_insertions(12, 1)[0], folder, fp=request.param)
    return folder


def command_of(folder: Path) -> list[str]:
    """The one line of the README, without its compiler, optimisation, output and run."""
    line = re.search(r"^ {4}cc (.*) -o selftest", (folder / "README.md").read_text(), re.MULTILINE)
    assert line
    words = [word for word in line[1].split() if word != "-O2"]
    at = words.index("flight/*.c")
    return (
        words[:at]
        + sorted(f"flight/{path.name}" for path in (folder / "flight").glob("*.c"))
        + words[at + 1 :]
    )


def run_selftest(folder: Path, compiler: tuple[str, ...], emulator: tuple[str, ...], *options: str) -> str:
    made = folder / f"selftest{len(list(folder.iterdir()))}"
    command = [*compiler, *STRICT[1:], *options, *command_of(folder), "-o", str(made)]
    built = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    done = subprocess.run([*emulator, str(made)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("target", TARGETS)
def test_the_selftest_has_the_recorded_bits_on_other_machines(exported: Path, target: str) -> None:
    compiler, emulator = TARGETS[target]
    need(compiler[0], emulator[0])
    assert run_selftest(exported, compiler, emulator, "-static", "-O3").count("the recorded bits") == 3


def test_the_readmes_line_builds_a_selftest_that_passes(exported: Path) -> None:
    assert run_selftest(exported, ("gcc",), (), "-O2").count("the recorded bits") == 3


def test_memory_is_used_as_the_sanitizers_ask(exported: Path) -> None:
    options = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    assert run_selftest(exported, ("gcc",), (), *options).count("the recorded bits") == 3


def test_the_library_compiles_for_a_cortex_r52(exported: Path, tmp_path: Path) -> None:
    need("arm-none-eabi-gcc")
    words = [word for word in command_of(exported) if word not in ("-lm", "selftest.c")]
    words = [str(exported / word) if word.endswith(".c") else word for word in words]
    words = [word.replace("-I", f"-I{exported}/") if word.startswith("-I") else word for word in words]
    chip = ("-mcpu=cortex-r52", "-mfloat-abi=hard", "-mfpu=neon-fp-armv8")
    done = subprocess.run(
        ["arm-none-eabi-gcc", *chip, *STRICT[1:], "-O2", "-c", *words],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_text_and_stack_are_within_the_stated_bounds(tmp_path: Path) -> None:
    need("aarch64-linux-gnu-gcc", "aarch64-linux-gnu-size")
    for fp in (64, 32):
        compile_ = ["aarch64-linux-gnu-gcc", *STRICT, "-O2", f"-DORBSOC_FP={fp}", "-fstack-usage", "-c"]
        subprocess.run([*compile_, *map(str, sources())], cwd=tmp_path, check=True)
        objects = sorted(str(path) for path in tmp_path.glob("*.o"))
        size = subprocess.run(
            ["aarch64-linux-gnu-size", *objects], capture_output=True, text=True, check=True
        )
        assert sum(int(line.split()[0]) for line in size.stdout.splitlines()[1:]) < TEXT_BYTES
        frames = [
            line.split("\t") for path in tmp_path.glob("*.su") for line in path.read_text().splitlines()
        ]
        assert all(kind == "static" for _, _, kind in frames), "no frame grows"
        # The deepest paths: through a stage to the substitution, and through the verdict to a certificate.
        largest = {name.rpartition(":")[2]: int(size_) for name, size_, _ in frames}
        stage = ("orbsoc_solve_from", "solve_with_restarts", "follow", "orbsoc_run", "solve_sides", "refine_sides",
                 "orbsoc_refine", "orbsoc_measure", "orbsoc_statistics", "substitute", "residual")  # fmt: skip
        assert sum(largest.get(name, 0) for name in stage) < STACK_BYTES
        assert sum(sorted(largest.values())[-4:]) < STACK_BYTES


def test_static_analysis_finds_nothing() -> None:
    need("cppcheck")
    done = subprocess.run(
        ["cppcheck", "--std=c99", "--enable=warning,performance,portability", "--inline-suppr", "--quiet",
         "--error-exitcode=1", f"-I{FLIGHT}", str(FLIGHT)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_deviations_from_misra_are_those_that_the_guide_gives_reasons_for() -> None:
    need("cppcheck")
    text = (ROOT / "docs" / "flight-code.md").read_text()
    table = text[text.index("Deviations from MISRA") : text.index("## On a board")]
    known = {
        rule for row in re.findall(r"^\| ([\d., ]+) \|", table, re.MULTILINE) for rule in row.split(", ")
    }
    done = subprocess.run(
        ["cppcheck", "--addon=misra", "--std=c99", "--quiet", "-DORBSOC_FP=64", "-DORBSOC_INDEX_BITS=16",
         "-DFLT_EVAL_METHOD=0", f"-I{FLIGHT}", str(FLIGHT)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    found = set(re.findall(r"misra-c2012-(\d+\.\d+)", done.stderr))
    assert found, "the addon ran"
    assert found <= known, sorted(found - known)


def test_the_library_in_the_wheel_is_that_of_the_sources() -> None:
    written = {path.name: path.read_text() for path in FLIGHT.iterdir() if path.suffix in (".c", ".h")}
    assert _core.flight_sources() == written


def test_the_driver_in_the_wheel_is_that_of_the_sources() -> None:
    folder = ROOT / "rtl" / "driver"
    assert _core.driver_sources() == {path.name: path.read_text() for path in folder.iterdir()}


def test_the_command_exports_a_partition_and_names_what_it_refuses(tmp_path: Path) -> None:
    SMALL.save(tmp_path / "small.json")
    begin = ["export", "c", str(tmp_path / "small.json"), "--out", str(tmp_path / "c"), "--partition"]
    for more, words in (
        (["other"], "other"), (["paper", "--engine", "lanes"], "'lanes'"), (["paper", "--engine", "lines=2"], "'lines=2'"),
        (["paper", "--microcode", "dense"], "'dense'"), (["paper", "--engine", "banks=3"], "banks"),
        (["all_ps", "--limit-clocks", "9"], "limit_clocks = 9: the partition has nothing on the PL to stop"),
    ):  # fmt: skip
        done = CliRunner().invoke(app, [*begin, *more])
        assert done.exit_code == 2, more
        assert words in done.output
        assert not (tmp_path / "c").exists()
    shape = ["--engine", "lanes=1,banks=4", "--microcode", "compressed", "--limit-clocks", "77777"]
    done = CliRunner().invoke(app, [*begin, "resident", *shape])
    assert done.exit_code == 0, done.output
    assert "program_buffers, flag, 77777u};" in (tmp_path / "c" / "pl_program.c").read_text()
    assert run_selftest(tmp_path / "c", ("gcc",), (), "-O2").count("the recorded bits") == 3
    assert (tmp_path / "c" / "driver" / "orbsoc_device.c").exists()
    assert "orbsoc_pl_attach" in (tmp_path / "c" / "README.md").read_text()


def test_the_library_has_neither_heap_nor_global_state() -> None:
    text = "\n".join(path.read_text() for path in sources())
    assert not re.search(r"\b(malloc|calloc|realloc|free|alloca)\(", text)
    assert not re.search(r"^static (?!const|inline)[^(]*=", text, re.MULTILINE)
    every = text + "".join(path.read_text() for path in FLIGHT.glob("*.h"))
    assert set(re.findall(r"#include <(.*?)>", every)) == {"float.h", "math.h", "stddef.h", "stdint.h"}
    # Of the mathematics, what every machine rounds the same: roots and magnitudes.
    assert set(re.findall(r"\b(sin|cos|tan|exp|log|pow|cbrt|hypot|fmod|fma|floor|ceil)f?\(", every)) == set()


def test_lines_are_at_most_100_columns() -> None:
    wide = [
        line for path in FLIGHT.glob("*.[ch]") for line in path.read_text().splitlines() if len(line) > 100
    ]
    assert wide == []


def test_the_lists_and_the_restart_policy_are_the_methods() -> None:
    text = (FLIGHT / "method.c").read_text()
    stages = {f"STAGE_{name.upper()}": name for name in _core.stages()}
    lists = {
        "startup": _core.startup(), "warm_startup": _core.warm_startup(), "iteration": _core.iteration(),
        "closing": _core.closing(),
    }  # fmt: skip
    for name, steps in lists.items():
        body = re.search(rf"orbsoc_step {name}\[\] = {{(.*?)}};", text, re.DOTALL)
        assert body
        pairs = re.findall(r"ONCE\((\w+)\)|\{(\w+), (\w+)\}", body[1])
        assert [(stages[a],) if a else (stages[b], stages[c]) for a, b, c in pairs] == steps
    header = (FLIGHT / "method.h").read_text()
    numbered = re.findall(r"STAGE_\w+", header[: header.index("ORBSOC_STAGES")])
    assert [stages[name] for name in numbered] == list(_core.stages())
    rows = re.search(r"orbsoc_restarts\[ORBSOC_RESTARTS\] = {(.*?)};", text, re.DOTALL)
    assert rows
    found = re.findall(r"\{([^{}]*)\}", rows[1])
    for row, policy in zip(found, _core.restarts(), strict=True):
        after, stalled, _, attempt, refinement, regularization = (part.strip() for part in row.split(","))
        assert re.findall(r"ATTEMPT_(\w+)", after) == [name.upper() for name in policy.after]
        assert (stalled == "1", attempt) == (policy.stalled, f"ATTEMPT_{policy.attempt.upper()}")
        factors = policy.refinement_factor, policy.regularization_factor
        assert (float(refinement), float(regularization)) == factors


def test_tables_of_rec1_are_below_100_kb(exported: Path) -> None:
    assert sum((exported / name).stat().st_size for name in ("pattern.c", "pattern.h")) < 100_000


def test_bad_input_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    taken = tmp_path / "taken"
    taken.mkdir()
    with pytest.raises(FlightError, match="exists already"):
        orbsoc.export_c(SMALL, taken)
    assert list(taken.iterdir()) == []
    with pytest.raises(FlightError, match="allowed is 64 or 32"):
        orbsoc.export_c(SMALL, tmp_path / "none", fp=16)
    assert not (tmp_path / "none").exists()


def test_the_command_exports_a_problem_file_and_refuses_missions_without_c(tmp_path: Path) -> None:
    SMALL.save(tmp_path / "small.json")
    done = CliRunner().invoke(
        app, ["export", "c", str(tmp_path / "small.json"), "--out", str(tmp_path / "c")]
    )
    assert done.exit_code == 0, done.output
    assert run_selftest(tmp_path / "c", ("gcc",), (), "-O2").count("the recorded bits") == 3
    scenario = ROOT / "scenarios" / "paper001_equal.toml"
    done = CliRunner().invoke(app, ["export", "c", str(scenario), "--out", str(tmp_path / "none")])
    assert done.exit_code == 2
    assert "has no program in C" in done.output
    (tmp_path / "cones.json").write_text((tmp_path / "small.json").read_text().replace('"q"', '"exp"'))
    done = CliRunner().invoke(
        app, ["export", "c", str(tmp_path / "cones.json"), "--out", str(tmp_path / "none")]
    )
    assert done.exit_code == 2
    assert not (tmp_path / "none").exists()


def test_bounds_in_instructions_are_met_and_hold_for_other_data(tmp_path: Path) -> None:
    """Bounds of a pattern against data sets that they were not taken from, and against an attempt made in full."""
    need(COMPILER, EMULATOR, "gcc")
    problem, settings = rendezvous(6, 0), Settings()
    orbsoc.export_c(problem, tmp_path / "c", instructions=True)
    page = (tmp_path / "c" / "BOUNDS.md").read_text()
    stated = {
        name: int(count) for name, count in re.findall(r"^\| (\w+) \| \d+ \| (\d+) \|$", page, re.MULTILINE)
    }
    around = re.search(r"\(begin (\d+), load_point (\d+), conclude (\d+), restart (\d+)\)", page)
    assert around
    stated |= dict(
        zip(("begin", "load_point", "conclude", "restart"), map(int, around.groups()), strict=True)
    )
    seen = counted(tmp_path, varied(problem, 5, seed=1), settings, 64, "stages")
    assert set(seen.runs) == set(stated)
    for stage, runs in seen.runs.items():
        assert 0.98 * stated[stage] - 2 <= max(runs) <= stated[stage], stage
    full = counted(tmp_path, [problem], settings, 64, "worst").runs["worst"][0]
    short = replace(settings, max_iterations=WORST_ITERATIONS)
    assert 0.98 <= full / solve_instructions(stated, short, 1, warm=False) <= 1.0
    solved = counted(tmp_path, varied(problem, 10, seed=2), settings, 64, "solves")
    for k, outcome in enumerate(solved.outcomes):
        taken = solved.runs["solve_from" if k % 2 else "solve"][k // 2]
        assert taken <= used_instructions(stated, outcome, warm=k % 2 == 1)
