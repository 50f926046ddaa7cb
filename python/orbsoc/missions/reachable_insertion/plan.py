"""A plan with one burn as `guidance.mission.Plan` has it, the functions by which the mission makes one, and what is said of it:
the lines *Answer*, *Option* and *Optimum*, and the same in sentences."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orbsoc.guidance.claims import Kind
from orbsoc.guidance.figure_style import image_element
from orbsoc.guidance.mission import Difference, FigureFile, PaperRow, PlanStatus
from orbsoc.guidance.scenario_file import of_mission
from orbsoc.guidance.scp import ExitReason, Iteration, Solve, solver
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word
from orbsoc.orbit import elements_from_state

from .figures.orbit import orbit_figure
from .figures.panels import draw_figures
from .paper import compare
from .planner import searched
from .record.attitude import attitude_table
from .record.document import plan_document, starts_tried, violations
from .record.messages import messages
from .record.words import Phrases, answer_line, fitted, optimum_line, sentences, wait_in_words
from .scenario import ProblemName, Scenario
from .search.ignition import LaterIgnition, later_ignition
from .search.run import Claim, SearchResult
from .search.setup import InsertionSetup
from .search.strategies import NULL_BURN
from .targets.rows import Row
from .two_burns.instead import two_burns_instead
from .two_burns.planner import TwoBurnPlan, plan_two_burns
from .verification import THRUST_EXCESS, Arcs, Verification, shape_of, short_shape

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TIME_REL = 1e-7
SMA_REL = 1e-7
NODE_STATE = 1e-6
"""Largest difference of a collocated state, in Earth radii and circular speeds, that counts as agreement."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Plan(SearchResult):
    """What the search came to, with its verdict and files."""

    @property
    def later(self) -> LaterIgnition | None:
        """A later ignition that shortens the burn or makes one possible; looked for when first asked."""
        return later_ignition(self)

    @property
    def verdict(self) -> Verdict:
        """The answer, a cheaper option where one is known, and what is claimed of the optimum."""
        return verdict_of(self)

    def to_dict(self) -> dict[str, Any]:
        return plan_document(self, details(self), self.later, two_burns_instead(self))

    @property
    def arcs(self) -> Arcs | None:
        """Coast and burn as flown; None where nothing was."""
        found = self.verification
        return None if found is None else Arcs.of_one(self.scenario, self.ignition_s, found.flight)

    def tables(self) -> dict[str, str]:
        arcs = self.arcs if self.status is PlanStatus.VERIFIED else None
        if arcs is None:
            return {}
        table = {"attitude.csv": attitude_table(self.scenario, arcs)}
        return table | (messages(self.scenario, arcs) if self.time_of_flight_s else {})

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        return draw_figures(self, self.arcs, folder)

    def plot(self) -> Figure:
        """The orbit before and after with the burn, a Matplotlib figure. Raises ValueError for a plan that was not flown."""
        if (arcs := self.arcs) is None:
            raise ValueError(f"nothing to plot: the plan is {self.status.value}; {self.message}")
        start = self.scenario.launch_inertial(self.scenario.initial)
        return orbit_figure(f"{self.scenario.name}: the orbit before and after", start, arcs)

    def differences(self, other: Plan) -> tuple[Difference, ...]:
        """Burn time and semi-major axis, relative, and states at the nodes of the other, canonical; grids may differ."""
        mine, theirs = self.trajectory, other.trajectory
        at_nodes = mine.grid.interpolate_from_start(self.setup.burn.start, mine.states, theirs.grid.nodes)
        apart = [float(np.abs(at_nodes - theirs.states).max()), float(np.abs(mine.end - theirs.end).max())]
        longest = max(mine.duration, theirs.duration)  # 0 of two burns of 0 s
        time_rel = abs(mine.duration - theirs.duration) / longest if longest else 0.0
        ours_m, theirs_m = (_sma_m(plan) for plan in (self, other))
        return (
            Difference("time_of_flight_rel", "burn time", time_rel, TIME_REL),
            Difference("sma_rel", "semi-major axis", abs(ours_m - theirs_m) / abs(theirs_m), SMA_REL),
            Difference("node_state", "node states", max(apart), NODE_STATE, "canonical"),
        )

    def __repr__(self) -> str:
        found = self.verification
        lines = [
            f"Plan {self.scenario.name!r}, {self.scenario.problem}: {self.status.value}",
            f"  burn {self.time_of_flight_s:.3f} s, {self.propellant_kg:.1f} kg of propellant, ignition {self.ignition_s:.1f} s",
        ]
        if found is not None:
            inclination_deg = np.rad2deg(found.planned_orbit.inc_rad)
            lines.append(f"  orbit {shape_of(found.planned_orbit)}, inclination {inclination_deg:.3f}°")
        return "\n".join([*lines, f"  {len(self.subproblems)} subproblems; {self.message}"])

    def _repr_html_(self) -> str:
        """Of a notebook: the verdict, and the figure where there is one."""
        text = self.verdict._repr_html_()
        if self.verification is None:
            return text
        return text + image_element(self.plot(), "the orbit before and after")


