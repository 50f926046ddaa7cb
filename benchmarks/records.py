"""Measurements as CSV and as JSON, and back."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from benchmarks.measure import Measurement, Spread
from orbsoc.conic.verify import Verification

SCHEMA = "orbsoc.bench/1"
SPREADS = ("setup", "solve", "total")
PARTS = ("median", "q1", "q3")


def records(measurements: Iterable[Measurement]) -> list[dict[str, Any]]:
    """One flat record for each solver on each problem; times in µs."""
    return [
        {
            "problem": m.problem,
            "group": m.group,
            "n": m.n,
            "p": m.p,
            "m": m.m,
            "solver": m.solver,
            "settings": m.variant or "default",
            "status": m.status,
            "counts": m.counts,
            "failure": m.failure,
            "iterations": m.iterations,
            "pres": m.verification.pres,
            "dres": m.verification.dres,
            "gap": m.verification.gap,
            **{
                f"{name}_{part}_us": getattr(spread, part)
                for name, spread in zip(SPREADS, (m.setup, m.solve, m.total), strict=True)
                for part in PARTS
            },
        }
        for m in measurements
    ]


def to_csv(header: Mapping[str, str], measurements: Sequence[Measurement]) -> str:
    """CSV with the header as `# key: value` lines; times to a hundredth of a µs."""
    out = io.StringIO()
    out.writelines(f"# {key}: {value}\n" for key, value in header.items())
    rows = [
        {key: round(value, 2) if key.endswith("_us") else value for key, value in record.items()}
        for record in records(measurements)
    ]
    writer = csv.DictWriter(out, fieldnames=list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()


def to_json(header: Mapping[str, str], measurements: Sequence[Measurement]) -> str:
    """Schema `orbsoc.bench/1`: header and records, every bit of them; a residual that is not finite is null."""
    rows = [
        {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in row.items()}
        for row in records(measurements)
    ]
    document = {"schema": SCHEMA, "header": dict(header), "measurements": rows}
    return json.dumps(document, indent=1, allow_nan=False) + "\n"


def from_json(text: str) -> tuple[dict[str, str], list[Measurement]]:
    """Header and measurements of `to_json`'s text. Raises ValueError for another schema."""
    document = json.loads(text)
    if document.get("schema") != SCHEMA:
        raise ValueError(f"schema is {document.get('schema')!r}; this reader knows {SCHEMA!r}")
    return document["header"], [_measurement(row) for row in document["measurements"]]


def _measurement(row: Mapping[str, Any]) -> Measurement:
    residuals = (math.inf if row[name] is None else float(row[name]) for name in ("pres", "dres", "gap"))
    setup, solve, total = (Spread(*(row[f"{name}_{part}_us"] for part in PARTS)) for name in SPREADS)
    return Measurement(
        problem=row["problem"],
        group=row["group"],
        n=row["n"],
        p=row["p"],
        m=row["m"],
        solver=row["solver"],
        variant="" if row["settings"] == "default" else row["settings"],
        status=row["status"],
        iterations=row["iterations"],
        verification=Verification(*residuals),
        setup=setup,
        solve=solve,
        total=total,
        failure=row["failure"],
    )
