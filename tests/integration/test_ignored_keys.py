"""No parameter is ignored in silence: under every command, changing a key changes the report, or it is refused.

What a report echoes is taken out before it is compared: a key that changes only its own echo counts as ignored.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from hw_model import load_partition, load_platform
from hw_model.platform.platform_toml import to_toml
from orbsoc.commands.app import app
from orbsoc.commands.hw_precision import ALL
from orbsoc.hw.workload import load_workload
from tests.integration.small_problem import small_problem

KEYS = [key for key, _ in load_platform("zu9eg").parameters() if not key.startswith("pl.latencies.")]
KEYS += ["pl.latency_preset", "runtime.preset"]

# Two values a key, so that one of them is felt: few cores or ports bind at one end only.
OTHERS: dict[str, tuple[object, ...]] = {
    "pl.latency_preset": ("vendor_ip",), "runtime.preset": ("linux",), "runtime.completion": ("polling",),
    "ps.price": ("executed_instructions",), "runtime.schedule": ("overlapped",), "pl.microcode_format": ("flat",), "pl.lanes": (2, 16), "pl.banks": (2, 64), "ps.overlap": (0.0, 1.0),
    "pl.dividers": (2, 4), "runtime.cores_used": (3, 4), "ps.cores": (1,), "ps.cache_line_bytes": (16, 256),
    "ps.parallel_fraction": (0.5, 1.0), "link.ddr_efficiency": (0.001, 1.0), "link.flags_per_register": (1, 64),
    "resources.uram": (3,), "pl.storage_memory": ("ultra_ram",), "pl.storage_depth": ("exact",), "pl.parity": ("per_word",), "pl.microcode_memory": ("streamed", "ultra_ram"),
    "pl.microcode_compression": (1.5, 40.0), "pl.overlap_exponent": (1.0, 40.0), "runtime.jitter_exponent": (1.0,),
}  # fmt: skip


def values_of(key: str) -> tuple[object, ...]:
    """Values that differ from the default, far to both sides."""
    if key in OTHERS:
        return OTHERS[key]
    section, _, name = key.partition(".")
    was = getattr(getattr(load_platform("zu9eg"), section), name).value
    if section == "resources":
        return (3,)  # less than anything takes, so that this one is the tightest
    if name.endswith("ceiling"):
        return (1e-4,)
    if isinstance(was, int):
        return max(1, was // 3), 3 * was + 1
    return (max(1e-3, was / 20), min(900.0, 20 * was)) if was else (10.0,)


@pytest.fixture(scope="module")
def workload(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("keys")
    small_problem().save(folder / "small.json")
    # Buffers are small here: a DMA that starts sooner pays for some of them, each way.
    quick = load_platform("zu9eg").with_values(
        {"link.dma_fixed_us": 0.2, "link.cache_clean_ns_per_line": 1.0}
    )
    (folder / "zu9eg.toml").write_text(to_toml(quick), encoding="utf-8")
    (folder / "times.csv").write_text("stage,runs,microseconds\nfactorize,10,150.0\nstatistics,10,180.0\n")
    return folder / "small.json"


COMMANDS: dict[str, tuple[str, ...]] = {
    "trace": ("trace", "{w}"),
    "trace of a trace's estimate": ("trace", "{w}", "--estimate"),
    "trace on the PS": ("trace", "{w}", "--partition", "all_ps"),
    "trace with two cores": ("trace", "{w}", "--set", "runtime.cores_used=2"),
    "trace with polling": ("trace", "{w}", "--set", "runtime.completion=polling"),
    "throughput": ("throughput", "{w}", "--ordering", "amd", "--shapes", "4x1x16x1", "--copies", "1", "--engines", "1"),
    "explain": ("explain", "{w}", "{d}:all_ps", "{d}:paper:{k}"),
    "budget": ("budget", "{w}"),
    "budget by the estimate": ("budget", "{w}", "--estimate"),
    "budget of nothing": ("budget", "{w}", "--partition", "all_ps"),
    "partition": ("partition", "{w}", "--lanes", "4", "--clocks", "150"),
    "partition by the estimate": (
        "partition", "{w}", "--lanes", "4", "--clocks", "150", "--estimate",
    ),
    "calibrate": ("calibrate", "{w}", "{t}"),
    "run": ("run", "{w}"),
    "precision": ("precision", "{w}"),
}  # fmt: skip


def invoke(
    arguments: tuple[str, ...], workload: Path, out: Path, key: str = "", value: object = None
) -> Result:
    pair = f"{key}={json.dumps(value)}"
    times, device = workload.with_name("times.csv"), workload.with_name("zu9eg.toml")
    filled = [
        item.format(w=workload, t=times, k=pair, d=device).removesuffix(":=null")
        for item in ("hw", *arguments)
    ]
    filled += [] if "explain" in arguments else ["--device", str(device)]
    setting = ["--set", pair] if key and not any("{k}" in item for item in arguments) else []
    result = CliRunner().invoke(app, [*filled, *setting, "--json", "--out", str(out)])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


def numbers(result: Result, out: Path) -> Any:
    """The report without its echo; of a calibration the file that it writes, without what says that a value was set."""
    if (out / "zu9eg-calibrated.toml").exists():
        lines = (out / "zu9eg-calibrated.toml").read_text().splitlines()
        return [line.partition(", tag =")[0] for line in lines]
    document = json.loads(result.stdout)
    for echo in ("assumptions", "parameters", "headline", "a", "b"):
        if echo != "a" and echo != "b":
            document.pop(echo, None)
        elif echo in document:
            document[echo].pop("name")
    document.pop("folder", None)
    if (out / "partition.csv").exists():
        document["csv"] = (out / "partition.csv").read_text()
    return document


recorded_once = cache(load_workload)


@pytest.fixture(autouse=True)
def _no_pictures(monkeypatch: pytest.MonkeyPatch, workload: Path) -> None:
    """Figures show the same numbers and take most of the time; the workload is recorded once a command."""
    monkeypatch.setattr("orbsoc.commands.hw_precision.CHOICES", ((53, ALL), (24, ("factorization",))))
    few = [load_partition(name) for name in ("all_ps", "paper", "factor_only")]
    monkeypatch.setattr("hw_model.platform.partition.all_partitions", lambda **_: few)
    monkeypatch.setattr("orbsoc.hw.workload.load_workload", recorded_once)
    for name in (
        "hw_model.figures.gantt.gantt_figure", "hw_model.figures.difference.difference_figure",
        "hw_model.figures.area.area_figure", "orbsoc.commands.hw_partition._draw",
        "hw_model.figures.throughput.throughput_figure",
        "orbsoc.hw.utilisation_figure.utilisation_figure",
    ):  # fmt: skip
        monkeypatch.setattr(name, lambda *_, **__: None)
    monkeypatch.setattr("orbsoc.hw.exact_cycles.exact_units", lambda *_: None)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_key_changes_the_report_or_is_refused(command: str, workload: Path, tmp_path: Path) -> None:
    arguments = COMMANDS[command]
    plain = invoke(arguments, workload, tmp_path / "plain")
    assert plain.exit_code in (0, 1), plain.output
    before = numbers(plain, tmp_path / "plain")
    read, refused, silent = [], [], []
    for key in KEYS:
        if any(f"{key}=" in item for item in arguments):
            continue
        outcomes = []
        for value in values_of(key):
            out = tmp_path / "changed"
            result = invoke(arguments, workload, out, key, value)
            if result.exit_code == 2:
                words = json.loads(result.stdout)["error"]
                assert f"`{key}`" in words or "cores_used" in words, words
                outcomes.append("refused")
            else:
                assert result.exit_code in (0, 1), result.output
                outcomes.append("read" if numbers(result, out) != before else "silent")
            if outcomes[-1] == "read":
                break
        if "read" in outcomes:
            read.append(key)
        elif "silent" in outcomes:
            silent.append(key)
        else:
            refused.append(key)
    assert not silent, silent
    assert read, command
    assert refused, command


def refusal(workload: Path, out: Path, *arguments: str) -> str:
    """The words with which a command refuses its input; nothing is written."""
    result = CliRunner().invoke(app, ["hw", *arguments, "--json", "--out", str(out)])
    assert result.exit_code == 2, result.output
    assert not out.exists()
    return json.loads(result.stdout)["error"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (
            ("trace", "{w}", "--set", "pl.overlap_exponent=3.0"),
            "`pl.overlap_exponent` = 3.0 would do nothing here: cycles come from exact schedules; ask for --estimate",
        ),
        (
            ("partition", "{w}", "--set", "pl.lanes=8"),
            "--set 'pl.lanes=8' would do nothing here: --lanes sets `pl.lanes`; use that one",
        ),
        (("partition", "{w}", "--set", "pl.clock_mhz=90.0"), "--clocks sets `pl.clock_mhz`"),
        (("run", "{w}", "--lanes", "2", "--set", "pl.lanes=8"), "--lanes sets `pl.lanes`; use that one"),
        (("run", "{w}", "--banks", "4", "--set", "pl.banks=8"), "--banks sets `pl.banks`; use that one"),
        (
            ("run", "{w}", "--set", "ps.clock_mhz=90.0"),
            "`ps.clock_mhz` = 90.0 would do nothing here: this report times no PS",
        ),
        (("run", "{w}", "--set", "runtime.preset=linux"), "`runtime.preset` = 'linux' would do nothing here"),
        (
            ("budget", "{w}", "--set", "link.core_write_ns_per_byte=9.0"),
            "`link.core_write_ns_per_byte` = 9.0 would do nothing here",
        ),
        (
            ("budget", "{w}", "--set", "pl.microcode_compression=8.0"),
            "`pl.microcode_compression` = 8.0 would do nothing here: the schedules' own microcode is compressed and counted",
        ),
        (
            ("trace", "{w}", "--set", "pl.lanes=8", "--set", "pl.lanes=4"),
            "`pl.lanes` was set to 8 before; set it once",
        ),
        (
            ("explain", "{w}", "zu9eg:paper:pl.lanes=8,pl.lanes=4", "zu9eg:paper"),
            "`pl.lanes` was set to 8 before; set it once",
        ),
        (
            ("explain", "{w}", "zu9eg:paper", "zu9eg:all_ps:pl.lanes=8"),
            "`pl.lanes` = 8 would do nothing here: the partition leaves the PL idle; choose one that uses it",
        ),
        (("trace", "{w}", "--set", "pl.latency_preset=vendor_ip", "--exact"), "ask for --estimate"),
        (("run", "{w}", "--set", "pl.latency_preset=vendor_ip"), "schedules are made with the latencies of"),
        (("partition", "{w}", "--lanes", "2,2"), "--lanes '2,2': names 2 twice; it would be counted twice"),
        (("partition", "{w}", "--clocks", "100,1e2"), "--clocks '100,1e2': names 100.0 twice"),
        (("partition", "{w}", "--device", "zu9eg,zu9eg"), "--device 'zu9eg,zu9eg': names zu9eg twice"),
        (
            ("trace", "{w}", "--partition", "factorization+factorization"),
            "names 'factorization' twice; name it once",
        ),
    ],
)
def test_what_would_do_nothing_is_refused_with_its_reason(
    workload: Path, tmp_path: Path, arguments: tuple[str, ...], says: str
) -> None:
    filled = [item.format(w=workload) for item in arguments]
    assert says in refusal(workload, tmp_path / "out", *filled)


@pytest.mark.parametrize(
    ("axes", "says"),
    [
        (
            "'pl.overlap_exponent' = [2.0, 3.0]",
            "`pl.overlap_exponent` = (2.0, 3.0) would do nothing here: cycles come",
        ),
        ("'runtime.jitter_exponent' = [2.0]", "`runtime.jitter_exponent` = (2.0,) would do nothing here"),
        ("'pl.lanes' = [1, 2]\n[axes.pl]\nlanes = [4]", "`axes.pl.lanes` = [4]: was given as [1, 2] before"),
        ("'pl.clock_mhz' = [100, 100.0]", "names a value twice"),
        (
            "partition = ['factor_only', 'factorization']",
            "'factorization' is the same as 'factor_only'; name it once",
        ),
        ("device = ['zu9eg', 'zu9eg']", "names a value twice"),
        (
            "partition = ['all_ps']\n'pl.lanes' = [1, 2]",
            "`pl.lanes` = (1, 2) would do nothing here: the partition leaves",
        ),
    ],
)
def test_an_axis_that_would_do_nothing_is_refused(
    workload: Path, tmp_path: Path, axes: str, says: str
) -> None:
    file = tmp_path / "sweep.toml"
    file.write_text(f"[axes]\n{axes}\n", encoding="utf-8")
    assert says in refusal(workload, tmp_path / "out", "sweep", str(file), str(workload))