def _sma_m(plan: SearchResult) -> float:
    end = plan.setup.units.state_to_si(plan.trajectory.end)
    return elements_from_state(end[:3], end[3:], plan.scenario.constants).sma_m


def plan(
    scenario: Scenario,
    *,
    solve: Solve | None = None,
    problem: ProblemName | None = None,
    callback: Callable[[Iteration], None] | None = None,
) -> Plan | TwoBurnPlan:
    """Plan the insertion of `scenario`; `problem` overrides the scenario's, `callback` sees every iteration.

    `solve` is any solver with the call shape of `orbsoc.solve`, which is the default. A target that cannot be
    reached, or a sequence that does not converge, is a status with its reason. Raises
    `orbsoc.guidance.scenario_file.ScenarioError` when `problem` contradicts the scenario.
    """
    solve = solver(solve)
    if problem is not None and problem != scenario.problem:
        scenario = scenario.with_changes(problem=problem)
    if scenario.burn.count == 1:
        found = searched(scenario, solve, callback)
    else:
        found = searched(scenario, solve, callback, (NULL_BURN,))
        if not found.attempts:
            return plan_two_burns(InsertionSetup.of(scenario), solve, callback)
    return Plan(found.setup, found.attempts, found.proof, found.interrupted)


def reproduce(scenarios: Path) -> tuple[PaperRow, ...]:
    """Both problems of every scenario in a folder that names a case of the paper; each row's quantity names its plan."""
    rows: list[PaperRow] = []
    for scenario in of_mission(Scenario, scenarios):
        for problem in ("min_time", "max_energy") if scenario.compare_with else ():
            planned = plan(scenario.with_changes(problem=problem))
            assert isinstance(planned, Plan)  # the paper has one burn
            found = compare(planned)
            rows += (replace(row, quantity=f"{scenario.name}, {problem}: {row.quantity}") for row in found)
    return tuple(rows)


def verdict_of(plan: SearchResult) -> Verdict:
    """The lines of a plan."""
    optimum = _optimum(plan) if plan.status is PlanStatus.VERIFIED else None
    return Verdict.of([_answer(plan), _later_line(plan) or _two_burns_line(plan), optimum])


def _answer(plan: SearchResult) -> VerdictLine:
    found = plan.verification
    if plan.status is PlanStatus.VERIFIED and plan.time_of_flight_s == 0.0:
        return fitted(Question.ANSWER, Word.VERIFIED, "burn 0 s: the vehicle is on its target orbit")
    coast = f"coast {plan.ignition_s:.0f} s, " if plan.ignition_s > 0.0 else ""
    orbit = "" if found is None else short_shape(found.planned_orbit)
    left, tried = violations(plan), len(starts_tried(plan))
    worst = left[0].words if left else "a flight through the ground"
    return answer_line(
        plan,
        f"{coast}burn {plan.time_of_flight_s:.3f} s → {orbit}",
        f"{tried} start{'s' if tried > 1 else ''}; the closest leaves {worst}",
        _proved_for(plan),
    )


def _proved_for(plan: SearchResult) -> str:
    """The class of a proof of infeasibility."""
    return f"a burn that starts {'now' if plan.ignition_s == 0.0 else 'then'} and stays above the ground"


