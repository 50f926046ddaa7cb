"""A programme of impulses as data: times and velocity changes, in `impulses.csv` and `plan.json`."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from orbsoc.orbit.array import Array, Flags

NOISE = 1e-8
"""Of the total: smaller impulses are the solver's zeros."""

CSV_COLUMNS = ("time_s", "dv_r_m_s", "dv_t_m_s", "dv_n_m_s")
"""Of `impulses.csv`: R outward, T along the motion, N along the angular momentum."""


class ImpulseFileError(ValueError):
    """An impulse file cannot be read; the message names the line, the column, the value and what is allowed."""


@dataclass(frozen=True, slots=True, eq=False)
class ImpulseProgramme:
    """N impulses: `times_s` (N,), strictly increasing, and `dv_m_s` (N, 3), in the target's frame (R, T, N).

    Raises ValueError for shapes that do not fit, times that do not increase, or numbers that are not finite.

    >>> programme = ImpulseProgramme([0.0, 60.0], [[0.0, 0.3, 0.4], [0.0, 0.0, -0.5]])
    >>> programme.total_m_s, len(programme)
    (1.0, 2)
    """

    times_s: Array
    dv_m_s: Array

    def __init__(self, times_s: ArrayLike, dv_m_s: ArrayLike) -> None:
        times = np.array(times_s, dtype=np.float64)
        dv = np.array(dv_m_s, dtype=np.float64).reshape((-1, 3) if np.size(dv_m_s) else (0, 3))
        if times.shape != (len(dv),):
            raise ValueError(f"{times.shape} times for {dv.shape} velocity changes: must be (N,) and (N, 3)")
        if not (np.isfinite(times).all() and np.isfinite(dv).all()):
            raise ValueError("an impulse programme holds finite numbers only")
        if np.any(np.diff(times) <= 0.0):
            k = int(np.argmax(np.diff(times) <= 0.0))
            raise ValueError(f"impulse {k + 1} at {times[k + 1]:g} s is not after that at {times[k]:g} s")
        times.setflags(write=False)
        dv.setflags(write=False)
        object.__setattr__(self, "times_s", times)
        object.__setattr__(self, "dv_m_s", dv)

    def __len__(self) -> int:
        return self.times_s.size

    @property
    def sizes_m_s(self) -> Array:
        """Of each impulse, its 2-norm, (N,)."""
        return np.asarray(np.linalg.norm(self.dv_m_s, axis=1))

    @property
    def total_m_s(self) -> float:
        """Sum of the 2-norms."""
        return float(self.sizes_m_s.sum())

    @property
    def worth_firing(self) -> Flags:
        """Whether an impulse is more than the solver's zero, (N,)."""
        return self.sizes_m_s > NOISE * self.total_m_s

    @property
    def fired(self) -> int:
        """How many impulses are worth firing: zero ones do not count."""
        return int(self.worth_firing.sum())

    @property
    def words(self) -> str:
        """The total and the number of impulses; those that are zero are counted apart."""
        fired = self.fired
        if fired < len(self):
            return f"{self.total_m_s:.4f} m/s in {fired} of {len(self)} impulses, the rest zero"
        return f"{self.total_m_s:.4f} m/s in {fired} impulse{'s' * (fired != 1)}"

    @property
    def total_absolutes_m_s(self) -> float:
        """Sum of the 1-norms: for thrusters fixed along the axes."""
        return float(np.abs(self.dv_m_s).sum())

    @property
    def largest_m_s(self) -> float:
        """The largest 2-norm; 0 without impulses."""
        return float(self.sizes_m_s.max(initial=0.0))

    def without_small(self, least_m_s: float) -> ImpulseProgramme:
        """The impulses of at least that size."""
        kept = self.sizes_m_s >= least_m_s
        return ImpulseProgramme(self.times_s[kept], self.dv_m_s[kept])

    def first(self, count: int) -> ImpulseProgramme:
        """The first `count` impulses: what is flown when the engine fails after them."""
        return ImpulseProgramme(self.times_s[:count], self.dv_m_s[:count])

    def to_list(self) -> list[dict[str, Any]]:
        """The `impulses` of plan.json."""
        rows = zip(self.times_s.tolist(), self.dv_m_s.tolist(), self.sizes_m_s.tolist(), strict=True)
        return [{"time_s": t, "dv_m_s": dv, "norm_m_s": size} for t, dv, size in rows]

    def to_csv(self) -> str:
        """`impulses.csv`: a header of `CSV_COLUMNS` and a line an impulse, every number with all its digits."""
        rows = np.column_stack([self.times_s, self.dv_m_s]).tolist()
        return "\n".join([",".join(CSV_COLUMNS), *(",".join(map(repr, row)) for row in rows)]) + "\n"

    @classmethod
    def from_csv(cls, text: str, *, source: str = "impulses.csv") -> ImpulseProgramme:
        """The programme of an `impulses.csv`; blank lines are skipped. Raises ImpulseFileError."""
        lines = [
            (k, line.strip()) for k, line in enumerate(text.lstrip("\ufeff").splitlines(), 1) if line.strip()
        ]
        header = [name.strip() for name in lines[0][1].split(",")] if lines else []
        if header != list(CSV_COLUMNS):
            found = ",".join(header) or "nothing"
            raise ImpulseFileError(f"{source}: the first line is {found}; it must be {','.join(CSV_COLUMNS)}")
        rows: list[list[float]] = []
        for number, line in lines[1:]:
            cells = [cell.strip() for cell in line.split(",")]
            if len(cells) != len(CSV_COLUMNS):
                raise ImpulseFileError(
                    f"{source}, line {number}: {len(cells)} values; there must be {len(CSV_COLUMNS)}"
                )
            rows.append([_number(cell, f"{source}, line {number}, {column}") for cell, column in zip(
                cells, CSV_COLUMNS, strict=True)])  # fmt: skip
            if len(rows) > 1 and not rows[-1][0] > rows[-2][0]:
                raise ImpulseFileError(
                    f"{source}, line {number}, time_s = {rows[-1][0]:g}: must be after {rows[-2][0]:g}, the one before"
                )
        if not rows:
            raise ImpulseFileError(f"{source}: no impulses; there must be at least one line of numbers")
        table = np.array(rows)
        return cls(table[:, 0], table[:, 1:])

    @classmethod
    def read(cls, path: str | PathLike[str]) -> ImpulseProgramme:
        """The programme of a file. Raises ImpulseFileError, also for a file that is missing or no text."""
        try:
            text = Path(path).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise ImpulseFileError(f"{path}: cannot be read as text: {error}") from error
        return cls.from_csv(text, source=str(path))


def _number(cell: str, where: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        raise ImpulseFileError(f"{where} = {cell!r}: must be a finite number")
    return value
