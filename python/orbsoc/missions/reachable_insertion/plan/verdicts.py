"""What a plan says in words: the verdict first, every violated row by name and in units a person can picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scp import ExitReason
from orbsoc.orbit import EARTH, CanonicalUnits, Elements

from ..model.problems import Iterate
from ..scenario import MOST_NODES, Scenario
from ..search.ignition import later_ignition
from ..targets.any_target import AnyTarget
from ..targets.free_target import FreeTarget
from ..targets.rows import Row
from ..two_burns.instead import two_burns_instead
from ..verification import EndOfFlight
from .burn_plan import BurnPlan
from .claims import Claim

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Violation:
    """One terminal row that could not be met: its name, its canonical value, and what that means."""

    row: Row
    value: float
    words: str


def violations(plan: BurnPlan) -> tuple[Violation, ...]:
    """Terminal rows the sequence had to leave violated, worst first; empty for a feasible plan."""
    return violations_of(plan, plan.iterate)


def violations_of(plan: BurnPlan, iterate: Iterate) -> tuple[Violation, ...]:
    """The same of any iterate of the search."""
    floor = 1e-9  # below it the slack is the solver's, not the trajectory's
    found = [Violation(row, value, _in_words(plan, iterate, row, value)) for row, value in iterate.slack]
    return tuple(sorted((v for v in found if abs(v.value) > floor), key=lambda v: -abs(v.value)))


def verdict(plan: BurnPlan) -> str:
    """One or two sentences: what was found, what the propagation says, and what to try when it is no plan."""
    if plan.status is PlanStatus.VERIFIED:
        if plan.time_of_flight_s == 0.0:
            return "VERIFIED: the vehicle is on its target orbit already; a burn of 0 s, and nothing to steer"
        return f"VERIFIED: {_achievement(plan)}. {_evidence(plan)}{turns_in_words(plan.scenario, plan.verification)}{_later(plan)}"
    if plan.status is PlanStatus.NOT_VERIFIED:
        return f"NOT VERIFIED, do not fly: {_achievement(plan)}, but {_objection(plan)}"
    if plan.status is PlanStatus.INFEASIBLE:
        return _infeasible(plan)
    if plan.status is PlanStatus.NOT_FOUND:
        return _not_found(plan)
    if plan.status is PlanStatus.INTERRUPTED:
        return f"INTERRUPTED: {plan.message}; there is no plan"
    return (
        f"NO ANSWER: {plan.message}. This is not evidence that the target is out of reach;"
        f" {_what_to_try(plan)}"
    )


def in_words(wait_s: float) -> str:
    """A wait that a search ends near, as exactly as the burn asks for."""
    return f"about {wait_s:.0f} s" if wait_s < 120.0 else f"about {wait_s / 60.0:.0f} min"


ACTIVE = 0.999
"""Share of the bound on the attitude rate, from which on a plan is at it."""


def rate_is_active(scenario: Scenario, found: EndOfFlight | None) -> bool | None:
    """Whether a flight turns as fast as the scenario allows; None without a bound or a flight."""
    if scenario.limits is None or found is None:
        return None
    return bool(np.rad2deg(found.peak_rate_rad_s) >= ACTIVE * scenario.limits.attitude_rate_deg_s)


def shape_of(orbit: Elements) -> str:
    """Perigee and apogee heights; of a hyperbola the perigee height, C3 and v∞."""
    perigee = f"{orbit.perigee_height_m() / 1e3:.2f}"
    if orbit.ecc < 1.0:
        return f"{perigee} × {orbit.apogee_height_m() / 1e3:.2f} km"
    c3 = -EARTH.mu_m3_s2 / orbit.sma_m
    return f"a hyperbola of C3 {c3 / 1e6:.4f} km²/s² (v∞ {np.sqrt(c3):.1f} m/s), perigee {perigee} km"


def _achievement(plan: BurnPlan) -> str:
    assert plan.verification is not None
    orbit = plan.verification.planned_orbit
    shape = shape_of(orbit)
    if plan.scenario.problem == "min_time":
        grid = f"a grid of {plan.trajectory.grid.size} nodes follows"
        if plan.claim is Claim.FAST_TURN:
            peak = f"{np.rad2deg(plan.verification.peak_rate_rad_s):.4g} °/s"
            return (
                f"a burn of {plan.time_of_flight_s:.3f} s onto the target orbit, {shape}, that turns at up to {peak}, about as"
                f" fast as {grid}; the shortest one turns faster{_coast(plan)}"
            )
        if plan.claim is Claim.SMOOTH_TURN:
            return (
                f"a burn of {plan.time_of_flight_s:.3f} s onto the target orbit, {shape}, that turns smoothly; the"
                f" shortest one turns faster than {grid}{_coast(plan)}"
            )
        return f"the shortest burn found onto the target orbit, {shape}, takes {plan.time_of_flight_s:.3f} s{_coast(plan)}"
    direction = plan.scenario.target.perigee_direction
    return (
        f"the largest orbit found for a burn of {plan.time_of_flight_s:.3f} s is {shape}, in the target plane"
        f" with the perigee direction {direction}"
    )


def _coast(plan: BurnPlan) -> str:
    burn = plan.scenario.burn
    oblate = " with J2" if burn.coast_j2 else ""
    return f" after a coast of {plan.ignition_s:.1f} s{oblate}" if burn.ignition == "free" else ""


def _evidence(plan: BurnPlan) -> str:
    found = plan.verification
    assert found is not None
    return (
        "Flown by an independent integrator, the attitude programme ends within"
        f" {found.angular_momentum_rel:.0e} of the promised angular momentum and {found.laplace_rel:.0e} of the"
        f" promised eccentricity vector, on a grid of {plan.trajectory.grid.size} nodes"
        f"{'; J2 acts on the coast, and not on the burn' if plan.scenario.burn.coast_j2 else ''}"
    )


def turns_in_words(scenario: Scenario, found: EndOfFlight | None) -> str:
    """How fast the thrust turns, of a scenario that bounds it."""
    limits = scenario.limits
    if limits is None or found is None:
        return ""
    peak = f"{np.rad2deg(found.peak_rate_rad_s):.4g} °/s"
    allowed = f"{limits.attitude_rate_deg_s:g} °/s are allowed"
    standing = "which is the bound" if rate_is_active(scenario, found) else allowed
    return f". The thrust turns at up to {peak}; {standing}"


def _objection(plan: BurnPlan) -> str:
    found = plan.verification
    assert found is not None
    text = f"the propagation does not confirm it: {'; '.join(found.failures)}"
    if plan.stages[-1].outcome.reason is not ExitReason.CONVERGED:
        return f"{text}. On {plan.stages[-1].nodes} nodes the sequence ended thus: {plan.message}"
    most = plan.scenario.method.max_nodes
    advice = f"raise method.max_nodes above {most}" if most < MOST_NODES else "no grid allowed is finer"
    return f"{text}; {_later(plan, sentence=False) or advice}"


def _infeasible(plan: BurnPlan) -> str:
    proof = plan.proof
    assert proof is not None
    speed = CanonicalUnits.of(EARTH).speed_m_s
    burn = f"burn of {plan.time_of_flight_s:.3f} s" if plan.scenario.problem == "max_energy" else "burn"
    return (
        f"INFEASIBLE: no {burn}, however steered, reaches the target. {proof.what[0].upper()}{proof.what[1:]} takes more"
        f" than {speed * proof.needed:.1f} m/s, and the vehicle has {speed * proof.available:.1f} m/s. This is a proof"
        f" for a burn that starts {'now' if plan.ignition_s == 0.0 else 'then'} and stays above the ground"
        f"{_later(plan) or _two_burns(plan)}"
    )


def _not_found(plan: BurnPlan) -> str:
    found = violations(plan)
    worst = found[0].words if found else "no row that stands out"
    below = plan.verification is not None and plan.verification.below_ground
    if plan.verification is not None and below:
        worst = (
            f"the burn {-plan.verification.flight.lowest_altitude_m / 1e3:.1f} km below the ground on its way"
        )
    elif found:
        worst += f", a total violation of {sum(abs(v.value) for v in found):.1e} (canonical units)"
    longest_s = plan.scenario.vehicle.longest_burn_s
    burn = f"burn of {plan.time_of_flight_s:.3f} s" if plan.scenario.problem == "max_energy" else "burn"
    if plan.scenario.problem == "min_time" and plan.time_of_flight_s > 0.97 * longest_s:
        burn += f", even one of all the propellant ({longest_s:.3f} s),"
    tried = starts_tried(plan)
    turning = "" if plan.scenario.limits is None else " within the attitude rate"
    return (
        f"NOT FOUND: no {burn} that meets all terminal conditions{turning} was found from {len(tried)}"
        f" start{'s' if len(tried) > 1 else ''}. The closest one leaves {worst}. This is not a proof that there is none;"
        f" {_later(plan, sentence=False) or _two_burns(plan, sentence=False) or _what_to_try(plan)}"
    )


def starts_tried(plan: BurnPlan) -> list[dict[str, Any]]:
    """Every start of the search, in its order: how its last sequence ended, the worst row that it left, and by how much."""
    last = {(stage.start, stage.ignition_s): stage for stage in plan.stages}
    found: list[dict[str, Any]] = []
    for (start, ignition_s), stage in last.items():
        left = violations_of(plan, stage.outcome.iterate)
        found.append(start_tried(start, ignition_s, stage.outcome.reason, left))
    return found


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


def _later(plan: BurnPlan, *, sentence: bool = True) -> str:
    """What a later ignition would save, as a sentence after a verdict or as a clause within one; empty where none is known."""
    later = later_ignition(plan)
    if later is None:
        return ""
    flow = plan.scenario.vehicle.mass_flow_kg_s
    text = f"ignition {in_words(later.ignition_s)} later a burn of {later.burn_s:.1f} s reaches the target"
    if plan.status is PlanStatus.VERIFIED:
        saved_s = plan.time_of_flight_s - later.burn_s
        share = 100.0 * saved_s / plan.time_of_flight_s
        text += f" and saves {flow * saved_s:.1f} kg of propellant ({share:.0f} %)"
    text += ": --set burn.ignition=free"
    return f". With {text}" if sentence else f"with {text}"


def _two_burns(plan: BurnPlan, *, sentence: bool = True) -> str:
    """Two burns that reach the target, as `_later` has it."""
    found = two_burns_instead(plan)
    if found is None:
        return ""
    wait = f" after a coast of {found.ignition_s:.0f} s" if found.ignition_s > 0.0 else ""
    text = (
        f"burns of {found.first_s:.1f} s{wait} and, {found.coast_s:.0f} s later, {found.second_s:.1f} s reach the target"
        " as flown: --set burn.count=2"
    )
    return f". Two {text}" if sentence else f"two {text}"


def _what_to_try(plan: BurnPlan) -> str:
    if any(row is Row.ATTITUDE_RATE for row, _ in plan.iterate.slack):
        return "allow a faster turn, leave elements of the target free, or let the ignition wait: --set burn.ignition=free"
    if plan.scenario.problem == "max_energy":
        return "try a longer burn.duration_s, another target plane or perigee height, or more method.nodes"
    return "try another burn.duration_s as first guess, a nearer target, or more method.nodes"


def _in_words(plan: BurnPlan, iterate: Iterate, row: Row, value: float) -> str:
    if row is Row.ATTITUDE_RATE:
        return rate_in_words(plan.scenario, value)
    if row is Row.PERIGEE_RADIUS and not isinstance(plan.target, FreeTarget):
        return f"the perigee too low by {_perigee_shortfall_m(plan, value) / 1e3:.2f} km"
    scales = (iterate.momentum_scale, iterate.laplace_scale)
    return row_in_words(plan.target, row, value, iterate.trajectory.end, scales)


def rate_in_words(scenario: Scenario, over: float) -> str:
    """An attitude rate that is above the scenario's bound by so much, rad per canonical time."""
    assert scenario.limits is not None
    over_deg_s, bound = (
        np.rad2deg(over) / CanonicalUnits.of(EARTH).time_s,
        scenario.limits.attitude_rate_deg_s,
    )
    return (
        f"the attitude rate at {bound + over_deg_s:.4g} °/s, {over_deg_s:.4g} above"
        f" limits.attitude_rate_deg_s = {bound:g}"
    )


