"""What is told of a plan with one burn or two: violated rows in units a person can picture, lines of the verdict, sentences."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from orbsoc.guidance.claims import Claim, Kind
from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scp import ExitReason, Iteration
from orbsoc.guidance.verdict import Question, VerdictLine, Word, shortened
from orbsoc.orbit import CanonicalUnits

from ..model.proof import Proof
from ..scenario import MOST_NODES, Scenario
from ..targets.rows import Row
from ..verification import EndOfFlight

ACTIVE = 0.999
"""Share of the bound on the attitude rate, from which on a plan is at it."""


class Told(Protocol):
    """What a plan has to tell, with one burn or with two; see `SearchResult`."""

    @property
    def scenario(self) -> Scenario: ...
    @property
    def status(self) -> PlanStatus: ...
    @property
    def message(self) -> str: ...
    @property
    def verification(self) -> Any: ...
    @property
    def proof(self) -> Proof | None: ...
    @property
    def attempts(self) -> Sequence[Any]: ...
    @property
    def subproblems(self) -> Sequence[Iteration]: ...
    @property
    def time_of_flight_s(self) -> float: ...
    @property
    def propellant_kg(self) -> float: ...
    @property
    def ignition_s(self) -> float: ...


# violated rows


@dataclass(frozen=True, slots=True)
class Violation:
    """One row that could not be met: its name, its canonical value, and what that means."""

    row: Row
    value: float
    words: str


def worst_first(found: Iterable[Violation], floor: float = 1e-9) -> tuple[Violation, ...]:
    """Those above a floor, below which a violation is the solver's and not the trajectory's."""
    return tuple(sorted((each for each in found if abs(each.value) > floor), key=lambda v: -abs(v.value)))


def rate_in_words(scenario: Scenario, over: float) -> str:
    """An attitude rate that is above the scenario's bound by so much, rad per canonical time."""
    bound = scenario.limits.attitude_rate_deg_s
    assert bound is not None
    over_deg_s = np.rad2deg(over) / CanonicalUnits.of(scenario.constants).time_s
    return (
        f"the attitude rate at {bound + over_deg_s:.4g} °/s, {over_deg_s:.4g} above"
        f" limits.attitude_rate_deg_s = {bound:g}"
    )


def start_tried(
    start: str, ignition_s: float, ended: ExitReason, left: tuple[Violation, ...]
) -> dict[str, Any]:
    """A start of the search as data: how it ended, and the worst of the rows that it `left`."""
    return {
        "start": start,
        "ignition_s": ignition_s,
        "ended": ended.value,
        "worst_row": left[0].row.value if left else None,
        "by_canonical": left[0].value if left else None,
        "words": left[0].words if left else "",
    }


# lines of the verdict


def fitted(
    question: Question, word: Word, figure: str, evidence: str = "", claim: Claim | None = None
) -> VerdictLine:
    """A line whose figure, made elsewhere, ends with a clause; the sentences of the plan have the rest."""
    return VerdictLine(question, word, shortened(figure), evidence=evidence, claim=claim)


def wait_in_words(wait_s: float) -> str:
    """A wait that a search ends near, as exactly as the burn asks for."""
    return f"about {wait_s:.0f} s" if wait_s < 120.0 else f"about {wait_s / 60.0:.0f} min"


def optimum_line(kind: Kind, figure: str, class_: str, evidence: str) -> VerdictLine:
    """*Optimum*: what is claimed of the burns, for which class of them, by what evidence."""
    claim = Claim(kind, figure, class_, evidence)
    return fitted(Question.OPTIMUM, Word[kind.name], figure, claim=claim)


def answer_line(plan: Told, verified: str, closest: str, proved_for: str) -> VerdictLine:
    """*Answer*: the figure of a plan to fly is `verified`, of one that is not found what the `closest` start leaves, and a proof
    of infeasibility is one `proved_for` a class of burns."""
    found, status, word = plan.verification, plan.status, Word[plan.status.name]
    if status is PlanStatus.VERIFIED and found is not None:
        evidence = _flown_within(plan.scenario, found)
        return fitted(Question.ANSWER, word, verified, evidence)
    if status is PlanStatus.NOT_VERIFIED and found is not None:
        most = plan.scenario.method.max_nodes
        advice = f"try method.max_nodes above {most}" if most < MOST_NODES else ""
        return fitted(Question.ANSWER, word, f"do not fly: {found.failures[0]}", advice)
    if status is PlanStatus.INFEASIBLE and plan.proof is not None:
        needed, available = speeds_m_s(plan.proof, plan.scenario)
        figure = f"{plan.proof.what} takes {needed:.1f} m/s, there are {available:.1f} m/s"
        claim = Claim(Kind.PROVED, figure, proved_for, "a bound on what a velocity of this size changes")
        return fitted(Question.ANSWER, word, figure, "proved", claim)
    return fitted(
        Question.ANSWER, word, closest if status is PlanStatus.NOT_FOUND and closest else plan.message
    )