def _later_line(plan: SearchResult) -> VerdictLine | None:
    later = later_ignition(plan)
    if later is None:
        return None
    free = {"burn.ignition": "free"}
    if plan.status is not PlanStatus.VERIFIED:
        figure = f"{wait_in_words(later.ignition_s)} later a burn of {later.burn_s:.1f} s reaches it"
        return VerdictLine(Question.OPTION, Word.POSSIBLE, figure, settings=free)
    saved = 100.0 * (1.0 - later.burn_s / plan.time_of_flight_s)
    figure = f"with ignition free the burn takes {later.burn_s:.1f} s (−{saved:.0f} %)"
    return VerdictLine(Question.OPTION, Word.CHEAPER, figure, settings=free)


def _two_burns_line(plan: SearchResult) -> VerdictLine | None:
    found = two_burns_instead(plan)
    if found is None:
        return None
    figure = f"two burns of {found.first_s:.1f} and {found.second_s:.1f} s reach it"
    return VerdictLine(Question.OPTION, Word.POSSIBLE, figure, settings={"burn.count": "2"})


def _optimum(plan: SearchResult) -> VerdictLine:
    found, nodes = plan.verification, plan.trajectory.grid.size
    bound = plan.scenario.limits.attitude_rate_deg_s
    assert found is not None
    peak = f"{np.rad2deg(found.peak_rate_rad_s):.4g} °/s"
    problems, tried = len(plan.subproblems), len(starts_tried(plan))
    figure = f"a local optimum of {problems} conic problems on {nodes} nodes"
    if plan.claim is Claim.NOTHING_TO_BURN:
        figure = "no burn is shorter than 0 s"
        return optimum_line(Kind.PROVED, figure, "all burns", "the vehicle is on its target orbit")
    if plan.claim is Claim.FAST_TURN:
        figure = f"turns at up to {peak}; {_shorter(plan)}"
    elif plan.claim is Claim.SMOOTH_TURN:
        figure = f"turns smoothly; {_shorter(plan)}"
    elif bound is not None:
        figure = f"a local optimum; turns at up to {peak}, allowed {bound:g} °/s"
    what = "burns of this time" if plan.scenario.problem == "max_energy" else "burns onto the target orbit"
    evidence = f"{problems} conic problems and {len(plan.attempts)} flights from {tried} starts and ignitions"
    return optimum_line(Kind.BEST_FOUND, figure, what, evidence)


def _shorter(plan: SearchResult) -> str:
    """What is known of shorter burns: one that a sequence led to, and that turned too fast for its grid, the finest one."""
    tried = [
        each
        for each in plan.attempts
        if each.verification is not None
        and each.trajectory.duration < plan.trajectory.duration
        and any(words.startswith(THRUST_EXCESS) for words in each.verification.failures)
    ]
    if not tried:
        return "no shorter one was found"
    best = min(tried, key=lambda each: (-each.nodes, each.trajectory.duration))
    duration_s = best.trajectory.duration * plan.setup.units.time_s
    return f"one of {duration_s:.3f} s turned faster than {best.nodes} nodes follow"


def details(plan: SearchResult) -> str:
    """One or two sentences: what was found, what the propagation says, and what to try when it is no plan."""
    found, scenario = plan.verification, plan.scenario
    if plan.status is PlanStatus.VERIFIED and plan.time_of_flight_s == 0.0:
        return "VERIFIED: the vehicle is on its target orbit already; a burn of 0 s, and nothing to steer"
    largest = scenario.problem == "max_energy"
    burn = f"burn of {plan.time_of_flight_s:.3f} s" if largest else "burn"
    sought = burn
    longest_s = scenario.vehicle.longest_burn_s
    if not largest and plan.time_of_flight_s > 0.97 * longest_s:
        sought += f", even one of all the propellant ({longest_s:.3f} s),"
    tried = len(starts_tried(plan))
    turning = "" if scenario.limits.attitude_rate_deg_s is None else " within the attitude rate"
    option = _later(plan) or _two_burns(plan)
    last = plan.attempts[-1]
    objection = f"; {_later(plan)}" if _later(plan) else ""
    if last.outcome.reason is not ExitReason.CONVERGED:
        objection = f". On {last.nodes} nodes the sequence ended thus: {last.outcome.message}"
    return sentences(
        plan,
        Phrases(
            achievement="" if found is None else _achievement(plan, found),
            flown="the attitude programme ends",
            nodes=f"{plan.trajectory.grid.size} nodes",
            oblate="J2 acts on the coast, and not on the burn",
            objection=objection,
            option=f". {option[0].upper()}{option[1:]}" if option else "",
            which=f"{burn}, however steered",
            proved_for=_proved_for(plan),
            sought=f"{sought} that meets all terminal conditions{turning} was found from {tried} start{'s' if tried > 1 else ''}",
            left=f"The closest one leaves {_left(plan, found)}",
            advice=option or _what_to_try(plan),
        ),
    )