def row_in_words(
    target: AnyTarget, row: Row, value: float, end: Array, scales: tuple[float, float] = (1.0, 1.0)
) -> str:
    """What a row of a target, of S_H and S_L times its vectors, is violated by at a canonical end state (6,)."""
    if isinstance(target, FreeTarget):
        return _missed_in_words(row, value)
    momentum = scales[0] * target.momentum
    units = CanonicalUnits.of(EARTH)
    if row in (Row.LEAN_TO_PERIGEE, Row.LEAN_ACROSS):
        angle = abs(value) / momentum
        speed_m_s = angle * float(np.linalg.norm(end[3:])) * units.speed_m_s
        axis = "line of apsides" if row is Row.LEAN_ACROSS else "in-plane normal of the line of apsides"
        return (
            f"the orbit plane tilted by {np.rad2deg(angle):.4f}° about the {axis} (some {speed_m_s:.1f} m/s of"
            " velocity out of the plane)"
        )
    if row is Row.MOMENTUM:
        radius = float(np.linalg.norm(end[:3]))
        return (
            f"the angular momentum too {'small' if value < 0 else 'large'} by {abs(value) / momentum:.2e} of itself"
            f" (about {abs(value) / radius * units.speed_m_s:.1f} m/s of horizontal velocity)"
        )
    if row is Row.ECCENTRICITY:
        return f"the eccentricity too {'small' if value < 0 else 'large'} by {abs(value):.2e}"
    eccentricity = max(scales[1] * target.eccentricity, abs(value))
    return f"the perigee direction off by {np.rad2deg(np.arctan2(abs(value), eccentricity)):.3f}°"


def _missed_in_words(row: Row, value: float) -> str:
    """Of a target with free elements, whose rows are relative."""
    if row is Row.INCLINATION:
        return f"the inclination too {'low' if value < 0 else 'high'} by {abs(np.rad2deg(value)):.4f}°"
    if row in (Row.LEAN_TO_PERIGEE, Row.LEAN_ACROSS):
        return f"the orbit plane tilted by {abs(np.rad2deg(value)):.4f}°"
    if row is Row.ENERGY:
        speed = CanonicalUnits.of(EARTH).speed_m_s
        return (
            f"v²/2 − μ/r too {'small' if value < 0 else 'large'} by {abs(value) * speed**2 / 1e6:.4f} km²/s²"
        )
    if row is Row.PERIGEE_DIRECTION:
        return f"the eccentricity vector off the perigee direction by {abs(value):.2e}"
    return f"the {row.value} off by {abs(value):.2e} of itself"


def _perigee_shortfall_m(plan: BurnPlan, value: float) -> float:
    """Slack s in e ≤ p/r_p − 1 + s lets the perigee sink by about r_p s/(1 + e)."""
    height_km = plan.scenario.target.perigee_height_km or 0.0
    return abs(value) * (EARTH.earth_radius_m + 1e3 * height_km)
