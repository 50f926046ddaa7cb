"""Solution files: every number comes back exactly, whatever it is; every damage is refused by field."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbsoc.conic.errors import FileError
from orbsoc.conic.solution import Certificate, Solution, Status
from orbsoc.conic.solution_file import encode_solution
from orbsoc.conic.verify import Verification
from orbsoc.files.json_fields import write_json

doubles = st.floats(allow_nan=True, allow_infinity=True, allow_subnormal=True)
counts = st.integers(0, 2**40)


@st.composite
def solutions(draw: st.DrawFn) -> Solution:
    """Any record that a solver could return, NaN and infinities included."""
    vectors = [np.array(draw(st.lists(doubles, max_size=5)), dtype=np.float64) for _ in "xyzs"]
    return Solution(
        draw(st.sampled_from(Status)), *vectors, draw(doubles), draw(doubles), draw(counts), draw(counts),
        draw(doubles), draw(doubles), Certificate(*(draw(doubles) for _ in range(4))), draw(st.text(max_size=20)),
        draw(counts), draw(counts),
    )  # fmt: skip


def bits(solution: Solution) -> list[object]:
    """Every field, numbers as their bytes; one NaN is as good as another."""
    out: list[object] = []
    for field in dataclasses.fields(solution):
        value = getattr(solution, field.name)
        if isinstance(value, Certificate):
            value = np.array(dataclasses.astuple(value))
        elif isinstance(value, float):
            value = np.array([value])
        if isinstance(value, np.ndarray):
            out.append(np.where(np.isnan(value), np.nan, value).tobytes())
        else:
            out.append(value)
    return out


@given(solutions())
def test_a_saved_solution_comes_back_bit_for_bit(
    tmp_path_factory: pytest.TempPathFactory, solution: Solution
) -> None:
    path = tmp_path_factory.mktemp("solution") / "s.json"
    solution.save(path)
    assert bits(Solution.load(path)) == bits(solution)


SOLUTION = Solution(
    Status.SOLVED, np.array([1.0]), np.zeros(0), np.array([2.0]), np.array([0.5]), 1.0, 1.0, 5, 3, 0.1, 0.2,
    Certificate(1e-9, 2e-9, 3e-9, float("nan")), "verified", 3, 2,
)  # fmt: skip


def test_the_document_is_strict_json_and_carries_the_verification(tmp_path: Path) -> None:
    path = tmp_path / "s.json"
    write_json(encode_solution(SOLUTION, Verification(1e-9, float("inf"), 0.0)), path)
    document = json.loads(path.read_text(), parse_constant=lambda name: pytest.fail(name))
    assert document["schema"] == "orbsoc.solution/1"
    assert document["status"] == "SOLVED"
    assert document["verification"] == {"pres": 1e-9, "dres": "inf", "gap": 0.0}
    assert document["certificate"]["radius"] == "nan"
    assert Solution.load(path).certificate.gap == 3e-9


DAMAGE: list[tuple[Callable[[dict[str, Any]], Any], str]] = [
    (
        lambda d: d.update(schema="orbsoc.problem/1"),
        "field `schema` is 'orbsoc.problem/1'; this reader knows",
    ),
    (lambda d: d.update(colour=1), "field `colour` is unknown"),
    (lambda d: d.update(status="FINE"), "field `status` is 'FINE'; known are SOLVED, "),
    (lambda d: d.pop("status"), "field `status` is None; it must be text"),
    (lambda d: d.update(x=[1, "two"]), "field `x[1]` is 'two'; it must be a number, "),
    (lambda d: d.update(z=1), "field `z` is 1; it must be a list"),
    (lambda d: d.pop("objective"), "field `objective` is None; it must be a number"),
    (lambda d: d.update(iterations=-1), "field `iterations` is -1; it must be an integer, 0 or more"),
    (lambda d: d.update(certificate=[]), "field `certificate` must be one JSON object"),
    (lambda d: d["certificate"].pop("gap"), "field `certificate.gap` is None; it must be a number"),
]


@pytest.mark.parametrize(("damage", "message"), DAMAGE, ids=[row[1] for row in DAMAGE])
def test_a_damaged_file_is_refused_by_field(
    tmp_path: Path, damage: Callable[[dict[str, Any]], Any], message: str
) -> None:
    path = tmp_path / "s.json"
    SOLUTION.save(path)
    document = json.loads(path.read_text())
    damage(document)
    path.write_text(json.dumps(document))
    with pytest.raises(FileError, match=re.escape(message)) as caught:
        Solution.load(path)
    assert str(caught.value).startswith(str(path))


@pytest.mark.parametrize("text", ["", "[", "[" * 100_000, "[]", '{"x": Infinity}', "\x00", "9" * 5000])
def test_a_file_that_is_not_such_a_document_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "s.json"
    path.write_text(text)
    with pytest.raises(FileError, match=re.escape(str(path))):
        Solution.load(path)


@pytest.mark.parametrize("number", ["1e999", "9" * 400])
def test_a_number_beyond_a_double_is_refused_by_field(tmp_path: Path, number: str) -> None:
    path = tmp_path / "s.json"
    SOLUTION.save(path)
    document = json.loads(path.read_text()) | {"x": ["here"]}
    path.write_text(json.dumps(document).replace('"here"', number))
    with pytest.raises(FileError, match=r"field `x\[0\]` is .*; it is too large"):
        Solution.load(path)
