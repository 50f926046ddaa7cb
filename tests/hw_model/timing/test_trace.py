"""The trace schema: what is accepted, and that every damage is named."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hw_model.errors import TraceError
from hw_model.timing.trace import load_trace, parse_trace
from tests.hw_model.synthetic import synthetic_trace

Damage = Callable[[dict[str, Any]], object]


def test_the_synthetic_trace_has_the_sizes_it_states() -> None:
    trace = parse_trace(synthetic_trace())
    [pattern] = trace.patterns
    assert pattern.n + pattern.p + pattern.m == 245
    assert pattern.nnz_l == 4372
    assert pattern.stages["factorize"].count("mul_sub") == 39_000


def test_tuples_and_json_are_read_alike(tmp_path: Path) -> None:
    raw = synthetic_trace(iterations=2)
    path = tmp_path / "trace.json"
    path.write_text(json.dumps(raw), encoding="utf-8")
    raw["solves"][0]["events"] = [tuple(event) for event in raw["solves"][0]["events"]]
    assert load_trace(path) == parse_trace(raw)


def _pattern(raw: dict[str, Any]) -> dict[str, Any]:
    return raw["patterns"][0]


def _factor(raw: dict[str, Any]) -> dict[str, Any]:
    return _pattern(raw)["stages"]["factorize"]


DAMAGES: dict[str, tuple[Damage, str]] = {
    "other version": (lambda t: t.update(schema="orbsoc.trace/1"), r"`schema` = 'orbsoc\.trace/1': this model reads"),
    "no version": (lambda t: t.pop("schema"), r"`schema` = None"),
    "datapath": (lambda t: t.update(datapath="f16"), r"`datapath` = 'f16': allowed are f64, f32"),
    "unknown key": (lambda t: t.update(note="x"), r"`note` = 'x' is not a known key; allowed here: schema_?, datapath"),
    "unknown key of a pattern": (
        lambda t: _pattern(t).update(nnz_u=3),
        r"`patterns\.0\.nnz_u` = 3 is not a known key; allowed here: n, p, m, cones",
    ),
    "unknown key of a stage": (
        lambda t: _factor(t).update(flops=3),
        r"`patterns\.0\.stages\.factorize\.flops` = 3 is not a known key",
    ),
    "unknown key of a solve": (
        lambda t: t["solves"][0].update(seconds=3),
        r"`solves\.0\.seconds` = 3 is not a known key; allowed here: pattern, status, iterations, events",
    ),
    "no patterns": (lambda t: t.pop("patterns"), r"`patterns` is missing"),
    "patterns kind": (lambda t: t.update(patterns=3), r"`patterns` = 3"),
    "no solves": (lambda t: t.update(solves=[]), "solves is empty: a trace holds at least one"),
    "unknown stage": (
        lambda t: t["solves"][0]["events"].append(["factorise", 1]),
        r"solves\.0\.events\.\d+ names stage 'factorise'; stages of pattern 0: equilibrate, ",
    ),
    "unknown pattern": (lambda t: t["solves"][0].update(pattern=1), r"solves\.0\.pattern = 1: the trace has 1 pattern"),
    "event shape": (lambda t: t["solves"][0]["events"].insert(0, ["factorize"]), r"`solves\.0\.events\.0\.1` is missing"),
    "negative iteration": (
        lambda t: t["solves"][0]["events"].insert(0, ["factorize", -1]), r"`solves\.0\.events\.0\.1` = -1",
    ),
    "no status": (lambda t: t["solves"][0].pop("status"), r"`solves\.0\.status` is missing"),
    "iterations kind": (lambda t: t["solves"][0].update(iterations=1.5), r"`solves\.0\.iterations` = 1\.5"),
    "missing count": (
        lambda t: _factor(t)["operations"].pop("div"),
        r"`patterns\.0\.stages\.factorize\.operations`: missing counts: div; unknown operations: none",
    ),
    "unknown operation": (
        lambda t: _factor(t)["operations"].update(fma=3), r"operations`: missing counts: none; unknown operations: fma",
    ),
    "negative count": (
        lambda t: _factor(t)["operations"].update(mul=-1), r"`patterns\.0\.stages\.factorize\.operations\.mul` = -1",
    ),
    "huge count": (lambda t: _factor(t)["operations"].update(mul=10**400), r"factorize\.operations\.mul` = 10+"),
    "fractional count": (lambda t: _factor(t)["operations"].update(mul=1.0), r"factorize\.operations\.mul` = 1\.0"),
    "true count": (lambda t: _factor(t)["operations"].update(mul=True), r"factorize\.operations\.mul` = True"),
    "no counts": (lambda t: _factor(t).pop("operations"), r"`patterns\.0\.stages\.factorize\.operations` is missing"),
    "module": (
        lambda t: _factor(t).update(module="fft"),
        r"`patterns\.0\.stages\.factorize\.module`: 'fft' is no module; allowed: ps, matrix_update, ",
    ),
    "module kind": (lambda t: _factor(t).update(module=[1]), r"factorize\.module`: \[1\] is no module"),
    "critical path": (lambda t: _factor(t).update(critical_path={"orbsoc_rtl": -3}), r"critical_path\.orbsoc_rtl` = -3"),
    "unknown buffer": (
        lambda t: _factor(t)["reads"].append("ghost"), r"stages\.factorize\.reads names 'ghost'; buffers: a, alpha, ",
    ),
    "buffer size": (lambda t: _pattern(t)["buffers"].update(l="many"), r"`patterns\.0\.buffers\.l` = 'many'"),
    "cones": (lambda t: _pattern(t)["cones"].update(l=21), r"`patterns\.0`: cones\.l \+ sum\(cones\.q\) = 81, but m = 80"),
    "cone of nothing": (lambda t: _pattern(t)["cones"]["q"].append(0), r"`patterns\.0\.cones\.q\.15` = 0"),
    "no nnz_l": (lambda t: _pattern(t).pop("nnz_l"), r"`patterns\.0\.nnz_l` is missing; required here: n, p, m, "),
}  # fmt: skip


@pytest.mark.parametrize("damage", DAMAGES)
def test_damage_is_refused_and_named(damage: str) -> None:
    raw = synthetic_trace(iterations=1)
    inflict, says = DAMAGES[damage]
    inflict(raw)
    with pytest.raises(TraceError, match=says):
        parse_trace(raw)


@pytest.mark.parametrize("data", [None, 3, [], "orbsoc.trace/2"])
def test_what_is_no_mapping_is_refused(data: Any) -> None:
    with pytest.raises(TraceError, match="a trace is a mapping"):
        parse_trace(data)


def test_a_file_that_is_no_trace_is_named(tmp_path: Path) -> None:
    path = tmp_path / "trace.json"
    path.write_text("{", encoding="utf-8")
    with pytest.raises(TraceError, match=r"trace\.json: not JSON"):
        load_trace(path)
    path.write_text('{"schema": "orbsoc.trace/1", "schema": "orbsoc.trace/2"}', encoding="utf-8")
    with pytest.raises(TraceError, match="key 'schema' is set twice"):
        load_trace(path)
    with pytest.raises(TraceError, match=r"none\.json: cannot be read"):
        load_trace(tmp_path / "none.json")


def test_many_complaints_are_cut_short() -> None:
    raw = synthetic_trace(iterations=1)
    raw["solves"][0]["events"] = [["factorize", -1]] * 14
    with pytest.raises(TraceError, match="… and 4 more"):
        parse_trace(raw)
