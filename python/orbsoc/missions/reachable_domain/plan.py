"""A plan as `guidance.mission.Plan` has it, its verdict, and the function by which the mission makes one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.guidance.mission import Difference, FigureFile, PlanStatus
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word, shortened

from .planner import Point, PointPlan, made
from .scenario import Scenario

SMA_REL = 1e-6
"""Difference of two plans' semi-major axes up to which they agree."""
SAMPLES = 201
"""Times of `attitude.csv`."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan(PointPlan):
    """A point of the domain with its verdict and files."""

    @property
    def verdict(self) -> Verdict:
        """Answer, and how the largest orbit was found, of which there is no proof."""
        return Verdict.of([_answer(self), _optimum(self)])

    def to_dict(self) -> dict[str, Any]:
        """The content of `plan.json`; null for what is not known."""
        return {
            "mission": self.scenario.mission,
            "name": self.scenario.name,
            "status": self.status.value,
            "message": self.message,
            "details": f"{self.message}; this is one point of the domain, and orbsoc reach solves all points of the scenario",
            "point": {name: _plain(value) for name, value in self.point.items()},
            "verification": self.verification,
            "scp_iterations": len(self.subproblems),
            "subproblems": [row.to_dict() for row in self.subproblems],
            "scenario": self.scenario.model_dump(mode="json"),
        }

    def tables(self) -> dict[str, str]:
        """`attitude.csv`: the flown thrust direction in ECI, uniform in time."""
        if self.programme is None:
            return {}
        times_s = np.linspace(0.0, self.scenario.burn.duration_s, SAMPLES)
        grid = legendre_gauss(len(self.programme))
        vectors = grid.interpolate(self.programme, 2.0 * times_s / times_s[-1] - 1.0)
        vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
        rows = (",".join(f"{value:.12g}" for value in row) for row in np.column_stack([times_s, vectors]))
        return {"attitude.csv": "\n".join(["t_s,ux,uy,uz", *rows]) + "\n"}

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        """The orbits of a point that is reached; the figures of the domain are those of `orbsoc reach`."""
        from .figures.point import draw_point

        return () if self.programme is None else draw_point(self, folder)

    def differences(self, other: Plan) -> tuple[Difference, ...]:
        if PlanStatus.VERIFIED not in (self.status, other.status):
            return ()
        value = abs(self.point["a_km"] - other.point["a_km"]) / abs(other.point["a_km"])
        return (Difference("sma_rel", "semi-major axis", value, SMA_REL),)


def plan(
    scenario: Scenario,
    *,
    solve: Solve | None = None,
    callback: Callable[[Iteration], None] | None = None,
    point: Point | None = None,
) -> Plan:
    """Plan one point of the domain; `callback` sees every subproblem.

    `solve` is any solver with the call shape of `orbsoc.solve`, which is the default. A point that is not reached is a
    status with its evidence.
    """
    found = made(scenario, solve, callback, point)
    return Plan(**{field.name: getattr(found, field.name) for field in fields(PointPlan)})


def _answer(plan: Plan) -> VerdictLine:
    """The largest semi-major axis as it is flown, or that none was found and by how much."""
    found, word = plan.point, Word[plan.status.name]
    sign = "=" if plan.scenario.perigee.condition == "equal" else "≥"
    where = f"i {found['inc_deg']:.2f}°, Ω {found['raan_deg']:.2f}°, perigee {sign} {found['perigee_bound_km']:g} km"
    if plan.status is PlanStatus.VERIFIED:
        limit = f"{plan.scenario.verification.sma_rel:.0e}".replace("e-0", "e-")
        flown = f"flown to {found['sma_error_rel']:.0e} ≤ {limit}"
        return VerdictLine(Question.ANSWER, word, f"a {found['a_km']:.3f} km at {where}", evidence=flown)
    short = found["tilt_deg"] - found["furthest_tilt_deg"]
    why = f"the plane is {short:.3f}° too far" if short > 0.0 else plan.message
    return VerdictLine(Question.ANSWER, word, shortened(f"{where}: {why}"))


def _optimum(plan: Plan) -> VerdictLine | None:
    """Where the plan is from; nothing is proved over all programmes."""
    if plan.status is not PlanStatus.VERIFIED:
        return None
    figure = f"{plan.message}; {plan.point['sequence_iterations']} conic problems"
    return VerdictLine(Question.OPTIMUM, Word.BEST_FOUND, shortened(figure))


def _plain(value: Any) -> Any:
    """A value of the table as JSON has it."""
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    return int(value) if isinstance(value, np.integer) else value