def _flown_within(scenario: Scenario, found: EndOfFlight) -> str:
    """The larger of the two errors of a flight, in parts of what is allowed."""
    rules = scenario.verification
    error, allowed = max(
        (found.angular_momentum_rel, rules.angular_momentum_rel),
        (found.laplace_rel, rules.laplace_rel),
        key=lambda each: each[0] / each[1],
    )
    return f"flown to {error:.0e} ≤ {allowed:.0e}".replace("e-0", "e-")


def speeds_m_s(proof: Proof, scenario: Scenario) -> tuple[float, float]:
    """What is needed, and what there is."""
    speed = CanonicalUnits.of(scenario.constants).speed_m_s
    return speed * proof.needed, speed * proof.available


# sentences


@dataclass(frozen=True, slots=True)
class Phrases:
    """What a plan with one burn and one with two say differently; each is asked for only where it is told.

    `achievement`: what was found; `flown`: what ends within the errors, `nodes`: on which grid, `oblate`: where J2 acts;
    `objection` and `option`: what else is to be said of a plan that is not verified, and of one that is; `which`: burns that a
    proof excludes, `proved_for`: under which conditions; `sought`: what no start led to; `left`: what the closest one leaves;
    `advice`: what to try.
    """

    achievement: str
    flown: str
    nodes: str
    oblate: str
    objection: str
    option: str
    which: str
    proved_for: str
    sought: str
    left: str
    advice: str


def sentences(plan: Told, say: Phrases) -> str:
    """What was found, what the propagation says, and what to try when it is no plan; without the last full stop."""
    found, status = plan.verification, plan.status
    if status is PlanStatus.VERIFIED and found is not None:
        oblate = f"; {say.oblate}" if plan.scenario.burn.coast_j2 else ""
        return (
            f"VERIFIED: {say.achievement}. Flown by an independent integrator, {say.flown} within"
            f" {found.angular_momentum_rel:.0e} of the promised angular momentum and {found.laplace_rel:.0e} of the"
            f" promised eccentricity vector, on a grid of {say.nodes}{oblate}{_turns(plan.scenario, found)}{say.option}"
        )
    if status is PlanStatus.NOT_VERIFIED and found is not None:
        most = plan.scenario.method.max_nodes
        advice = f"raise method.max_nodes above {most}" if most < MOST_NODES else "no grid allowed is finer"
        return (
            f"NOT VERIFIED, do not fly: {say.achievement}, but the propagation does not confirm it:"
            f" {'; '.join(found.failures)}{say.objection or f'; {advice}'}"
        )
    if status is PlanStatus.INFEASIBLE and plan.proof is not None:
        needed, available = speeds_m_s(plan.proof, plan.scenario)
        what = f"{plan.proof.what[0].upper()}{plan.proof.what[1:]}"
        return (
            f"INFEASIBLE: no {say.which}, reaches the target. {what} takes more than {needed:.1f} m/s, and the vehicle has"
            f" {available:.1f} m/s. This is a proof for {say.proved_for}{say.option}"
        )
    if status is PlanStatus.INTERRUPTED:
        return f"INTERRUPTED: {plan.message}; there is no plan"
    if status is PlanStatus.NOT_FOUND:
        left = f"{say.left}. " if say.left else ""
        return f"NOT FOUND: no {say.sought}. {left}This is not a proof that there is none; {say.advice}"
    return f"NO ANSWER: {plan.message}. This is not evidence that the target is out of reach; {say.advice}"


def rate_is_active(scenario: Scenario, found: EndOfFlight | None) -> bool | None:
    """Whether a flight turns as fast as the scenario allows; None without a bound or a flight."""
    bound = scenario.limits.attitude_rate_deg_s
    if bound is None or found is None:
        return None
    return bool(np.rad2deg(found.peak_rate_rad_s) >= ACTIVE * bound)


def _turns(scenario: Scenario, found: EndOfFlight) -> str:
    """How fast the thrust turns, of a scenario that bounds it."""
    bound = scenario.limits.attitude_rate_deg_s
    if bound is None:
        return ""
    peak = f"{np.rad2deg(found.peak_rate_rad_s):.4g} °/s"
    allowed = f"{bound:g} °/s are allowed"
    standing = "which is the bound" if rate_is_active(scenario, found) else allowed
    return f". The thrust turns at up to {peak}; {standing}"
