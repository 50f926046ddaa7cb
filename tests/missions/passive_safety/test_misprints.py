"""The paper's linear programme in its own variables and axes, correct and as it is printed."""

from __future__ import annotations

import numpy as np
import pytest

import orbsoc
from orbsoc.missions.passive_safety.paper import ROWS, TableRow

W, KEEP_OUT, CAPTURE, SAMPLES, N = 1e-3, 40.0, 60.0, 36, 4


def programme(row: TableRow, variant: str = "", samples: int = SAMPLES) -> orbsoc.Problem:
    """min Σ (δx⁺ + δx⁻ + δz⁺ + δz⁻) in the order δx₁⁺, δx₁⁻, δz₁⁺, δz₁⁻, …; x along the velocity, z to the nadir."""
    times = np.arange(N) * row.duration_s / N

    def effect(t: float, n: int) -> np.ndarray:
        """Rows x, z at t of the first n impulses, (2, 4 N)."""
        found = np.zeros((2, 4 * N))
        for i in range(n):
            tau = W * (t - times[i])
            s, c = np.sin(tau), np.cos(tau)
            by = np.array([[4 * s / W - 3 * (t - times[i]), 2 / W * (1 - c)], [2 / W * (c - 1), s / W]])
            if variant == "cos + 1" and n > 1:
                by[1, 0] = 2 / W * (c + 1)
            found[:, 4 * i : 4 * i + 4] = by @ np.array([[1, -1, 0, 0], [0, 0, 1, -1]])
        return found

    end = effect(row.duration_s, N) if variant != "cos + 1" else programme_end(row)
    if variant == "capture cos - 1":
        end[0, 2::4], end[0, 3::4] = -end[0, 2::4], -end[0, 3::4]
    first = np.zeros((1, 4 * N))
    first[0, :2] = 1.0, -1.0
    A = np.vstack([first, W * end])
    b = np.array([0.0, -W * row.start_m, W * CAPTURE])
    far = np.zeros((1, 4 * N))
    far[0, 2:4] = 4.0, -4.0
    short = row.condition == "short"
    rows = [-W * effect(times[1], 1)[1:], far if short else -far]
    sides = [-W * KEEP_OUT, W * (-KEEP_OUT - row.start_m if short else row.start_m - KEEP_OUT)]
    for n in range(1 if variant == "from n = 1" else 2, N + 1):
        for j in range(1, samples + 1):
            rows.append(-W * effect(times[n - 1] + 2 * np.pi * j / (samples * W), n)[1:])
            sides.append(-W * KEEP_OUT)
    G = np.vstack([-np.eye(4 * N), *rows])
    h = np.concatenate([np.zeros(4 * N), sides])
    return orbsoc.Problem(c=np.ones(4 * N), A=A, b=b, G=G, h=h, cones=orbsoc.Cones(l=len(h)))


def programme_end(row: TableRow) -> np.ndarray:
    """The capture rows with the correct effects."""
    problem = programme(row)
    return np.asarray(problem.A.toarray()[1:] / W)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"row{row.number}")
def test_the_papers_own_form_has_the_same_optimum(row: TableRow) -> None:
    problem = programme(row)
    assert (problem.n, problem.p, problem.m) == (16, 3, 126)
    assert orbsoc.solve(problem, tol=1e-9).objective == pytest.approx(row.fitted_total, abs=1e-6)


@pytest.mark.parametrize("variant", ["cos + 1", "from n = 1"])
def test_as_equation_6_is_printed_no_row_is_feasible(variant: str) -> None:
    for row in ROWS:
        assert orbsoc.solve(programme(row, variant)).status is orbsoc.Status.PRIMAL_INFEASIBLE


def test_as_the_capture_row_is_printed_the_table_is_missed_and_36_samples_are_its_fingerprint() -> None:
    def spread(variant: str = "", samples: int = SAMPLES) -> float:
        """Root mean square over all pulses, row 4's first corrected."""
        off = []
        for row in ROWS:
            pulses = (0.260, *row.pulses[1:]) if row.number == 4 else row.pulses
            found = orbsoc.solve(programme(row, variant, samples), tol=1e-9).x.reshape(N, 4).sum(axis=1)
            off.append(found - pulses)
        return float(np.sqrt(np.mean(np.square(off))))

    assert spread() == pytest.approx(0.00104, abs=2e-5)
    assert spread("capture cos - 1") > 0.1
    assert spread(samples=35) > 0.01
    assert spread(samples=37) > 0.005