def _achievement(plan: SearchResult, found: Verification) -> str:
    shape, time = shape_of(found.planned_orbit), f"{plan.time_of_flight_s:.3f} s"
    burn, target = plan.scenario.burn, plan.scenario.target
    if plan.scenario.problem != "min_time":
        return (
            f"the largest orbit found for a burn of {time} is {shape}, in the target plane"
            f" with the perigee direction {target.perigee_direction}"
        )
    oblate = " with J2" if burn.coast_j2 else ""
    coast = f" after a coast of {plan.ignition_s:.1f} s{oblate}" if burn.ignition == "free" else ""
    grid = f"a grid of {plan.trajectory.grid.size} nodes follows"
    if plan.claim is Claim.FAST_TURN:
        turn = f"turns at up to {np.rad2deg(found.peak_rate_rad_s):.4g} °/s, about as fast as {grid}"
        return f"a burn of {time} onto the target orbit, {shape}, that {turn}; {_shorter(plan)}{coast}"
    if plan.claim is Claim.SMOOTH_TURN:
        turn = f"turns smoothly; {_shorter(plan)}"
        return f"a burn of {time} onto the target orbit, {shape}, that {turn}{coast}"
    return f"the shortest burn found onto the target orbit, {shape}, takes {time}{coast}"


def _left(plan: SearchResult, found: Verification | None) -> str:
    if found is not None and found.below_ground:
        return f"the burn {-found.flight.lowest_altitude_m / 1e3:.1f} km below the ground on its way"
    left = violations(plan)
    if not left:
        return "no row that stands out"
    total = sum(abs(each.value) for each in left)
    return f"{left[0].words}, a total violation of {total:.1e} (canonical units)"


def _later(plan: SearchResult) -> str:
    """What a later ignition would save; empty where none is known."""
    later = later_ignition(plan)
    if later is None:
        return ""
    text = f"with ignition {wait_in_words(later.ignition_s)} later a burn of {later.burn_s:.1f} s reaches the target"
    if plan.status is PlanStatus.VERIFIED:
        saved_s = plan.time_of_flight_s - later.burn_s
        saved_kg, share = (
            plan.scenario.vehicle.mass_flow_kg_s * saved_s,
            100.0 * saved_s / plan.time_of_flight_s,
        )
        text += f" and saves {saved_kg:.1f} kg of propellant ({share:.0f} %)"
    return f"{text}: --set burn.ignition=free"


def _two_burns(plan: SearchResult) -> str:
    """Two burns that reach the target; empty where none are known."""
    found = two_burns_instead(plan)
    if found is None:
        return ""
    wait = f" after a coast of {found.ignition_s:.0f} s" if found.ignition_s > 0.0 else ""
    return (
        f"two burns of {found.first_s:.1f} s{wait} and, {found.coast_s:.0f} s later, {found.second_s:.1f} s reach the target"
        " as flown: --set burn.count=2"
    )


def _what_to_try(plan: SearchResult) -> str:
    if any(row is Row.ATTITUDE_RATE for row, _ in plan.iterate.slack):
        return "allow a faster turn, leave elements of the target free, or let the ignition wait: --set burn.ignition=free"
    if plan.scenario.problem == "max_energy":
        return "try a longer burn.duration_s, another target plane or perigee height, or more method.nodes"
    return "try another burn.duration_s as first guess, a nearer target, or more method.nodes"
